// The light of one place of the snow: its spectrum has the colour of the picture there, and visitors of all kinds of
// input see and hear it.

import assert from "node:assert/strict";
import { control, follow, IS_FIREFOX, lit, pageTest, pixels, viewSize } from "./page.mjs";

/** Both have the light of the same vertices, in single precision. */
const ROUNDING = 1e-5;
/**
 * Of light that is reflected after few scatterings. The picture reads a table that is right within 4 % between its
 * values (`a_table_is_read_between_its_values` in snowblue-transport).
 */
const REFLECTION = 0.04;
/** Views, and what the table may add to their light: nothing where all of it comes through the snow. */
const VIEWS = [
  ["shape=block", 0],
  ["shape=drift", 0],
  ["shape=block&lamp=0.4,-0.6,0.5,D65,10&lamp=0,0.3,0.2,A,5&camera=0,5,1.25", REFLECTION],
  ["shape=igloo&lamp=0.1,-0.6,0.5,D65,10", REFLECTION],
  ["shape=igloo&sky=overcast,18", REFLECTION],
  ["shape=sculpture&sky=clear,35,200,2.5", REFLECTION],
];
/** Of the width and of the height of the view. */
const COLUMNS = [0.3, 0.4, 0.45, 0.5, 0.55, 0.6, 0.7];
const ROWS = [0.25, 0.35, 0.45, 0.55, 0.65];
/** A pixel and those to its left, its right, above and below. */
const CROSS = [[0, 0], [-1, 0], [1, 0], [0, -1], [0, 1]];

function probe(page, place) {
  return page.evaluate((place) => window.__snowblue.probe(place), place);
}

/** By how much the graphics card may move a vertex: half a step of its grid, in pixels. */
function shift(page) {
  return page.evaluate(() => {
    const gl = document.createElement("canvas").getContext("webgl2");
    return 0.5 * 2 ** -gl.getParameter(gl.SUBPIXEL_BITS);
  });
}

/** Greatest difference of a channel. */
function apart(one, other) {
  return Math.max(...[0, 1, 2].map((channel) => Math.abs(one[channel] - other[channel])));
}

pageTest("the colour of a probed spectrum is that of the picture", {}, async (page, t) => {
  const moved = await shift(page);
  for (const [fragment, reflection] of VIEWS) {
    await t.test(fragment, async () => {
      await follow(page, fragment);
      await lit(page);
      const [width, height] = await viewSize(page);
      const places = COLUMNS.flatMap((x) => ROWS.map((y) => [Math.floor(x * width), Math.floor(y * height)]));
      const shown = await pixels(page, places.flatMap(([x, y]) =>
        CROSS.map(([across, down]) => [x + across, y + down])));
      let count = 0;
      for (const [number, [x, y]] of places.entries()) {
        const around = shown.slice(CROSS.length * number, CROSS.length * (number + 1));
        if (!around.every(([, , , alpha]) => alpha === 1)) continue;
        const [here, left, right, above, below] = around;
        const middle = { x: (x + 0.5) / width, y: (y + 0.5) / height };
        const { linear_rgb, radiance, wavelengths_nm } = await probe(page, middle);
        // How the picture changes with the place, across and down.
        const across = Math.max(apart(here, left), apart(here, right));
        const slope = across + Math.max(apart(here, above), apart(here, below));
        const tolerance = moved * slope + (ROUNDING + reflection) * Math.max(...here.slice(0, 3));
        const difference = apart(linear_rgb, here);
        assert.ok(difference <= tolerance, `${[x, y]}: ${linear_rgb}, but the picture has ${here}; ${tolerance}`);
        assert.deepEqual([radiance.length, wavelengths_nm[0], wavelengths_nm[30]], [31, 400, 700]);
        count += 1;
      }
      assert.ok(count > 12, `${count} places`);
    });
  }
});

/** What the card says of a spectrum. */
function sentence({ wavelengths_nm, radiance }) {
  const [blue, red] = [450, 650].map((nm) => radiance[wavelengths_nm.indexOf(nm)]);
  const [one, other, ratio] = blue > red ? ["blue", "red", blue / red] : ["red", "blue", red / blue];
  return `Here ${one} is ${Number(ratio.toPrecision(2))} times as bright as ${other}.`;
}

/** A place of the window in the view, 0 to 1 from its left and from above. */
async function inWindow(page, { x, y }) {
  const box = await page.locator(".sb-field").boundingBox();
  return [box.x + x * box.width, box.y + y * box.height];
}

/** Playwright has no pens, but the protocol of Chromium does. */
const pens = !IS_FIREFOX;
const MIDDLE = { x: 0.5, y: 0.5 };
const ON_BLOCK = { x: 0.48, y: 0.6 };
const BESIDE = { x: 0.9, y: 0.1 };

pageTest("the light of a place is seen and heard", { fragment: "shape=block", hasTouch: true }, async (page, t) => {
  await lit(page);
  await page.locator(".sb-field").scrollIntoViewIfNeeded();
  const card = page.locator(".sb-probe");
  const heard = page.locator(".sb-layer [role=status]");
  const shows = async (place) => {
    const found = await probe(page, place);
    await card.filter({ hasText: sentence(found) }).waitFor();
    const color = await card.locator(".sb-probe-color").evaluate((one) => getComputedStyle(one).backgroundColor);
    assert.equal(color, `rgb(${found.srgb.join(", ")})`);
  };

  await t.test("where the pointer is", async () => {
    await page.mouse.move(...await inWindow(page, ON_BLOCK));
    await shows(ON_BLOCK);
    assert.equal(await heard.textContent(), "");
    await page.mouse.move(...await inWindow(page, BESIDE));
    await card.waitFor({ state: "hidden" });
  });

  await t.test("of the middle by a key, until Escape", async () => {
    await page.locator(".sb-field").press("p");
    await shows(MIDDLE);
    assert.equal(await heard.textContent(), sentence(await probe(page, MIDDLE)));
    await page.locator(".sb-field").press("Escape");
    await card.waitFor({ state: "hidden" });
  });

  await t.test("where a finger taps, also after the light has changed", async () => {
    await page.touchscreen.tap(...await inWindow(page, ON_BLOCK));
    await shows(ON_BLOCK);
    const before = await card.textContent();
    await control(page, "Lamp 1 light").selectOption("A");
    await lit(page);
    await shows(ON_BLOCK);
    assert.notEqual(await card.textContent(), before);
    assert.equal(await heard.textContent(), sentence(await probe(page, ON_BLOCK)));
    await page.touchscreen.tap(...await inWindow(page, BESIDE));
    await card.waitFor({ state: "hidden" });
    assert.equal(await heard.textContent(), "There is no lit snow here.");
  });

  await t.test("where a pen taps that does not hover", { skip: !pens && "pens cannot be driven here" }, async () => {
    const pen = await page.context().newCDPSession(page);
    const [x, y] = await inWindow(page, ON_BLOCK);
    const send = (type, buttons) => pen.send("Input.dispatchMouseEvent",
      { type, x, y, buttons, button: "left", clickCount: 1, pointerType: "pen" });
    await page.locator(".sb-field").evaluate((field) => {
      window.pens = [];
      for (const type of ["pointerdown", "pointerup"]) {
        field.addEventListener(type, ({ pointerType }) => window.pens.push(pointerType));
      }
    });
    await send("mousePressed", 1);
    await send("mouseReleased", 0);
    // A pen that does not hover leaves when it is lifted.
    await page.locator(".sb-field").evaluate((field) =>
      field.dispatchEvent(new PointerEvent("pointerleave", { pointerType: "pen" })));
    assert.deepEqual(await page.evaluate(() => window.pens), ["pen", "pen"]);
    await shows(ON_BLOCK);
    await page.locator(".sb-probed").waitFor();
    assert.equal(await heard.textContent(), sentence(await probe(page, ON_BLOCK)));
    await page.locator(".sb-field").press("Escape");
  });

  await t.test("by one question at a time", async () => {
    await page.evaluate(() => {
      window.questions = { open: 0, most: 0, all: 0 };
      const post = Worker.prototype.postMessage;
      Worker.prototype.postMessage = function (message, ...rest) {
        if ("probe" in message) {
          window.questions.all += 1;
          window.questions.most = Math.max(window.questions.most, (window.questions.open += 1));
          this.addEventListener("message", function answered({ data }) {
            if (data.probe !== message.probe) return;
            window.questions.open -= 1;
            this.removeEventListener("message", answered);
          });
        }
        return post.call(this, message, ...rest);
      };
    });
    for (let step = 0; step < 30; step++) {
      await page.mouse.move(...await inWindow(page, { x: 0.42 + 0.004 * step, y: 0.55 }));
    }
    await page.waitForFunction(() => window.questions.open === 0);
    const { most, all } = await page.evaluate(() => window.questions);
    assert.ok(most === 1 && all > 1, `${most} of ${all} questions at once`);
    await shows({ x: 0.42 + 0.004 * 29, y: 0.55 });
  });
});

const PHONE = { width: 390, height: 800 };

pageTest("the card covers no snow on a phone", { fragment: "", viewport: PHONE }, async (page, t) => {
  for (const fragment of ["", ...["block", "ball", "igloo", "sculpture", "drift"].map((shape) => `shape=${shape}`)]) {
    await t.test(fragment || "the story", async () => {
      if (fragment !== "") await follow(page, fragment);
      await lit(page);
      await page.locator(".sb-field").press("p");
      const card = page.locator(".sb-probe");
      await card.waitFor();
      const [field, over] = [await page.locator(".sb-field").boundingBox(), await card.boundingBox()];
      const [width, height] = await viewSize(page);
      const column = (x) => Math.min(width - 1, Math.max(0, ((x - field.x) * width) / field.width));
      const row = (y) => Math.min(height - 1, Math.max(0, ((y - field.y) * height) / field.height));
      const steps = Array.from({ length: 41 }, (_, step) => step / 40);
      const places = steps.flatMap((x) => steps.map((y) =>
        [column(over.x + x * over.width), row(over.y + y * over.height)]));
      const covered = (await pixels(page, places)).filter(([, , , alpha]) => alpha === 1);
      assert.equal(covered.length, 0, `${covered.length} of ${places.length} places under the card are snow`);
    });
  }
});
