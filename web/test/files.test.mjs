// Files in and out: meshes of the visitor, broken links, and what is saved.

import assert from "node:assert/strict";
import { inFolder } from "./command.mjs";
import { cubeGlb, cubePly, openPly, soupPly } from "./cube.mjs";
import { chooseMesh, control, final, follow, lit, pageTest, pixel, saved, viewSize } from "./page.mjs";

const GLB = cubeGlb();
/** What cannot be used, and what is said of it. */
const REFUSED = [
  ["broken.ply", Buffer.from("ply\nformat ascii 1.0\nelement vertex 3\n"), /^The mesh broken\.ply was refused: .+\.$/],
  ["short.ply", Buffer.from(cubePly().slice(0, 180)), /^The mesh short\.ply was refused: .+\.$/],
  ["short.glb", GLB.subarray(0, GLB.length / 2), /^The mesh short\.glb was refused: .+\.$/],
  ["noise.glb", Buffer.alloc(200, 7), /^The mesh noise\.glb was refused: .+\.$/],
  ["text.txt", Buffer.from("This is no mesh."), /^The mesh text\.txt was refused: the extension is "txt", but .+\.$/],
  ["open.ply", Buffer.from(openPly()), /^The mesh open\.ply has 3 open edges, but snow must be a closed solid\.$/],
];

const PNG = [0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a];

function assertStart(file, bytes) {
  assert.deepEqual([...file.subarray(0, bytes.length)], bytes);
}

async function middle(page) {
  const [width, height] = await viewSize(page);
  return pixel(page, [width / 2, height / 2]);
}

/** The shape whose button is pressed. */
async function shape(page) {
  const own = await page.locator("#toolbar .own").getAttribute("aria-pressed");
  return own === "true" ? "own" : page.locator("#toolbar .shapes input:checked").inputValue();
}

pageTest("files in and out", {}, async (page, t) => {
  await final(page);
  await lit(page);
  const before = await middle(page);
  for (const [name, file, sentence] of REFUSED) {
    await t.test(`${name} is refused in place`, async () => {
      await page.getByRole("radio", { name: "Block" }).check();
      await chooseMesh(page, name, file);
      const error = page.locator("#view-error", { hasText: name.split(".")[0] });
      await error.waitFor();
      assert.match(await error.textContent(), sentence);
      assert.equal(await shape(page), "block");
      await lit(page);
      assert.deepEqual(await middle(page), before);
    });
  }

  const cubes = [["cube.ply", Buffer.from(cubePly())], ["cube.glb", GLB], ["soup.ply", Buffer.from(soupPly())]];
  for (const [name, file] of cubes) {
    await t.test(`${name} is shown as snow`, async () => {
      await page.getByRole("radio", { name: "Ball" }).check();
      await chooseMesh(page, name, file);
      await page.waitForFunction(() => document.querySelector("#toolbar .own").ariaPressed === "true");
      await lit(page);
      const [red, green, blue, alpha] = await middle(page);
      assert.ok(alpha === 1 && blue > green && green > red && red > 0, `${[red, green, blue]} is not blue snow`);
      assert.equal(await page.locator("#view-error").isVisible(), false);
    });
  }

  await t.test("CSV", async () => {
    const lines = String((await saved(page, "CSV"))["snow.csv"]).split("\n");
    assert.equal(lines[0], "place,sample,wavelength_nm,reflectance,reflectance_se,transmittance," +
      "transmittance_se,absorptance,absorptance_se");
    assert.match(lines[1], /^0,"15 cm, 400 µm, 300 kg\/m³",400,0\.97/);
  });

  await t.test("SVG", async () => {
    assert.match(String((await saved(page, "SVG"))["snow.svg"]), /^<svg [^]*<\/svg>$/);
  });

  await t.test("PNG", async () => assertStart((await saved(page, "PNG"))["snow.png"], PNG));

  await t.test("3-D PNG", async () => {
    const file = (await saved(page, "3-D PNG"))["snow-view.png"];
    assertStart(file, PNG);
    // Width and height follow the signature, the length and the name of the first chunk.
    assert.deepEqual([file.readUInt32BE(16), file.readUInt32BE(20)], await viewSize(page));
  });

  await t.test("Picture to share", async () => {
    const file = (await saved(page, "Picture to share"))["snow-blue.png"];
    assertStart(file, PNG);
    const [width, height] = await viewSize(page);
    assert.equal(file.readUInt32BE(16), width);
    assert.ok(file.readUInt32BE(20) > height, "there is no strip below the view");
    // Left in the strip, half way down.
    const place = [width / 24, (height + file.readUInt32BE(20)) / 2];
    const color = await page.evaluate(async ([bytes, [x, y]]) => {
      const bitmap = await createImageBitmap(new Blob([Uint8Array.from(bytes)]));
      const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
      context.drawImage(bitmap, 0, 0);
      return [...context.getImageData(x, y, 1, 1).data.subarray(0, 3)];
    }, [[...file], place]);
    const { srgb } = await page.evaluate(() => window.__snowblue.probe({ x: 0.5, y: 0.5 }));
    assert.deepEqual(color, srgb);
  });

  await t.test("the caption of the picture to share says what is seen", async () => {
    await follow(page, "shape=ball");
    await lit(page);
    await page.evaluate(() => {
      window.written = [];
      const { fillText } = OffscreenCanvasRenderingContext2D.prototype;
      OffscreenCanvasRenderingContext2D.prototype.fillText = function (text, ...rest) {
        window.written.push(text);
        fillText.call(this, text, ...rest);
      };
    });
    await saved(page, "Picture to share");
    const { wavelengths_nm, radiance } = await page.evaluate(() => window.__snowblue.probe({ x: 0.5, y: 0.5 }));
    const [blue, red] = [450, 650].map((nm) => radiance[wavelengths_nm.indexOf(nm)]);
    const times = Number((blue / red).toPrecision(2));
    assert.deepEqual((await page.evaluate(() => window.written)).slice(0, 2), [
      "Ball of 38 cm: 400 µm, 300 kg/m³, lamplight", `in the middle, blue is ${times} times as bright as red`,
    ]);
    await follow(page, "shape=block");
    await lit(page);
  });

  await t.test("3-D GLB", async () => {
    const file = (await saved(page, "3-D GLB"))["snow.glb"];
    assert.equal(file.toString("latin1", 0, 4), "glTF");
    assert.deepEqual([file.readUInt32LE(4), file.readUInt32LE(8)], [2, file.length]);
    const { meshes } = JSON.parse(file.toString("utf8", 20, 20 + file.readUInt32LE(12)));
    // Those of the command `snowblue bake`.
    const names = ["COLOR_0", "NORMAL", "POSITION", "_LAMP_0", "_SKY"];
    assert.deepEqual(Object.keys(meshes[0].primitives[0].attributes).sort(), names);
  });

  await t.test("a link that cannot be read says why", async () => {
    const notice = page.locator("#notice");
    for (const [fragment, reason] of [
      ["layer=density_kg_m3:9000", "density is 9000 kg/m³, but must lie in 10–900 kg/m³"],
      ["layer=thickness_cm:x", "'x' is not a number for thickness_cm"],
      ["lamp=1,2", "a lamp has a position of three numbers, an illuminant and a strength"],
      ["shape=own", "'own' is not known for shape"],
      ["sky=rain,3", "'rain' is not known for sky"],
      ["sky=clear,95,0,3", "sun elevation is 95°, but must lie in 0–90°"],
      ["foo=1", "'foo' is not known"],
    ]) {
      await follow(page, fragment);
      assert.equal(await notice.textContent(), `The link cannot be read: ${reason}. The default snow is shown.`);
      assert.ok(await notice.isVisible());
    }
    await follow(page, "illuminant=A");
    assert.equal(await notice.isVisible(), false);
  });

  await t.test("a link is taken although the page writes its address before the event", async () => {
    await page.evaluate(() => new Promise((resolve) => {
      addEventListener("hashchange", resolve, { once: true });
      location.hash = "illuminant=FL2";
      history.replaceState(null, "", "#illuminant=A");
    }));
    assert.equal(await control(page, "Illuminant").inputValue(), "FL2");
  });

  /** The command ends with an error if it cannot read the scene or if its snow is not closed. */
  const check = async (files) => {
    assert.match(String(files["scene.toml"]), /^# .*\n\n\[camera\]\n/s);
    await inFolder(files, (run) => run("render", "scene.toml", "--check"));
  };
  for (const [fragment, count] of [
    ["shape=block&illuminant=A", 1], ["shape=ball", 1], ["shape=igloo", 2], ["shape=drift", 1], ["shape=sculpture", 2],
    ["sky=clear,20,30,2.5", 1], ["sky=overcast,30", 1],
  ]) {
    await t.test(`the command takes the scene file of ${fragment}`, async () => {
      await follow(page, fragment);
      await check(await saved(page, "Scene TOML", count));
    });
  }

  await t.test("the command takes the scene file of an own mesh", async () => {
    await chooseMesh(page, "cube.ply", Buffer.from(cubePly()));
    await page.waitForFunction(() => document.querySelector("#toolbar .own").ariaPressed === "true");
    const files = await saved(page, "Scene TOML", 2);
    assert.deepEqual(Object.keys(files).sort(), ["cube.obj", "scene.toml"]);
    await check(files);
  });

  await t.test("the command takes the scene file of snow with all that a layer can say", async () => {
    await follow(page, "layer=thickness_cm:15,grain_size_um:300~900,size_measure:optical-diameter,sphericity:0.9," +
      "facetness:0.1~0.5~0.2~0.1,temperature_c:-20,black-carbon:20,saharan-dust:3000&ice=picard2016");
    await check(await saved(page, "Scene TOML"));
  });
});
