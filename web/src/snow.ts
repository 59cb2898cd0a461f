/** The values of a layer as the controls show them, and what they mean as keys of a layer. */

import { impurities, parameters, properties, spreads, type NumberKey, type SpreadKey } from "./catalog";
import type { Layer } from "./state";

/** A distribution about a mean within mean ± half-width, cut at the ends of its range. */
export interface Spread {
  mean: number;
  half_width: number;
  /** Of the normal distribution before it is cut; a grain size has none. */
  deviation: number;
}

/** The spread that a plain mean has, or that of the default sphericity. */
function defaultSpread(key: SpreadKey): Omit<Spread, "mean"> {
  const { half_width, deviation } = spreads[key];
  return { half_width: tidy(half_width), deviation };
}

export function spread(layer: Layer, key: SpreadKey): Spread {
  const value = layer[key] ?? parameters[key].default;
  if (typeof value === "number") {
    return key === "sphericity" && layer[key] !== undefined
      ? { mean: value, half_width: 0, deviation: defaultSpread(key).deviation }
      : { mean: value, ...defaultSpread(key) };
  }
  const [least, greatest, mean = (least! + greatest!) / 2, deviation = 0] = value;
  return { mean, half_width: tidy(Math.max(greatest! - mean, mean - least!)), deviation };
}

export function setSpread(layer: Layer, key: SpreadKey, { mean, half_width, deviation }: Spread): void {
  const { least, greatest, default: usual } = parameters[key];
  const plain = defaultSpread(key);
  const isPlain = half_width === plain.half_width && deviation === plain.deviation;
  if (isPlain && mean === usual) {
    delete layer[key];
  } else if (key === "grain_size_um") {
    layer[key] = isPlain ? mean : [tidy(mean - half_width), tidy(mean + half_width)];
  } else if (key === "sphericity" && half_width === 0) {
    layer[key] = mean;
  } else if (key === "facetness" && isPlain) {
    layer[key] = mean;
  } else {
    const ends = [Math.max(least, tidy(mean - half_width)), Math.min(greatest, tidy(mean + half_width))];
    layer[key] = [...ends, mean, deviation];
  }
}

/** Keys of a layer that are single numbers with a default. */
export type PlainKey = Exclude<NumberKey, SpreadKey | "ssa_m2_kg">;

export function plain(layer: Layer, key: PlainKey): number {
  return layer[key] ?? parameters[key].default;
}

export function setPlain(layer: Layer, key: PlainKey, value: number): void {
  if (value === parameters[key].default) delete layer[key];
  else layer[key] = value;
}

export function impurity(layer: Layer, name: string): number {
  return layer.impurities_ng_g?.[name] ?? 0;
}

export function setImpurity(layer: Layer, name: string, value: number): void {
  const amounts = { ...layer.impurities_ng_g };
  if (value === 0) delete amounts[name];
  else amounts[name] = value;
  if (Object.keys(amounts).length === 0) delete layer.impurities_ng_g;
  else layer.impurities_ng_g = amounts;
}

const ORDER = [
  "thickness_cm",
  ...properties.flatMap(({ key }) => (key === "grain_size_um" ? [key, "size_measure"] as const : [key])),
] as const satisfies (keyof Layer)[];

/** The keys of a layer that are set, in one order, without its impurities and the table of ice. */
export function entries(layer: Layer): [string, string | number | number[]][] {
  return ORDER.flatMap((key) => (layer[key] === undefined ? [] : [[key, layer[key]]]));
}

/** The impurities of a layer, in one order. */
export function amounts({ impurities_ng_g = {} }: Layer): [string, number][] {
  return impurities.flatMap(({ name }) => (impurities_ng_g[name] === undefined ? [] : [[name, impurities_ng_g[name]]]));
}

/** A number without the rounding of a sum. */
function tidy(value: number): number {
  return Number(value.toPrecision(10));
}
