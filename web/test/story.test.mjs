// The story: each step by click and by keyboard, and that its control changes its figure.

import assert from "node:assert/strict";
import { control, final, follow, lit, pageTest, pixels, relight, saved, viewSize } from "./page.mjs";
import { rowsOf } from "./command.mjs";

/** Each step: its control, a value to set, and whether its figure is the 3-D snow. */
const STEPS = [
  { label: "Snow above the lamp", value: 22, isSnow: true },
  { label: "Path through ice", value: 10, isSnow: false },
  { label: "Wavelength", value: 450, isSnow: false },
  { label: "Grain size", value: 1200, isSnow: true },
  { label: "Thickness", value: 40, isSnow: true },
  { label: "Soot", value: 200, isSnow: true },
  { label: "Height of the sun", value: 50, isSnow: true },
  { label: "Lamp to the side", value: 12, isSnow: true },
];
/** The light changes by more than this, many times the error of the light field. */
const CHANGE = 0.1;

const stepButton = (page, index) =>
  page.getByRole("navigation", { name: "Steps of the story" }).getByRole("button").nth(index);
const text = (page) => page.locator("#story-text").textContent();
/** The laboratory has controls of the same names. */
const storyControl = (page, label) => page.locator("#story").getByLabel(label, { exact: true });
const drawing = (page) => page.locator("#story-drawing").innerHTML();

/** Light on a grid of places in the middle of the view, by red, green, blue and alpha; this is 1 on snow. */
async function light(page) {
  await lit(page);
  const [width, height] = await viewSize(page);
  const places = [0.4, 0.5, 0.6].flatMap((x) => [0.4, 0.5, 0.6].map((y) => [x * width, y * height]));
  return pixels(page, places);
}

/** Every ratio in the text is that of the light that the picture has at a ring, and there is one for each ring. */
async function statesItsPicture(page) {
  const rings = page.locator(".sb-probed:not([hidden])");
  const expected = async () => {
    const clauses = [];
    for (const ring of await rings.all()) {
      const [x, y] = await ring.evaluate(({ style: { left, top } }) => [left, top].map((one) => parseFloat(one) / 100));
      const place = { x, y };
      const { wavelengths_nm, radiance } = await page.evaluate((place) => window.__snowblue.probe(place), place);
      const [blue, red] = [450, 650].map((nm) => radiance[wavelengths_nm.indexOf(nm)]);
      const [one, other, times] = blue >= red ? ["blue", "red", blue / red] : ["red", "blue", red / blue];
      clauses.push(`${one} is ${Number(times.toPrecision(2))} times as bright as ${other}`);
    }
    return clauses;
  };
  await page.locator("#story-text", { hasText: "times as bright as" }).waitFor();
  // The text follows the fine light.
  const clauses = await expected();
  assert.ok(clauses.length > 0, "there is no ring");
  await page.waitForFunction((clauses) => {
    const said = document.getElementById("story-text").textContent.match(/(blue|red) is [^ ]+ times as bright as \w+/g);
    return JSON.stringify(said) === JSON.stringify(clauses);
  }, clauses, { timeout: 20_000 });
}

/** Mean of a channel on snow. */
function mean(all, channel) {
  const snow = all.filter(([, , , alpha]) => alpha === 1);
  assert.ok(snow.length > 0, "there is no snow");
  return snow.reduce((sum, pixel) => sum + pixel[channel], 0) / snow.length;
}

/** The greatest relative change of green at places that have snow before and after. */
function change(before, after) {
  const both = before.map((pixel, place) => [pixel, after[place]]).filter((pair) => pair.every(([, , , a]) => a === 1));
  return Math.max(...both.map(([[, one], [, other]]) => Math.abs(other / one - 1)));
}

/** As a block of 40 cm is beside one of 15 cm. */
function isDarkerAndBluer(thick, thin) {
  const ratio = (all) => mean(all, 2) / mean(all, 0);
  assert.ok(mean(thick, 1) < 0.2 * mean(thin, 1), "it is not darker");
  assert.ok(ratio(thick) > 2 * ratio(thin), `blue to red is ${ratio(thin)} and ${ratio(thick)}`);
}

async function shows(page, index) {
  await page.locator("#story-words", { hasText: `${index + 1} of ${STEPS.length}` }).waitFor();
  assert.equal(await stepButton(page, index).getAttribute("aria-current"), "step");
  const sliders = page.locator("#story input[type=range]");
  assert.equal(await sliders.count(), 1);
  assert.equal(await sliders.getAttribute("aria-label"), `${STEPS[index].label}, slider`);
  assert.equal(await page.locator("#story-drawing").isVisible(), !STEPS[index].isSnow);
  // The view in 3-D loads after the page.
  await page.locator(".sb-field").waitFor({ state: STEPS[index].isSnow ? "visible" : "hidden" });
}

pageTest("the story", { fragment: "" }, async (page, t) => {
  await t.test("it opens on snow that glows blue, with the laboratory hidden", async () => {
    await page.locator("#story-text", { hasText: "times as bright as red" }).waitFor();
    await shows(page, 0);
    assert.equal(await page.locator("#lab").isVisible(), false);
    const all = await light(page);
    const [red, green, blue] = [0, 1, 2].map((channel) => mean(all, channel));
    assert.ok(blue > green && green > red && red > 0, `${[red, green, blue]} is not blue`);
  });

  for (const [index, { label, value, isSnow }] of STEPS.entries()) {
    await t.test(`step ${index + 1} by click: "${label}" changes its figure and its text`, async () => {
      await stepButton(page, index).click();
      await shows(page, index);
      await page.waitForFunction((step) => location.hash === (step === 1 ? "" : `#story=${step}`), index + 1);
      const look = async () => (isSnow ? light(page) : drawing(page));
      await page.locator("#story-text:not(:empty)").waitFor();
      const [before, wordsBefore] = [await look(), await text(page)];
      const set = () => storyControl(page, label).fill(String(value));
      await (isSnow ? relight(page, set) : set());
      await page.waitForFunction((words) => document.getElementById("story-text").textContent !== words, wordsBefore);
      const after = await look();
      if (isSnow) await statesItsPicture(page);
      if (isSnow) {
        assert.ok(change(before, after) > CHANGE, `the light changes by ${change(before, after)}`);
        if (label === "Thickness") isDarkerAndBluer(after, before);
      } else {
        assert.notEqual(after, before);
      }
    });
  }

  await t.test("the paths of light agree with the spectrum", async () => {
    await stepButton(page, 2).click();
    await storyControl(page, "Wavelength").fill("650");
    await page.waitForFunction(() => document.getElementById("precision").textContent.startsWith("Final"));
    const percent = Number(/650 nm, (\d+)/.exec(await text(page))[1]);
    await page.getByRole("button", { name: "Laboratory", exact: true }).click();
    await final(page);
    const rows = rowsOf((await saved(page, "CSV"))["snow.csv"]);
    const at = (nm) => Number(rows.find(({ wavelength_nm }) => Number(wavelength_nm) === nm).transmittance);
    // Blue itself loses a hundredth, and the text is rounded.
    assert.ok(Math.abs(percent - (100 * at(650)) / at(450)) <= 1, `${percent} %, ${at(650)} and ${at(450)}`);
  });
});

pageTest("the story by keyboard, and the way to the laboratory and back", { fragment: "" }, async (page, t) => {
  const tabTo = async (name) => {
    for (let stop = 0; stop < 60; stop++) {
      await page.keyboard.press("Tab");
      if (await page.evaluate((name) => document.activeElement.ariaLabel === name ||
        document.activeElement.textContent === name, name)) return;
    }
    assert.fail(`the Tab key does not reach "${name}"`);
  };
  await page.locator("#story-text:not(:empty)").waitFor();

  for (const [index, { label, isSnow }] of STEPS.entries()) {
    await t.test(`step ${index + 1}: its slider and the next step`, async () => {
      await shows(page, index);
      await tabTo(`${label}, slider`);
      const value = () => storyControl(page, label).inputValue();
      const [before, figure] = [await value(), await drawing(page)];
      await page.keyboard.press("ArrowLeft");
      assert.notEqual(await value(), before);
      if (!isSnow) assert.notEqual(await drawing(page), figure);
      await tabTo(index === STEPS.length - 1 ? "To the laboratory" : "Next");
      await page.keyboard.press("Enter");
    });
  }

  await t.test("after the last step the laboratory has the same snow and view", async () => {
    assert.equal(await page.locator("#story").isVisible(), false);
    assert.equal(await control(page, "Light transport").inputValue(), "pcasnow");
    await page.waitForFunction(() => location.hash.includes("method=pcasnow"));
  });

  await t.test("the button of the browser leads back to the step", async () => {
    await page.goBack();
    await page.waitForFunction(() => location.hash === "#story=8");
    await shows(page, 7);
  });

  await t.test("the button leads back to a step that was open for a moment only", async () => {
    await page.evaluate(() => {
      document.querySelector("nav[aria-label='Steps of the story'] button:nth-child(4)").click();
      document.getElementById("open-laboratory").click();
    });
    await page.goBack();
    await page.waitForFunction(() => location.hash === "#story=4");
    await shows(page, 3);
  });

  await t.test("soot of the story is soot of the laboratory", async () => {
    await stepButton(page, 5).press("Enter");
    await shows(page, 5);
    const soot = await storyControl(page, "Soot").inputValue();
    await page.getByRole("button", { name: "Laboratory", exact: true }).press("Enter");
    assert.ok(Number(soot) > 0);
    await page.waitForFunction((soot) => location.hash.includes(`black-carbon:${soot}`), soot);
    await page.getByRole("button", { name: "Story", exact: true }).press("Enter");
    await shows(page, 0);
  });
});

const KEPT = "layer=thickness_cm:22&pin=layer%3Dthickness_cm:30";

pageTest("steps are in the history, and the story keeps pins and sample", { fragment: KEPT }, async (page, t) => {
  const pins = page.locator("#compare-table tbody tr", { hasText: "30 cm, " });
  await final(page);
  await page.getByRole("button", { name: "Story", exact: true }).click();
  await shows(page, 0);

  await t.test("the button of the browser leads back step by step", async () => {
    // Keys, as a click misses a button that the words of a step move.
    await stepButton(page, 3).press("Enter");
    await shows(page, 3);
    await page.getByRole("button", { name: "Next", exact: true }).press("Enter");
    await shows(page, 4);
    await page.goBack();
    await shows(page, 3);
    await page.goBack();
    await shows(page, 0);
    await page.goForward();
    await shows(page, 3);
  });

  await t.test("the laboratory is as it was", async () => {
    await page.getByRole("button", { name: "Laboratory", exact: true }).click();
    assert.equal(await control(page, "Thickness").inputValue(), "22");
    await pins.waitFor();
  });
});

pageTest("the block of step 5 opens with its shades", { fragment: "story=5" }, async (page) => {
  const all = await light(page);
  const { stops } = await page.evaluate(() => window.__snowblue.figures);
  const white = all.filter((pixel) => pixel[3] === 1 && Math.max(...pixel.slice(0, 3)) * 2 ** stops >= 1);
  assert.equal(white.length, 0, `${white.length} of ${all.length} places are white`);
});

pageTest("links", { fragment: "shape=ball&layer=thickness_cm:22&camera=0,10,1.2" }, async (page, t) => {
  await t.test("a link of a state opens the laboratory", async () => {
    await final(page);
    assert.equal(await page.locator("#story").isVisible(), false);
    assert.equal(await control(page, "Thickness").inputValue(), "22");
    assert.ok(await page.getByRole("radio", { name: "Ball" }).isChecked());
  });

  await t.test("a link of a step opens the step", async () => {
    await follow(page, "story=4");
    await shows(page, 3);
  });

  await t.test("a step that there is not is refused", async () => {
    await follow(page, "story=9");
    await page.getByRole("alert").filter({ hasText: "'story' is not known" }).waitFor();
  });
});

pageTest("the block is as thick as the snow, and lamps behind it look behind", {}, async (page) => {
  const before = await light(page);
  await page.getByText("The block is 15 cm thick.").waitFor();
  await control(page, "Thickness").fill("40");
  await page.getByText("The block is 40 cm thick.").waitFor();
  assert.ok(mean(await light(page), 1) < 0.2 * mean(before, 1), "the picture is the same");
  await control(page, "Thickness").fill("200");
  await page.getByText("The block is 60 cm thick, the most that is drawn.").waitFor();
  const isBehind = () => page.locator(".sb-lamp").evaluate((one) => one.classList.contains("sb-behind"));
  assert.equal(await isBehind(), true);
  await follow(page, "camera=180,14,1.25");
  await lit(page);
  await page.waitForFunction(() => !document.querySelector(".sb-lamp").classList.contains("sb-behind"));
});
