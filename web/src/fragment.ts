/**
 * The state as the fragment of an address: `#layer=thickness_cm:15,density_kg_m3:200&illuminant=A`. Missing keys have
 * their defaults. Numbers of a range are separated by `~`; a pinned sample is a fragment in itself.
 */

import { illuminants, impurities, parameters, properties, type ParameterKey } from "./catalog";
import { outside } from "./numbers";
import { defaultState } from "./request";
import { amounts, entries } from "./snow";
import {
  AT_DEPTH, METHODS, MOST_LAMPS, MOST_LAYERS, MOST_PINNED, RANGES, SHAPES,
  type Camera, type IceTable, type Lamp, type Layer, type MeshPlace, type Sample, type Sky, type State, type Vector,
} from "./state";
import { defaults } from "./view/shapes";
import { AZIMUTH as SUN_AZIMUTH } from "./view/sky";

const ICE_TABLES: readonly IceTable[] = ["warren2008", "picard2016"];
const SIZE_MEASURES: readonly NonNullable<Layer["size_measure"]>[] = [
  "greatest-extension", "volume-diameter", "optical-diameter",
];
const OBSERVERS: readonly Sample["observer"][] = ["1931", "1964"];
/** Keys of a layer whose values are numbers, and how many of them one may have that is no single number. */
const LAYER_NUMBERS = ["thickness_cm", ...properties.map(({ key }) => key)] as const;
const COUNTS: Partial<Record<ParameterKey, readonly number[]>> = {
  grain_size_um: [1, 2], facetness: [1, 4], sphericity: [1, 4],
};
/** Keys beside those of a sample. */
const OF_STATE = [
  "exposure", "range", "at_depth", "shape", "mesh", "method", "view_exposure", "lamp", "sky", "camera", "pin",
];
const METRES = { least: -100, greatest: 100, default: 0, unit: "m" };
const STRENGTH = { least: 0, greatest: 1e6, default: 10, unit: "W/sr" };
const UNIT = { least: 1e-6, greatest: 1e6, default: 1, unit: "m" };
const DISTANCE = { least: 0.01, greatest: 100, default: 1, unit: "m" };
const AZIMUTH = { least: -360, greatest: 360, default: 0, unit: "°" };
const ELEVATION = { least: -90, greatest: 90, default: 0, unit: "°" };

export function encode(state: State): string {
  const usual = defaultState();
  const pairs = samplePairs(state, usual);
  const add = (key: string, value: unknown, unless: unknown) => {
    if (String(value) !== String(unless)) pairs.push([key, String(value)]);
  };
  const { view } = state;
  const mesh = view.shape === "own" ? view.mesh : undefined;
  // Of a mesh that is too large, the link shows the default shape instead, with its lamps and camera.
  const { shape, lamps, camera } = view.shape === "own" && !mesh?.packed ? usual.view : view;
  const placed = defaults(shape);
  add("exposure", state.swatch_exposure, usual.swatch_exposure);
  add("range", state.range, usual.range);
  add("at_depth", state.at_depth, usual.at_depth);
  if (shape !== "own") add("shape", shape, usual.view.shape);
  else pairs.push(["mesh", [mesh!.name, mesh!.scale, rounded(mesh!.length), mesh!.packed].join()]);
  add("method", view.method, usual.view.method);
  add("view_exposure", view.exposure, usual.view.exposure);
  const places = lamps.map(lampText);
  if (places.join() !== placed.lamps.map(lampText).join()) pairs.push(...places.map((text) => ["lamp", text] as const));
  if (view.sky !== undefined) pairs.push(["sky", Object.values(view.sky).join()]);
  add("camera", cameraText(camera), cameraText(placed.camera));
  pairs.push(...state.pinned.map((sample) => ["pin", encodeSample(sample)] as const));
  return join(pairs);
}

/** A sample as a text that equal samples share. */
export function encodeSample(sample: Sample): string {
  return join(samplePairs(sample, defaultState()));
}

/** The state of a fragment without its `#`. Throws an `Error` with one sentence if it has none. */
export function decode(fragment: string): State {
  const state = defaultState();
  const given = pairsOf(fragment);
  const lamps = given.getAll("lamp");
  const pins = given.getAll("pin");
  decodeSample(given, state, OF_STATE);
  state.swatch_exposure = exposure(given.get("exposure"));
  state.range = word("range", given.get("range") ?? state.range, RANGES);
  state.at_depth = word("at_depth", given.get("at_depth") ?? state.at_depth, AT_DEPTH);
  const shape = word("shape", given.get("shape") ?? state.view.shape, SHAPES);
  Object.assign(state.view, { shape, ...structuredClone(defaults(shape)) });
  const ofMesh = given.get("mesh");
  if (ofMesh !== null) {
    Object.assign(state.view, { shape: "own", mesh: mesh(ofMesh), ...structuredClone(defaults("own")) });
  }
  state.view.method = word("method", given.get("method") ?? state.view.method, METHODS);
  state.view.exposure = exposure(given.get("view_exposure"));
  atMost("lamps", lamps.length, MOST_LAMPS);
  if (lamps.length > 0) state.view.lamps = lamps.map(lamp);
  const ofSky = given.get("sky");
  if (ofSky !== null) state.view.sky = sky(ofSky);
  const camera = given.get("camera");
  if (camera !== null) {
    const [azimuth, elevation, distance] = numbers("camera", camera.split(","), [3]);
    state.view.camera = {
      azimuth_deg: inside("azimuth", azimuth!, AZIMUTH),
      elevation_deg: inside("elevation", elevation!, ELEVATION),
      distance_m: inside("distance", distance!, DISTANCE),
    };
  }
  atMost("pinned samples", pins.length, MOST_PINNED);
  state.pinned = pins.map((pin) => decodeSample(pairsOf(pin), defaultState(), []));
  return state;
}

function samplePairs(sample: Sample, usual: Sample): (readonly [string, string])[] {
  const pairs: (readonly [string, string])[] = [];
  const layers = sample.layers.map(layerText);
  if (layers.join() !== usual.layers.map(layerText).join()) {
    pairs.push(...layers.map((text) => ["layer", text] as const));
  }
  const ice = sample.layers[0]?.ice;
  if (ice !== undefined) pairs.push(["ice", ice]);
  for (const key of ["ground_albedo", "angle_deg", "illuminant", "observer"] as const) {
    if (sample[key] !== usual[key]) pairs.push([key, String(sample[key])]);
  }
  return pairs;
}

function decodeSample(given: URLSearchParams, into: State, others: readonly string[]): Sample {
  const known = ["layer", "ice", "ground_albedo", "angle_deg", "illuminant", "observer", ...others];
  for (const key of given.keys()) {
    if (!known.includes(key)) throw new Error(`'${key}' is not known`);
  }
  const layers = given.getAll("layer");
  atMost("layers", layers.length, MOST_LAYERS);
  if (layers.length > 0) into.layers = layers.map(layer);
  const ice = given.get("ice");
  if (ice !== null) {
    const table = word("ice", ice, ICE_TABLES);
    for (const one of into.layers) one.ice = table;
  }
  const ground = given.get("ground_albedo");
  if (ground !== null) {
    into.ground_albedo = inside("ground albedo", number("ground_albedo", ground), parameters.ground_albedo);
  }
  const angle = given.get("angle_deg");
  if (angle === "diffuse") into.angle_deg = angle;
  else if (angle !== null) into.angle_deg = inside("angle", number("angle_deg", angle), parameters.angle_deg);
  into.illuminant = word("illuminant", given.get("illuminant") ?? into.illuminant, illuminants);
  into.observer = word("observer", given.get("observer") ?? into.observer, OBSERVERS);
  return into;
}

function layerText(layer: Layer): string {
  return [...entries(layer), ...amounts(layer)].map(([key, value]) => `${key}:${[value].flat().join("~")}`).join(",");
}

function layer(text: string): Layer {
  const made: Layer = { thickness_cm: parameters.thickness_cm.default };
  for (const entry of text.split(",")) {
    const at = entry.indexOf(":");
    const [key, value] = [entry.slice(0, at), entry.slice(at + 1)];
    if (key === "size_measure") {
      made.size_measure = word(key, value, SIZE_MEASURES);
      continue;
    }
    const name = LAYER_NUMBERS.find((known) => known === key);
    if (name !== undefined) {
      const values = numbers(key, value.split("~"), COUNTS[name] ?? [1]);
      // The deviation of a distribution, its last number, has no range here; the engine checks it.
      for (const one of values.slice(0, 3)) inside(parameters[name].quantity, one, parameters[name]);
      Object.assign(made, { [key]: values.length === 1 ? values[0] : values });
    } else if (impurities.some(({ name }) => name === key)) {
      const amount = inside(key, number(key, value), parameters.impurities_ng_g);
      made.impurities_ng_g = { ...made.impurities_ng_g, [key]: amount };
    } else {
      throw new Error(`'${key}' is not known of a layer`);
    }
  }
  if (made.ssa_m2_kg !== undefined && made.grain_size_um !== undefined) {
    throw new Error("a layer has a grain size or a specific surface area, not both");
  }
  return made;
}

function lampText({ position, illuminant, radiant_intensity_w_sr }: Lamp): string {
  return [...position.map(rounded), illuminant, rounded(radiant_intensity_w_sr)].join(",");
}

function lamp(text: string): Lamp {
  const parts = text.split(",");
  if (parts.length !== 5) throw new Error("a lamp has a position of three numbers, an illuminant and a strength");
  const [strength, ...position] = numbers("lamp", [parts[4]!, ...parts.slice(0, 3)], [4]);
  return {
    position: position.map((one) => inside("position", one, METRES)) as Vector,
    illuminant: word("illuminant", parts[3]!, illuminants),
    radiant_intensity_w_sr: inside("strength", strength!, STRENGTH),
  };
}

function sky(text: string): Sky {
  const [type, ...rest] = text.split(",");
  if (type === "overcast") {
    const [elevation] = numbers("sky", rest, [1]);
    return { type, elevation_deg: inside("sun elevation", elevation!, parameters.elevation_deg) };
  }
  if (type !== "clear") throw new Error(`'${type}' is not known for sky`);
  const [elevation, azimuth, turbidity] = numbers("sky", rest, [3]);
  return {
    type,
    elevation_deg: inside("sun elevation", elevation!, parameters.elevation_deg),
    azimuth_deg: inside("sun azimuth", azimuth!, SUN_AZIMUTH),
    turbidity: inside("turbidity", turbidity!, parameters.turbidity),
  };
}

function mesh(text: string): MeshPlace {
  const [name, scale, length, packed] = text.split(",");
  if (!/^[\w.-]+\.(ply|obj|stl|glb)$/i.test(name!) || !packed) {
    throw new Error("a mesh has the name of a file, a unit, a length and its content");
  }
  return {
    name: name!, packed, scale: inside("unit of the mesh", number("mesh", scale!), UNIT),
    length: number("mesh", length ?? ""),
  };
}

function cameraText({ azimuth_deg, elevation_deg, distance_m }: Camera): string {
  return [azimuth_deg, elevation_deg, distance_m].map(rounded).join(",");
}

function exposure(text: string | null): number | "auto" {
  return text === null || text === "auto" ? "auto" : inside("exposure", number("exposure", text), parameters.exposure);
}

function pairsOf(fragment: string): URLSearchParams {
  return new URLSearchParams(fragment.replaceAll("+", "%2B"));
}

function join(pairs: (readonly [string, string])[]): string {
  return pairs.map(([key, value]) => `${key}=${encodeURIComponent(value).replace(/%(2C|3A|7E)/g, decodeURIComponent)}`)
    .join("&");
}

function rounded(value: number): number {
  return Number(value.toPrecision(4));
}

function number(key: string, text: string): number {
  return numbers(key, [text], [1])[0]!;
}

function numbers(key: string, texts: string[], counts: readonly number[]): number[] {
  const values = texts.map((text) => (text.trim() === "" ? NaN : Number(text)));
  if (!counts.includes(values.length) || !values.every(Number.isFinite)) {
    throw new Error(`'${texts.join(", ")}' is not ${counts[0] === 1 ? "a number" : `${counts[0]} numbers`} for ${key}`);
  }
  return values;
}

function inside(quantity: string, value: number, range: Parameters<typeof outside>[2]): number {
  const reason = outside(quantity, value, range);
  if (reason !== undefined) throw new Error(reason);
  return value;
}

function word<Word extends string>(key: string, text: string, known: readonly Word[]): Word {
  const found = known.find((one) => one === text);
  if (found === undefined) throw new Error(`'${text}' is not known for ${key}`);
  return found;
}

function atMost(what: string, count: number, most: number): void {
  if (count > most) throw new Error(`there are ${count} ${what}, but at most ${most} are possible`);
}
