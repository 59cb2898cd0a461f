/** Scripts beside this one that are loaded when they are needed. */

/** A function that imports a script once. After a failure the next call tries again. */
export function imported<Module>(file: string): () => Promise<Module> {
  let started: Promise<Module> | undefined;
  let failures = 0;
  return () => {
    const address = new URL(file, import.meta.url);
    // Firefox does not load an address again that has failed.
    if (failures > 0) address.search = String(failures);
    started ??= (import(address.href) as Promise<Module>).catch((error) => {
      failures += 1;
      started = undefined;
      throw error;
    });
    return started;
  };
}
