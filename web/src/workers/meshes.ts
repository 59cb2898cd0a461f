/** Reads a mesh file of a visitor as a closed mesh. */

import init, { closed_mesh } from "native:meshes";
import { compiled } from "../compiled";
import type { MeshFile } from "../view/field-messages";
import type { MeshAnswer } from "../view/file-messages";

const module = compiled("./meshes_bg.wasm");

self.onmessage = async ({ data: { name, bytes } }: MessageEvent<MeshFile>) => post(await read(name, bytes));

async function read(name: string, bytes: Uint8Array): Promise<MeshAnswer> {
  try {
    await init({ module_or_path: await module() });
    const mesh = closed_mesh(name, bytes);
    return { about: JSON.parse(mesh.about()), obj: mesh.obj() as Uint8Array<ArrayBuffer> };
  } catch (error) {
    return { error: error instanceof Error ? error.message : String(error) };
  }
}

function post(answer: MeshAnswer): void {
  self.postMessage(answer);
}
