/** What the view and the workers of files say to each other. */

import type { Vector } from "../state";
import type { MeshFile } from "./field-messages";

/** The light field of a scene, as a file. */
export interface FileRequest {
  scene: string;
  mesh: MeshFile | undefined;
}

export type FileAnswer = { bytes: Uint8Array<ArrayBuffer> } | { error: string };

/** A closed mesh with z upwards, in the unit of its file. */
export interface MeshInfo {
  triangles: number;
  least: Vector;
  lengths: Vector;
  /** Of holes that were filled. */
  open_edges: number;
  notes: string[];
}

export type MeshAnswer = { about: MeshInfo; obj: Uint8Array<ArrayBuffer> } | { error: string };
