// Renders a baked file by the lines for three.js of the chapter on real time, with a white point lamp, for
// `scripts/compare renderers`. It reads JSON: glb, size, lamp (where it is), view (position, target, degrees) and
// intensity (of the lamp, in units of the file). It writes the radiance of all pixels, row by row.

import { readFile } from "node:fs/promises";
import { text } from "node:stream/consumers";
import { chromium } from "playwright-core";
import { FLAGS, radiance } from "./test/three.mjs";

const CHAPTER = new URL("../docs/src/realtime.md", import.meta.url);

const { glb, size, lamp, view, intensity } = JSON.parse(await text(process.stdin));
const [, chapter] = (await readFile(CHAPTER, "utf8")).match(/```js\n(.*?)```/s);
const lines = `${chapter}
  const lamp = new THREE.PointLight(0xffffff, ${intensity});
  lamp.position.copy(turned(${JSON.stringify(lamp)}));
  scene.add(lamp);`;
const places = Array.from({ length: size * size }, (_, number) => [number % size, Math.floor(number / size)]);
const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: FLAGS });
try {
  const page = await browser.newPage();
  console.log(JSON.stringify(await radiance(page, lines, await readFile(glb), [size, ...view, places])));
} finally {
  await browser.close();
}
