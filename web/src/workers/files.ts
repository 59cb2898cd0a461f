/** Makes one file of a scene: the light field on its snow as GLB, or without a scene the mesh as OBJ. */

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
    if (mesh !== undefined) files.add_mesh(mesh.name, mesh.positions, mesh.triangles);
    if (scene !== undefined && (JSON.parse(scene) as ReturnType<typeof sceneOf>).sky?.type === "clear") {
      await addCoefficients(files);
    }
    post({ bytes: scene === undefined ? files.content(mesh!.name) : bake_glb(scene, files) });
  } catch (error) {
    post({ error: error instanceof Error ? error.message : String(error) });
  }
}

function post(answer: FileAnswer): void {
  self.postMessage(answer);
}
