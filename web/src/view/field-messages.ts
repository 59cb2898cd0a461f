/** What the view and the worker `field` say to each other. */

/** A mesh file under the name that a scene has for it. */
export interface MeshFile {
  name: string;
  bytes: Uint8Array<ArrayBuffer>;
}

export interface FieldRequest {
  version: number;
  /** Differs between bodies, snows and sizes of cells. */
  bodyKey: string;
  scene: string;
  mesh: MeshFile | undefined;
  /** Rays through grains for the optics of the snow, if not the default. */
  grain_rays: number | undefined;
  /** Greatest distance of vertices in cells, if not the default. */
  cells_per_edge: number | undefined;
  /** JSON of lights, and by what each is multiplied. */
  lights: string[];
  strengths: number[];
}

/** A question for the light that leaves the snow where a ray meets it, towards the origin of the ray. */
export interface ProbeRequest {
  probe: number;
  bodyKey: string;
  /** Origin and direction. */
  ray: number[];
  strengths: number[];
  /** Of the picture: the factor of its light, and its tone curve by name. */
  exposure: number;
  tone: string;
}

/** The answer of `LightField.probe`. */
export interface ProbedLight {
  wavelengths_nm: number[];
  /** In W/(m² sr) as a band density. */
  radiance: number[];
  /** Its colour, and that of the picture from 0 to 255. */
  linear_rgb: Rgb;
  srgb: Rgb;
}

/** An object's surface; see `LightField` of the module `scene`. */
export interface SurfaceGeometry {
  positions: Float32Array;
  normals: Float32Array;
  triangles: Uint32Array;
  escape: number[];
}

/** J and V (four values) and H (three values) at each vertex of an object, and V F (three values) of a sky. */
export interface LightOnObject {
  flux: Float32Array;
  irradiance: Float32Array;
  sky: Float32Array;
}

export type Rgb = [number, number, number];

/** The light at a place: undefined beside the snow, and null while it is not known. */
export type Probed = ProbedLight | undefined | null;

export type FieldAnswer =
  | {
      kind: "body";
      version: number;
      bodyKey: string;
      objects: SurfaceGeometry[];
      reflection: Float32Array;
      nodes: number;
    }
  | {
      kind: "light";
      version: number;
      bodyKey: string;
      /** The place of the light among those of the request. */
      light: number;
      json: string;
      objects: LightOnObject[];
      rgb: Rgb;
      /** Radiance of a sky from each of the directions `DOME_DIRECTIONS`. */
      dome: Float32Array;
      milliseconds: number;
      stops: number | undefined;
    }
  /** The automatic exposure of all lights. */
  | { kind: "exposure"; bodyKey: string; stops: number | undefined }
  | { kind: "probe"; probe: number; light: Probed }
  | { kind: "error"; version: number; text: string };
