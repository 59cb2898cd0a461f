/** The canvas of the view: snow, grid and lamps, drawn when something changed. */

import { FloatType, PerspectiveCamera, Raycaster, Scene, Vector3, WebGLRenderer, WebGLRenderTarget } from "three";
import { primaryLuminances } from "../catalog";
import type { View } from "../state";
import type { LitBody } from "./lit-body";
import { cameraPosition, verticalFieldOfView } from "./scene";
import { type Wanted, wantedOf } from "./lights";
import type { Output } from "./snow-material";
import { grid, LampMarks, SunMark } from "./surroundings";

const MOST_PIXELS = 2_000_000;
const MOST_PIXEL_RATIO = 2;
/** Pixels while something moves and frames are slow. */
const FEW_PIXELS = 250_000;
const SLOW_FRAME_MS = 50;
const REST_MS = 150;
/** The exposure comes near to a new one within this, and is that one within a step of so many stops. */
const EASE_MS = 150;
const EASE_STOPS = 0.02;
/** Columns and rows by which the view is metered. */
const FEW_PLACES = [48, 36] as const;

/** Behind the snow: a dark room with a grid on its ground, or the open land at dusk or by day. */
export type Backdrop = "dark" | "dusk" | "day";

export class SnowCanvas {
  readonly camera = new PerspectiveCamera();
  readonly element: HTMLCanvasElement;
  /** Frames so far. */
  frames = 0;
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly grid = grid();
  private readonly marks = new LampMarks();
  private readonly sun = new SunMark();
  private body: LitBody | undefined;
  private wanted: Wanted[] = [];
  /** A factor of radiance. The picture follows it smoothly as long as the snow is the same. */
  exposure = 1;
  private shown = 1;
  private isOther = true;
  private tone: Output = "filmic";
  private size = { width: 1, height: 1 };
  private frame = 0;
  private lastFrame = 0;
  private isSlow = false;
  private timer = 0;

  /** Throws if there is no WebGL 2. */
  constructor(private readonly drawn: () => void) {
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true, powerPreference: "high-performance" });
    this.element = this.renderer.domElement;
    this.element.className = "sb-field";
    this.element.addEventListener("webglcontextrestored", () => this.invalidate());
    this.camera.up.set(0, 0, 1);
    this.scene.add(this.grid, this.marks.group, this.sun.group);
  }

  resize(width: number, height: number): void {
    if (width === 0 || height === 0) return;
    this.size = { width, height };
    this.camera.fov = verticalFieldOfView(width, height);
    this.camera.aspect = width / height;
    this.camera.near = 0.01;
    this.camera.far = 30;
    this.camera.updateProjectionMatrix();
    this.sharpen();
  }

  aim(camera: View["camera"], target: readonly [number, number, number]): void {
    this.camera.position.set(...cameraPosition(camera, [...target]));
    this.camera.lookAt(new Vector3(...target));
    this.camera.updateMatrixWorld();
    this.invalidate();
  }

  /** The grid and the lines that measure are drawn in the dark room only. */
  setBackdrop(backdrop: Backdrop): void {
    const isMeasured = backdrop === "dark";
    this.grid.visible = isMeasured;
    this.marks.lines.visible = isMeasured;
    this.sun.lines.visible = isMeasured;
    this.invalidate();
  }

  /** From the eye through a place of the view, 0 to 1 from the left and from above: origin and direction. */
  rayThrough({ x, y }: { x: number; y: number }): number[] {
    const { ray } = new Raycaster();
    ray.origin.copy(this.camera.position);
    ray.direction.set(2 * x - 1, 1 - 2 * y, 0.5).unproject(this.camera).sub(ray.origin).normalize();
    return [...ray.origin, ...ray.direction];
  }

  /** Whether snow is between the eye and a place. */
  isBehindSnow(place: Vector3): boolean {
    if (this.body === undefined) return false;
    const eye = this.camera.position;
    const ray = new Raycaster(eye, place.clone().sub(eye).normalize(), 0, eye.distanceTo(place));
    return ray.intersectObject(this.body.group).length > 0;
  }

  /** Sets what is shown, and its tone curve. */
  show(
    body: LitBody | undefined,
    { lamps, sky }: Pick<View, "lamps" | "sky">,
    tone: Output,
  ): void {
    this.tone = tone;
    if (this.body !== body) {
      this.isOther ||= this.body?.number !== body?.number;
      if (this.body !== undefined) this.scene.remove(this.body.group);
      if (body !== undefined) this.scene.add(body.group);
      this.body = body;
    }
    this.wanted = wantedOf({ lamps, sky });
    this.marks.set(sky === undefined ? lamps : []);
    this.sun.set(sky);
    this.invalidate();
  }

  /** Draws soon. Slow frames have fewer pixels until nothing has moved for a while. */
  invalidate(): void {
    this.frame ||= requestAnimationFrame((now) => {
      this.frame = 0;
      const since = now - this.lastFrame;
      this.lastFrame = now;
      if (since > SLOW_FRAME_MS && since < 3 * REST_MS && !this.isSlow) {
        this.isSlow = true;
        this.setPixels(FEW_PIXELS);
      }
      if (this.isSlow) {
        clearTimeout(this.timer);
        this.timer = setTimeout(() => {
          this.isSlow = false;
          this.lastFrame = 0;
          this.sharpen();
        }, REST_MS);
      }
      this.draw(this.eased(since));
      this.drawn();
    });
  }

  /** The exposure after some time. */
  private eased(since_ms: number): number {
    const rest = Math.log2(this.exposure / this.shown);
    if (this.isOther || Math.abs(rest) < EASE_STOPS) {
      this.shown = this.exposure;
    } else {
      this.shown *= 2 ** (rest * (1 - Math.exp(-Math.min(since_ms, EASE_MS) / EASE_MS)));
      this.invalidate();
    }
    this.isOther = false;
    return this.shown;
  }

  /** Draws now, for a copy of the canvas. */
  draw(exposure = this.exposure): void {
    this.body?.show(this.wanted, exposure, this.tone);
    this.renderer.render(this.scene, this.camera);
    this.frames += 1;
  }

  /** Draws now and waits until the frame is done. */
  finish(): void {
    this.draw();
    const gl = this.renderer.getContext();
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
  }

  /** Calls for drawing and triangles of the last frame. */
  get work(): { calls: number; triangles: number } {
    const { calls, triangles } = this.renderer.info.render;
    return { calls, triangles };
  }

  /** Radiance in W/(m² sr) as linear sRGB of pixels of the canvas, from the upper left, four values each. */
  readPixels(x: number, y: number, width: number, height: number): Float32Array {
    const { width: columns, height: rows } = this.element;
    const upwards = this.radiance(columns, rows);
    const downwards = new Float32Array(4 * width * height);
    for (let row = 0; row < height; row++) {
      const from = 4 * ((rows - 1 - y - row) * columns + x);
      downwards.set(upwards.subarray(from, from + 4 * width), 4 * width * row);
    }
    return downwards;
  }

  /** Median luminance of the snow in view, in W/(m² sr); none without snow. */
  medianLuminance(): number | undefined {
    const pixels = this.radiance(...FEW_PLACES);
    const [redLuminance, greenLuminance, blueLuminance] = primaryLuminances;
    const luminances: number[] = [];
    for (let at = 0; at < pixels.length; at += 4) {
      const [red, green, blue, alpha] = pixels.subarray(at, at + 4) as unknown as [number, number, number, number];
      if (alpha === 1) luminances.push(redLuminance * red + greenLuminance * green + blueLuminance * blue);
    }
    return luminances.sort((one, other) => one - other)[luminances.length >> 1];
  }

  /** Radiance of the view in rows from below. */
  private radiance(columns: number, rows: number): Float32Array {
    const target = new WebGLRenderTarget(columns, rows, { type: FloatType });
    const hidden = [this.grid, this.marks.group, this.sun.group].filter(({ visible }) => visible);
    for (const one of hidden) one.visible = false;
    this.body?.show(this.wanted, this.exposure, "radiance");
    this.renderer.setRenderTarget(target);
    this.renderer.clear();
    this.renderer.render(this.scene, this.camera);
    const pixels = new Float32Array(4 * columns * rows);
    this.renderer.readRenderTargetPixels(target, 0, 0, columns, rows, pixels);
    this.renderer.setRenderTarget(null);
    for (const one of hidden) one.visible = true;
    target.dispose();
    return pixels;
  }

  dispose(): void {
    cancelAnimationFrame(this.frame);
    clearTimeout(this.timer);
    this.renderer.dispose();
    this.element.remove();
  }

  private sharpen(): void {
    this.setPixels(MOST_PIXELS);
    this.invalidate();
  }

  private setPixels(most: number): void {
    const { width, height } = this.size;
    const ratio = Math.min(window.devicePixelRatio, MOST_PIXEL_RATIO, Math.sqrt(most / (width * height)));
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
  }
}
