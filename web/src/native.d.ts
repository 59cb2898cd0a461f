/** The JSON that functions of the module `spectrum` take and give. The build writes types into `web/wasm`. */

/** What is known of a snow: the keys of a layer in `snowblue spectrum --layers`. Missing keys have the defaults. */
export interface Snow {
  /** Kind of snow, one of `kinds()`. */
  snow?: string;
  /** A mean, or [least, greatest], in µm. */
  grain_size_um?: number | number[];
  size_measure?: "greatest-extension" | "volume-diameter" | "optical-diameter";
  /** Specific surface area in m²/kg, instead of a grain size. */
  ssa_m2_kg?: number;
  /** A mean, or [least, greatest, mean, standard deviation]. */
  facetness?: number | number[];
  sphericity?: number | number[];
  density_kg_m3?: number;
  /** Fraction of the pore volume. */
  water_saturation?: number;
  /** Mass fractions by the names of `impurities()`, in ng/g. */
  impurities_ng_g?: Record<string, number>;
  temperature_c?: number;
  ice?: "warren2008" | "picard2016";
}

/** Snow on a ground and the light on it. */
export interface SampleRequest {
  /** Top first; one for a slab. */
  layers: (Snow & { thickness_cm: number })[];
  ground_albedo?: number;
  angle_deg: number | "diffuse";
  /** Rays through grains; fewer are faster. 16384 is coarse, 262144 (default) fine. */
  tally_rays?: number;
}

/** What `spectrum` computes. */
export interface SpectrumRequest {
  sample: SampleRequest;
  illuminant: string;
  observer: "1931" | "1964";
  /** Of the hex colours: stops, or "auto". */
  exposure: number | "auto";
  standard_errors?: boolean;
}

/** What `light_at_depth` computes. */
export interface DepthRequest {
  sample: SampleRequest;
  depths_cm: number[];
  wavelengths_nm: number[];
}

export type Measures = "reflectance" | "transmittance";

/** A file for `measured_curve`. */
export interface CurveFile {
  name: string;
  text: string;
  quantity: Measures;
}

export interface Curve {
  wavelengths_nm: number[];
  values: number[];
}

export interface MeasuredCurve extends Curve {
  /** Sentences on what of the file it is made of. */
  notes: string[];
}

/** What `difference_from` computes. */
export interface DifferenceRequest extends Curve {
  sample: SampleRequest;
  quantity: Measures;
  /** Wavelengths outside are left out. */
  first_nm: number;
  last_nm: number;
}

/** Measured − computed. */
export interface Difference {
  /** Number of wavelengths, and the first and the last of them. */
  count: number;
  first_nm: number;
  last_nm: number;
  root_mean_square: number;
  mean: number;
}

export interface Color {
  xyz: [number, number, number];
  lab: [number, number, number];
  linear_rgb: [number, number, number];
  /** As `#rrggbb`, mapped into sRGB. */
  hex: string;
}

/** Values at each wavelength. */
export interface Spectrum {
  wavelengths_nm: number[];
  reflectance: number[];
  transmittance: number[];
  absorptance: number[];
  /** With `standard_errors`. */
  reflectance_se?: number[];
  transmittance_se?: number[];
  absorptance_se?: number[];
}

export interface SpectrumAnswer extends Spectrum {
  /** By 31 wavelengths. */
  transmitted: Color;
  reflected: Color;
  /** By three wavelengths, and its difference ΔE*ab. */
  transmitted_3: Color;
  transmitted_3_delta_e: number;
}

/** Means over a band of sunlight. */
export interface Band {
  name: "solar" | "visible" | "near-infrared" | "par";
  first_nm: number;
  last_nm: number;
  full_sun: number;
  unit: string;
  reflectance: number;
  transmittance: number;
  absorptance: number;
}

/** The spectrum over all wavelengths of the model, and its means. */
export interface SunlightAnswer extends Spectrum {
  bands: Band[];
}

/** Fluxes over the incident flux at one wavelength, for each depth. */
export interface DepthProfile {
  wavelength_nm: number;
  down: number[];
  up: number[];
  fluence: number[];
  /** Of the snow below each depth. */
  e_folding_depth_cm: number[];
}

/** A range of a parameter and its default. */
export interface Range {
  least: number;
  greatest: number;
  default: number;
  unit: string;
}

/** What a parameter is, and what it does to the light. */
export interface Parameter extends Range {
  title: string;
  /** As in the messages of the command. */
  quantity: string;
  text: string;
  effect: string;
  source: string;
}
