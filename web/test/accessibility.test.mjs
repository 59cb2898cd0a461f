// What axe-core finds, narrow windows, and reduced motion.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { IS_FIREFOX, chooseCurve, final, follow, pageTest, sunlit } from "./page.mjs";

const AXE = await readFile(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
/** Two layers, pins, two lamps, fixed exposures, infrared light: all controls that there are. */
const ALL = "layer=thickness_cm:15,black-carbon:20&layer=thickness_cm:3&pin=layer%3Dthickness_cm:30&pin=&" +
  "lamp=0,0.3,0.2,D65,10&lamp=0.1,0.3,0.2,A,5&view_exposure=1&exposure=3&range=solar";

/** Serious and critical findings in a part of the page. The policy of the page lets no other script in by a tag. */
function findings(page, part) {
  return page.evaluate(`(async () => {
    ${AXE};
    const { violations } = await axe.run(${JSON.stringify(part)});
    return violations.filter(({ impact }) => impact === "serious" || impact === "critical")
      .map(({ id, nodes }) => [id, ...nodes.map(({ html }) => html.slice(0, 120))]);
  })()`);
}

/** How many pixels the page is wider than its window. */
function overflow(page) {
  return page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
}

/** How long the colour of a swatch takes to change. */
function transition(page) {
  return page.locator("#swatches .color").first().evaluate((one) => getComputedStyle(one).transitionDuration);
}

/** Opens all that is folded, chooses a measured curve, and makes an entry wrong. */
async function showAll(page) {
  await page.locator(".sb-lamp").nth(1).waitFor();
  await sunlit(page);
  await chooseCurve(page, "field.csv", "500,0.9\n1000,0.7\n");
  await page.locator("#measured .ring").waitFor();
  await page.getByRole("button", { name: "Explain all" }).click();
  await page.locator("details").evaluateAll((all) => all.forEach((one) => (one.open = true)));
  await page.getByLabel("Density", { exact: true }).fill("5");
  await final(page);
}

pageTest("for everyone", { fragment: ALL, reducedMotion: "reduce" }, async (page, t) => {
  await showAll(page);
  for (const width of [360, 1440]) {
    await page.setViewportSize({ width, height: 900 });
    for (const colorScheme of ["light", "dark"]) {
      await t.test(`nothing serious at ${width} px, ${colorScheme}`, async () => {
        await page.emulateMedia({ colorScheme });
        assert.deepEqual(await findings(page, "body"), []);
        assert.equal(await overflow(page), 0);
      });
    }
  }

  await t.test("nothing serious under a clear sky, at 360 px", async () => {
    await page.setViewportSize({ width: 360, height: 900 });
    await follow(page, "sky=clear,20,30,2.5");
    assert.deepEqual(await findings(page, "#toolbar"), []);
    assert.equal(await overflow(page), 0);
    assert.equal(await page.locator(".sb-lamp").count(), 0);
  });

  const skip = IS_FIREFOX && "Firefox ESR 153 cannot emulate a preference for reduced motion";
  await t.test("nothing moves by itself where that is wanted", { skip }, async () => {
    assert.equal(await transition(page), "0s");
    await page.emulateMedia({ reducedMotion: "no-preference" });
    assert.notEqual(await transition(page), "0s");
    await page.emulateMedia({ reducedMotion: "reduce" });
  });

  await t.test("nothing serious in the notice of a broken link, at 360 px", async () => {
    await page.setViewportSize({ width: 360, height: 900 });
    await follow(page, "snow=1");
    await page.getByRole("alert").filter({ hasText: "The link cannot be read" }).waitFor();
    assert.deepEqual(await findings(page, "#notice"), []);
    assert.equal(await overflow(page), 0);
  });
});

pageTest("the story for everyone", { fragment: "", reducedMotion: "reduce" }, async (page, t) => {
  const steps = page.getByRole("navigation", { name: "Steps of the story" }).getByRole("button");
  await page.locator("#story-text:not(:empty)").waitFor();
  for (let step = 0; step < await steps.count(); step++) {
    await steps.nth(step).click();
    for (const width of [360, 900, 1600]) {
      await page.setViewportSize({ width, height: 900 });
      for (const colorScheme of ["light", "dark"]) {
        await t.test(`nothing serious in step ${step + 1} at ${width} px, ${colorScheme}`, async () => {
          await page.emulateMedia({ colorScheme });
          assert.deepEqual(await findings(page, "body"), []);
          assert.equal(await overflow(page), 0);
        });
      }
    }
  }
});
