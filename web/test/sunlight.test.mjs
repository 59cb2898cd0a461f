// Infrared light, sunlight, light at depth and a measured curve: the figures are those of the command.

import assert from "node:assert/strict";
import { after } from "node:test";
import { inFolder, inPython, PYTHON, rowsOf } from "./command.mjs";
import {
  browserTest, chooseCurve, code, control, final, follow, pageTest, saved, serve, server, sunlit,
} from "./page.mjs";

const QUANTITIES = ["reflectance", "transmittance", "absorptance"];
/** The command writes nine digits; this leaves three for the sines and powers of other machines. */
const RELATIVE = 1e-6;
/** Deep infrared light is a difference of modes that cancel to some 10⁻¹⁵ of the light. */
const ABSOLUTE = 1e-12;
const LAYERS = "layer=thickness_cm:2,ssa_m2_kg:80&layer=thickness_cm:8,grain_size_um:700&" +
  "ground_albedo=0.3&angle_deg=diffuse";
/** Of the figures in the tables: three digits, or four decimals. */
const THREE_DIGITS = 5.1e-3;
const FOUR_DECIMALS = 5.1e-5;

/** The server `unready` does not have the script of sunlight while this is so. */
let isMissing = true;
const unready = await serve(async (file) => {
  if (isMissing && file === "sunlight.js") throw new Error("it is missing");
});
after(() => unready.close());

/** Runs the lines of the page's own command in a folder. */
function inFolderOf(page, work) {
  return (async () => {
    const lines = (await code(page, "Command line")).split("\n").map((line) => line.split(" ").slice(1));
    const layers = page.getByRole("region", { name: "File layers.toml" });
    const files = await layers.isVisible() ? { "layers.toml": await layers.textContent() } : {};
    return inFolder(files, (run, read) => work(lines, run, read));
  })();
}

/** The cells of a table by row, as text. */
function cells(page, table) {
  return page.locator(`${table} tbody tr`).evaluateAll((rows) =>
    rows.map((row) => [...row.cells].map((cell) => cell.textContent)));
}

/** A number of the page, which may be a power of ten. */
function number(text) {
  const [, mantissa, exponent] = /^(−?[\d.]+)(?: × 10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+))?/.exec(text);
  const power = [...(exponent ?? "⁰")].map((one) => (one === "⁻" ? "-" : "⁰¹²³⁴⁵⁶⁷⁸⁹".indexOf(one))).join("");
  return Number(mantissa.replace("−", "-")) * 10 ** Number(power);
}

async function spectrumAndBandsAgree(page, count) {
  await final(page);
  await sunlit(page);
  const here = rowsOf((await saved(page, "CSV"))["snow.csv"]);
  assert.equal(here.length, count);
  const means = await cells(page, "#bands");
  await inFolderOf(page, async ([, , solar, bands], run, read) => {
    await run(...solar);
    const there = rowsOf(await read("solar.csv"));
    assert.deepEqual(here.map((row) => row.wavelength_nm), there.map((row) => row.wavelength_nm));
    spectraAgree(here, there, "the command");
    if (PYTHON !== undefined) await agreesWithPython(page, here, means);
    await run(...bands);
    const rows = rowsOf(await read("bands.csv"));
    bandsAgree(means, rows, "the command");
    rows.forEach((row, index) => {
      const [, first_nm, last_nm] = /([\d.]+)-([\d.]+)$/.exec(row.band);
      assert.ok(means[index][0].endsWith(`${first_nm}–${last_nm} nm`), `${means[index][0]} is not ${row.band}`);
    });
    const [lead] = /^0\.\d{3}/.exec(await page.locator("#bands .lead").textContent());
    assert.ok(Math.abs(Number(lead) - Number(rows[0].reflectance)) <= 5.1e-4, `${lead}, not ${rows[0].reflectance}`);
  });
}

/** Rows of the quantities at each wavelength of the page and of another program. */
function spectraAgree(here, there, program) {
  assert.equal(here.length, there.length);
  here.forEach((row, index) => {
    for (const quantity of QUANTITIES) {
      const [one, other] = [row, there[index]].map((values) => Number(values[quantity]));
      const what = `${quantity} at ${row.wavelength_nm} nm: ${one}, not ${other} of ${program}`;
      assert.ok(Math.abs(one - other) <= RELATIVE * other + ABSOLUTE, what);
    }
  });
}

/** Cells of the bands of the page, and rows of the quantities of another program. */
function bandsAgree(means, rows, program) {
  assert.equal(means.length, rows.length);
  rows.forEach((row, index) => QUANTITIES.forEach((quantity, column) => {
    const [one, other] = [Number(means[index][column + 1]), Number(row[quantity])];
    const what = `${quantity} of ${means[index][0]}: ${one}, not ${other} of ${program}`;
    assert.ok(Math.abs(one - other) <= FOUR_DECIMALS, what);
  }));
}

/** The lines in Python give the same solar spectrum and bands. */
async function agreesWithPython(page, here, means) {
  const names = QUANTITIES.flatMap((quantity) => [`solar.${quantity}`, `bands.${quantity}`]);
  const values = await inPython(await code(page, "Python"), names);
  const rowsOf = (kind, count) => {
    for (const quantity of QUANTITIES) assert.equal(values[`${kind}.${quantity}`].length, count);
    const row = (_, index) => Object.fromEntries(QUANTITIES.map((one) => [one, values[`${kind}.${one}`][index]]));
    return Array.from({ length: count }, row);
  };
  spectraAgree(here, rowsOf("solar", here.length), "Python");
  bandsAgree(means, rowsOf("bands", means.length), "Python");
}

/** The light at the depth of the cursor. */
async function depthAgrees(page) {
  const depth_cm = Number(/[\d.]+/.exec(await page.locator("#depth-at strong").textContent())[0]);
  const shown = await cells(page, "#depth-chart");
  const lead = await page.locator("#depth-chart .lead strong").textContent();
  await inFolderOf(page, async ([spectrum], run) => {
    const words = spectrum.slice(0, spectrum.indexOf("-o"));
    const at = ["--depths", `0,2,${depth_cm}`, "--wavelengths", "450,550,650,850", "--format", "csv"];
    const rows = rowsOf(await run(...words, ...at));
    const of = (wavelength_nm, depth_cm) => rows.find((row) =>
      Number(row.wavelength_nm) === wavelength_nm && Number(row.depth_cm) === depth_cm);
    assert.equal(shown.length, 4);
    for (const [wavelength, ...values] of shown) {
      const row = of(Number(wavelength.split(" ")[0]), depth_cm);
      ["down", "up", "fluence", "e_folding_depth_cm"].forEach((name, column) => {
        const [one, other] = [number(values[column]), Number(row[name])];
        assert.ok(Math.abs(one / other - 1) <= THREE_DIGITS, `${name} at ${wavelength}: ${one}, not ${other}`);
      });
    }
    const tops = lead.split(", ").map((depth) => number(depth));
    [0, 2].forEach((top_cm, layer) => {
      const { e_folding_depth_cm: expected } = of(450, top_cm);
      assert.ok(Math.abs(tops[layer] / Number(expected) - 1) <= THREE_DIGITS, `${tops[layer]}, not ${expected}`);
    });
  });
}

pageTest("sunlight and depth are those of the command line", { fragment: `${LAYERS}&range=solar` }, async (page, t) => {
  await t.test("layers on a ground under diffuse light", () => spectrumAndBandsAgree(page, 221));

  await t.test("light at depth, read by keyboard", async () => {
    const reading = page.getByRole("slider", { name: "Reading of the light at a depth" });
    await reading.focus();
    for (const key of ["End", "PageUp", "ArrowUp", "ArrowRight", "ArrowDown"]) await page.keyboard.press(key);
    assert.match(await reading.getAttribute("aria-valuetext"), /^[\d.]+ centimetres, 450 nanometres 0\.\d+, /);
    await depthAgrees(page);
    await page.keyboard.press("Home");
    assert.equal(await page.locator("#depth-at strong").textContent(), "0 cm");
  });

  await t.test("the spectrum is read in the infrared", async () => {
    const reading = page.getByRole("slider", { name: "Reading of the spectrum at a wavelength" });
    await reading.focus();
    await page.keyboard.press("End");
    assert.match(await reading.getAttribute("aria-valuetext"), /^2500 nanometres, reflectance 0\.0\d+, /);
    await page.keyboard.press("PageDown");
    assert.equal(await reading.getAttribute("aria-valuenow"), "2450");
  });

  await t.test("choices are in the link", async () => {
    await page.getByRole("radio", { name: "Fluence rate" }).check({ force: true });
    await page.waitForFunction(() => /range=solar&at_depth=fluence/.test(location.hash));
    await page.getByRole("radio", { name: "Visible", exact: true }).check({ force: true });
    await page.waitForFunction(() => !location.hash.includes("range"));
    assert.equal(rowsOf((await saved(page, "CSV"))["snow.csv"]).length, 31);
    await follow(page, "range=infrared");
    assert.match(await page.locator("#notice").textContent(), /'infrared' is not known for range/);
  });

  await t.test("a file has the present sample, although no chart is in view", async () => {
    await follow(page, "range=solar");
    await sunlit(page);
    await page.locator("#stage").scrollIntoViewIfNeeded();
    await page.waitForFunction(() => document.getElementById("chart").getBoundingClientRect().top > innerHeight + 200);
    await control(page, "Thickness").evaluate((field) => {
      field.value = "3";
      for (const type of ["input", "change"]) field.dispatchEvent(new Event(type, { bubbles: true }));
    });
    const files = await saved(page, "CSV", 1, (button) => button.dispatchEvent("click"));
    const rows = String(files["snow.csv"]).split("\n");
    assert.match(rows[1], /^0,"3 cm, 400 µm, 300 kg\/m³",300,/);
    assert.equal(rows.length, 223);
  });

  await t.test("dirty snow", async () => {
    await follow(page, "layer=thickness_cm:5,black-carbon:100&range=solar");
    await spectrumAndBandsAgree(page, 221);
  });
});

/** A curve as the page saves it, higher by a constant. */
function higher(csv, by) {
  const rows = rowsOf(csv).map(({ wavelength_nm, reflectance }) => `${wavelength_nm},${Number(reflectance) + by}\n`);
  return `wavelength_nm,albedo\n${rows.join("")}`;
}

pageTest("a measured curve", {}, async (page, t) => {
  await final(page);
  await page.locator("#chart").scrollIntoViewIfNeeded();
  const input = page.locator("#measured input[type=file]");
  await input.waitFor({ state: "attached" });
  const note = page.locator("#measured .note");
  const error = page.locator("#measured .error");
  const compared = () =>
    page.waitForFunction(() => /nm\.$/.test(document.querySelector("#measured .note").textContent));
  const curve = higher((await saved(page, "CSV"))["snow.csv"], 0.01);

  await t.test("is drawn with its difference", async () => {
    await chooseCurve(page, "field.csv", curve);
    await compared();
    assert.equal(await note.textContent(), "field.csv, reflectance: root-mean-square difference from the current " +
      "sample 0.0100, mean of measured − computed 0.0100, over 31 wavelengths of 400–700 nm.");
    assert.equal(await page.locator("#chart .chart circle[r='2.5']").count(), 31);
  });

  await t.test("is named in the file of the chart", async () => {
    const file = String((await saved(page, "SVG"))["snow.svg"]);
    assert.match(file, />field\.csv; measured reflectance<\/text>/);
    // 31 in the chart and three in the legend.
    assert.equal(file.match(/<circle /g).length, 34);
  });

  await t.test("is compared with another sample", async () => {
    await control(page, "Thickness").fill("2");
    await page.waitForFunction(() => /difference from the current sample 0\.[1-9]/.test(
      document.querySelector("#measured .note").textContent));
  });

  for (const [name, content, why] of [
    ["words.csv", "wavelength_nm,albedo\n400,bright\n", undefined],
    ["ascends.csv", "500,0.9\n500,0.9\n", undefined],
    ["empty.csv", "# nothing\n", undefined],
    ["percent.csv", "400,97\n", "percent.csv:1: albedo is 97, but must lie in -0.5–1.5"],
    ["below.csv", "400,0.9\n410,-0.6\n", "below.csv:2: albedo is -0.6, but must lie in -0.5–1.5"],
    ["long.csv", "4".repeat(1_100_000), "long.csv: has 1100000 bytes, but may have 1048576"],
  ]) {
    await t.test(`${name} is refused in one line${why === undefined ? ", that of the command" : ""}`, async () => {
      await chooseCurve(page, name, content);
      await error.filter({ hasText: name }).waitFor();
      const expected = why ?? await inFolder({ [name]: content }, async (run) => {
        const { stderr } = await run("color", "--reflected", "--spectrum", name).then(() => assert.fail(), (it) => it);
        return stderr.trim().replace(/^snowblue: /, "");
      });
      assert.equal((await error.textContent()).replace(/\.$/, ""), expected);
      assert.equal(await page.locator("#chart .chart circle[r='2.5']").count(), 0);
    });
  }

  await t.test("is read as an instrument writes it", async () => {
    const lines = ["Ger\xe4t;Spektrometer", "Wavelength (\xb5m);Reflectance (%)", "0,6;60,5", "0,55;NaN", "0,5;90"];
    await chooseCurve(page, "field.txt", Buffer.from(`${lines.join("\r\n")}\r\n`, "latin1"));
    await note.filter({ hasText: "over 2 wavelengths of 500–600 nm." }).waitFor();
    assert.match(await note.textContent(), new RegExp("^field\\.txt, .+ nm\\. Lines above the names of its columns, " +
      "which are not read: 1\\. Its wavelengths are in µm\\. Its values are in percent\\. Rows without a value, " +
      "which are left out: 1\\.$"));
    assert.equal(await page.locator("#chart .chart circle[r='2.5']").count(), 2);
  });

  await t.test("is dropped on the chart, and shows the infrared that it has", async () => {
    await page.locator("#chart").evaluate((chart) => {
      const transfer = new DataTransfer();
      transfer.items.add(new File(["500,0.9\n1000,0.8\n2600,0.1\n"], "dropped.csv"));
      for (const type of ["dragover", "drop"]) {
        chart.dispatchEvent(new DragEvent(type, { bubbles: true, cancelable: true, dataTransfer: transfer }));
      }
    });
    await compared();
    assert.match(await note.textContent(), /^dropped\.csv, .+ over 2 wavelengths of 500–1000 nm\.$/);
    await page.waitForFunction(() => location.hash.includes("range=solar"));
    assert.equal(await error.isVisible(), false);
  });

  await t.test("noise below 0 is read", async () => {
    await chooseCurve(page, "noise.csv", "500,0.9\n2400,-0.01\n");
    await note.filter({ hasText: /^noise\.csv, .+ over 2 wavelengths of 500–2400 nm\.$/ }).waitFor();
  });

  await t.test("is removed", async () => {
    await page.locator("#measured").getByRole("button", { name: "Remove" }).click();
    assert.match(await note.textContent(), /^A text file of wavelengths and values/);
    assert.equal(await page.evaluate(() => document.activeElement.textContent), "Measured curve…");
  });
});

/** Makes the workers of spectra answer every request with an error while `window.isBroken` is set. */
function breakable() {
  const Intact = window.Worker;
  window.Worker = class extends Intact {
    postMessage(data, ...more) {
      if (window.isBroken && data.name !== undefined) setTimeout(() => this.onmessage({ data: { error: "it broke" } }));
      else super.postMessage(data, ...more);
    }
  };
}

browserTest("nothing says that a computation goes on after it failed", async (page) => {
  await page.addInitScript(breakable);
  await page.goto(`${server.url}#laboratory`);
  await final(page);
  await sunlit(page);
  await page.evaluate(() => (window.isBroken = true));
  await control(page, "Thickness").fill("4");
  for (const part of ["#chart", "#bands", "#depth-chart"]) {
    await page.locator(part).scrollIntoViewIfNeeded();
    const note = page.locator(part === "#chart" ? "#precision" : `${part} .precision`);
    await note.filter({ hasText: "The figures are those of the sample before." }).waitFor();
  }
  await page.evaluate(() => (window.isBroken = false));
  await control(page, "Thickness").fill("5");
  await final(page);
  await sunlit(page);
});

browserTest("a pinned sample that cannot be computed says so, and is computed later", async (page) => {
  await page.addInitScript(breakable);
  await page.goto(`${server.url}#laboratory`);
  await final(page);
  await page.evaluate(() => (window.isBroken = true));
  await control(page, "Thickness").fill("4");
  await page.getByRole("button", { name: "Pin this sample" }).click();
  const row = page.locator("#compare-table tbody tr", { hasText: "Pin 1" });
  await row.filter({ hasText: "No spectrum: it broke" }).waitFor();
  const error = page.locator("#compare-error");
  const why = "The pinned sample 4 cm, 400 µm, 300 kg/m³ has no spectrum: it broke.";
  assert.equal(await error.textContent(), why);
  await page.getByRole("button", { name: "CSV", exact: true }).click();
  await page.locator("#share-status", { hasText: "CSV failed: it broke" }).waitFor();
  await page.evaluate(() => (window.isBroken = false));
  // The present sample and the pinned one, at 31 wavelengths each.
  assert.equal(rowsOf((await saved(page, "CSV"))["snow.csv"]).length, 62);
  await row.filter({ hasText: /#[0-9a-f]{6}/ }).waitFor();
  assert.equal(await error.isVisible(), false);
});

browserTest("sunlight that could not be loaded is loaded later", async (page) => {
  await page.goto(`${unready.url}#range=solar`);
  await final(page);
  await page.locator("#sunlight").scrollIntoViewIfNeeded();
  const error = page.locator("#sunlight-error", { hasText: "Sunlight cannot be computed" });
  await error.waitFor();
  await page.getByRole("button", { name: "CSV", exact: true }).click();
  await page.locator("#share-status", { hasText: "CSV failed: sunlight cannot be computed" }).waitFor();
  isMissing = false;
  await page.getByRole("button", { name: "Story", exact: true }).click();
  await page.getByRole("button", { name: "Laboratory", exact: true }).click();
  await page.locator("#sunlight").scrollIntoViewIfNeeded();
  await error.waitFor({ state: "hidden" });
  await sunlit(page);
  // The laboratory has the range that it had before the story.
  assert.equal(rowsOf((await saved(page, "CSV"))["snow.csv"]).length, 221);
}, { expected: /404|sunlight\.js/ });

pageTest("results are announced in one place, when they no longer change", {}, async (page) => {
  await final(page);
  await sunlit(page);
  await page.locator("#summary", { hasText: "Light at depth" }).waitFor({ state: "attached" });
  await page.evaluate(() => {
    window.said = [];
    new MutationObserver(() => window.said.push(document.getElementById("summary").textContent))
      .observe(document.getElementById("summary"), { childList: true, characterData: true, subtree: true });
  });
  for (const thickness of [6, 7, 8]) await control(page, "Thickness").fill(String(thickness));
  await final(page);
  await page.locator("#summary", { hasText: "8 cm, " }).waitFor({ state: "attached" });
  const said = await page.evaluate(() => window.said);
  assert.ok(said.length <= 2 && !/\b[67] cm, /.test(said.join("\n")), said.join("\n"));
  assert.equal(await page.locator("#results [role=status]:not([hidden])").count(), 0);
});
