/** Files that the module `scene` makes, each in a worker of its own. */

import type { FileAnswer, FileRequest } from "./file-messages";
import { sceneWorker } from "./native-scene";

export function fileOf(request: FileRequest): Promise<Blob> {
  return new Promise((resolve, reject) => {
    const failed = () => reject(new Error("its worker could not be loaded"));
    const worker = sceneWorker("./files.js", failed);
    worker.onmessage = ({ data }: MessageEvent<FileAnswer>) => {
      worker.terminate();
      if ("error" in data) reject(new Error(data.error));
      else resolve(new Blob([data.bytes]));
    };
    worker.postMessage(request);
  });
}
