/** Modules of WebAssembly that lie beside the scripts. */

import { once } from "./once";

/** The content type that `compileStreaming` accepts. */
const TYPE = "application/wasm";

/** A function that compiles a module once. After a failure the next call tries again. */
export function compiled(file: string): () => Promise<WebAssembly.Module> {
  return once(async () => {
    const response = await fetch(new URL(file, import.meta.url));
    if (!response.ok) throw new Error(`${file} cannot be loaded (${response.status})`);
    if (response.headers.get("content-type") === TYPE) return WebAssembly.compileStreaming(response);
    return WebAssembly.compile(await response.arrayBuffer());
  });
}
