// The snow in 3-D: its colour, its agreement with `snowblue render`, and its lamps.

import assert from "node:assert/strict";
import { cameraOf } from "./camera.mjs";
import { inFolder } from "./command.mjs";
import { readExr } from "./exr.mjs";
import { control, follow, lit, pageTest, pixel, pixels, saved, viewSize } from "./page.mjs";
import { coarsePicture, mean } from "./pictures.mjs";

/** A block of 28 cm, whose faces have room away from edges. */
const BLOCK = "shape=block&layer=thickness_cm:28";
/** On the front and on the right side of the block, away from edges, in m. */
const ON_BLOCK = [
  ...[-0.12, 0, 0.12].flatMap((x) => [0.1, 0.2, 0.3].map((z) => [x, -0.14, z])),
  ...[0.1, 0.2, 0.3].map((z) => [0.2, 0.02, z]),
];
/** On the side of the ball that faces the camera. */
const ON_BALL = [-40, -25, -10, 10, 25, 40].flatMap((azimuth) => [-30, -20, -10, 0, 10, 20, 30].map((elevation) => {
  const [across, up] = [azimuth, elevation].map((angle) => (angle * Math.PI) / 180);
  return [
    0.19 * Math.sin(across) * Math.cos(up), -0.19 * Math.cos(across) * Math.cos(up), 0.19 + 0.19 * Math.sin(up),
  ];
}));
/**
 * Of the brightest channel. Both engines solve the same equations on the same cells; the page interpolates between
 * vertices and reads its table of reflections in half floats.
 */
const RELATIVE = 1e-2;
/**
 * Of one place on a curved surface. It crosses the cells in steps, at which each engine reads the light a few percent
 * too bright or too dark, at places of its own; so RELATIVE holds for the mean of many places.
 */
const RELATIVE_AT_STEPS = 0.05;
const DARK_SIDE = [0, -0.14, 0.2];
/** Of 255: light that differs by RELATIVE differs by one level at most, and both are rounded. */
const LEVELS = 2;
/** The level of a luminance of 0.8, at which the tone curve leaves the straight line. */
const ABOVE_KNEE = 231;

/**
 * Of one place under a sky. The light field samples the sky 16 times at each element of the surface, so that J varies
 * from cell to cell by up to 2 % of the light, and the page interpolates it between vertices. RELATIVE holds for the
 * mean.
 */
const RELATIVE_UNDER_SKY = 0.03;
/** Skies as links have them, and what they are. */
const SKIES = [
  ["overcast,30", "an overcast sky"],
  ["clear,18,10,2.5", "a clear sky with the sun behind it"],
  ["clear,35,200,2.5", "a clear sky with the sun in front of it"],
];
/** Samples of a pixel of the command: the light of a sky at single places then has noise of some 0.6 %. */
const SAMPLES_AT_PLACES = 1024;

async function seen(page, place) {
  const camera = cameraOf(String((await saved(page, "Scene TOML"))["scene.toml"]));
  return camera(place, await viewSize(page));
}

function isBlue([red, green, blue]) {
  assert.ok(blue > green && green > red && red > 0, `${[red, green, blue]} is not the blue of thick snow`);
}

/** Light at some places, of the page and of the command. */
async function both(page, places) {
  const toml = String((await saved(page, "Scene TOML"))["scene.toml"]);
  const [size, camera] = [await viewSize(page), cameraOf(toml)];
  const at = places.map((place) => camera(place, size).map(Math.floor));
  const film = ["--width", String(size[0]), "--height", String(size[1]), "--spp", "4"];
  const picture = await inFolder({ "scene.toml": toml }, async (run, read) => {
    await run("render", "scene.toml", "--integrator", "diffusion", ...film, "-o", "scene.exr");
    return readExr(await read("scene.exr"));
  });
  const shown = await pixels(page, at);
  return at.map(([x, y], place) => ({
    here: shown[place].slice(0, 3), there: ["R", "G", "B"].map((channel) => picture(x, y, channel)),
  }));
}

/** As `both`, where the command has larger pixels with many samples. */
async function bothUnderSky(page, places) {
  const { picture, size, coarse, camera } = await coarsePicture(page, SAMPLES_AT_PLACES);
  const shown = await pixels(page, places.map((place) => camera(place, size)));
  return places.map((place, number) => {
    const [x, y] = camera(place, coarse).map(Math.floor);
    return { here: shown[number].slice(0, 3), there: picture(x, y) };
  });
}

/** Colours of both at some places, as PNG files have them. */
async function bothColors(page, places) {
  const toml = String((await saved(page, "Scene TOML"))["scene.toml"]);
  const [size, camera] = [await viewSize(page), cameraOf(toml)];
  const at = places.map((place) => camera(place, size).map(Math.floor));
  const film = ["--width", String(size[0]), "--height", String(size[1]), "--spp", "4"];
  const picture = await inFolder({ "scene.toml": toml }, async (run, read) => {
    await run("render", "scene.toml", "--integrator", "diffusion", ...film, "-o", "scene.png");
    return read("scene.png");
  });
  const [here, there] = [(await saved(page, "3-D PNG"))["snow-view.png"], picture];
  const [shown, expected] = [await colors(page, here, at), await colors(page, there, at)];
  return shown.map((color, place) => ({ here: color, there: expected[place] }));
}

/** Red, green and blue of a PNG at some places. */
function colors(page, png, places) {
  return page.evaluate(async ([bytes, places]) => {
    const bitmap = await createImageBitmap(new Blob([Uint8Array.from(bytes)]));
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
    context.drawImage(bitmap, 0, 0);
    return places.map(([x, y]) => [...context.getImageData(x, y, 1, 1).data.subarray(0, 3)]);
  }, [[...png], places]);
}

function assertNear({ here, there }, relative) {
  const brightest = Math.max(...there);
  assert.ok(brightest > 0, "the command has no light there");
  const apart = Math.max(...here.map((value, channel) => Math.abs(value - there[channel])));
  assert.ok(apart <= relative * brightest, `the light is ${here}, but the command has ${there}`);
}

pageTest("snow in 3-D", { fragment: BLOCK }, async (page, t) => {
  await lit(page);
  const place = await seen(page, DARK_SIDE);

  await t.test("the dark side of the block is blue, and the sky is not", async () => {
    isBlue(await pixel(page, place));
    assert.deepEqual(await pixel(page, [2, 2]), [0, 0, 0, 0]);
  });

  await t.test("the block has the light of snowblue render", async () => {
    for (const lights of await both(page, ON_BLOCK)) assertNear(lights, RELATIVE);
  });

  await t.test("the block has the colours of snowblue render", async () => {
    const found = await bothColors(page, ON_BLOCK);
    for (const { here, there } of found) {
      const apart = Math.max(...here.map((value, channel) => Math.abs(value - there[channel])));
      assert.ok(apart <= LEVELS, `the colour is ${here}, but the command has ${there}`);
    }
    assert.ok(found.some(({ there }) => there.every((value) => value < 255)), "all places are white");
  });

  await t.test("a lamp twice as strong gives twice the light without a new solution", async () => {
    const figures = () => page.evaluate(() => window.__snowblue.figures);
    const [before, { latency_ms }] = [await pixel(page, place), await figures()];
    await control(page, "Lamp 1 strength").fill("20");
    const after = await pixel(page, place);
    // Single precision has seven digits.
    for (const channel of [0, 1, 2]) assert.ok(Math.abs(after[channel] / before[channel] - 2) < 1e-5);
    await lit(page);
    assert.deepEqual(await pixel(page, place), after);
    assert.equal((await figures()).latency_ms, latency_ms, "the light was solved for again");
  });

  await t.test("a lamp is dragged, and the dark side stays blue", async () => {
    const before = await pixel(page, place);
    const lamp = page.locator(".sb-lamp");
    await lamp.scrollIntoViewIfNeeded();
    const { x, y, width, height } = await lamp.boundingBox();
    const [across, down] = [x + width / 2, y + height / 2];
    await page.mouse.move(across, down);
    await page.mouse.down();
    await page.mouse.move(across - 40, down - 30, { steps: 4 });
    await page.mouse.up();
    assert.notEqual(await lamp.getAttribute("aria-label"), "Lamp 1 at x -5 cm, y 30 cm, z 24 cm");
    await lit(page);
    const after = await pixel(page, place);
    isBlue(after);
    // The lamp moves by centimetres, many times more than what would change the light by the error of the field.
    assert.ok(Math.abs(after[2] / before[2] - 1) > 0.05, `the light is the same: ${before} and ${after}`);
  });

  // At the exposure of the light field the method of the paper clips to white.
  await page.locator("#toolbar").getByLabel("Fixed").check();
  await control(page, "Stops").fill("-4");

  for (const [method, name] of [["pcasnow", "PCASnow"], ["hybrid", "Random walks"]]) {
    await t.test(`the method ${method} shows a picture beside it`, async () => {
      await control(page, "Light transport").selectOption(method);
      await page.getByText(new RegExp(`^${name}, \\d+ samples? for each pixel$`)).waitFor();
      const [red, , blue] = await tracedPixel(page, place);
      assert.ok(blue > red, `red ${red}, blue ${blue}`);
    });
  }

  await t.test("the line between both moves by keyboard", async () => {
    const line = page.getByRole("slider", { name: "Share of the light field in the picture, in percent" });
    await line.press("ArrowLeft");
    assert.equal(await line.getAttribute("aria-valuenow"), "45");
  });

  await t.test("a face that a lamp shines on has the light of snowblue render", async () => {
    await follow(page, `${BLOCK}&lamp=0.4,-0.6,0.5,D65,10&camera=0,5,1.25`);
    await lit(page);
    for (const lights of await both(page, ON_BLOCK.filter(([, y]) => y === DARK_SIDE[1]))) assertNear(lights, RELATIVE);
  });

  await t.test("light above white rolls off as in the PNG of snowblue render", async () => {
    await follow(page, `${BLOCK}&lamp=0.4,-0.6,0.5,D65,10&camera=0,5,1.25&view_exposure=-0.5`);
    await lit(page);
    const found = await bothColors(page, ON_BLOCK.filter(([, y]) => y === DARK_SIDE[1]));
    for (const { here, there } of found) {
      const apart = Math.max(...here.map((value, channel) => Math.abs(value - there[channel])));
      assert.ok(apart <= LEVELS, `the colour is ${here}, but the command has ${there}`);
    }
    assert.ok(found.some(({ there: [, green] }) => green > ABOVE_KNEE), "no place is bright enough");
  });

  for (const [sky, name] of SKIES) {
    await t.test(`the block has the light of snowblue render under ${name}`, async () => {
      await follow(page, `${BLOCK}&sky=${sky}`);
      await lit(page);
      const lights = await bothUnderSky(page, ON_BLOCK);
      for (const light of lights) assertNear(light, RELATIVE_UNDER_SKY);
      assertNear(mean(lights), RELATIVE);
    });
  }

  await t.test("a lamp in front does not make the igloo white all over", async () => {
    await follow(page, "shape=igloo&lamp=0.1,-0.6,0.5,D65,10");
    await lit(page);
    const [width, height] = await viewSize(page);
    const places = [0.4, 0.5, 0.6].flatMap((x) => [0.4, 0.5, 0.6].map((y) => [x * width, y * height].map(Math.floor)));
    const greens = (await colors(page, (await saved(page, "3-D PNG"))["snow-view.png"], places)).map(([, one]) => one);
    assert.ok(Math.max(...greens) < 254 && Math.min(...greens) > 50, `greens of ${greens}`);
    assert.ok(Math.max(...greens) - Math.min(...greens) > 10, `greens of ${greens} have no relief`);
  });

  await t.test("the ball has the light of snowblue render", async () => {
    await follow(page, "shape=ball");
    await lit(page);
    const lights = await both(page, ON_BALL);
    for (const light of lights) assertNear(light, RELATIVE_AT_STEPS);
    assertNear(mean(lights), RELATIVE);
  });
});

/** Mean colour of 5 x 5 pixels of the traced picture about a place of the view, to calm its noise. */
async function tracedPixel(page, [x, y]) {
  const [width, height] = await viewSize(page);
  return page.evaluate(([across, down]) => {
    const canvas = document.querySelector(".sb-picture");
    const left = [across * canvas.width - 2, down * canvas.height - 2];
    const { data } = canvas.getContext("2d").getImageData(...left.map(Math.round), 5, 5);
    return [0, 1, 2].map((channel) => data.filter((_, at) => at % 4 === channel).reduce((a, b) => a + b) / 25);
  }, [x / width, y / height]);
}
