// Numbers that visitors type, names that tell samples apart, and words where there is hardly any light.

import assert from "node:assert/strict";
import { control, final, follow, lit, pageTest } from "./page.mjs";

/** Types as people do, key by key. */
async function type(field, text) {
  await field.fill("");
  await field.pressSequentially(text);
}

pageTest("numbers are read as they are typed, or refused", { fragment: "layer=thickness_cm:15" }, async (page, t) => {
  const thickness = control(page, "Thickness");
  const layer = () => page.waitForFunction(() => location.hash.includes("thickness_cm:2.5"));

  await t.test("a decimal comma", async () => {
    await type(thickness, "2,5");
    await layer();
    assert.equal(await control(page, "Thickness, slider").getAttribute("aria-valuetext"), "2.5 cm");
  });

  for (const [text, reason] of [
    ["1/2", "Enter a number in 0.1–100000 cm."],
    ["2.5.1", "Enter a number in 0.1–100000 cm."],
    ["1,500", "1,500 may be 1.5 or 1500: enter it without the comma."],
    ["", "Enter a number in 0.1–100000 cm."],
  ]) {
    await t.test(`"${text}" is refused and changes nothing`, async () => {
      await type(thickness, text);
      const error = page.locator(`[id="${(await thickness.getAttribute("aria-describedby")).split(" ")[1]}"]`);
      assert.match(await error.textContent(), new RegExp(`^${reason.replace("0.1–100000", ".+")}$`));
      assert.equal(await thickness.getAttribute("aria-invalid"), "true");
    });
  }

  await t.test("what was refused did not reach the sample", async () => {
    await follow(page, "layer=thickness_cm:2.5,facetness:0.3");
    await final(page);
    await page.locator("#summary", { hasText: /^2\.5 cm, / }).waitFor({ state: "attached" });
  });
});

pageTest("a number that is typed in the story moves its slider", { fragment: "" }, async (page) => {
  await page.locator("#story-text:not(:empty)").waitFor();
  const slider = page.locator("#story input[type=range]");
  for (const depth of ["22", "5,5"]) {
    await type(page.locator("#story").getByLabel("Snow above the lamp", { exact: true }), depth);
    assert.equal(await slider.inputValue(), depth.replace(",", "."));
  }
});

pageTest("samples that differ have names that differ", {}, async (page) => {
  const snows = [
    "layer=thickness_cm:15", "layer=thickness_cm:15,facetness:0.3", "layer=thickness_cm:15,temperature_c:-20",
    "layer=thickness_cm:15,sphericity:0.9", "layer=thickness_cm:15,sphericity:0.7~0.9~0.8~0.2", "observer=1964",
    "layer=thickness_cm:15,grain_size_um:300~500",
    "layer=thickness_cm:15,grain_size_um:400,size_measure:optical-diameter",
    "layer=thickness_cm:5&layer=thickness_cm:10", "layer=thickness_cm:5&layer=thickness_cm:10,facetness:0.3",
  ];
  const names = [];
  for (const few of [snows.slice(0, 4), snows.slice(4, 8), snows.slice(8)]) {
    await follow(page, few.map((snow) => `pin=${encodeURIComponent(snow)}`).join("&"));
    await page.waitForFunction((count) => document.querySelectorAll("#compare-table .words").length === count + 1,
      few.length);
    names.push(...(await page.locator("#compare-table .words").allTextContents()).slice(1));
  }
  assert.equal(names[0], "15 cm, 400 µm, 300 kg/m³");
  assert.equal(new Set(names).size, snows.length, names.join("\n"));
});

const DARK = "shape=block&layer=thickness_cm:60,black-carbon:100000";

pageTest("where hardly any light is left, the page says so", { fragment: DARK }, async (page) => {
  await final(page);
  assert.equal(await page.locator("#meaning").textContent(), "Hardly any light comes through this snow.");
  await follow(page, "shape=ball&layer=thickness_cm:60");
  await final(page);
  assert.match(await page.locator("#meaning").textContent(), /^Through this snow, blue is [\d.]+ times as bright as/);
  await follow(page, "layer=thickness_cm:300");
  await final(page);
  const words = await page.locator("#meaning").textContent();
  assert.match(words, /blue is more than 10,000 times as bright as red|Hardly any light/);
  await lit(page);
});
