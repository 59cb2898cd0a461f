/** A module of WebAssembly that lies beside the scripts. It is not streamed, since a host may not know its type. */
export async function compiled(file: string): Promise<WebAssembly.Module> {
  const response = await fetch(new URL(file, import.meta.url));
  if (!response.ok) throw new Error(`${file} cannot be loaded (${response.status})`);
  return WebAssembly.compile(await response.arrayBuffer());
}
