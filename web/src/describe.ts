/** A sample in a few words. */

import { short } from "./numbers";
import { amounts, plain, spread } from "./snow";
import type { Layer, Sample } from "./state";

export function describe({ layers, angle_deg, ground_albedo, illuminant }: Sample): string {
  const [first] = layers;
  const total = short(layers.reduce((sum, { thickness_cm }) => sum + thickness_cm, 0));
  const words = layers.length === 1
    ? [`${total} cm`, ...describeLayer(first!)]
    : [`${layers.length} layers, ${total} cm`];
  if (angle_deg === "diffuse") words.push("diffuse light");
  else if (angle_deg !== 0) words.push(`${short(angle_deg)}°`);
  if (ground_albedo > 0) words.push(`ground ${short(ground_albedo)}`);
  if (illuminant !== "D65") words.push(illuminant);
  return words.join(", ");
}

function describeLayer(layer: Layer): string[] {
  const grains = layer.ssa_m2_kg === undefined
    ? `${short(spread(layer, "grain_size_um").mean)} µm`
    : `${short(layer.ssa_m2_kg)} m²/kg`;
  const words = [grains, `${short(plain(layer, "density_kg_m3"))} kg/m³`];
  const water = plain(layer, "water_saturation");
  if (water > 0) words.push(`${short(100 * water)} % water`);
  for (const [name, ng_g] of amounts(layer)) words.push(`${short(ng_g)} ng/g ${name.replaceAll("-", " ")}`);
  if (layer.ice === "picard2016") words.push("ice of Picard et al. 2016");
  return words;
}
