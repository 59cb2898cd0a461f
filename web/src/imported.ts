/** Scripts beside this one that are loaded when they are needed. */

import { once } from "./once";

/** A function that imports a script once. After a failure the next call tries again. */
export function imported<Module>(file: string): () => Promise<Module> {
  let failures = 0;
  return once(async () => {
    const address = new URL(file, import.meta.url);
    // Firefox does not load an address again that has failed.
    if (failures > 0) address.search = String(failures);
    try {
      return (await import(address.href)) as Module;
    } catch (error) {
      failures += 1;
      throw error;
    }
  });
}
