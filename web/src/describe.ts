/** A sample in a few words, which differ between samples that differ. */

import { parameters, type ParameterKey } from "./catalog";
import { minus, short, withUnit } from "./numbers";
import { amounts, entries, plain, spread } from "./snow";
import type { Layer, Sample, State } from "./state";
import { block_cm } from "./view/shapes";

export function describe({ layers, angle_deg, ground_albedo, illuminant, observer }: Sample): string {
  const [first] = layers;
  const total = short(layers.reduce((sum, { thickness_cm }) => sum + thickness_cm, 0));
  const words = layers.length === 1
    ? [`${total} cm`, ...describeSnow(first!)]
    : [`${layers.length} layers, ${total} cm: ${layers.map(describeLayer).join("; ")}`];
  if (first!.ice === "picard2016") words.push("ice of Picard et al. 2016");
  if (angle_deg === "diffuse") words.push("diffuse light");
  else if (angle_deg !== 0) words.push(`${short(angle_deg)}°`);
  if (ground_albedo > 0) words.push(`ground ${short(ground_albedo)}`);
  if (illuminant !== "D65") words.push(illuminant);
  if (observer !== "1931") words.push(`observer of ${observer}`);
  return words.join(", ");
}

/** What the view shows, whose snow is that of the first layer. */
export function describeView({ layers: [first], view }: State): string {
  const shape = {
    block: `Block of ${short(block_cm(first!.thickness_cm))} cm`, ball: "Ball of 38 cm",
    igloo: "Wall of an igloo", drift: "Drift", sculpture: "Sculpture", own: `Mesh ${view.mesh?.name}`,
  }[view.shape];
  const words = [...describeSnow(first!), view.sky === undefined ? "lamplight" : `${view.sky.type} sky`];
  if (view.method === "pcasnow") words.push("on the right PCASnow");
  if (view.method === "hybrid") words.push("on the right random walks");
  return `${shape}: ${words.join(", ")}`;
}

function describeLayer(layer: Layer): string {
  return [`${short(layer.thickness_cm)} cm`, ...describeSnow(layer)].join(", ");
}

/** Grains and density, and what else is not as by default. */
export function describeSnow(layer: Layer): string[] {
  const { grain_size_um, ssa_m2_kg } = layer;
  const size = grain_size_um ?? spread(layer, "grain_size_um").mean;
  const words = ssa_m2_kg === undefined ? [`${values(size)} µm`] : [`${values(ssa_m2_kg)} m²/kg`];
  if (layer.size_measure !== undefined) words[0] += ` ${layer.size_measure.replace("-", " ")}`;
  words.push(`${short(plain(layer, "density_kg_m3"))} kg/m³`);
  for (const [key, value] of entries(layer)) {
    if (NAMED.has(key) || typeof value === "string") continue;
    const { quantity, unit } = parameters[key as ParameterKey];
    words.push(withUnit(`${quantity} ${values(value)}`, unit));
  }
  for (const [name, ng_g] of amounts(layer)) words.push(`${short(ng_g)} ng/g ${name.replaceAll("-", " ")}`);
  return words;
}

const NAMED = new Set(["thickness_cm", "grain_size_um", "size_measure", "ssa_m2_kg", "density_kg_m3"]);

/** A number, or a distribution: its ends, and its mean and deviation if it has these. */
function values(value: number | number[]): string {
  const [least, ...others] = [value].flat().map((one) => minus(short(one)));
  const [greatest, mean, deviation] = others;
  const ends = greatest === undefined ? least! : `${least}–${greatest}`;
  return mean === undefined ? ends : `${ends} (mean ${mean}, deviation ${deviation})`;
}
