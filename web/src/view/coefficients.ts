/** The coefficients of the clear sky, which workers load when they first need them. */

import type { Files } from "native:scene";

const FILES = ["hosek_wilkie_2012_spectral.csv", "hosek_wilkie_2013_sun.csv"];

let loaded: Promise<[string, Uint8Array][]> | undefined;

/** Adds the files that a clear sky needs. */
export async function addCoefficients(files: Files): Promise<void> {
  loaded ??= Promise.all(FILES.map(load));
  // The next sky tries again.
  loaded.catch(() => (loaded = undefined));
  for (const [name, content] of await loaded) files.add(name, content);
}

async function load(name: string): Promise<[string, Uint8Array]> {
  const response = await fetch(new URL(name, import.meta.url));
  if (!response.ok) throw new Error(`the clear sky cannot be loaded (${response.status})`);
  return [name, new Uint8Array(await response.arrayBuffer())];
}
