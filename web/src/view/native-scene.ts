/** The compiled module `scene`, which all workers share. */

import { compiled } from "../compiled";

const sceneModule = compiled("./scene_bg.wasm");

/** A worker of the module `scene`: its first message is the compiled module. `failed` is called if loading fails. */
export function sceneWorker(script: string, failed: () => void): Worker {
  const worker = new Worker(new URL(script, import.meta.url), { type: "module" });
  worker.onerror = failed;
  sceneModule().then((module) => worker.postMessage(module), failed);
  return worker;
}
