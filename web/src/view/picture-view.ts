/** A traced picture beside the light field, on the right of a line that is dragged. */

import type { MeshFile } from "./field-messages";
import { sceneWorker } from "./native-scene";
import type { PictureAnswer, PictureRequest } from "./picture-messages";

/** Rest of camera and lamps before the picture starts, in ms. */
const REST_MS = 250;
const KEY_STEP = 0.05;
const LEAST_SHARE = 0.05;

/** A scene to be traced. */
export interface PictureInput {
  scene: string;
  mesh: MeshFile | undefined;
  /** Name of the method for the caption. */
  name: string;
}

export class PictureView {
  private readonly canvas = document.createElement("canvas");
  private readonly handle = document.createElement("div");
  private readonly left = document.createElement("p");
  private readonly right = document.createElement("p");
  private worker: Worker | undefined;
  private version = 0;
  private timer = 0;
  private input: PictureInput | undefined;
  private share = 0.5;

  constructor(
    private readonly layer: HTMLElement,
    private readonly error: (text: string) => void,
  ) {
    this.canvas.className = "sb-picture";
    this.canvas.setAttribute("aria-hidden", "true");
    this.left.className = this.right.className = "sb-caption";
    this.left.textContent = "Light field";
    this.handle.className = "sb-split";
    this.handle.tabIndex = 0;
    this.handle.setAttribute("role", "slider");
    this.handle.setAttribute("aria-label", "Share of the light field in the picture, in percent");
    this.handle.setAttribute("aria-valuemin", "5");
    this.handle.setAttribute("aria-valuemax", "95");
    this.handle.addEventListener("pointerdown", (event) => this.drag(event));
    this.handle.addEventListener("keydown", (event) => this.key(event));
    layer.append(this.canvas, this.left, this.right, this.handle);
    this.split(this.share);
    this.hide();
  }

  /** Traces a scene once it rests; nothing happens if it is the present one. Without one the picture is hidden. */
  set(input: PictureInput | undefined): void {
    if (input?.scene === this.input?.scene && input?.mesh?.bytes === this.input?.mesh?.bytes) return;
    this.input = input;
    this.version += 1;
    clearTimeout(this.timer);
    this.post({ version: this.version, scene: undefined, mesh: undefined });
    if (input === undefined) {
      this.hide();
      return;
    }
    for (const one of [this.left, this.right, this.handle]) one.hidden = false;
    this.canvas.hidden = true;
    this.right.textContent = input.name;
    this.worker ??= this.start();
    const { scene, mesh } = input;
    this.timer = setTimeout(() => this.post({ version: this.version, scene, mesh }), REST_MS);
  }

  /** Whether the picture is seen at a place, 0 to 1 from the left. */
  covers(x: number): boolean {
    return !this.canvas.hidden && x > this.share;
  }

  /** Draws the picture over a copy of the light field. */
  drawOnto(context: CanvasRenderingContext2D): void {
    if (this.canvas.hidden) return;
    const { width, height } = context.canvas;
    const from = this.share * width;
    const scale = this.canvas.width / width;
    const part = [from * scale, 0, (width - from) * scale, this.canvas.height] as const;
    context.drawImage(this.canvas, ...part, from, 0, width - from, height);
  }

  dispose(): void {
    clearTimeout(this.timer);
    this.worker?.terminate();
  }

  private start(): Worker {
    const worker = sceneWorker("./picture.js", () => {
      worker.terminate();
      if (this.worker === worker) this.worker = undefined;
      this.error("The path tracer cannot be loaded. Choose it again to try again.");
    });
    worker.onmessage = ({ data }: MessageEvent<PictureAnswer>) => this.receive(data);
    return worker;
  }

  private post(request: PictureRequest): void {
    this.worker?.postMessage(request);
  }

  private receive(answer: PictureAnswer): void {
    if (answer.version !== this.version) return;
    if (answer.kind === "error") {
      this.error(answer.text);
      return;
    }
    const { width, height, pixels, samples } = answer;
    if (this.canvas.width !== width || this.canvas.height !== height) {
      [this.canvas.width, this.canvas.height] = [width, height];
    }
    this.canvas.getContext("2d")!.putImageData(new ImageData(pixels, width, height), 0, 0);
    this.canvas.hidden = false;
    const count = samples === 0 ? "first samples" : `${samples} ${samples === 1 ? "sample" : "samples"} for each pixel`;
    this.right.textContent = `${this.input!.name}, ${count}`;
  }

  private hide(): void {
    for (const one of [this.canvas, this.left, this.right, this.handle]) one.hidden = true;
  }

  private split(share: number): void {
    this.share = Math.min(Math.max(share, LEAST_SHARE), 1 - LEAST_SHARE);
    const percent = `${(100 * this.share).toFixed(1)}%`;
    this.handle.style.left = percent;
    this.handle.setAttribute("aria-valuenow", String(Math.round(100 * this.share)));
    this.canvas.style.clipPath = `inset(0 0 0 ${percent})`;
  }

  private drag(down: PointerEvent): void {
    this.handle.setPointerCapture(down.pointerId);
    const move = (event: PointerEvent) => {
      const { left, width } = this.layer.getBoundingClientRect();
      this.split((event.clientX - left) / width);
    };
    const end = () => {
      this.handle.removeEventListener("pointermove", move);
      this.handle.removeEventListener("pointerup", end);
      this.handle.removeEventListener("pointercancel", end);
    };
    this.handle.addEventListener("pointermove", move);
    this.handle.addEventListener("pointerup", end);
    this.handle.addEventListener("pointercancel", end);
  }

  private key(event: KeyboardEvent): void {
    const shares: Record<string, number> = {
      ArrowLeft: this.share - KEY_STEP,
      ArrowDown: this.share - KEY_STEP,
      ArrowRight: this.share + KEY_STEP,
      ArrowUp: this.share + KEY_STEP,
      Home: 0,
      End: 1,
    };
    const share = shares[event.key];
    if (share === undefined) return;
    event.preventDefault();
    this.split(share);
  }
}
