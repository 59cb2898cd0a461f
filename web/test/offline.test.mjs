// After the first visit the page needs no server.

import assert from "node:assert/strict";
import { code, control, final, lit, pageTest, pixel, serve, viewSize } from "./page.mjs";

const { url, close } = await serve();

pageTest("figures and snow without the server", { url }, async (page) => {
  await page.waitForFunction(() => navigator.serviceWorker.controller?.state === "activated");
  await close();
  await assert.rejects(fetch(url), "the server still answers");
  await page.reload();
  await control(page, "Thickness").fill("21");
  await final(page);
  assert.match(await code(page, "Command line"), /--thickness 21 /);
  const summary = page.locator("#summary", { hasText: /^21 cm, .+ transmitted colour #[0-9a-f]{6}/ });
  await summary.waitFor({ state: "attached" });
  await lit(page);
  const [width, height] = await viewSize(page);
  const [red, green, blue] = await pixel(page, [width / 2, height / 2]);
  assert.ok(blue > green && green > red && red > 0, `${[red, green, blue]} is not blue snow`);
  await page.goto(`${url}index.html#layer=thickness_cm:22`);
  await page.locator("#summary", { hasText: /^22 cm, / }).waitFor({ state: "attached" });
});
