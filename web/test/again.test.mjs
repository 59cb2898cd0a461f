// What could not be loaded is loaded when the visitor asks for it again.

import assert from "node:assert/strict";
import { readdir, readFile } from "node:fs/promises";
import test, { after } from "node:test";
import { cubePly } from "./cube.mjs";
import { browserTest, chooseMesh, lit, pixel, serve, viewSize } from "./page.mjs";

const SOURCE = new URL("../src/", import.meta.url);

/** What the server does not have. */
let missing;
const server = await serve(async (file) => {
  if (file === missing) throw new Error("it is missing");
});
after(() => server.close());

for (const [file, said] of [
  ["viewer.js", "The 3-D snow cannot be loaded"], ["scene_bg.wasm", "The light field cannot be loaded."],
]) {
  browserTest(`without ${file} at first`, async (page) => {
    missing = file;
    await page.goto(`${server.url}#laboratory`);
    const error = page.locator("#view-error", { hasText: said });
    await error.waitFor();
    const again = page.getByRole("button", { name: "Try again" });
    // It fails once more, and says so again.
    await again.click();
    await error.waitFor();
    await again.waitFor();
    missing = undefined;
    await again.click();
    await lit(page);
    const [width, height] = await viewSize(page);
    assert.equal((await pixel(page, [width / 2, height / 2]))[3], 1, "there is no snow");
    assert.equal(await page.locator("#view-error").isVisible(), false);
    assert.equal(await again.isVisible(), false);
    assert.equal(await page.locator(".sb-view").count(), 1);
  }, { expected: /404|viewer\.js/ });
}

browserTest("without WebGL 2 the view says so, and its light says nothing", async (page) => {
  await page.addInitScript(() => {
    const { getContext } = HTMLCanvasElement.prototype;
    HTMLCanvasElement.prototype.getContext = function (type, ...options) {
      return type.startsWith("webgl") ? null : getContext.call(this, type, ...options);
    };
  });
  // The worker of the light fails, which the view is not told.
  missing = "scene_bg.wasm";
  const failed = page.waitForResponse((response) => response.url().endsWith("scene_bg.wasm"));
  await page.goto(`${server.url}#laboratory`);
  await page.locator("#view-error", { hasText: "no WebGL 2" }).waitFor();
  await failed;
  // The answer to the worker came before that to the same question here.
  await page.evaluate(() => fetch("scene_bg.wasm"));
  assert.match(await page.locator("#view-error").textContent(), /no WebGL 2/);
  assert.equal(await page.getByRole("button", { name: "Try again" }).isVisible(), false);
  missing = undefined;
}, { expected: /404|WebGL/ });

browserTest("a view that is gone says nothing more", async (page) => {
  await page.addInitScript(() => {
    window.workers = [];
    window.Worker = class extends Worker {
      constructor(...words) {
        super(...words);
        if (String(words[0]).endsWith("/field.js")) window.workers.push(this);
      }
    };
  });
  missing = "scene_bg.wasm";
  await page.goto(`${server.url}#laboratory`);
  const again = page.getByRole("button", { name: "Try again" });
  await again.waitFor();
  const gone = await page.evaluate(() => window.workers.length);
  missing = undefined;
  await again.click();
  await lit(page);
  // Errors and answers of the workers of the first view, which the page could no longer tell from those of the second.
  await page.evaluate((gone) => {
    for (const worker of window.workers.slice(0, gone)) {
      worker.dispatchEvent(new Event("error"));
      const error = { kind: "error", version: 1, text: "this is late" };
      worker.dispatchEvent(new MessageEvent("message", { data: error }));
    }
  }, gone);
  assert.equal(await page.locator("#view-error").isVisible(), false);
  assert.match(await page.locator("#view-status").textContent(), /Squares on the ground/);
  const [width, height] = await viewSize(page);
  assert.equal((await pixel(page, [width / 2, height / 2]))[3], 1, "there is no snow");
}, { expected: /404/ });

const cube = Buffer.from(cubePly());

for (const file of ["meshes.js", "meshes_bg.wasm"]) {
  browserTest(`without ${file} at first`, async (page) => {
    missing = file;
    await page.goto(`${server.url}#laboratory`);
    await lit(page);
    const error = page.locator("#view-error", { hasText: "The mesh cube.ply was refused: " });
    await chooseMesh(page, "cube.ply", cube);
    await error.waitFor();
    missing = undefined;
    await chooseMesh(page, "cube.ply", cube);
    await error.waitFor({ state: "hidden" });
    await lit(page);
    const [width, height] = await viewSize(page);
    assert.equal((await pixel(page, [width / 2, height / 2]))[3], 1, "there is no snow");
  }, { expected: /404|meshes/ });
}

test("all scripts that are loaded later are imported by the rule that tries again", async () => {
  const files = (await readdir(SOURCE, { recursive: true })).filter((file) => /(?<!\.d)\.ts$/.test(file));
  const texts = await Promise.all(files.map((file) => readFile(new URL(file, SOURCE), "utf8")));
  // Not `typeof import("…")`, which is a type.
  const importing = files.filter((_, number) => /(?<!typeof\s+)\bimport\s*\(/.test(texts[number]));
  assert.deepEqual(importing, ["imported.ts"]);
});
