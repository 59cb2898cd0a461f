// All shapes under all kinds of light have the light of `snowblue render`: a lamp in front, whose light their own front
// must not hide, an overcast sky, and a clear one.

import assert from "node:assert/strict";
import { follow, lit, pageTest } from "./page.mjs";
import { differenceOf, everywhere, mean } from "./pictures.mjs";

const LAMP = "lamp=0.1,-0.6,0.5,D65,10";
/** Lights as links have them. The sun stands in front. */
const LIGHTS = [LAMP, "sky=overcast,18", "sky=clear,35,200,2.5"];
/** Samples of a pixel of the command: noise of some 1 % of a pixel under a sky or in a hollow. */
const SAMPLES = 256;
/** Fewest pixels; the sculpture, the narrowest, has some 480. */
const LEAST_PIXELS = 400;
/**
 * Of the mean of all pixels, whose noise and whose steps between cells cancel: both engines solve the same equations on
 * the same cells. The greatest difference is that of the igloo, some 0.8 %.
 */
const RELATIVE_OF_MEAN = 0.01;
/** Shapes, and whether each is a mesh. */
const SHAPES = [["block", false], ["ball", false], ["drift", false], ["sculpture", true], ["igloo", true]];
/**
 * Half of the pixels agree within this: light is interpolated between vertices. The light of other surfaces comes from
 * cells on the page, and from rays of each pixel in the command.
 */
const RELATIVE_OF_HALF = 0.03;
/** Nine of ten agree within this: shadows and grooves are interpolated between vertices. */
const RELATIVE_OF_NINE_TENTHS = 0.15;
/**
 * Where this does not hold. On the side of the block that the lamp does not reach, with some 0.5 to 6 % of the light of
 * the front, the page is 15 to 25 % too bright.
 */
const BLOCK_BY_LAMP = `block ${LAMP}`;
const RELATIVE_OF_NINE_TENTHS_ON_BLOCK = 0.3;

/** Where half of the pixels differ by more: the page is mostly too dark on dim parts of the sculpture. */
const RELATIVE_OF_HALF_ON_SCULPTURE = 0.035;
const SCULPTURE_BY_LAMP = `sculpture ${LAMP}`;

const CASES = SHAPES.flatMap(([shape, isMesh]) => LIGHTS.map((light) => [shape, light, isMesh]));
// The sun behind.
CASES.push(["sculpture", "sky=clear,18,10,2.5", true]);

pageTest("all shapes have the light of snowblue render", { fragment: "shape=block" }, async (page, t) => {
  for (const [shape, light, isMesh] of CASES) {
    const name = `${shape} ${light}`;
    await t.test(name, async () => {
      await follow(page, `shape=${shape}&${light}`);
      await lit(page);
      const lights = await everywhere(page, SAMPLES, isMesh);
      assert.ok(lights.length > LEAST_PIXELS, `${lights.length} pixels`);
      const errors = lights.map(differenceOf).sort((one, other) => one - other);
      const [half, nineTenths] = [0.5, 0.9].map((share) => errors[Math.floor(share * errors.length)]);
      const ofMean = differenceOf(mean(lights));
      const found = `mean ${ofMean.toFixed(4)}, half ${half.toFixed(4)}, nine tenths ${nineTenths.toFixed(4)}`;
      t.diagnostic(`${name}: ${found}`);
      assert.ok(ofMean < RELATIVE_OF_MEAN, found);
      assert.ok(half < (name === SCULPTURE_BY_LAMP ? RELATIVE_OF_HALF_ON_SCULPTURE : RELATIVE_OF_HALF), found);
      const mostOfNineTenths = name === BLOCK_BY_LAMP ? RELATIVE_OF_NINE_TENTHS_ON_BLOCK : RELATIVE_OF_NINE_TENTHS;
      assert.ok(nineTenths < mostOfNineTenths, found);
    });
  }
});

/** Of the exposure in stops, between the coarse and the fine light; a third of a stop is hardly seen. */
const STEP_STOPS = 0.35;

pageTest("the exposure of the fine light is that of the coarse one", { fragment: "shape=block" }, async (page) => {
  await lit(page);
  for (const shape of ["igloo", "sculpture", "ball"]) {
    await follow(page, `shape=${shape}`);
    const [coarse, fine] = await page.evaluate(() => new Promise((resolve) => {
      let [coarse, isReady] = [undefined, false];
      void window.__snowblue.ready.then(() => (isReady = true));
      const look = () => {
        const { nodes, stops } = window.__snowblue.figures;
        if (isReady) return resolve([coarse, stops]);
        // The fine light of the shape before has more nodes.
        if (nodes < 10_000) coarse = stops;
        setTimeout(look, 5);
      };
      look();
    }));
    assert.ok(coarse !== undefined, "there was no coarse light");
    assert.ok(Math.abs(fine - coarse) < STEP_STOPS, `${shape}: ${coarse} and ${fine} stops`);
  }
});
