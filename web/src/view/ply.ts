/** PLY files of triangles. */

import { PLYLoader } from "three/addons/loaders/PLYLoader.js";
import type { Triangles } from "./triangles";

/** The triangles of a PLY file, whose axes are those of scenes. Throws an error that says what is wrong. */
export function readPly(file: ArrayBuffer): Triangles {
  const header = new TextDecoder().decode(new Uint8Array(file, 0, Math.min(file.byteLength, 1 << 16)));
  if (!/^ply\r?\n/.test(header) || !/\nend_header\r?\n/.test(header)) throw new Error("has no header of a PLY");
  const wanted = (element: string) => Number(new RegExp(`\\nelement ${element} (\\d+)`).exec(header)?.[1] ?? 0);
  const geometry = new PLYLoader().parse(file);
  const position = geometry.getAttribute("position");
  const index = geometry.getIndex();
  if (position === undefined || index === null || position.count < wanted("vertex")) {
    throw new Error("ends too early or has no triangles");
  }
  return { positions: Float32Array.from(position.array), triangles: Uint32Array.from(index.array) };
}

/** A binary PLY file. */
export function writePly({ positions, triangles }: Triangles): Blob {
  const header = [
    "ply",
    "format binary_little_endian 1.0",
    `element vertex ${positions.length / 3}`,
    ...["x", "y", "z"].map((axis) => `property float ${axis}`),
    `element face ${triangles.length / 3}`,
    "property list uchar uint vertex_indices",
    "end_header",
    "",
  ].join("\n");
  const faces = new DataView(new ArrayBuffer((13 * triangles.length) / 3));
  triangles.forEach((vertex, corner) => {
    const face = 13 * Math.floor(corner / 3);
    if (corner % 3 === 0) faces.setUint8(face, 3);
    faces.setUint32(face + 1 + 4 * (corner % 3), vertex, true);
  });
  return new Blob([header, positions.slice(), faces.buffer], { type: "model/ply" });
}
