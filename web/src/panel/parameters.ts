/** The number controls: their limits and texts, and how their sliders divide. */

import { parameters, type Impurity, type ParameterKey } from "../catalog";
import type { Range } from "../native";

interface Slider {
  /** Ends of the slider, where they differ from those of the range. */
  slider?: readonly [number, number];
  /** How the slider's way divides: evenly, by equal factors, or finer towards zero. */
  scale: "linear" | "log" | "cubic";
  /** Of a linear slider. */
  step?: number;
}

export interface Control extends Slider {
  label: string;
  /** As in the messages of the command. */
  quantity: string;
  range: Range;
  sentence: string;
  source: string;
}

export function control(key: ParameterKey, slider: Slider): Control {
  const { title, quantity, text, effect, source, ...range } = parameters[key];
  return { label: title, quantity, range, sentence: `${text}. ${effect}`, source, ...slider };
}

export const THICKNESS = control("thickness_cm", { slider: [0.1, 300], scale: "log" });
export const GRAIN_SIZE = control("grain_size_um", { scale: "log" });
export const SURFACE_AREA = control("ssa_m2_kg", { scale: "log" });
export const DENSITY = control("density_kg_m3", { scale: "linear", step: 5 });
export const FACETNESS = control("facetness", { scale: "linear", step: 0.01 });
export const SPHERICITY = control("sphericity", { scale: "linear", step: 0.01 });
export const WATER = control("water_saturation", { scale: "linear", step: 0.01 });
export const TEMPERATURE = control("temperature_c", { scale: "linear", step: 1 });
export const ANGLE = control("angle_deg", { scale: "linear", step: 1 });
export const GROUND = control("ground_albedo", { scale: "linear", step: 0.01 });

export function impurityControl({ name, text, source }: Impurity): Control {
  const words = name.replaceAll("-", " ");
  const slider = [0, name === "black-carbon" ? 1e3 : 1e5] as const;
  return {
    ...control("impurities_ng_g", { slider, scale: "cubic" }),
    label: words[0]!.toUpperCase() + words.slice(1), quantity: words, sentence: text, source,
  };
}
