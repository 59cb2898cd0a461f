/** What the view and the worker `files` say to each other. */

import type { NamedMesh } from "./field-messages";

/** The light field of a scene, or without one the mesh, as a file. */
export interface FileRequest {
  scene: string | undefined;
  mesh: NamedMesh | undefined;
}

export type FileAnswer = { bytes: Uint8Array<ArrayBuffer> } | { error: string };
