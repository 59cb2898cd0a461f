// A 3-D view that could not be loaded is loaded when the visitor asks for it again.

import assert from "node:assert/strict";
import { after } from "node:test";
import { browserTest, lit, pixel, serve, viewSize } from "./page.mjs";

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
