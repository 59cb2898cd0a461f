// The figures of the page are those of its own command line.

import assert from "node:assert/strict";
import { code, control, final, follow, pageTest, saved } from "./page.mjs";
import { inFolder, inPython, PYTHON, rowsOf } from "./command.mjs";

const QUANTITIES = ["reflectance", "transmittance", "absorptance"];
/** Both engines trace the same rays; only the last digits of sine and power differ, far below the standard error. */
const OF_ERROR = 1e-3;
/** The command writes nine digits; this leaves three for the sines and powers of other machines. */
const RELATIVE = 1e-6;

async function agrees(page) {
  await final(page);
  const page_rows = rowsOf((await saved(page, "CSV"))["snow.csv"]);
  const lines = (await code(page, "Command line")).split("\n");
  const layers = page.getByRole("region", { name: "File layers.toml" });
  const files = await layers.isVisible() ? { "layers.toml": await layers.textContent() } : {};
  await inFolder(files, async (run, read) => {
    const [spectrum, color] = lines.map((line) => line.split(" ").slice(1));
    await run(...spectrum);
    compare(page_rows, rowsOf(await read("spectrum.csv")));
    const [{ hex }] = rowsOf(await run(...color));
    assert.equal(await page.locator("#swatches .hex").first().textContent(), hex);
  });
  if (PYTHON !== undefined) await agreesWithPython(page, page_rows);
}

/** The lines in Python give the same figures. */
async function agreesWithPython(page, page_rows) {
  const names = [...QUANTITIES.map((quantity) => `snow.${quantity}`), "snow.wavelength", "color.hex"];
  const values = await inPython(await code(page, "Python"), names);
  compare(page_rows, page_rows.map((_, index) => ({
    wavelength_nm: String(values["snow.wavelength"][index]),
    ...Object.fromEntries(QUANTITIES.map((quantity) => [quantity, values[`snow.${quantity}`][index]])),
  })));
  assert.deepEqual(values["color.hex"], [await page.locator("#swatches .hex").first().textContent()]);
}

function compare(page_rows, command_rows) {
  assert.equal(page_rows.length, 31);
  assert.equal(command_rows.length, 31);
  page_rows.forEach((row, index) => {
    assert.equal(row.wavelength_nm, command_rows[index].wavelength_nm);
    for (const quantity of QUANTITIES) {
      const [here, there] = [row, command_rows[index]].map((one) => Number(one[quantity]));
      const error = Number(row[`${quantity}_se`]);
      assert.ok(error > 0, `${quantity} at ${row.wavelength_nm} nm has no standard error`);
      const most = Math.max(OF_ERROR * error, RELATIVE * there);
      assert.ok(Math.abs(here - there) <= most, `${quantity} at ${row.wavelength_nm} nm: ${here}, not ${there}`);
    }
  });
}

const LAYERS = "layer=thickness_cm:2,ssa_m2_kg:80&" +
  "layer=thickness_cm:8,grain_size_um:700,size_measure:volume-diameter&ground_albedo=0.3&angle_deg=diffuse";
const OTHER_EYE = "layer=thickness_cm:25,sphericity:0.85,temperature_c:-20&ice=picard2016&angle_deg=40&" +
  "illuminant=FL2&observer=1964&exposure=4.5";

pageTest("the figures are those of the command line", { fragment: LAYERS }, async (page, t) => {
  await t.test("layers on a ground under diffuse light", () => agrees(page));

  await t.test("another illuminant, the observer of 1964 and a fixed exposure", async () => {
    await follow(page, OTHER_EYE);
    await agrees(page);
  });

  await t.test("the default sample", async () => {
    await follow(page, "laboratory");
    await agrees(page);
    assert.match(await code(page, "Command line"), /--thickness 15 --angle 0 .*\n.*--illuminant D65 --observer 1931/);
  });

  await t.test("impurities and wet snow, set by the controls", async () => {
    await control(page, "Thickness").fill("6");
    await control(page, "Water saturation").fill("0.1");
    await page.locator("summary", { hasText: "Impurities" }).click();
    await control(page, "Black carbon").fill("20");
    await control(page, "Saharan dust").fill("3000");
    await agrees(page);
    assert.match(await code(page, "Command line"), /-saturation 0.1 --impurity black-carbon=20,saharan-dust=3000/);
  });
});
