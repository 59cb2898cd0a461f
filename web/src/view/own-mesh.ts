/** A visitor's mesh: read, and put on the ground. */

import type { Triangles } from "./triangles";
import { readGlb } from "./glb";
import { readPly } from "./ply";

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
    read = extension === "glb" ? readGlb(bytes) : readPly(bytes);
  } catch (error) {
    throw new Error(`${file.name} cannot be read: it ${reason(error)}.`);
  }
  const count = read.triangles.length / 3;
  if (count < 4) throw new Error(`${file.name} has ${count} triangles; a solid has four at least.`);
  if (count > MOST_TRIANGLES) {
    throw new Error(`${file.name} has ${count} triangles; there may be ${MOST_TRIANGLES}.`);
  }
  if (!read.positions.every(Number.isFinite)) throw new Error(`${file.name} has a vertex that is no number.`);
  return placed(file.name.replace(/\.\w+$/, ""), read);
}

function reason(error: unknown): string {
  if (error instanceof SyntaxError || error instanceof RangeError || error instanceof TypeError) return "is broken";
  return error instanceof Error ? error.message : "is broken";
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
  return {
    name,
    triangles: { positions: moved, triangles },
    height_m: Number((factor * lengths[2]!).toFixed(4)),
    size_m: factor * size,
    factor: isKept ? undefined : factor,
  };
}
