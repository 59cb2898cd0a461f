// Pictures of the page against those of `snowblue render`.

import { cameraOf } from "./camera.mjs";
import { inFolder } from "./command.mjs";
import { readExr } from "./exr.mjs";
import { saved, viewSize } from "./page.mjs";

/** Pixels of the page along a side of a pixel of the command. */
const COARSER = 4;
/** Pixels of the command from one compared to the next. */
const STRIDE = 2;

/** A picture of the command with larger pixels than those of the page. Its filter would smooth shadows of the sky. */
export async function coarsePicture(page, samples, isMesh = false) {
  // A mesh comes as a file of its own.
  const files = await saved(page, "Scene TOML", isMesh ? 2 : 1);
  const toml = String(files["scene.toml"]);
  const size = await viewSize(page);
  const coarse = size.map((length) => Math.floor(length / COARSER));
  const film = ["--width", String(coarse[0]), "--height", String(coarse[1]), "--spp", String(samples)];
  const channels = await inFolder(files, async (run, read) => {
    await run("render", "scene.toml", "--integrator", "diffusion", "--raw", ...film, "-o", "scene.exr");
    return readExr(await read("scene.exr"));
  });
  const picture = (x, y) => ["R", "G", "B"].map((channel) => channels(x, y, channel));
  return { picture, size, coarse, camera: cameraOf(toml) };
}

/** Light of both all over the snow but at its outline. */
export async function everywhere(page, samples, isMesh) {
  const { picture, coarse: [width, height] } = await coarsePicture(page, samples, isMesh);
  const isSnow = (x, y) => Math.max(...picture(x, y)) > 0;
  const inside = [];
  for (let y = STRIDE; y < height - STRIDE; y += STRIDE) {
    for (let x = STRIDE; x < width - STRIDE; x += STRIDE) {
      if ([-1, 0, 1].every((down) => [-1, 0, 1].every((across) => isSnow(x + across, y + down)))) inside.push([x, y]);
    }
  }
  const shown = await means(page, inside);
  return inside.map(([x, y], number) => ({ here: shown[number], there: picture(x, y) }));
}

/** The mean of the pixels of the page that each of some pixels of the command covers. */
function means(page, places) {
  return page.evaluate(([places, side]) => {
    const { width, height } = document.querySelector(".sb-field");
    const all = window.__snowblue.readPixels(0, 0, width, height);
    const sums = places.map(() => [0, 0, 0]);
    for (const [number, [x, y]] of places.entries()) {
      for (let row = side * y; row < side * (y + 1); row++) {
        for (let column = side * x; column < side * (x + 1); column++) {
          for (const channel of [0, 1, 2]) sums[number][channel] += all[4 * (row * width + column) + channel];
        }
      }
    }
    return sums.map((sum) => sum.map((value) => value / side ** 2));
  }, [places, COARSER]);
}

/** The greatest difference of a channel, relative to the brightest of the command. */
export function differenceOf({ here, there }) {
  return Math.max(...here.map((value, channel) => Math.abs(value - there[channel]))) / Math.max(...there);
}

/** The mean light of all places. */
export function mean(lights) {
  const of = (key) => [0, 1, 2].map((channel) =>
    lights.reduce((sum, light) => sum + light[key][channel], 0) / lights.length);
  return { here: of("here"), there: of("there") };
}
