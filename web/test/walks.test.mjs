// The walks of the story obey the law that they are made from.

import assert from "node:assert/strict";
import { fileURLToPath } from "node:url";
import test from "node:test";
import * as esbuild from "esbuild";

const ENTRY = fileURLToPath(new URL("../src/story/walks.ts", import.meta.url));
const { outputFiles } = await esbuild.build({ entryPoints: [ENTRY], bundle: true, format: "esm", write: false });
const { absorbing, freePath, meanOf, transmitted, walks } =
  await import(`data:text/javascript;base64,${Buffer.from(outputFiles[0].contents).toString("base64")}`);

const COUNT = 20_000;

for (const transmittance of [0.02, 0.05, 0.2]) {
  test(`walks through snow that transmits ${transmittance}`, () => {
    const all = walks(COUNT, freePath(transmittance));
    const found = transmitted(all).length / COUNT;
    // Four standard deviations of a count, and 1 % for the diffusion approximation.
    const most = 4 * Math.sqrt((transmittance * (1 - transmittance)) / COUNT) + 0.01 * transmittance;
    assert.ok(Math.abs(found - transmittance) <= most, `${found} of the walks get through`);
  });
}

test("light that walks lose by absorption is what was asked for", () => {
  const through = transmitted(walks(COUNT, freePath(0.05)));
  for (const part of [0.9, 0.4, 0.01]) {
    const factor = absorbing(through, part);
    assert.ok(Math.abs(meanOf(through, (length) => Math.exp(-factor * length)) / part - 1) < 1e-9);
  }
});
