/**
 * The light field at two sizes of cells, each in a worker of its own: a coarse one follows lights as they move, a fine
 * one is solved for when they stop moving.
 *
 * It does not need the scripts that draw, so that light is solved for while these are loaded.
 */

import type { Layer, View } from "../state";
import type { FieldAnswer, FieldRequest, Probed, ProbeRequest } from "./field-messages";
import { lightsOf, type Wanted, wantedOf } from "./lights";
import type { LitBody } from "./lit-body";
import { sceneWorker } from "./native-scene";
import { fieldScene } from "./scene";
import { type Body, type Size, surfaceOf } from "./shapes";

/** Rays through grains for the coarse field: an error of 1 % in the light behind 15 cm. */
const COARSE_RAYS = 1 << 14;
/**
 * Greatest distance of vertices in the fine field, in cells. At 0.7 cells half of the pixels of the drift are within
 * 0.4 % of a rendering, here within 0.8 %; but a software GPU draws 8 frames a second instead of 18.
 */
const FINE_CELLS_PER_EDGE = 1.5;
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
  /** JSON of lights, and by what each is multiplied. */
  lights: string[];
  strengths: number[];
}

/** What is to be lit in a view of some snow. */
export function fieldInput(body: Body, { thickness_cm: _, ...snow }: Layer, view: View): FieldInput {
  const scene = (size: Size) => fieldScene(surfaceOf(body, size), snow, size);
  return {
    body,
    scenes: { coarse: scene("coarse"), fine: scene("fine") },
    lights: lightsOf(view),
    strengths: wantedOf(view).map(({ strength }) => strength),
  };
}

/** Makes meshes of a body. */
type MakeBody = (answer: Extract<FieldAnswer, { kind: "body" }>) => LitBody;

interface StageEvents extends Omit<FieldEvents, "failed"> {
  /** Its worker cannot be loaded. */
  failed(): void;
}

class Stage {
  body: LitBody | undefined;
  /** Started by the first request: that of the fine field would delay the first coarse light. */
  private worker: Worker | undefined;
  private next: LitBody | undefined;
  private readonly questions = new Map<number, (light: Probed) => void>();
  private asked = 0;
  /** Answers that came before it was disposed of may be waiting for the view. */
  private isGone = false;

  constructor(
    private readonly version: () => number,
    private readonly events: StageEvents,
    private readonly opened: Promise<MakeBody>,
  ) {}

  ask(request: FieldRequest | ProbeRequest): void {
    if (this.isGone) return;
    this.worker ??= this.started();
    this.worker.postMessage(request);
  }

  /** What leaves the snow that is shown. */
  probe(question: Omit<ProbeRequest, "probe" | "bodyKey">): Promise<Probed> {
    const probe = (this.asked += 1);
    this.ask({ ...question, probe, bodyKey: this.body!.key });
    return new Promise((resolve) => this.questions.set(probe, resolve));
  }

  dispose(): void {
    this.isGone = true;
    this.worker?.terminate();
    this.body?.dispose();
    this.next?.dispose();
  }

  private started(): Worker {
    const failed = () => {
      if (!this.isGone) this.events.failed();
    };
    const worker = sceneWorker("./field.js", () => void this.opened.then(failed));
    worker.onmessage = ({ data }: MessageEvent<FieldAnswer>) =>
      void this.opened.then((makeBody) => this.receive(data, makeBody));
    return worker;
  }

  private receive(answer: FieldAnswer, makeBody: MakeBody): void {
    if (this.isGone) return;
    if (answer.kind === "error") {
      if (answer.version === this.version()) this.events.error(answer.text);
    } else if (answer.kind === "body") {
      this.next?.dispose();
      this.next = makeBody(answer);
    } else if (answer.kind === "probe") {
      this.questions.get(answer.probe)?.(answer.light);
      this.questions.delete(answer.probe);
    } else if (answer.kind === "exposure") {
      if (this.body?.key !== answer.bodyKey) return;
      this.body.stops = answer.stops;
      this.events.changed();
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
  /** Of the wait for rest. */
  private timer: number | undefined;
  /** Whether the fine field of the present lights is asked for. */
  private isRefined = false;
  /** When light was asked for that is not there yet. */
  private asked: number | undefined;
  private readonly coarse: Stage;
  private readonly fine: Stage;

  private events!: FieldEvents;
  private start!: (makeBody: MakeBody) => void;

  constructor() {
    const version = () => this.version;
    const error = (text: string) => {
      clearTimeout(this.timer);
      this.timer = undefined;
      this.events.error(text);
    };
    const failed = () => this.events.failed("The light field cannot be loaded.");
    // The fine field is asked for once there is coarse light.
    const fineFailed = () => error("The light stays coarse: the fine light field cannot be loaded.");
    const opened = new Promise<MakeBody>((resolve) => (this.start = resolve));
    this.coarse = new Stage(version, { changed: () => this.coarseChanged(), error, failed }, opened);
    this.fine = new Stage(version, { changed: () => this.events.changed(), error, failed: fineFailed }, opened);
  }

  /** Gives the answers to a view, those too that came before. */
  open(events: FieldEvents, makeBody: MakeBody): void {
    this.events = events;
    this.start(makeBody);
  }

  /** Asks for the light of a body. Nothing happens if it is known. */
  ask(input: FieldInput): void {
    const before = this.input;
    const isSameBody = before !== undefined && before.scenes.fine === input.scenes.fine && before.body === input.body;
    const isSameLight = isSameBody && before.lights.join() === input.lights.join();
    if (isSameLight && before.strengths.join() === input.strengths.join()) return;
    this.input = input;
    if (isSameLight) {
      // Only the exposure changes.
      this.coarse.ask(this.request("coarse", input));
      if (this.isRefined) this.fine.ask(this.request("fine", input));
      return;
    }
    this.version += 1;
    if (!isSameBody) this.bodies += 1;
    this.asked = performance.now();
    this.coarse.ask(this.request("coarse", input));
    this.isRefined = false;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      this.timer = undefined;
      this.refine();
    }, REST_MS);
  }

  /** Asks for the fine field, once the lights rest and the coarse one is there, which it would slow down. */
  private refine(): void {
    if (this.isRefined || this.timer !== undefined || !this.isReady(this.coarse, "coarse")) return;
    this.isRefined = true;
    this.fine.ask(this.request("fine", this.input!));
  }

  /** The best light that is known; that of the body before until there is some. */
  get best(): LitBody | undefined {
    return this.bestStage.body;
  }

  private get bestStage(): Stage {
    if (this.isReady(this.fine, "fine")) return this.fine;
    const isCurrent = ({ body }: Stage, stage: Size) => body?.key === this.key(stage);
    return isCurrent(this.coarse, "coarse") || !isCurrent(this.fine, "fine") ? this.coarse : this.fine;
  }

  /** The light that leaves the snow as it is shown by lights of some types; none beside it. */
  async probe(wanted: readonly Wanted[], ray: number[], exposure: number, tone: string) {
    const stage = this.bestStage;
    if (stage.body === undefined) return undefined;
    return stage.probe({ ray, strengths: stage.body.strengths(wanted), exposure, tone });
  }

  /** Whether at least the coarse light of all lights where they are now is known. */
  get isLit(): boolean {
    return this.isFine || this.isReady(this.coarse, "coarse");
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
    if (this.asked !== undefined && this.isReady(this.coarse, "coarse")) {
      this.latency_ms = performance.now() - this.asked;
      this.asked = undefined;
    }
    this.refine();
    this.events.changed();
  }

  private isReady({ body }: Stage, stage: Size): boolean {
    return this.input !== undefined && body?.key === this.key(stage) && body.hasAll(this.input.lights);
  }

  private key(stage: Size): string {
    return `${stage} ${this.bodies}`;
  }

  private request(stage: Size, { body, scenes, lights, strengths }: FieldInput): FieldRequest {
    const { mesh } = surfaceOf(body, stage);
    const [grain_rays, cells] = stage === "coarse" ? [COARSE_RAYS, undefined] : [undefined, FINE_CELLS_PER_EDGE];
    return {
      version: this.version, bodyKey: this.key(stage), scene: scenes[stage], mesh, grain_rays, cells_per_edge: cells,
      lights, strengths,
    };
  }
}
