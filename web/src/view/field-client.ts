/**
 * The light field at two sizes of cells, each in a worker of its own: a coarse one follows lights as they move, a fine
 * one is solved for once they rest.
 */

import { type Body, namedMesh, type Size, surfaceOf } from "./shapes";
import type { FieldAnswer, FieldRequest } from "./field-messages";
import { LitBody } from "./lit-body";
import { sceneWorker } from "./native-scene";

/** Rays through grains for the coarse field: an error of 1 % in the light behind 15 cm. */
const COARSE_RAYS = 1 << 14;
/** Rest of the lights before the fine field is solved for, in ms. */
const REST_MS = 300;

export interface FieldEvents {
  /** There is something new to show. */
  changed(): void;
  /** The present snow cannot be lit. */
  error(text: string): void;
  /** There will be no light at all. */
  failed(text: string): void;
}

/** What is to be lit. */
export interface FieldInput {
  body: Body;
  /** JSON of the scene at both sizes of cells. */
  scenes: Record<Size, string>;
  /** Greatest distance of vertices in the fine field, in mm. */
  fine_edge_mm: number;
  /** JSON of lights. */
  lights: string[];
}

class Stage {
  body: LitBody | undefined;
  private readonly worker: Worker;
  private next: LitBody | undefined;

  constructor(
    private readonly version: () => number,
    private readonly events: FieldEvents,
  ) {
    this.worker = sceneWorker("./field.js", () =>
      events.failed("The light field could not be loaded. Reload the page to try again."),
    );
    this.worker.onmessage = ({ data }: MessageEvent<FieldAnswer>) => this.receive(data);
  }

  ask(request: FieldRequest): void {
    this.worker.postMessage(request);
  }

  dispose(): void {
    this.worker.terminate();
    this.body?.dispose();
    this.next?.dispose();
  }

  private receive(answer: FieldAnswer): void {
    if (answer.kind === "error") {
      if (answer.version === this.version()) this.events.error(answer.text);
    } else if (answer.kind === "body") {
      this.next?.dispose();
      this.next = new LitBody(answer);
    } else {
      // A new body is shown once it is lit.
      if (this.next?.key === answer.bodyKey) {
        this.body?.dispose();
        [this.body, this.next] = [this.next, undefined];
      }
      if (this.body?.key !== answer.bodyKey) return;
      this.body.light(answer);
      this.events.changed();
    }
  }
}

export class FieldClient {
  /** Time from the last request to the coarse light of all lights, in ms. */
  latency_ms = 0;
  private version = 0;
  private bodies = 0;
  private input: FieldInput | undefined;
  private timer = 0;
  private asked = 0;
  private readonly coarse: Stage;
  private readonly fine: Stage;

  constructor(private readonly events: FieldEvents) {
    const version = () => this.version;
    const error = (text: string) => {
      clearTimeout(this.timer);
      events.error(text);
    };
    const failed = (text: string) => events.failed(text);
    this.coarse = new Stage(version, { changed: () => this.coarseChanged(), error, failed });
    this.fine = new Stage(version, { changed: () => events.changed(), error, failed });
  }

  /** Asks for the light of a body. Nothing happens if it is known. */
  ask(input: FieldInput): void {
    const before = this.input;
    const isSameBody = before !== undefined && before.scenes.fine === input.scenes.fine && before.body === input.body;
    if (isSameBody && before.lights.join() === input.lights.join()) return;
    this.input = input;
    this.version += 1;
    if (!isSameBody) this.bodies += 1;
    this.asked = performance.now();
    this.coarse.ask(this.request("coarse", input));
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.fine.ask(this.request("fine", input)), REST_MS);
  }

  /** The best light that is known; that of the body before until there is some. */
  get best(): LitBody | undefined {
    if (this.isReady(this.fine, "fine")) return this.fine.body;
    const isCurrent = ({ body }: Stage, stage: Size) => body?.key === this.key(stage);
    if (isCurrent(this.coarse, "coarse") || !isCurrent(this.fine, "fine")) return this.coarse.body;
    return this.fine.body;
  }

  /** Whether the fine light of all lights where they are now is known. */
  get isFine(): boolean {
    return this.isReady(this.fine, "fine");
  }

  dispose(): void {
    clearTimeout(this.timer);
    this.coarse.dispose();
    this.fine.dispose();
  }

  private coarseChanged(): void {
    if (this.isReady(this.coarse, "coarse")) this.latency_ms = performance.now() - this.asked;
    this.events.changed();
  }

  private isReady({ body }: Stage, stage: Size): boolean {
    return this.input !== undefined && body?.key === this.key(stage) && body.hasAll(this.input.lights);
  }

  private key(stage: Size): string {
    return `${stage} ${this.bodies}`;
  }

  private request(stage: Size, { body, scenes, fine_edge_mm, lights }: FieldInput): FieldRequest {
    const mesh = namedMesh(surfaceOf(body, stage));
    const [grain_rays, edge_mm] = stage === "coarse" ? [COARSE_RAYS, undefined] : [undefined, fine_edge_mm];
    return { version: this.version, bodyKey: this.key(stage), scene: scenes[stage], mesh, grain_rays, edge_mm, lights };
  }
}
