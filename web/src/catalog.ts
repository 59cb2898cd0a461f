/** Names, limits, texts and defaults of all parameters, as the engine states them. */

import catalog from "virtual:catalog";
import type { Parameter, Snow } from "./native";

export interface Kind {
  name: string;
  ssa_m2_kg: number;
  density_kg_m3: number;
  source: string;
}

export interface Impurity {
  name: string;
  text: string;
  source: string;
  /** Whether it takes many streams. */
  has_sharp_peak: boolean;
}

/** A property of snow that is a number. */
export interface Property {
  key: NumberKey;
  /** The key without its unit. */
  name: string;
}

export interface Catalog {
  version: string;
  illuminants: string[];
  kinds: Kind[];
  impurities: Impurity[];
  properties: Property[];
  parameters: Record<ParameterKey, Parameter>;
  spreads: Record<SpreadKey, { half_width: number; deviation: number }>;
  /** Colours of 400, 410, … 700 nm. */
  wavelengthColors: string[];
  /** Luminances of red, green and blue light of linear sRGB. */
  primaryLuminances: [number, number, number];
  /** Clear ice; absorption coefficients at 400, 410, … 700 nm. */
  clearIce: { density_kg_m3: number; absorption_per_m: number[] };
  /** The name of the spectrum of sunlight. */
  sunlight: string;
}

/** Keys whose values are distributions. */
export type SpreadKey = "grain_size_um" | "facetness" | "sphericity";

/** Keys of snow whose values are numbers. */
export type NumberKey = Exclude<keyof Snow, "snow" | "size_measure" | "impurities_ng_g" | "ice">;

export type ParameterKey =
  | NumberKey
  | "impurities_ng_g"
  | "thickness_cm"
  | "angle_deg"
  | "ground_albedo"
  | "exposure"
  | "elevation_deg"
  | "turbidity";

export const {
  version, illuminants, kinds, impurities, properties, parameters, spreads, wavelengthColors, primaryLuminances,
  clearIce, sunlight,
} = catalog;
