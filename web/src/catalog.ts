/** Names, ranges and defaults of all parameters, as the engine states them. */

import catalog from "virtual:catalog";
import type { Range } from "./native";

export interface Kind {
  name: string;
  ssa_m2_kg: number;
  density_kg_m3: number;
  source: string;
}

export interface Impurity {
  name: string;
  source: string;
}

export interface Catalog {
  version: string;
  illuminants: string[];
  kinds: Kind[];
  impurities: Impurity[];
  ranges: Record<RangeKey, Range>;
}

export type RangeKey =
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
  | "ground_albedo";

export const { version, illuminants, kinds, impurities, ranges } = catalog;
