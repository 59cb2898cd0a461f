// Meshes of the visitor: their formats, their size, their repair and their links.

import assert from "node:assert/strict";
import { ballObj, cubeObj, cubePly, cubeStl, openPly, prismPly } from "./cube.mjs";
import { chooseMesh, control, lit, pageTest, pixel, viewSize } from "./page.mjs";

async function middle(page) {
  const [width, height] = await viewSize(page);
  return pixel(page, [width / 2, height / 2]);
}

/** Chooses a file, and waits until it is shown as snow. */
async function show(page, name, content) {
  await chooseMesh(page, name, Buffer.from(content));
  await page.waitForFunction(() => document.querySelector("#toolbar .own").ariaPressed === "true");
  await shows(page);
}

/** Snow that the light comes through, which is blue. */
async function shows(page) {
  await lit(page);
  const [red, green, blue, alpha] = await middle(page);
  assert.ok(alpha === 1 && blue > green && green > red && red > 0, `${[red, green, blue]} is not blue snow`);
}

const length = (page) => control(page, "Greatest length").inputValue();

pageTest("meshes of the visitor", {}, async (page, t) => {
  await lit(page);
  const files = [["prism.ply", prismPly()], ["cube.obj", cubeObj()], ["cube.stl", cubeStl()]];
  for (const [name, content] of files) {
    await t.test(`${name} is shown as snow of 30 cm`, async () => {
      await page.getByRole("radio", { name: "Ball" }).check();
      await show(page, name, content);
      assert.equal(Math.round(await length(page)), 30);
      assert.equal(await page.locator("#view-error").isVisible(), false);
    });
  }

  await t.test("another unit or length gives another size, with the lamp and the camera", async () => {
    const lampAt = () => page.locator(".sb-lamp").getAttribute("aria-label");
    const before = await lampAt();
    await control(page, "Unit of mesh files").selectOption("0.0254");
    await page.waitForFunction(() => document.querySelector(".sb-lamp").ariaLabel.includes("z 53"));
    assert.equal(await length(page), "762");
    await control(page, "Greatest length").fill("30");
    await page.waitForFunction((before) => document.querySelector(".sb-lamp").ariaLabel === before, before);
    await lit(page);
  });

  await t.test("an open mesh is refused, the mesh before stays, and a repair is offered", async () => {
    const before = await middle(page);
    await chooseMesh(page, "open.ply", Buffer.from(openPly()));
    await page.locator("#view-error", { hasText: "The mesh open.ply has 3 open edges" }).waitFor();
    await lit(page);
    assert.deepEqual(await middle(page), before);
    await control(page, "Unit of mesh files").selectOption("1");
    await chooseMesh(page, "open.ply", Buffer.from(openPly()));
    await page.locator("#view-error", { hasText: "The mesh open.ply has 3 open edges" }).waitFor();
    await page.getByRole("button", { name: "Repair the mesh" }).click();
    await page.locator("#view-status", { hasText: "3 edges of holes were closed" }).waitFor();
    await shows(page);
    assert.equal(await page.getByRole("button", { name: "Repair the mesh" }).isVisible(), false);
  });

  await t.test("a small mesh is in the link", async () => {
    await show(page, "cube.ply", cubePly());
    await page.waitForFunction(() => location.hash.includes("mesh=cube.obj"));
    await page.getByRole("button", { name: "Copy link" }).click();
    await page.locator("#share-status", { hasText: /^The link is copied\.$/ }).waitFor();
    const light = await middle(page);
    await page.reload();
    // There is no snow before the mesh of the link is read.
    const isLit = () => page.evaluate(() => window.__snowblue?.ready.then(() => true, () => false));
    while (!await isLit()) await page.waitForTimeout(50);
    await shows(page);
    // The light field need not have the cells of the earlier one.
    const again = await middle(page);
    assert.ok(again.every((value, k) => Math.abs(value - light[k]) < 0.02 * light[k]), `${again} ${light}`);
  });

  await t.test("a link says that it cannot hold a large mesh", async () => {
    await show(page, "ball.obj", ballObj());
    await page.waitForFunction(() => !location.hash.includes("mesh="));
    await page.getByRole("button", { name: "Copy link" }).click();
    await page.locator("#share-status", { hasText: "without the mesh, which is too large for a link" }).waitFor();
    assert.equal(await page.evaluate(() => location.hash.includes("mesh=")), false);
  });
});

pageTest("a link with a mesh opens it", { fragment: "mesh=cube.ply,1,0.3,broken" }, async (page) => {
  await page.locator("#view-error", { hasText: "The mesh cube.ply of the link is broken." }).waitFor();
});
