// Axes of the charts.

import assert from "node:assert/strict";
import test from "node:test";
import { fileURLToPath } from "node:url";
import * as esbuild from "esbuild";

const HERE = fileURLToPath(new URL(".", import.meta.url));

const { outputFiles } = await esbuild.build({
  stdin: {
    contents: 'export * from "../src/chart/scale"; export * from "../src/sunlight/ticks";',
    resolveDir: HERE, loader: "ts",
  },
  bundle: true, format: "esm", write: false,
});
const { niceStep, scaleOf, ticksOf } =
  await import(`data:text/javascript;base64,${Buffer.from(outputFiles[0].contents).toString("base64")}`);

test("steps are 1, 2 or 5 times a power of ten", () => {
  for (const [rough, step] of [[1, 1], [1.1, 2], [3, 5], [0.07, 0.1], [367, 500], [733, 1000]]) {
    assert.ok(Math.abs(niceStep(rough) / step - 1) < 1e-12, `${niceStep(rough)} is not ${step}`);
  }
});

test("ticks go from 0 to the greatest value", () => {
  assert.deepEqual(ticksOf(15, 6), [0, 5, 10, 15]);
  assert.deepEqual(ticksOf(19, 6), [0, 5, 10, 15]);
  assert.deepEqual(ticksOf(0, 6), [0]);
});

test("a logarithmic axis spans whole decades, and lower values lie at its end", () => {
  const { place, ticks } = scaleOf("log", [0.02, 3], 4);
  assert.deepEqual(ticks.filter(({ label }) => label !== "").map(({ value }) => value), [0.01, 0.1, 1, 10]);
  assert.ok(Math.abs(place(1) - 2 / 3) < 1e-12 && place(1e-9) === 0);
});
