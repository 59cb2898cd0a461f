// Everything works by keyboard alone.

import assert from "node:assert/strict";
import {
  IS_FIREFOX, chooseCurve, code, control, final, lit, pageTest, pixel, sunlit, viewSize,
} from "./page.mjs";

/** More stops than the page has; going on for longer would mean that the focus is caught. */
const MOST_STOPS = 400;
const ALL = "layer=thickness_cm:15&layer=thickness_cm:3&pin=layer%3Dthickness_cm:30&lamp=0,0.3,0.2,D65,10&" +
  "lamp=0.1,0.3,0.2,A,5&view_exposure=1&exposure=3";

/** Opens all that is folded, without moving the focus. */
async function openAll(page) {
  await page.getByRole("button", { name: "Explain all" }).evaluate((one) => one.click());
  await page.locator("details").evaluateAll((all) => all.forEach((one) => (one.open = true)));
}

/** Marks all that the Tab key must reach, and counts it. Of radio buttons it reaches one in each group. */
function expected(page) {
  return page.evaluate(() => {
    const focusable = "a[href], button, input, select, summary, [tabindex]";
    const all = [...document.querySelectorAll(focusable)].filter((one) =>
      one.tabIndex >= 0 && !one.disabled && one.checkVisibility({ visibilityProperty: true }));
    const must = all.filter((one) => one.type !== "radio" || one.checked);
    must.forEach((one) => (one.dataset.must = ""));
    return must.length;
  });
}

/** What has the focus: whether it was there before, and whether the focus is seen. */
function focused(page) {
  return page.evaluate(() => {
    const one = document.activeElement;
    const isOutlined = (style) => style.outlineStyle !== "none" && parseFloat(style.outlineWidth) >= 2;
    const styles = [getComputedStyle(one), getComputedStyle(one, "::after")];
    if (one.nextElementSibling !== null) styles.push(getComputedStyle(one.nextElementSibling));
    const before = "visited" in one.dataset;
    one.dataset.visited = "";
    return {
      before, isPage: one === document.body, isMust: "must" in one.dataset, isSeen: styles.some(isOutlined),
      html: one.outerHTML.slice(0, 120),
    };
  });
}

/** The name that assistive technology has for what has the focus. */
async function nameOfFocused(session) {
  const { result } = await session.send("Runtime.evaluate", { expression: "document.activeElement" });
  const { nodes } = await session.send("Accessibility.getPartialAXTree", {
    objectId: result.objectId, fetchRelatives: false,
  });
  return nodes[0].name?.value ?? "";
}

const NAMES = { fragment: ALL, skip: IS_FIREFOX && "names come from the protocol of Chromium" };

pageTest("the Tab key reaches every control, which has a name and shows its focus", NAMES, async (page) => {
  await page.locator(".sb-lamp").nth(1).waitFor();
  await final(page);
  await sunlit(page);
  await chooseCurve(page, "field.csv", "500,0.9\n1000,0.7\n");
  await page.locator("#measured .ring").waitFor();
  await openAll(page);
  const session = await page.context().newCDPSession(page);
  const count = await expected(page);
  assert.ok(count > 80, `only ${count} controls are there`);
  for (let stop = 0; ; stop++) {
    assert.ok(stop < MOST_STOPS, "the focus does not come to an end");
    await page.keyboard.press("Tab");
    const { before, isPage, isMust, isSeen, html } = await focused(page);
    if (isPage || before) break;
    assert.ok(isMust, `an unexpected stop: ${html}`);
    assert.ok(isSeen, `the focus is not seen: ${html}`);
    assert.notEqual((await nameOfFocused(session)).trim(), "", `no name: ${html}`);
  }
  const missed = await page.locator("[data-must]:not([data-visited])").evaluateAll((all) =>
    all.map((one) => one.outerHTML.slice(0, 120)));
  assert.deepEqual(missed, []);
});

pageTest("controls, light and lamps by keyboard", {}, async (page, t) => {
  const command = () => code(page, "Command line");
  const press = async (locator, ...keys) => {
    await locator.focus();
    for (const key of keys) await page.keyboard.press(key);
  };

  await t.test("a number field takes digits, and refuses what is outside its range", async () => {
    const field = control(page, "Thickness");
    await press(field, "Control+a", "2", "2");
    assert.match(await command(), /--thickness 22 /);
    await press(control(page, "Density"), "Control+a", "5");
    assert.equal(await control(page, "Density").getAttribute("aria-invalid"), "true");
    await page.getByText("Density is 5 kg/m³, but must lie in").waitFor();
    assert.match(await command(), /--density 300 /);
    await press(control(page, "Density"), "Control+a", "2", "5", "0");
    assert.match(await command(), /--density 250 /);
  });

  await t.test("a slider moves its number", async () => {
    const before = Number(await control(page, "Thickness").inputValue());
    await press(control(page, "Thickness, slider"), "ArrowRight");
    const after = Number(await control(page, "Thickness").inputValue());
    assert.ok(after > before && after < 1.1 * before, `${before} became ${after}`);
  });

  await t.test("the arrow keys choose in a group and in a list", async () => {
    await press(page.getByRole("radio", { name: "1931, 2°" }), "ArrowRight");
    assert.match(await command(), /--observer 1964/);
    const list = control(page, "Illuminant");
    const before = await list.inputValue();
    await press(list, "ArrowDown");
    const after = await list.inputValue();
    assert.notEqual(after, before);
    assert.match(await command(), new RegExp(`--illuminant ${after} `));
  });

  await t.test("folded controls open and close", async () => {
    const fold = page.locator("details", { hasText: "Impurities" });
    await press(fold.locator("summary"), "Enter");
    await control(page, "Black carbon").waitFor();
    await page.keyboard.press("Space");
    await control(page, "Black carbon").waitFor({ state: "hidden" });
  });

  await t.test("an explanation opens and closes", async () => {
    const button = page.getByRole("button", { name: "About Density" });
    await press(button, "Enter");
    await page.getByText("Density of the dry snow. Denser snow").waitFor();
    assert.equal(await button.getAttribute("aria-expanded"), "true");
    await press(button, "Space");
    assert.equal(await button.getAttribute("aria-expanded"), "false");
  });

  await t.test("the chart is read at each wavelength", async () => {
    await final(page);
    const chart = page.getByRole("slider", { name: "Reading of the spectrum at a wavelength" });
    await press(chart, "Home", "ArrowRight");
    assert.equal(await chart.getAttribute("aria-valuenow"), "410");
    await press(chart, "End");
    assert.match(await chart.getAttribute("aria-valuetext"), /^700 nanometres, reflectance .+ absorptance /);
  });

  await t.test("a lamp moves, and the light follows", async () => {
    await lit(page);
    const [width, height] = await viewSize(page);
    const middle = [width / 2, height / 2];
    const before = await pixel(page, middle);
    const lamp = page.locator(".sb-lamp");
    await press(lamp, "ArrowRight", "ArrowRight", "ArrowUp", "PageUp", "PageUp");
    assert.equal(await lamp.getAttribute("aria-label"), "Lamp 1 at x -3 cm, y 31 cm, z 26 cm");
    await lit(page);
    const after = await pixel(page, middle);
    // Both lie on the snow; a lamp that moves by 3 cm changes its light by more than the error of one in a thousand.
    assert.ok(before[3] === 1 && after[3] === 1);
    assert.ok(Math.abs(after[2] / before[2] - 1) > 1e-3, `${before} and ${after} are the same`);
  });

  await t.test("a sky is chosen, its sun moves, and the lamps come back", async () => {
    await press(page.getByRole("radio", { name: "Lamps" }), "ArrowRight");
    await press(control(page, "Sun elevation, slider"), "ArrowRight", "ArrowRight");
    await page.waitForFunction(() => location.hash.includes("sky=clear,20,10,2.5"));
    assert.equal(await page.locator(".sb-lamp").count(), 0);
    await press(page.getByRole("radio", { name: "Clear sky" }), "ArrowLeft");
    await page.waitForFunction(() => !location.hash.includes("sky="));
    await page.locator(".sb-lamp").waitFor();
  });

  await t.test("the view turns and comes nearer", async () => {
    await press(page.locator(".sb-field"), "ArrowLeft", "ArrowUp", "+");
    await page.waitForFunction(() => location.hash.includes("camera=27,19,1.136"));
  });
});
