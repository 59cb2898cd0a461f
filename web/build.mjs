// Bundles the page: `node build.mjs FOLDER` takes the modules in FOLDER/wasm and writes FOLDER/dist; see
// scripts/build-web.

import { createHash } from "node:crypto";
import { copyFileSync, existsSync, mkdirSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { basename, dirname, join, resolve } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import * as esbuild from "esbuild";

const ROOT = dirname(fileURLToPath(import.meta.url));
const [WASM, DIST] = ["wasm", "dist"].map((name) => resolve(process.argv[2], name));

/** The licences of what the page holds: ours, those of data and packages in the modules, and that of three.js. */
function licences() {
  const data = readdirSync(join(ROOT, "../crates")).sort().flatMap((crate) => {
    const folder = join(ROOT, "../crates", crate, "data");
    const names = existsSync(folder) ? readdirSync(folder).sort() : [];
    return names.filter((name) => /^(LICENSE-.*|SOURCES\.md)$/.test(name)).map((name) => join(folder, name));
  });
  const ours = ["../LICENSE-MIT", "../LICENSE-APACHE", "node_modules/three/LICENSE"].map((name) => join(ROOT, name));
  const all = [...ours, ...data, join(WASM, "dependencies.txt")];
  return all.map((file) => readFileSync(file, "utf8")).join(`\n${"-".repeat(80)}\n\n`);
}

/** The module `spectrum`, running here. */
async function spectrumModule() {
  const file = join(WASM, "spectrum_bg.wasm");
  const native = await import(pathToFileURL(join(WASM, "spectrum.js")).href);
  await native.default({ module_or_path: readFileSync(file) });
  return native;
}

/** Import of `native:NAME` from wasm, and of values that are computed now. */
function provide(values) {
  return {
    name: "provide",
    setup(build) {
      build.onResolve({ filter: /^native:/ }, ({ path }) => ({ path: join(WASM, `${path.slice(7)}.js`) }));
      build.onResolve({ filter: /^virtual:/ }, ({ path }) => ({ path, namespace: "virtual" }));
      build.onLoad({ filter: /.*/, namespace: "virtual" }, ({ path }) => ({
        contents: JSON.stringify(values[path]),
        loader: "json",
      }));
    },
  };
}

const COMMON = { bundle: true, minify: true, target: "es2022", legalComments: "none", absWorkingDir: ROOT };

/** Evaluates a module of the page here. */
async function evaluate(entry, values) {
  const { outputFiles } = await esbuild.build({
    ...COMMON, entryPoints: [entry], format: "esm", write: false, plugins: [provide(values)],
  });
  return import(`data:text/javascript;base64,${Buffer.from(outputFiles[0].contents).toString("base64")}`);
}

/** Scripts that a script imports at once, itself first. */
function withImports(script, outputs) {
  const found = new Set(Object.keys(outputs).filter((path) => basename(path) === script));
  for (const file of found) {
    for (const { path, kind } of outputs[file].imports) if (kind === "import-statement") found.add(path);
  }
  return [...found].map((path) => basename(path));
}

/**
 * Links in the head of the page to what the first light needs. Without them a browser learns of each file from the one
 * before it.
 */
function links({ outputs }) {
  const first = withImports("main.js", outputs);
  const later = withImports("viewer.js", outputs).filter((script) => !first.includes(script));
  return [
    '<link rel="preload" href="poster.webp" as="image" fetchpriority="high">',
    ...first.map((script) => `<link rel="modulepreload" href="${script}">`),
    '<link rel="preload" href="scene_bg.wasm" as="fetch" crossorigin>',
    ...later.map((script) => `<link rel="modulepreload" href="${script}" fetchpriority="low">`),
  ];
}

/** The page with links in its head. */
function pageWith(tags) {
  const mark = "  <!-- links -->\n";
  const page = readFileSync(join(ROOT, "index.html"), "utf8");
  if (!page.includes(mark)) throw new Error(`index.html has no place for links: ${mark}`);
  return page.replace(mark, tags.map((tag) => `  ${tag}\n`).join(""));
}

const native = await spectrumModule();
const values = {
  "virtual:catalog": {
    version: native.version(),
    illuminants: JSON.parse(native.illuminants()),
    kinds: JSON.parse(native.kinds()),
    impurities: JSON.parse(native.impurities()),
    properties: JSON.parse(native.properties()),
    parameters: JSON.parse(native.parameters()),
    spreads: JSON.parse(native.spreads()),
    wavelengthColors: JSON.parse(native.wavelength_colors()),
    primaryLuminances: JSON.parse(native.luminances()),
    clearIce: JSON.parse(native.ice()),
    sunlight: native.sunlight_name(),
  },
  "virtual:display-shader": native.display_shader(),
};
const { defaultState, fineRequest } = await evaluate("src/request.ts", values);
values["virtual:first-answer"] = JSON.parse(native.spectrum(JSON.stringify(fineRequest(defaultState()))));

rmSync(DIST, { recursive: true, force: true });
mkdirSync(DIST);
const { metafile } = await esbuild.build({
  ...COMMON,
  entryPoints: [
    "src/main.ts",
    "src/sunlight/sunlight.ts",
    "src/view/viewer.ts",
    "src/style.css",
    ...readdirSync(join(ROOT, "src/workers")).map((file) => `src/workers/${file}`),
  ],
  entryNames: "[name]",
  chunkNames: "[name]-[hash]",
  format: "esm",
  splitting: true,
  outdir: DIST,
  metafile: true,
  plugins: [provide(values)],
});
for (const file of readdirSync(WASM).filter((name) => name.endsWith(".wasm"))) {
  copyFileSync(join(WASM, file), join(DIST, file));
}
copyFileSync(join(ROOT, "poster.webp"), join(DIST, "poster.webp"));
writeFileSync(join(DIST, "index.html"), pageWith(links(metafile)));
writeFileSync(join(DIST, "licences.txt"), licences());
// Of the clear sky, which only visitors that choose it load.
const SKY = join(ROOT, "../crates/snowblue-sky/data");
for (const file of ["hosek_wilkie_2012_spectral.csv", "hosek_wilkie_2013_sun.csv"]) {
  copyFileSync(join(SKY, file), join(DIST, file));
}
const icon = join(ROOT, "src/icons/icon.svg");
if (existsSync(icon)) copyFileSync(icon, join(DIST, "icon.svg"));

const files = readdirSync(DIST).sort();
const hash = createHash("sha256");
for (const file of files) hash.update(file).update(readFileSync(join(DIST, file)));
// The service worker knows the page by both of its addresses.
const kept = files.filter((file) => file !== "index.html");
await esbuild.build({
  ...COMMON,
  entryPoints: ["src/service-worker.ts"],
  format: "iife",
  outdir: DIST,
  define: { FILES: JSON.stringify(kept), BUILD: JSON.stringify(hash.digest("hex").slice(0, 16)) },
});
