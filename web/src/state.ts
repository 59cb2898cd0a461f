/** All that a visitor sets: the sample, the view of it in 3-D, and what is pinned beside it. */

import type { Snow } from "./native";

export type Shape = "block" | "ball" | "igloo" | "drift" | "sculpture" | "own";
export type Method = "field" | "pcasnow" | "hybrid";
/** Wavelengths of the spectrum: 400–700 nm, or all of the model. */
export type Range = "visible" | "solar";
/** What is shown at depths. */
export type AtDepth = "down" | "fluence";
export type Vector = [number, number, number];
export type IceTable = NonNullable<Snow["ice"]>;

/** All shapes but the visitor's own. */
export const SHAPES: readonly Exclude<Shape, "own">[] = ["block", "ball", "igloo", "drift", "sculpture"];
export const METHODS: readonly Method[] = ["field", "pcasnow", "hybrid"];
export const RANGES: readonly Range[] = ["visible", "solar"];
export const AT_DEPTH: readonly AtDepth[] = ["down", "fluence"];

/** At most so many lamps in the view. */
export const MOST_LAMPS = 4;
/** At most so many samples pinned. */
export const MOST_PINNED = 4;
/** At most so many layers. */
export const MOST_LAYERS = 6;

export interface Lamp {
  /** In m, z up. */
  position: Vector;
  illuminant: string;
  radiant_intensity_w_sr: number;
}

/** A sky, clear with its sun or overcast. The elevation is that of the sun, also behind clouds. */
export type Sky =
  | { type: "clear"; elevation_deg: number; azimuth_deg: number; turbidity: number }
  | { type: "overcast"; elevation_deg: number };

export interface Camera {
  azimuth_deg: number;
  elevation_deg: number;
  distance_m: number;
}

/** A visitor's mesh in the view. */
export interface MeshPlace {
  /** The name of its file. */
  name: string;
  /** The unit of the file in m. */
  scale: number;
  /** Greatest length along an axis, in the unit of the file. */
  length: number;
  /** The file for links, packed; empty if it is too large for a link. */
  packed: string;
}

export interface View {
  shape: Shape;
  /** Of the shape `own`. */
  mesh?: MeshPlace | undefined;
  lamps: Lamp[];
  /** Shines instead of the lamps. */
  sky: Sky | undefined;
  method: Method;
  exposure: number | "auto";
  camera: Camera;
}

export type Layer = Snow & { thickness_cm: number };

/** Snow on a ground and the light on it: all that a spectrum and its colours depend on. */
export interface Sample {
  /** Top first. */
  layers: Layer[];
  ground_albedo: number;
  angle_deg: number | "diffuse";
  illuminant: string;
  observer: "1931" | "1964";
}

export interface State extends Sample {
  /** Of the swatches: stops, or "auto". */
  swatch_exposure: number | "auto";
  range: Range;
  at_depth: AtDepth;
  view: View;
  pinned: Sample[];
}

/** The sample alone, without the view and the pins. */
export function sampleOf(state: Sample): Sample {
  const { layers, ground_albedo, angle_deg, illuminant, observer } = state;
  return structuredClone({ layers, ground_albedo, angle_deg, illuminant, observer });
}
