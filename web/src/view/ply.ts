/** Reads the triangles of a PLY file. */

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
