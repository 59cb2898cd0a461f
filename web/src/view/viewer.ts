/** Snow in 3-D, lit by lamps that are dragged, or by a sky. */

import type { Lamp, Layer, MeshPlace, Method, Vector, View } from "../state";
import { type FieldClient, fieldInput } from "./field-client";
import type { MeshFile, Probed } from "./field-messages";
import { LampHandles } from "./lamps";
import { wantedOf } from "./lights";
import { LitBody } from "./lit-body";
import { Orbit } from "./orbit";
import { OpenMesh, OwnMeshes } from "./own-mesh";
import { PictureView } from "./picture-view";
import { type Place, Probe } from "./probe";
import { Rings, type Ringed } from "./rings";
import { type Film, sceneOf, toToml } from "./scene";
import { fileOf } from "./scene-files";
import { BLOCK_CM, body as bodyOf, type Body, defaults } from "./shapes";
import { type Backdrop, SnowCanvas } from "./snow-canvas";
import { STYLE } from "./style";
import { testHook } from "./test-hook";

export interface ViewerEvents {
  change(view: View): void;
  /** The light of the present view is shown. */
  lit(): void;
  status(text: string): void;
  /** The light at the rings; none while it is computed. */
  ringed(lights: Ringed): void;
  /** One sentence, or nothing when the last one no longer applies; and a repair of what it says, if there is one. */
  error(text: string, repair?: () => void): void;
  /** The light of all snow cannot be computed; another view may be tried. */
  failed(text: string): void;
}

const NAMES: Record<Exclude<Method, "field">, string> = {
  pcasnow: "PCASnow",
  hybrid: "Random walks",
};
/** Longest side of a traced picture and of the picture that a scene file asks for, in pixels. */
const PICTURE_PIXELS = 512;
const FILE_PIXELS = 1024;
const PICTURE_SAMPLES = 256;
/** Greatest exposed median luminance of snow in view; white is 1. */
const BRIGHTEST_MEDIAN = 0.5;
/** What the camera looks at where there is no snow. */
const NO_TARGET: Body["target"] = [0, 0, 0.15];

/** Events of a disposed view. */
const IGNORED: ViewerEvents = {
  change: () => undefined, lit: () => undefined, status: () => undefined, ringed: () => undefined,
  error: () => undefined, failed: () => undefined,
};

const SHEET = new CSSStyleSheet();
SHEET.replaceSync(STYLE);

export class Viewer {
  private readonly root = document.createElement("div");
  private readonly layer = document.createElement("div");
  private readonly canvas: SnowCanvas | undefined;
  private readonly picture: PictureView;
  private readonly handles: LampHandles | undefined;
  private readonly probe: Probe | undefined;
  private readonly rings: Rings | undefined;
  private readonly observer: ResizeObserver;
  private first: Layer = { thickness_cm: 1 };
  private view: View | undefined;
  private readonly own = new OwnMeshes();
  /** What was shown before the visitor's mesh. */
  private beforeOwn: View | undefined;
  private stops = 0;
  private waiting: { resolve(): void; reject(reason: Error): void }[] = [];
  /** Whether the visitor's mesh has been lit. */
  private isOwnLit = false;

  /** `field` may have been asked for light before. */
  constructor(
    parent: HTMLElement,
    private readonly field: FieldClient,
    private events: ViewerEvents,
  ) {
    if (!document.adoptedStyleSheets.includes(SHEET)) document.adoptedStyleSheets.push(SHEET);
    this.root.className = "sb-view";
    this.layer.className = "sb-layer";
    this.root.append(this.layer);
    parent.append(this.root);
    this.canvas = this.makeCanvas();
    if (this.canvas === undefined) {
      field.dispose();
    } else {
      this.handles = new LampHandles(
        this.layer, this.canvas.camera,
        (place) => this.canvas!.isBehindSnow(place), (lamp, position) => this.moveLamp(lamp, position),
      );
      this.probe = new Probe(this.canvas.element, this.layer, (place) => this.lightAt(place));
      this.rings = new Rings(
        this.layer, this.canvas.camera, (place) => this.lightAt(place), (lights) => this.events.ringed(lights));
    }
    this.field.open({
      changed: () => this.lightChanged(),
      error: (text) => this.refused(text),
      failed: (text) => {
        this.fail(text);
        this.events.failed(text);
      },
    }, (answer) => new LitBody(answer));
    this.picture = new PictureView(this.layer, (text) => this.events.error(text));
    this.observer = new ResizeObserver(() => this.resized());
    this.observer.observe(this.root);
    window.__snowblue = testHook({
      canvas: () => this.canvas!, field, stops: () => this.stops, ready: () => this.whenFine(),
      probe: (place) => this.lightAt(place), camera: () => this.view!.camera, target: () => this.body!.target,
    });
  }

  /** Shows the snow of a layer in a view. Costs little if nothing changed. */
  set(layer: Layer, view: View): void {
    const before = this.view;
    const isNewShape = before !== undefined && before.shape !== view.shape;
    // What was refused is gone with other snow or another shape.
    const isOther = isNewShape || (before !== undefined && !same(this.first, layer));
    if (isOther && this.canvas !== undefined) this.events.error("");
    if (isNewShape && same(before.lamps, view.lamps) && same(before.camera, view.camera)) {
      this.change({ ...view, ...defaults(view.shape) }, layer);
    } else if (!same(before, view) || !same(this.first, layer)) {
      this.apply(structuredClone(view), structuredClone(layer));
    }
  }

  /** Sets what is seen behind the snow. */
  setBackdrop(backdrop: Backdrop): void {
    this.root.dataset["backdrop"] = backdrop;
    this.canvas?.setBackdrop(backdrop);
  }

  /** Marks places of the snow and states their light. */
  setRings(places: readonly Vector[]): void {
    this.rings?.set(places);
    this.rings?.refresh(this.field.isLit);
  }

  /** Shows a visitor's mesh; what cannot be used is refused by an error in one sentence. */
  async addMesh(file: File, scale: number, isRepaired = false): Promise<void> {
    try {
      const mesh = await this.own.take(file, scale, isRepaired);
      if (this.view === undefined) return;
      this.beforeOwn = this.view;
      this.isOwnLit = false;
      const size = scale * mesh.length;
      this.change({ ...this.view, shape: "own", mesh, ...around(size, this.own.height_m(mesh)) }, this.first);
    } catch (error) {
      const repair = error instanceof OpenMesh && !isRepaired ? () => void this.addMesh(file, scale, true) : undefined;
      this.events.error(textOf(error), repair);
    }
  }

  /** The mesh of a link. */
  private async unpack(mesh: MeshPlace): Promise<void> {
    try {
      await this.own.unpack(mesh);
      if (this.view?.mesh?.name === mesh.name) this.apply(this.view, this.first);
    } catch (error) {
      this.events.error(textOf(error));
    }
  }

  /** The light field on the snow, for other programs. Rejects if it cannot be computed. */
  async exportGlb(): Promise<Blob> {
    await this.whenFine();
    const [body, view] = [this.body!, this.view!];
    const scene = JSON.stringify(this.pictureScene(body, view, FILE_PIXELS));
    return fileOf({ scene, mesh: body.mesh });
  }

  /** The view as it is shown. */
  async exportPng(): Promise<Blob> {
    if (this.canvas === undefined) throw new Error("There is no picture.");
    this.canvas.draw();
    const copy = document.createElement("canvas");
    [copy.width, copy.height] = [this.canvas.element.width, this.canvas.element.height];
    const context = copy.getContext("2d")!;
    context.fillStyle = "#0b1118";
    context.fillRect(0, 0, copy.width, copy.height);
    context.drawImage(this.canvas.element, 0, 0);
    this.picture.drawOnto(context);
    return new Promise((resolve, reject) => {
      copy.toBlob((blob) => (blob === null ? reject(new Error("The picture has no pixels.")) : resolve(blob)));
    });
  }

  /** The scene file that `snowblue render` takes, with a comment that says what else it needs. */
  sceneToml(): string {
    const [view, body] = [this.view, this.body];
    if (view === undefined || body === undefined) throw new Error("There is no snow.");
    const comments: string[] = [];
    if (body.mesh !== undefined) comments.push(`Needs ${body.mesh.name} in the same folder.`);
    comments.push("snowblue render scene.toml -o scene.png");
    return toToml(this.pictureScene(body, view, FILE_PIXELS), comments);
  }

  /** The mesh file that the scene file needs, if it needs one. */
  get sceneMesh(): MeshFile | undefined {
    return this.body?.mesh;
  }

  /** Ends it. What comes late is of no interest: the page may show another view. */
  dispose(): void {
    this.events = IGNORED;
    this.fail("The view was closed.");
    this.observer.disconnect();
    this.field.dispose();
    this.picture.dispose();
    this.rings?.dispose();
    this.canvas?.dispose();
    this.root.remove();
    delete window.__snowblue;
  }

  private makeCanvas(): SnowCanvas | undefined {
    let canvas: SnowCanvas;
    try {
      canvas = new SnowCanvas(() => {
        this.handles?.place();
        this.rings?.place();
      });
    } catch {
      this.events.error("This browser has no WebGL 2, which the view in 3-D needs. All other parts work without it.");
      return undefined;
    }
    const { element } = canvas;
    element.tabIndex = 0;
    element.setAttribute("role", "application");
    element.setAttribute(
      "aria-label",
      "Snow in 3-D. Arrow keys turn the view, plus and minus change the distance, P shows the light at the middle of " +
        "the view, Escape hides it. The lamps follow as buttons.",
    );
    this.root.prepend(element);
    new Orbit(
      element,
      () => this.view!.camera,
      (camera) => this.change({ ...this.view!, camera }, this.first),
    );
    return canvas;
  }

  private get body(): Body | undefined {
    if (this.view === undefined) return undefined;
    const { shape, mesh } = this.view;
    return shape === "own" ? mesh && this.own.body(mesh) : bodyOf(shape, this.first.thickness_cm);
  }

  private moveLamp(lamp: number, position: Lamp["position"]): void {
    const lamps = this.view!.lamps.map((one, number) => (number === lamp ? { ...one, position } : one));
    this.change({ ...this.view!, lamps }, this.first);
  }

  /** A change made here, of which the page is notified. */
  private change(view: View, layer: Layer): void {
    this.apply(view, layer);
    this.events.change(structuredClone(view));
  }

  private apply(view: View, layer: Layer): void {
    [this.view, this.first] = [view, layer];
    const body = this.body;
    if (this.canvas === undefined) return;
    if (body !== undefined) this.light(body, view);
    else if (view.mesh !== undefined) void this.unpack(view.mesh);
    this.handles?.set(view.sky === undefined ? view.lamps : []);
    this.canvas.aim(view.camera, body?.target ?? NO_TARGET);
    this.show();
  }

  private light(body: Body, view: View): void {
    this.field.ask(fieldInput(body, this.first, view));
    if (!this.field.isFine) this.events.status("The light in the snow is being computed.");
  }

  private lightChanged(): void {
    this.show();
    if (this.field.isLit) this.events.lit();
    if (!this.field.isFine) return;
    this.isOwnLit ||= this.view?.shape === "own";
    this.events.status(
      [
        this.view?.shape === "block" ? this.blockNotice() : "",
        this.view?.sky === undefined ? "" : "Below the horizon the sky is dark.",
        "Squares on the ground measure 10 cm.",
        "Point at the snow, or tap it, for the spectrum of its light.",
        ...(this.view?.shape === "own" ? this.own.notes.map((note) => `Of the mesh: ${note}.`) : []),
      ].filter((sentence) => sentence !== "").join(" "),
    );
    for (const { resolve } of this.waiting.splice(0)) resolve();
  }

  /** The exposure for a view from any side, or less where the snow in view would be white all over. */
  private metered(stops: number): number {
    const median = this.canvas?.medianLuminance() ?? 0;
    return median > 0 ? Math.min(stops, Math.log2(BRIGHTEST_MEDIAN / median)) : stops;
  }

  private blockNotice(): string {
    const { thickness_cm } = this.first;
    const { least, greatest } = BLOCK_CM;
    if (thickness_cm > greatest) return `The block is ${greatest} cm thick, the most that is drawn.`;
    if (thickness_cm < least) return `The block is ${least} cm thick, the least that is drawn.`;
    return `The block is ${thickness_cm} cm thick.`;
  }

  private show(): void {
    const view = this.view;
    const lit = this.body === undefined ? undefined : this.field.best;
    if (view === undefined || this.canvas === undefined) return;
    this.canvas.show(lit, view, toneOf(view));
    this.stops = view.exposure === "auto" ? this.metered(lit?.stops ?? this.stops) : view.exposure;
    this.canvas.exposure = 2 ** this.stops;
    this.probe?.refresh();
    this.rings?.refresh(this.field.isLit);
    this.trace(view);
  }

  /** What leaves the snow at a place of the view where the light field is seen. */
  async lightAt(place: Place): Promise<Probed> {
    const view = this.view;
    if (view === undefined || this.body === undefined || this.picture.covers(place.x)) return undefined;
    const canvas = this.canvas!;
    return this.field.probe(wantedOf(view), canvas.rayThrough(place), canvas.exposure, toneOf(view));
  }

  /** Traces the picture beside the light field, once that is fine: automatic exposure is by the fine field. */
  private trace(view: View): void {
    const body = this.body;
    if (view.method === "field" || body === undefined || !(this.field.isFine || view.exposure !== "auto")) {
      this.picture.set(undefined);
      return;
    }
    const scene = this.pictureScene(body, view, PICTURE_PIXELS);
    scene.integrator.samples_per_pixel = PICTURE_SAMPLES;
    this.picture.set({ scene: JSON.stringify(scene), mesh: body.mesh, name: NAMES[view.method] });
  }

  private whenFine(): Promise<void> {
    return new Promise((resolve, reject) => {
      if (this.canvas === undefined || this.body === undefined) reject(new Error("There is no snow."));
      else if (this.field.isFine) resolve();
      else this.waiting.push({ resolve: () => resolve(), reject });
    });
  }

  private pictureScene(body: Body, view: View, longest: number): ReturnType<typeof sceneOf> {
    const { thickness_cm: _, ...snow } = this.first;
    return sceneOf(body, snow, view, this.film(longest));
  }

  private film(longest: number): Film {
    const { clientWidth, clientHeight } = this.root;
    const scale = longest / Math.max(clientWidth, clientHeight, 1);
    const pixels = (length: number) => Math.max(1, Math.round(scale * length));
    return { width: pixels(clientWidth), height: pixels(clientHeight), exposure: this.stops };
  }

  private resized(): void {
    this.canvas?.resize(this.root.clientWidth, this.root.clientHeight);
    this.handles?.place();
    this.show();
  }

  /** The light in the snow cannot be computed. */
  private fail(text: string): void {
    this.events.status("");
    this.events.error(text);
    for (const { reject } of this.waiting.splice(0)) reject(new Error(text));
  }

  /** The present snow cannot be lit. A mesh that never was is taken back. */
  private refused(text: string): void {
    this.fail(text);
    const { shape, mesh } = this.view ?? {};
    if (shape !== "own" || mesh === undefined || this.isOwnLit || this.beforeOwn === undefined) return;
    this.own.revert();
    this.change(this.beforeOwn, this.first);
    this.events.error(`The mesh ${mesh.name} was refused: ${text}.`);
  }
}

/** The tone curve. The traced picture beside the light field has none. */
function toneOf({ method }: View): "filmic" | "none" {
  return method === "field" ? "filmic" : "none";
}

function textOf(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}

function same(one: unknown, other: unknown): boolean {
  return JSON.stringify(one) === JSON.stringify(other);
}

/** Lamps and camera for a mesh of some size and height. */
function around(size_m: number, height_m: number): Pick<View, "lamps" | "camera"> {
  const { lamps, camera } = defaults("own");
  const metres = (value: number) => Number(value.toFixed(3));
  const position: Lamp["position"] = [metres(0.2 * size_m), metres(0.85 * size_m), metres(0.7 * height_m)];
  return {
    lamps: lamps.map((lamp) => ({ ...lamp, position })),
    camera: { ...camera, distance_m: metres(2.6 * size_m) },
  };
}
