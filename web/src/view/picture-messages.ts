/** What the view and the worker `picture` say to each other. */

import type { MeshFile } from "./field-messages";

/** Starts a picture, or stops the present one if there is no scene. */
export interface PictureRequest {
  version: number;
  scene: string | undefined;
  mesh: MeshFile | undefined;
}

export type PictureAnswer =
  | {
      kind: "picture";
      version: number;
      width: number;
      height: number;
      pixels: Uint8ClampedArray<ArrayBuffer>;
      samples: number;
    }
  | { kind: "error"; version: number; text: string };
