/** Reads the triangles of a binary glTF 2.0 (ISO/IEC 12113:2022). */

import type { Triangles } from "./triangles";

const MAGIC = 0x46546c67;
const JSON_CHUNK = 0x4e4f534a;
const BINARY_CHUNK = 0x004e4942;
const FLOAT = 5126;
const UNSIGNED_INT = 5125;
const TRIANGLES = 4;

interface Accessor {
  bufferView?: number;
  byteOffset?: number;
  componentType: number;
  count: number;
  type: string;
  sparse?: unknown;
}

interface Primitive {
  attributes: Record<string, number>;
  indices?: number;
  mode?: number;
  extensions?: Record<string, unknown>;
}

interface Node {
  mesh?: number;
  children?: number[];
  matrix?: number[];
  translation?: number[];
  rotation?: number[];
  scale?: number[];
}

interface Gltf {
  scene?: number;
  scenes?: { nodes?: number[] }[];
  nodes?: Node[];
  meshes?: { primitives: Primitive[] }[];
  accessors?: Accessor[];
  bufferViews?: { buffer: number; byteOffset?: number; byteLength: number; byteStride?: number }[];
  extensionsRequired?: string[];
}

/** Column-major, as in glTF. */
type Matrix = number[];
const IDENTITY: Matrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

/** All triangles of the scene of a GLB file, with z upwards. Throws an error that says what is wrong. */
export function readGlb(file: ArrayBuffer): Triangles {
  const { gltf, binary } = chunks(file);
  const required = gltf.extensionsRequired ?? [];
  if (required.length > 0) throw new Error(`needs ${required.join(", ")}; export it without compression`);
  const positions: number[] = [];
  const triangles: number[] = [];
  const visit = (index: number, parent: Matrix, depth: number) => {
    const node = gltf.nodes?.[index];
    if (node === undefined || depth > 64) throw new Error("has a node that does not exist");
    const matrix = product(parent, localMatrix(node));
    const mesh = node.mesh === undefined ? undefined : gltf.meshes?.[node.mesh];
    for (const primitive of mesh?.primitives ?? []) {
      if ((primitive.mode ?? TRIANGLES) !== TRIANGLES) continue;
      const points = numbers(gltf, binary, primitive.attributes.POSITION, "VEC3");
      const count = points.length / 3;
      const corners =
        primitive.indices === undefined
          ? Array.from({ length: count }, (_, corner) => corner)
          : numbers(gltf, binary, primitive.indices, "SCALAR");
      const first = positions.length / 3;
      for (let at = 0; at < points.length; at += 3) {
        const [x, y, z] = transformed(matrix, points[at]!, points[at + 1]!, points[at + 2]!);
        positions.push(x, -z, y);
      }
      const isMirrored = determinant(matrix) < 0;
      for (let at = 0; at + 2 < corners.length; at += 3) {
        const [a, b, c] = [corners[at]!, corners[at + 1]!, corners[at + 2]!];
        if (Math.max(a, b, c) >= count) throw new Error("has a triangle with a vertex that does not exist");
        triangles.push(first + a, first + (isMirrored ? c : b), first + (isMirrored ? b : c));
      }
    }
    for (const child of node.children ?? []) visit(child, matrix, depth + 1);
  };
  for (const root of gltf.scenes?.[gltf.scene ?? 0]?.nodes ?? []) visit(root, IDENTITY, 0);
  return { positions: Float32Array.from(positions), triangles: Uint32Array.from(triangles) };
}

function chunks(file: ArrayBuffer): { gltf: Gltf; binary: DataView } {
  const view = new DataView(file);
  if (view.byteLength < 20 || view.getUint32(0, true) !== MAGIC || view.getUint32(4, true) !== 2) {
    throw new Error("is not a binary glTF 2.0");
  }
  let gltf: Gltf | undefined;
  let binary = new DataView(new ArrayBuffer(0));
  for (let at = 12; at + 8 <= view.byteLength; ) {
    const [length, kind] = [view.getUint32(at, true), view.getUint32(at + 4, true)];
    if (at + 8 + length > view.byteLength) throw new Error("ends too early");
    if (kind === JSON_CHUNK) gltf = JSON.parse(new TextDecoder().decode(new Uint8Array(file, at + 8, length))) as Gltf;
    if (kind === BINARY_CHUNK) binary = new DataView(file, at + 8, length);
    at += 8 + length;
  }
  if (gltf === undefined) throw new Error("has no description");
  return { gltf, binary };
}

const READERS: Record<number, [number, (view: DataView, at: number) => number]> = {
  5121: [1, (view, at) => view.getUint8(at)],
  5123: [2, (view, at) => view.getUint16(at, true)],
  [UNSIGNED_INT]: [4, (view, at) => view.getUint32(at, true)],
  [FLOAT]: [4, (view, at) => view.getFloat32(at, true)],
};

function numbers(gltf: Gltf, binary: DataView, index: number | undefined, type: "VEC3" | "SCALAR"): number[] {
  const accessor = index === undefined ? undefined : gltf.accessors?.[index];
  const buffer = accessor?.bufferView === undefined ? undefined : gltf.bufferViews?.[accessor.bufferView];
  const reader = accessor && READERS[accessor.componentType];
  const isPlain = accessor?.type === type && accessor.sparse === undefined && buffer?.buffer === 0;
  if (!isPlain || !reader) {
    throw new Error("stores its triangles in a form that is not supported");
  }
  const [bytes, read] = reader;
  const size = type === "VEC3" ? 3 : 1;
  const stride = buffer.byteStride ?? size * bytes;
  const start = (buffer.byteOffset ?? 0) + (accessor.byteOffset ?? 0);
  if (start + (accessor.count - 1) * stride + size * bytes > binary.byteLength) throw new Error("ends too early");
  return Array.from({ length: accessor.count * size }, (_, number) =>
    read(binary, start + Math.floor(number / size) * stride + (number % size) * bytes),
  );
}

function localMatrix({ matrix, translation = [0, 0, 0], rotation = [0, 0, 0, 1], scale = [1, 1, 1] }: Node): Matrix {
  if (matrix !== undefined) return matrix;
  const [x, y, z, w] = rotation as [number, number, number, number];
  const [sx, sy, sz] = scale as [number, number, number];
  return [
    sx * (1 - 2 * (y * y + z * z)), sx * 2 * (x * y + z * w), sx * 2 * (x * z - y * w), 0,
    sy * 2 * (x * y - z * w), sy * (1 - 2 * (x * x + z * z)), sy * 2 * (y * z + x * w), 0,
    sz * 2 * (x * z + y * w), sz * 2 * (y * z - x * w), sz * (1 - 2 * (x * x + y * y)), 0,
    ...translation, 1,
  ];
}

function product(one: Matrix, other: Matrix): Matrix {
  return one.map((_, place) => {
    const [row, column] = [place % 4, Math.floor(place / 4)];
    return [0, 1, 2, 3].reduce((sum, k) => sum + one[4 * k + row]! * other[4 * column + k]!, 0);
  });
}

function transformed(m: Matrix, x: number, y: number, z: number): [number, number, number] {
  const row = (axis: number) => m[axis]! * x + m[4 + axis]! * y + m[8 + axis]! * z + m[12 + axis]!;
  return [row(0), row(1), row(2)];
}

function determinant(matrix: Matrix): number {
  const [a, b, c, , d, e, f, , g, h, i] = matrix as [
    number, number, number, number, number, number, number, number, number, number, number,
  ];
  return a * (e * i - f * h) - d * (b * i - c * h) + g * (b * f - c * e);
}
