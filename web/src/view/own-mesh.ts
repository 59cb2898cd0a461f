/** A visitor's mesh: read, freed of doubled vertices, and put on the ground. */

import type { Triangles } from "./triangles";
import { readGlb } from "./glb";

const MOST_MIB = 64;
const MOST_TRIANGLES = 200_000;
/** Sizes in m that are kept as they are, and the size of all others. */
const KEPT_SIZES_M = [0.05, 1] as const;
const SIZE_M = 0.4;

/** A mesh in metres with z upwards that stands on the ground about the origin. */
export interface OwnMesh {
  name: string;
  triangles: Triangles;
  height_m: number;
  /** Greatest of its lengths along the axes. */
  size_m: number;
  /** Factor from the units of the file, if the mesh was scaled. */
  factor: number | undefined;
}

/** Throws an error of one clear sentence if the file cannot be used. */
export async function readMesh(file: File): Promise<OwnMesh> {
  const extension = /\.(ply|glb)$/i.exec(file.name)?.[1]?.toLowerCase();
  if (extension === undefined) throw new Error(`${file.name} is neither a PLY nor a GLB file.`);
  if (file.size > MOST_MIB * 2 ** 20) throw new Error(`${file.name} is larger than ${MOST_MIB} MiB.`);
  let read: Triangles;
  try {
    const bytes = await file.arrayBuffer();
    read = extension === "glb" ? readGlb(bytes) : (await import("./ply")).readPly(bytes);
  } catch (error) {
    throw new Error(`${file.name} cannot be read: it ${reason(error)}.`);
  }
  const count = read.triangles.length / 3;
  if (count < 4) throw new Error(`${file.name} has ${count} triangles; a solid has four at least.`);
  if (count > MOST_TRIANGLES) {
    throw new Error(`${file.name} has ${count} triangles; there may be ${MOST_TRIANGLES}.`);
  }
  if (!read.positions.every(Number.isFinite)) throw new Error(`${file.name} has a vertex that is no number.`);
  return placed(file.name.replace(/\.\w+$/, ""), welded(read));
}

function reason(error: unknown): string {
  if (error instanceof SyntaxError || error instanceof RangeError || error instanceof TypeError) return "is broken";
  return error instanceof Error ? error.message : "is broken";
}

/** Vertices at the same position become one, so that shading is smooth across the seams of textures. */
function welded({ positions, triangles }: Triangles): Triangles {
  const numbers = new Map<string, number>();
  const kept: number[] = [];
  const vertices = Array.from({ length: positions.length / 3 }, (_, vertex) => {
    const place = positions.subarray(3 * vertex, 3 * vertex + 3);
    const key = place.join();
    const known = numbers.get(key);
    if (known !== undefined) return known;
    numbers.set(key, kept.length / 3);
    kept.push(...place);
    return kept.length / 3 - 1;
  });
  const corners: number[] = [];
  for (let at = 0; at < triangles.length; at += 3) {
    const [a, b, c] = [0, 1, 2].map((corner) => vertices[triangles[at + corner]!]!) as [number, number, number];
    if (a !== b && b !== c && c !== a) corners.push(a, b, c);
  }
  return { positions: Float32Array.from(kept), triangles: Uint32Array.from(corners) };
}

function placed(name: string, { positions, triangles }: Triangles): OwnMesh {
  const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  positions.forEach((value, place) => {
    low[place % 3] = Math.min(low[place % 3]!, value);
    high[place % 3] = Math.max(high[place % 3]!, value);
  });
  const lengths = low.map((least, axis) => high[axis]! - least);
  const size = Math.max(...lengths);
  const isKept = size >= KEPT_SIZES_M[0] && size <= KEPT_SIZES_M[1];
  const factor = isKept ? 1 : SIZE_M / size;
  const origin = [0.5 * (low[0]! + high[0]!), 0.5 * (low[1]! + high[1]!), low[2]!];
  const moved = positions.map((value, place) => factor * (value - origin[place % 3]!));
  // A solid that is inside out is turned.
  const isInsideOut = volume(moved, triangles) < 0;
  const turned = isInsideOut ? triangles.slice().reverse() : triangles;
  return {
    name,
    triangles: { positions: moved, triangles: turned },
    height_m: Number((factor * lengths[2]!).toFixed(4)),
    size_m: factor * size,
    factor: isKept ? undefined : factor,
  };
}

function volume(positions: Float32Array, triangles: Uint32Array): number {
  let sum = 0;
  for (let at = 0; at < triangles.length; at += 3) {
    const corner = (number: number) => positions.subarray(3 * triangles[at + number]!, 3 * triangles[at + number]! + 3);
    const [a, b, c] = [corner(0), corner(1), corner(2)] as unknown as [number[], number[], number[]];
    sum += a[0]! * (b[1]! * c[2]! - b[2]! * c[1]!) + a[1]! * (b[2]! * c[0]! - b[0]! * c[2]!) +
      a[2]! * (b[0]! * c[1]! - b[1]! * c[0]!);
  }
  return sum / 6;
}
