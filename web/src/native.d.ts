/** The interfaces of the two WebAssembly modules. Both are made by `scripts/build-web` into `web/wasm`. */

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

/** The module `spectrum`. All functions throw an `Error` with one clear line for bad input. */
export interface SpectrumModule {
  default(module: { module_or_path: WebAssembly.Module | string | URL }): Promise<unknown>;
  version(): string;
  /** JSON of a `SpectrumRequest` in, of a `SpectrumAnswer` out. */
  spectrum(request: string): string;
  /** JSON of a `SampleRequest` in, of a `SunlightAnswer` out. */
  sunlight(request: string): string;
  /** The name of the spectrum of sunlight. */
  sunlight_name(): string;
  /** JSON of a `DepthRequest` in, of a `DepthProfile[]` out, one for each wavelength. */
  light_at_depth(request: string): string;
  /** JSON of a `CurveFile` in, of a `MeasuredCurve` out. */
  measured_curve(file: string): string;
  /** JSON of a `DifferenceRequest` in, of a `Difference` out. */
  difference_from(request: string): string;
  /** JSON: `string[]`. */
  illuminants(): string;
  /** JSON: `{ name: string, ssa_m2_kg: number, density_kg_m3: number, source: string }[]`. */
  kinds(): string;
  /** JSON: `{ name: string, text: string, source: string }[]`. */
  impurities(): string;
  /** JSON: `{ key: string, name: string }[]`, keys of `Snow` that are numbers and their names without units. */
  properties(): string;
  /**
   * JSON: `Record<string, Parameter>` by the keys of `Snow`, and `thickness_cm`, `angle_deg`, `ground_albedo`,
   * `exposure` and the sky's `elevation_deg` and `turbidity`.
   */
  parameters(): string;
  /** JSON: `Record<string, { half_width: number, deviation: number }>` of the default snow, by keys of `Snow`. */
  spreads(): string;
  /** JSON: colours of 400, 410, … 700 nm as `#rrggbb`. */
  wavelength_colors(): string;
  /** JSON: luminances of red, green and blue light of linear sRGB. */
  luminances(): string;
  /** JSON: `{ density_kg_m3: number, absorption_per_m: number[] }`, absorption at 400, 410, … 700 nm. */
  ice(): string;
  /**
   * GLSL of `vec3 display(vec3 colour)`, from linear sRGB to what a display gets, and of `vec3 filmic(vec3 light)`, the
   * tone curve before it.
   */
  display_shader(): string;
  /** ΔE*ab of the JSON `[[L, a, b], [L, a, b]]`. */
  delta_e(colors: string): number;
}

/**
 * The module `scene`. A scene is JSON with the keys of a scene file (docs/src/rendering.md; lengths in metres, z up).
 * Its meshes (`{ mesh: "NAME", material: "drift" }`) are files that were added under that name.
 */
export interface SceneModule {
  default(module: { module_or_path: WebAssembly.Module | string | URL }): Promise<unknown>;
  Files: new () => Files;
  LightField: new (
    scene: string,
    files: Files,
    grain_rays: number | undefined,
    cells_per_edge: number | undefined,
  ) => LightField;
  Picture: {
    new (scene: string, files: Files): Picture;
    /** A first picture of few pixels with a sample each, with coarse cells of snow, if there can be one. */
    coarse(scene: string, files: Files): Picture | undefined;
  };
  /** The GLB of `snowblue bake`. */
  bake_glb(scene: string, files: Files): Uint8Array<ArrayBuffer>;
}

/** The module `meshes`. */
export interface MeshesModule {
  default(module: { module_or_path: WebAssembly.Module }): Promise<unknown>;
  /** Reads a PLY, OBJ, STL or GLB file, and closes its holes. */
  closed_mesh(name: string, content: Uint8Array): {
    /** JSON of a `MeshInfo`. */
    about(): string;
    /** As a Wavefront OBJ file with z upwards. */
    obj(): Uint8Array<ArrayBuffer>;
  };
}

/** Files that a scene names: meshes are OBJ files. */
export interface Files {
  add(name: string, content: Uint8Array): void;
  free(): void;
}

/**
 * The light of lamps, the sun and a sky in all snow of a scene, each solved for on its own and kept at a place.
 * `light_field.nodes` of the scene is about the number of unknowns, `grain_rays` the number of rays through grains for
 * the optics of the snow, and `cells_per_edge` the greatest distance of vertices, by default two cells. A surface of
 * snow sends out
 *
 *     L = R0(mu, mu0, phi) V F + (H + K(mu) J) / pi,
 *
 * F the irradiance by the light, V its visibility, H the irradiance by other snow, J the net flux, K a polynomial.
 */
export interface LightField {
  /** Unknowns of a solution at each wavelength. */
  node_count(): number;
  /** Number of objects of snow, in the order of the scene. */
  object_count(): number;
  positions(object: number): Float32Array;
  normals(object: number): Float32Array;
  triangles(object: number): Uint32Array;
  /** Coefficients of 1, mu, mu², mu³. */
  escape_polynomial(object: number): Float32Array;
  /**
   * Table of (mu + mu0) R0 of n³ values, in 1/sr: the azimuth fastest, then the cosine of incidence, then of exit,
   * regular in sin(phi/2) and in the roots of the cosines, phi the angle between both directions of propagation.
   */
  reflection_table(n: number): Float32Array;
  /** Solves for a lamp, JSON of a table `[[light]]`, without any other. */
  light(place: number, lamp: string): void;
  /**
   * Solves for the sun of a sky or the sky without its sun, JSON of a table `[sky]`. A clear sky needs the files of its
   * coefficients.
   */
  light_sky(place: number, sky: string, is_sun: boolean, files: Files): void;
  /** The exposure of a view from any side, under the lights at the first places times some factors. */
  exposure_stops(factors: Float64Array): number | undefined;
  /**
   * The light that leaves the snow where a ray (origin and direction) meets it, towards its origin: JSON of a
   * `ProbedLight`, none beside the snow. `directions` are those of `sky_radiance`; the colour is that of a picture.
   */
  probe(
    ray: Float32Array,
    factors: Float64Array,
    directions: Float32Array,
    exposure: number,
    tone: string,
  ): string | undefined;
  /**
   * Radiance of the last sky from each direction (3 values each) as linear sRGB, in W/(m² sr) as renderings have it.
   */
  sky_radiance(directions: Float32Array): Float32Array;
  /**
   * J at each vertex as linear sRGB, in W/m² as renderings weight them, of the last light, and V, 0 to 1; 1 for a sky.
   */
  flux_and_visibility(object: number): Float32Array;
  /** H at each vertex (3 values), the same. */
  diffuse_irradiance(object: number): Float32Array;
  /** V F of a sky at each vertex, the same; empty for a lamp and the sun. */
  sky_irradiance(object: number): Float32Array;
  /** Linear sRGB of the radiant intensity of a lamp, or of the irradiance of a surface that faces the sun. */
  strength_rgb(): Float32Array;
  free(): void;
}

/** A picture of a scene by its integrator, which gets better with each sample. */
export interface Picture {
  width(): number;
  height(): number;
  /** Samples of each pixel so far. */
  samples(): number;
  /** Adds samples for about some milliseconds; returns `samples()`. */
  add(milliseconds: number): number;
  /** Pixels for the display, RGBA, 8 bits. */
  display(): Uint8ClampedArray;
  free(): void;
}
