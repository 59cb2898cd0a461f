/** The command lines and the Python calls that give the figures of a sample. */

import { parameters } from "./catalog";
import { exact, toml } from "./toml";
import { amounts, entries, plain } from "./snow";
import type { Layer, State } from "./state";

type Asked = Pick<State, "layers" | "ground_albedo" | "angle_deg" | "illuminant" | "observer" | "swatch_exposure">;

/** Name of the file of layers in a command. */
export const LAYERS_FILE = "layers.toml";
const SPECTRUM_FILE = "spectrum.csv";

/** `snowblue spectrum` and `snowblue color`; layers come from a file. */
export function commandLines(sample: Asked): string {
  const { layers, angle_deg, ground_albedo } = sample;
  const [layer] = layers;
  const snow = layers.length === 1
    ? [...snowOptions(layer!), `--thickness ${exact(layer!.thickness_cm)}`]
    : [`--layers ${LAYERS_FILE}`];
  const ground = ground_albedo > 0 ? [`--ground-albedo ${exact(ground_albedo)}`] : [];
  const slab = [...snow, `--angle ${angle_deg}`, ...ground];
  const exposure = sample.swatch_exposure === "auto" ? "auto" : exact(sample.swatch_exposure);
  const light = [`--illuminant ${sample.illuminant}`, `--observer ${sample.observer}`, `--exposure ${exposure}`];
  return [
    ["snowblue spectrum", ...slab, `-o ${SPECTRUM_FILE}`],
    ["snowblue color", `--spectrum ${SPECTRUM_FILE}`, ...light],
  ].map((words) => words.join(" ")).join("\n");
}

/** The file of layers, if there are several. */
export function layersToml({ layers }: Asked): string | undefined {
  if (layers.length === 1) return undefined;
  const ice = layers[0]!.ice;
  const line = ([key, value]: [string, unknown]) => `${key} = ${toml(value)}\n`;
  const tables = layers.map((layer) => `[[layer]]\n${keysOf(layer).map(line).join("")}`);
  return [...(ice === undefined ? [] : [line(["ice", ice])]), ...tables].join("\n");
}

/** `snowblue.spectrum` or `snowblue.layers`, and `snowblue.color`. */
export function pythonCall(sample: Asked): string {
  const { layers, angle_deg, ground_albedo } = sample;
  const [layer] = layers;
  const angle = `angle_deg=${angle_deg === "diffuse" ? '"diffuse"' : exact(angle_deg)}`;
  const isSlab = layers.length === 1 && ground_albedo === 0;
  const keywords = (one: Layer) => [...keysOf(one), ...iceOf(one)].map(([key, value]) => `${key}=${python(value)}`);
  const arguments_ = isSlab
    ? [...keywords(layer!), angle]
    : [
        `[${layers.map((one) => `dict(${keywords(one).join(", ")})`).join(",\n     ")}]`,
        `ground_albedo=${exact(ground_albedo)}`,
        angle,
      ];
  const exposure = sample.swatch_exposure === "auto" ? "None" : exact(sample.swatch_exposure);
  return [
    "import snowblue",
    "",
    `snow = snowblue.${isSlab ? "spectrum" : "layers"}(`,
    ...arguments_.map((argument) => `    ${argument},`),
    ")",
    "color = snowblue.color(",
    `    snow.transmittance, illuminant="${sample.illuminant}", observer="${sample.observer}",`,
    `    exposure_stops=${exposure},`,
    ")",
  ].join("\n");
}

function snowOptions(layer: Layer): string[] {
  const options: string[] = [];
  if (layer.ssa_m2_kg !== undefined) options.push(`--ssa ${exact(layer.ssa_m2_kg)}`);
  else options.push(`--grain-size ${joined(layer.grain_size_um ?? parameters.grain_size_um.default)}`);
  if (layer.size_measure !== undefined) options.push(`--size-measure ${layer.size_measure}`);
  options.push(`--facetness ${joined(layer.facetness ?? parameters.facetness.default)}`);
  if (layer.sphericity !== undefined) options.push(`--sphericity ${joined(layer.sphericity)}`);
  options.push(`--density ${exact(plain(layer, "density_kg_m3"))}`);
  if (layer.water_saturation !== undefined) options.push(`--water-saturation ${exact(layer.water_saturation)}`);
  const present = amounts(layer).map(([name, ng_g]) => `${name}=${exact(ng_g)}`);
  if (present.length > 0) options.push(`--impurity ${present.join(",")}`);
  if (layer.temperature_c !== undefined) options.push(`--temperature ${exact(layer.temperature_c)}`);
  if (layer.ice !== undefined) options.push(`--ice ${layer.ice}`);
  return options;
}

/** The keys of a layer, those of size, facetness and density always among them. */
function keysOf(layer: Layer): [string, unknown][] {
  const size = layer.ssa_m2_kg === undefined ? { grain_size_um: parameters.grain_size_um.default } : {};
  const usual = { ...size, facetness: parameters.facetness.default, density_kg_m3: parameters.density_kg_m3.default };
  const keys: [string, unknown][] = entries({ ...usual, ...layer });
  const present = amounts(layer);
  return present.length === 0 ? keys : [...keys, ["impurities_ng_g", Object.fromEntries(present)]];
}

function iceOf({ ice }: Layer): [string, unknown][] {
  return ice === undefined ? [] : [["ice", ice]];
}

function joined(value: number | number[]): string {
  return [value].flat().map(exact).join(":");
}

function python(value: unknown): string {
  if (typeof value === "string") return `"${value}"`;
  if (typeof value === "number") return exact(value);
  if (Array.isArray(value)) return `(${value.map(python).join(", ")})`;
  return `{${Object.entries(value as object).map(([key, one]) => `"${key}": ${python(one)}`).join(", ")}}`;
}
