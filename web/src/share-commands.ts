/** The command lines and the Python calls that give the figures of a sample. */

import { parameters, properties } from "./catalog";
import { exact, toml } from "./toml";
import { amounts, entries } from "./snow";
import type { Layer, State } from "./state";

type Asked = Pick<State, "layers" | "ground_albedo" | "angle_deg" | "illuminant" | "observer" | "swatch_exposure">;

/** Name of the file of layers in a command. */
export const LAYERS_FILE = "layers.toml";
const SPECTRUM_FILE = "spectrum.csv";
const STEP_NM = 10;

/**
 * `snowblue spectrum` and `snowblue color`; layers come from a file. With the wavelengths of a solar spectrum this one
 * and the bands too.
 */
export function commandLines(sample: Asked, solar_nm?: readonly number[]): string {
  const { layers, angle_deg, ground_albedo } = sample;
  const [layer] = layers;
  const snow = layers.length === 1
    ? [...snowOptions(layer!), `--thickness ${exact(layer!.thickness_cm)}`]
    : [`--layers ${LAYERS_FILE}`];
  const ground = ground_albedo > 0 ? [`--ground-albedo ${exact(ground_albedo)}`] : [];
  const slab = [...snow, `--angle ${angle_deg}`, ...ground];
  const exposure = sample.swatch_exposure === "auto" ? "auto" : exact(sample.swatch_exposure);
  const light = [`--illuminant ${sample.illuminant}`, `--observer ${sample.observer}`, `--exposure ${exposure}`];
  const wavelengths = `--wavelengths ${solar_nm && (stepsOf(solar_nm)?.join(":") ?? solar_nm.join())}`;
  const solar = solar_nm === undefined ? [] : [
    ["snowblue spectrum", ...slab, wavelengths, "-o solar.csv"],
    ["snowblue spectrum", ...slab, wavelengths, "--broadband all", "-o bands.csv"],
  ];
  return [
    ["snowblue spectrum", ...slab, `-o ${SPECTRUM_FILE}`],
    ["snowblue color", `--spectrum ${SPECTRUM_FILE}`, ...light],
    ...solar,
  ].map((words) => words.join(" ")).join("\n");
}

/** First, last and step of wavelengths, if the last step is one like the others. */
function stepsOf(wavelengths_nm: readonly number[]): [number, number, number] | undefined {
  const [first, last] = [wavelengths_nm[0]!, wavelengths_nm.at(-1)!];
  return (last - first) % STEP_NM === 0 ? [first, last, STEP_NM] : undefined;
}

/** The file of layers, if there are several. */
export function layersToml({ layers }: Asked): string | undefined {
  if (layers.length === 1) return undefined;
  const ice = layers[0]!.ice;
  const line = ([key, value]: [string, unknown]) => `${key} = ${toml(value)}\n`;
  const tables = layers.map((layer) => `[[layer]]\n${keysOf(layer).map(line).join("")}`);
  return [...(ice === undefined ? [] : [line(["ice", ice])]), ...tables].join("\n");
}

/** `snowblue.spectrum` or `snowblue.layers`, and `snowblue.color`; and `snowblue.bands` of a solar spectrum. */
export function pythonCall(sample: Asked, solar_nm?: readonly number[]): string {
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
  const call = (name: string, more: readonly string[]) => [
    `${name} = snowblue.${isSlab ? "spectrum" : "layers"}(`,
    ...[...arguments_, ...more].map((argument) => `    ${argument},`),
    ")",
  ];
  const solar = solar_nm === undefined ? [] : [
    ...call("solar", [`wavelength_nm=${pythonRange(solar_nm)}`]),
    'bands = snowblue.bands(solar, ("solar", "visible", "near-infrared", "par"))',
  ];
  return [
    "import snowblue",
    "",
    ...call("snow", []),
    "color = snowblue.color(",
    `    snow.transmittance, illuminant="${sample.illuminant}", observer="${sample.observer}",`,
    `    exposure_stops=${exposure},`,
    ")",
    ...solar,
  ].join("\n");
}

function pythonRange(wavelengths_nm: readonly number[]): string {
  const steps = stepsOf(wavelengths_nm);
  return steps === undefined ? `[${wavelengths_nm.join(", ")}]` : `range(${steps[0]}, ${steps[1] + 1}, ${steps[2]})`;
}

function snowOptions(layer: Layer): string[] {
  const options = properties.flatMap(({ key, name }) => {
    const value = keysOf(layer).find(([known]) => known === key)?.[1] as number | number[] | undefined;
    const option = value === undefined ? [] : [`--${name.replaceAll("_", "-")} ${joined(value)}`];
    const measure = key === "grain_size_um" && layer.size_measure !== undefined;
    return measure ? [...option, `--size-measure ${layer.size_measure}`] : option;
  });
  const present = amounts(layer).map(([name, ng_g]) => `${name}=${exact(ng_g)}`);
  if (present.length > 0) options.push(`--impurity ${present.join(",")}`);
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
