/** Traces a picture of a scene and posts it as it gets better. A new request replaces the present one. */

import init, { Files, Picture } from "native:scene";
import { addCoefficients } from "../view/coefficients";
import type { PictureAnswer, PictureRequest } from "../view/picture-messages";
import type { sceneOf } from "../view/scene";

/** Time between two pictures. */
const SHARE_MS = 100;

let newest: number | undefined;
let load: (module: WebAssembly.Module) => void;
const loaded = new Promise<WebAssembly.Module>((resolve) => (load = resolve)).then((module) =>
  init({ module_or_path: module }),
);

/** One message is the compiled module, all others are requests. */
self.onmessage = ({ data }: MessageEvent<WebAssembly.Module | PictureRequest>) => {
  if (data instanceof WebAssembly.Module) {
    load(data);
  } else {
    newest = data.version;
    void trace(data);
  }
};

async function trace({ version, scene, mesh }: PictureRequest): Promise<void> {
  await loaded;
  await otherMessages();
  if (scene === undefined || newest !== version) return;
  const files = new Files();
  try {
    if (mesh !== undefined) files.add(mesh.name, mesh.bytes);
    const { integrator, sky } = JSON.parse(scene) as ReturnType<typeof sceneOf>;
    if (sky?.type === "clear") await addCoefficients(files);
    if (newest !== version) return;
    const coarse = Picture.coarse(scene, files);
    if (coarse !== undefined) {
      try {
        while (coarse.add(SHARE_MS) === 0);
        show(version, coarse, 0);
      } finally {
        coarse.free();
      }
      await otherMessages();
      if (newest !== version) return;
    }
    const picture = new Picture(scene, files);
    const wanted = integrator.samples_per_pixel;
    try {
      let samples = 0;
      while (newest === version && samples < wanted) {
        samples = picture.add(SHARE_MS);
        show(version, picture, samples);
        await otherMessages();
      }
    } finally {
      picture.free();
    }
  } catch (error) {
    post({ kind: "error", version, text: error instanceof Error ? error.message : String(error) });
  } finally {
    files.free();
  }
}

/** Posts a picture with so many samples for each pixel. */
function show(version: number, picture: Picture, samples: number): void {
  const pixels = picture.display() as Uint8ClampedArray<ArrayBuffer>;
  const [width, height] = [picture.width(), picture.height()];
  post({ kind: "picture", version, width, height, pixels, samples }, [pixels.buffer]);
}

/** Lets messages that arrived meanwhile come first. */
function otherMessages(): Promise<void> {
  return new Promise((resolve) => setTimeout(resolve));
}

function post(answer: PictureAnswer, transfer: ArrayBuffer[] = []): void {
  self.postMessage(answer, { transfer });
}
