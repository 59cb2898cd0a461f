/** The snow that the view shows: what scene files say of each shape, and where its camera and lamps are at first. */

import type { Shape, Vector, View } from "../state";
import type { MeshFile } from "./field-messages";
import type { MeshInfo } from "./file-messages";
import { drift } from "./drift";
import { sculpture } from "./sculpture";
import type { Triangles } from "./triangles";
import { wall } from "./wall";

/** A surface: keys of an `[[object]]` of a scene file without its material, and the mesh that they name. */
export interface Surface {
  object: Record<string, unknown>;
  mesh?: MeshFile;
}

/** A piece of snow. */
export interface Body extends Surface {
  /** The same surface with fewer vertices, for the coarse light field. */
  coarse?: Surface;
  /** What the camera looks at, in m. */
  target: [number, number, number];
}

/** Sizes of the cells of light fields. */
export type Size = "coarse" | "fine";

/** The surface of a body for light fields of a size of cells. */
export function surfaceOf(body: Body, size: Size): Surface {
  return size === "coarse" ? (body.coarse ?? body) : body;
}

/** Bodies of all shapes except `own`, each made once; of the block only the last. */
const made = new Map<Shape, Body>();
/** Thickness of the last block, in cm. */
let blockThickness_cm: number | undefined;

/** Thinnest and thickest block, in cm: thinner ones have no inside for the light field, and thicker ones no view. */
export const BLOCK_CM = { least: 2, greatest: 60 } as const;
/** The back of the block, towards its lamp, in m. The front moves with the thickness. */
const BLOCK_BACK_M = 0.14;

/** The thickness of the block for some snow. */
export function block_cm(snow_cm: number): number {
  return Math.min(Math.max(snow_cm, BLOCK_CM.least), BLOCK_CM.greatest);
}

/** The body of a shape. The block is as thick as the snow. */
export function body(shape: Exclude<Shape, "own">, snow_cm: number): Body {
  let one = made.get(shape);
  if (shape === "block") {
    const thickness_cm = block_cm(snow_cm);
    if (one === undefined || thickness_cm !== blockThickness_cm) one = block(thickness_cm);
    blockThickness_cm = thickness_cm;
  }
  one ??= MAKERS[shape as Exclude<Shape, "own" | "block">]();
  made.set(shape, one);
  return one;
}

/** The front of a block, towards the camera, in m. */
export function blockFront_m(thickness_cm: number): number {
  return metres(BLOCK_BACK_M - 0.01 * thickness_cm);
}

function metres(value: number): number {
  return Number(value.toFixed(6));
}

function block(thickness_cm: number): Body {
  const depth = metres(0.01 * thickness_cm);
  const middle = metres(BLOCK_BACK_M - 0.5 * depth);
  return { object: { shape: "box", size: [0.4, depth, 0.4], position: [0, middle, 0.2] }, target: [0, middle, 0.19] };
}

const MAKERS: Record<Exclude<Shape, "own" | "block">, () => Body> = {
  ball: () => ({
    object: { shape: "sphere", radius: 0.19, position: [0, 0, 0.19] },
    target: [0, 0, 0.19],
  }),
  igloo: () => ({
    ...meshSurface("igloo-wall", wall(10, 11)), target: [0, 0.02, 0.21],
    coarse: meshSurface("igloo-wall", wall(5, 6)),
  }),
  drift: () => ({
    object: drift(44),
    coarse: { object: drift(26) },
    target: [0, 0, 0.06],
  }),
  sculpture: () => ({
    ...meshSurface("sculpture", sculpture(36, 48)), target: [0, 0, 0.27],
    coarse: meshSurface("sculpture", sculpture(24, 33)),
  }),
};

/** Triangles as a Wavefront OBJ file: three coordinates of each vertex, three vertices of each triangle. */
function meshSurface(stem: string, { positions, triangles }: Triangles): Surface {
  const rows = (letter: string, values: number[]) =>
    values.flatMap((_, at) => (at % 3 === 0 ? [`${letter} ${values.slice(at, at + 3).join(" ")}\n`] : []));
  const text = [...rows("v", positions), ...rows("f", triangles.map((vertex) => vertex + 1))].join("");
  const name = `${stem}.obj`;
  return { object: { mesh: name, up: "z", smooth: true }, mesh: { name, bytes: new TextEncoder().encode(text) } };
}

/** The snow of a visitor's mesh, whose lengths are multiples of a scale in m. It stands on the ground. */
export function ownBody({ file, least, lengths }: MeshInfo & { file: MeshFile }, scale: number): Body {
  const [x, y, z] = least.map((from, axis) => metres(-scale * (from + (axis === 2 ? 0 : 0.5 * lengths[axis]!))));
  return {
    object: { mesh: file.name, up: "z", smooth: true, scale, position: [x, y, z] },
    mesh: file,
    target: [0, 0, metres(0.5 * scale * lengths[2])],
  };
}

/** Where the lamp of a shape is at first, and azimuth, elevation and distance of its camera. */
const PLACES: Record<Shape, { lamp: Vector; camera: Vector }> = {
  block: { lamp: [-0.05, 0.3, 0.24], camera: [32, 14, 1.25] },
  ball: { lamp: [0.08, 0.32, 0.28], camera: [0, 10, 1.1] },
  igloo: { lamp: [0.07, 0.44, 0.26], camera: [18, 10, 1.6] },
  drift: { lamp: [0, 0, 0], camera: [18, 24, 1.75] },
  sculpture: { lamp: [0.1, 0.34, 0.4], camera: [0, 12, 1.4] },
  own: { lamp: [0.1, 0.34, 0.4], camera: [0, 12, 1.4] },
};

/** Lamps and camera that suit a shape. */
export function defaults(shape: Shape): Pick<View, "lamps" | "camera"> {
  const { lamp, camera } = PLACES[shape];
  const [azimuth_deg, elevation_deg, distance_m] = camera;
  return {
    lamps: [{ position: [...lamp], illuminant: "D65", radiant_intensity_w_sr: 10 }],
    camera: { azimuth_deg, elevation_deg, distance_m },
  };
}
