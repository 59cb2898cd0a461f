/** What tests see of the view, as `window.__snowblue`. */

import type { Camera, Vector } from "../state";
import type { FieldClient } from "./field-client";
import type { Probed } from "./field-messages";
import type { Place } from "./probe";
import type { SnowCanvas } from "./snow-canvas";

export interface TestHook {
  /** Frames drawn so far. */
  readonly frames: number;
  /** Is kept once the fine light field of the present state is shown. */
  readonly ready: Promise<void>;
  /** Radiance of pixels of the canvas as linear sRGB with alpha, rows from above. */
  readPixels(x: number, y: number, width: number, height: number): Float32Array;
  /** The light at a place of the view, 0 to 1 from the left and from above. */
  probe(place: Place): Promise<Probed>;
  /** Frames in a second while the camera turns. */
  measureFrames(count: number): number;
  /**
   * Calls for drawing and triangles of a frame, unknowns of the field, ms from a move to the coarse light, and the
   * exposure in stops.
   */
  readonly figures: { calls: number; triangles: number; nodes: number; latency_ms: number; stops: number };
}

declare global {
  interface Window {
    __snowblue?: TestHook;
  }
}

/** The parts of a view. */
interface Parts {
  canvas(): SnowCanvas;
  field: FieldClient;
  stops(): number;
  ready(): Promise<void>;
  probe(place: Place): Promise<Probed>;
  camera(): Camera;
  target(): Vector;
}

export function testHook({ canvas, field, stops, ready, probe, camera, target }: Parts): TestHook {
  return {
    get frames() {
      return canvas().frames;
    },
    get ready() {
      return ready();
    },
    readPixels: (x, y, width, height) => canvas().readPixels(x, y, width, height),
    probe,
    measureFrames(count) {
      const start = performance.now();
      for (let frame = 0; frame < count; frame++) {
        canvas().aim({ ...camera(), azimuth_deg: camera().azimuth_deg + 1 }, target());
        canvas().finish();
      }
      canvas().aim(camera(), target());
      return (1e3 * count) / (performance.now() - start);
    },
    get figures() {
      const { best, latency_ms } = field;
      return { ...canvas().work, nodes: best?.nodes ?? 0, latency_ms, stops: stops() };
    },
  };
}
