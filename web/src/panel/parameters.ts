/** What the number controls are called, what they mean and where that comes from. */

import { ranges, type RangeKey } from "../catalog";
import type { Range } from "../native";

export interface Parameter {
  label: string;
  /** As in the messages of the command. */
  quantity: string;
  range: Range;
  /** Ends of the slider, where they differ from those of the range. */
  slider?: readonly [number, number];
  /** How the slider's way divides: evenly, by equal factors, or finer towards zero. */
  scale: "linear" | "log" | "cubic";
  /** Of a linear slider. */
  step?: number;
  sentence: string;
  source: string;
}

const PAPER = "Varsa & Baranoski 2024, doi:10.1109/MCG.2023.3307517";

function parameter(key: RangeKey, rest: Omit<Parameter, "range">): Parameter {
  return { range: ranges[key], ...rest };
}

export const THICKNESS = parameter("thickness_cm", {
  label: "Thickness",
  quantity: "thickness",
  slider: [0.1, 300],
  scale: "log",
  sentence: "Thicker snow transmits less light, and what remains is bluer.",
  source: PAPER,
});

export const GRAIN_SIZE = parameter("grain_size_um", {
  label: "Grain size",
  quantity: "grain size",
  scale: "log",
  sentence: "Coarse grains scatter less often and hold longer paths through ice, so the light gets deeper and bluer.",
  source: "Fierz et al. 2009, International Classification for Seasonal Snow on the Ground",
});

export const SURFACE_AREA = parameter("ssa_m2_kg", {
  label: "Specific surface area",
  quantity: "specific surface area",
  scale: "log",
  sentence: "The surface of the grains in a kilogram of snow; fine grains have more of it.",
  source: "Gallet et al. 2009, doi:10.5194/tc-3-167-2009",
});

export const DENSITY = parameter("density_kg_m3", {
  label: "Density",
  quantity: "density",
  scale: "linear",
  step: 5,
  sentence: "The mass of dry snow in a cubic metre; denser snow has more grains in the way of the light.",
  source: PAPER,
});

export const FACETNESS = parameter("facetness", {
  label: "Facetness",
  quantity: "facetness",
  scale: "linear",
  step: 0.01,
  sentence: "The roughness of the grains: 0 is smooth; rough grains scatter more light backwards.",
  source: PAPER,
});

export const SPHERICITY = parameter("sphericity", {
  label: "Sphericity",
  quantity: "sphericity",
  scale: "linear",
  step: 0.01,
  sentence: "Riley sphericity: 1 is a sphere, less is an elongated grain.",
  source: PAPER,
});

export const WATER = parameter("water_saturation", {
  label: "Water saturation",
  quantity: "water saturation",
  scale: "linear",
  step: 0.01,
  sentence: "The fraction of the pore volume filled with water, in which a grain deflects light far less.",
  source: "Röttgers et al. 2016, WOPP v3; Daimon & Masumura 2007, doi:10.1364/AO.46.003811",
});

export const TEMPERATURE = parameter("temperature_c", {
  label: "Temperature",
  quantity: "temperature",
  scale: "linear",
  step: 1,
  sentence: "It changes the density of ice, and nothing else, by 1 % over the whole range.",
  source: "snowblue, chapter Snow and its grains",
});

export const ANGLE = parameter("angle_deg", {
  label: "Angle of incidence",
  quantity: "angle",
  scale: "linear",
  step: 1,
  sentence: "The angle between a parallel beam and the normal of the surface; oblique light is reflected more.",
  source: PAPER,
});

export const GROUND = parameter("ground_albedo", {
  label: "Ground albedo",
  quantity: "ground albedo",
  scale: "linear",
  step: 0.01,
  sentence: "The fraction of light that a matt ground below the snow sends back; 0 is no ground.",
  source: "Stamnes et al. 1988, doi:10.1364/AO.27.002502",
});

/** What each impurity is. */
const IMPURITY_SENTENCES: Record<string, string> = {
  "black-carbon": "Uncoated soot; 10 ng/g absorb three times as much at 500 nm as the ice itself.",
  "brown-carbon": "Carbon of smouldering fires, which absorbs mostly blue light.",
  "saharan-dust": "Desert dust of 1.0–2.5 µm with a central share of haematite.",
  "colorado-dust": "Dust of 1.0–2.5 µm from the San Juan Mountains; it mostly scatters.",
  "snow-algae": "Red algae of 1 ng each, so that ng/g are cells per gram.",
};

export function impurityParameter(name: string, source: string): Parameter {
  const words = name.replaceAll("-", " ");
  return {
    label: words[0]!.toUpperCase() + words.slice(1),
    quantity: words,
    range: ranges.impurities_ng_g,
    slider: [0, name === "black-carbon" ? 1e3 : 1e5],
    scale: "cubic",
    sentence: IMPURITY_SENTENCES[name] ?? "",
    source,
  };
}
