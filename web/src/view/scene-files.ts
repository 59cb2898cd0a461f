/** Files that modules make or read, each in a worker of its own. */

import type { MeshFile } from "./field-messages";
import type { FileAnswer, FileRequest, MeshAnswer } from "./file-messages";
import { sceneWorker } from "./native-scene";

type Made<Answer> = Exclude<Answer, { error: string }>;

/** The light field of a scene. */
export async function fileOf(request: FileRequest): Promise<Blob> {
  const { bytes } = await asked<FileAnswer>((failed) => sceneWorker("./files.js", failed), request);
  return new Blob([bytes]);
}

/** The closed mesh of a file. */
export function meshOf(file: MeshFile): Promise<Made<MeshAnswer>> {
  return asked<MeshAnswer>((failed) => {
    const worker = new Worker(new URL("./meshes.js", import.meta.url), { type: "module" });
    worker.onerror = failed;
    return worker;
  }, file);
}

function asked<Answer extends object>(start: (failed: () => void) => Worker, request: unknown): Promise<Made<Answer>> {
  return new Promise((resolve, reject) => {
    const worker = start(() => reject(new Error("its worker could not be loaded")));
    worker.onmessage = ({ data }: MessageEvent<Answer | { error: string }>) => {
      worker.terminate();
      if ("error" in data) reject(new Error(data.error));
      else resolve(data as Made<Answer>);
    };
    worker.postMessage(request);
  });
}
