/** Names, limits, texts and defaults of all parameters, as the engine states them. */

import catalog from "virtual:catalog";
import type { Parameter } from "./native";

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
}

export interface Catalog {
  version: string;
  illuminants: string[];
  kinds: Kind[];
  impurities: Impurity[];
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

export type ParameterKey =
  | "grain_size_um"
  | "ssa_m2_kg"
  | "facetness"
  | "sphericity"
  | "density_kg_m3"
  | "water_saturation"
  | "temperature_c"
  | "impurities_ng_g"
  | "thickness_cm"
  | "angle_deg"
  | "ground_albedo"
  | "exposure"
  | "elevation_deg"
  | "turbidity";

export const {
  version, illuminants, kinds, impurities, parameters, spreads, wavelengthColors, primaryLuminances, clearIce,
  sunlight,
} = catalog;
