// The picture that stands for the first view of the story until its light is computed. After a change of that view,
// UPDATE_POSTER=1 writes it anew, into the folder of the page; then build the page again.

import assert from "node:assert/strict";
import { writeFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { lit, pageTest } from "./page.mjs";

const POSTER = fileURLToPath(new URL("../poster.webp", import.meta.url));
/** Wider than the view is on usual screens, which crop it. */
const WIDE = { viewport: { width: 1920, height: 800 } };
const QUALITY = 0.7;
/** Of 255, over all pixels. Compression takes some 0.6, and a lamp 1 cm higher changes 2. */
const MEAN_DIFFERENCE = 1;

pageTest("the first picture is what the story shows", { fragment: "", ...WIDE }, async (page) => {
  await lit(page);
  await page.locator("#poster.gone").waitFor({ state: "hidden" });
  await page.addStyleTag({ content: ".sb-layer { visibility: hidden }" });
  const shot = (await page.locator("#view").screenshot()).toString("base64");
  const { webp, difference } = await page.evaluate(async ([shot, quality]) => {
    const pixels = async (source) => {
      const image = await createImageBitmap(await (await fetch(source)).blob());
      const canvas = document.createElement("canvas");
      [canvas.width, canvas.height] = [image.width, image.height];
      const context = canvas.getContext("2d");
      context.drawImage(image, 0, 0);
      return { data: context.getImageData(0, 0, image.width, image.height).data, canvas };
    };
    const [live, poster] = [await pixels(`data:image/png;base64,${shot}`), await pixels("poster.webp")];
    const total = live.data.reduce((sum, value, at) => sum + Math.abs(value - poster.data[at]), 0);
    return { webp: live.canvas.toDataURL("image/webp", quality), difference: total / live.data.length };
  }, [shot, QUALITY]);
  if (process.env.UPDATE_POSTER) writeFileSync(POSTER, Buffer.from(webp.split(",")[1], "base64"));
  else assert.ok(difference < MEAN_DIFFERENCE, `it differs by ${difference} of 255`);
});

pageTest("no other view begins with that picture", { fragment: "story=4" }, async (page) => {
  await page.locator("#poster.gone").waitFor({ state: "hidden" });
});
