// The lines for three.js in the chapter on real time, in the browser, against the command.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { inFolder } from "./command.mjs";
import { readExr } from "./exr.mjs";
import { browserTest } from "./page.mjs";
import { radiance } from "./three.mjs";

const CHAPTER = new URL("../../docs/src/realtime.md", import.meta.url);
const SCENE = new URL("../../scenes/block_30cm.toml", import.meta.url);
const SIZE = 270;
/** Pixels on the dark face, away from its edges. */
const PLACES = [100, 115, 130].flatMap((column) => [90, 120, 150, 180].map((row) => [column, row]));
/** The file has a vertex every two cells of the light field, and light is linear between them. */
const MOST_DIFFERENCE = 0.01;

/** The numbers of a key of a scene. */
function numbers(scene, key) {
  return JSON.parse(scene.match(new RegExp(`^${key} = (.*)$`, "m"))[1]);
}

/** The view of a scene, with the places. */
function viewOf(scene) {
  return [SIZE, ...["position", "look_at", "vertical_fov_deg"].map((key) => numbers(scene, key)), PLACES];
}

browserTest("baked snow in three.js has the light of the command", async (page) => {
  const [, lines] = (await readFile(CHAPTER, "utf8")).match(/```js\n(.*?)```/s);
  const scene = await readFile(SCENE, "utf8");
  const sampled = ["--width", String(SIZE), "--height", String(SIZE), "--spp", "16"];
  // Light by way of the floor is part of the snow's own lighting, which the chapter leaves to three.js.
  const direct = ["--max-bounces", "0"];
  const { glb, picture } = await inFolder({ "block.toml": scene }, async (run, read) => {
    await run("bake", "block.toml", ...direct, "-o", "block.glb");
    await run("render", "block.toml", "--integrator", "diffusion", ...direct, ...sampled, "-o", "block.exr");
    return { glb: await read("block.glb"), picture: readExr(await read("block.exr")) };
  });
  const found = await radiance(page, lines, glb, viewOf(scene));
  for (const [number, [column, row]] of PLACES.entries()) {
    for (const [channel, name] of [..."RGB"].entries()) {
      const expected = picture(column, row, name);
      const difference = Math.abs(found[number][channel] / expected - 1);
      const place = `${column}, ${row}, ${name}`;
      assert.ok(expected > 0 && difference < MOST_DIFFERENCE, `${place}: ${found[number]}, ${expected}`);
    }
  }
});

browserTest("a lightmap in three.js is the colour of its file", async (page) => {
  const lines = 'new GLTFLoader().load("block.glb", ({ scene: snow }) => scene.add(snow));';
  const scene = await readFile(SCENE, "utf8");
  // Vertices 5 mm apart, and texels as far apart.
  const files = await inFolder({ "block.toml": scene }, async (run, read) => {
    await run("bake", "block.toml", "--lightmap", "256", "-o", "texture.glb");
    await run("bake", "block.toml", "--step-mm", "5", "-o", "vertices.glb");
    return [await read("texture.glb"), await read("vertices.glb")];
  });
  const pictures = [];
  for (const glb of files) pictures.push(await radiance(page, lines, glb, viewOf(scene)));
  for (const [number, [column, row]] of PLACES.entries()) {
    for (const channel of [0, 1, 2]) {
      const [texture, vertices] = pictures.map((picture) => picture[number][channel]);
      // Half a code of 8 bits at a code of 50 is 2.5 % of the light.
      const difference = Math.abs(texture / vertices - 1);
      assert.ok(vertices > 0.01 && difference < 0.025, `${column}, ${row}, ${channel}: ${texture}, ${vertices}`);
    }
  }
});

browserTest("the page of the chapter shows blue snow", async (page) => {
  const [, html] = (await readFile(CHAPTER, "utf8")).match(/```html\n(.*?)```/s);
  const scene = await readFile(SCENE, "utf8");
  const glb = await inFolder({ "block.toml": scene }, async (run, read) => {
    await run("bake", "block.toml", "--lightmap", "256", "-o", "block.glb");
    return read("block.glb");
  });
  await page.route("**/*", async (route) => {
    const { pathname } = new URL(route.request().url());
    if (pathname.startsWith("/node_modules/")) {
      const body = await readFile(new URL(`..${pathname}`, import.meta.url));
      return route.fulfill({ body, contentType: "text/javascript" });
    }
    return pathname === "/" ? route.fulfill({ body: html, contentType: "text/html" }) : route.fulfill({ body: glb });
  });
  await page.goto("http://snow.test/");
  // The dark side of the block, in a window of 800 × 600.
  const clip = { x: 340, y: 280, width: 40, height: 40 };
  const middle = async () => {
    const png = await page.screenshot({ clip });
    return page.evaluate(async (base64) => {
      const picture = await createImageBitmap(await (await fetch(`data:image/png;base64,${base64}`)).blob());
      const context = new OffscreenCanvas(picture.width, picture.height).getContext("2d");
      context.drawImage(picture, 0, 0);
      return [...context.getImageData(20, 20, 1, 1).data.subarray(0, 3)];
    }, png.toString("base64"));
  };
  let colour = [0, 0, 0];
  for (let tries = 0; tries < 100 && Math.max(...colour) === 0; tries++) {
    await page.waitForTimeout(100);
    colour = await middle();
  }
  const [red, green, blue] = colour;
  assert.ok(blue > 100 && blue > green && green > 1.5 * red, `${colour}`);
});
