// What a first visit transfers.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { join } from "node:path";
import { brotliCompressSync } from "node:zlib";
import { after } from "node:test";
import { DIST, IS_RELEASED, browserTest, lit, pageTest, serve } from "./page.mjs";

/** Greatest size of what the story of the released page needs without its live light, in bytes after brotli. */
const MOST_BYTES = 400_000;

let release;
const released = new Promise((resolve) => (release = resolve));
/** Files of the 3-D view. */
const isOfView = (file) => /^(viewer|scene|field)/.test(file);
const slow = await serve((file) => (isOfView(file) ? released : undefined));
/** The addresses of the page, each with a server of its own. */
const whole = await Promise.all(["", "index.html"].map(async (address) => ({ address, ...await serve() })));
after(() => Promise.all([slow, ...whole].map(({ close }) => close())));

async function size(files) {
  const contents = await Promise.all(files.map((file) => readFile(join(DIST, file))));
  return contents.reduce((sum, content) => sum + brotliCompressSync(content).length, 0);
}

pageTest("the story can be used before its light is computed", { fragment: "", url: slow.url }, async (page, t) => {
  const text = page.locator("#story-text");
  await text.filter({ hasText: "below 15 cm of this snow" }).waitFor();
  assert.ok(await page.locator("#poster").isVisible(), "there is no picture");
  await page.locator("#story").getByLabel("Snow above the lamp", { exact: true }).fill("20");
  await text.filter({ hasText: "below 20 cm of this snow" }).waitFor();
  await page.waitForFunction(() => document.getElementById("precision").textContent.startsWith("Final"));
  const files = [...new Set(slow.sent.map(({ file }) => file))];
  t.diagnostic(files.join(", "));
  if (IS_RELEASED) {
    const bytes = await size(files);
    t.diagnostic(`${bytes} bytes after brotli`);
    assert.ok(bytes < MOST_BYTES, `the story loads ${bytes} bytes`);
  }
  release();
  await lit(page);
});

for (const { address, url, sent } of whole) {
  browserTest(`no file is sent twice to a visitor of ./${address}`, async (page) => {
    await page.goto(`${url}${address}`);
    // It starts once there is light.
    await page.waitForFunction(() => navigator.serviceWorker.controller?.state === "activated");
    const files = sent.map(({ file }) => file);
    assert.deepEqual(files.filter((file, index) => files.indexOf(file) !== index), []);
  });
}
