/** Makes the light field on the snow of a scene as a GLB file. */

import init, { Files, bake_glb } from "native:scene";
import type { FileAnswer, FileRequest } from "../view/file-messages";
import { addCoefficients } from "../view/coefficients";
import type { sceneOf } from "../view/scene";

let request: FileRequest | undefined;
let module: WebAssembly.Module | undefined;

/** One message is the compiled module, one the request. */
self.onmessage = ({ data }: MessageEvent<WebAssembly.Module | FileRequest>) => {
  if (data instanceof WebAssembly.Module) module = data;
  else request = data;
  if (module !== undefined && request !== undefined) void make(module, request);
};

async function make(module: WebAssembly.Module, { scene, mesh }: FileRequest): Promise<void> {
  try {
    await init({ module_or_path: module });
    const files = new Files();
    if (mesh !== undefined) files.add(mesh.name, mesh.bytes);
    if ((JSON.parse(scene) as ReturnType<typeof sceneOf>).sky?.type === "clear") await addCoefficients(files);
    post({ bytes: bake_glb(scene, files) as Uint8Array<ArrayBuffer> });
  } catch (error) {
    post({ error: error instanceof Error ? error.message : String(error) });
  }
}

function post(answer: FileAnswer): void {
  self.postMessage(answer);
}
