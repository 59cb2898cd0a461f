/** Loads the 3-D view when the page stands, and keeps it and the state the same. */

import { byId, el, say } from "./dom";
import { imported } from "./imported";
import type { State, Vector, View } from "./state";
import type { Store } from "./store";
import { FieldClient, fieldInput } from "./view/field-client";
import type { Ringed } from "./view/rings";
import { body } from "./view/shapes";
import type { Backdrop } from "./view/snow-canvas";
import type { Viewer } from "./view/viewer";

/** Time without a change after which a control counts as at rest, in ms. */
const REST_MS = 200;

export class ViewHost {
  /** Resolves when the first light is shown, or cannot be. */
  readonly opened: Promise<void>;
  #open!: () => void;
  readonly #store: Store;
  readonly #script = imported<typeof import("./view/viewer")>("viewer.js");
  /** What to do about the error. */
  readonly #offer = el("button", { type: "button", class: "button", hidden: true });
  /** The light for the view that is loaded next. */
  #field: FieldClient | undefined;
  #viewer: Promise<Viewer> | undefined;
  /** The view once it is loaded. */
  #shown: Viewer | undefined;
  #rest: ReturnType<typeof setTimeout> | undefined;
  #backdrop: Backdrop = "dark";
  #rings: readonly Vector[] = [];
  #ringed: (lights: Ringed) => void = () => undefined;

  constructor(store: Store) {
    this.#store = store;
    this.opened = new Promise((resolve) => (this.#open = resolve));
    byId("view-error").after(this.#offer);
    store.subscribe((state, before) => {
      if (this.#shown !== undefined) this.#follow(this.#shown, state, before);
    });
  }

  /** Asks for the light of the present state, which the view then shows. It costs little here. */
  ask(): void {
    const { layers: [first], view } = this.#store.state;
    this.#field ??= new FieldClient();
    if (view.shape !== "own") this.#field.ask(fieldInput(body(view.shape, first!.thickness_cm), first!, view));
  }

  /** The view, loaded once. After a failure the next call tries again. */
  viewer(): Promise<Viewer> {
    this.#viewer ??= this.#load().catch((error) => {
      this.#fail(`The 3-D snow cannot be loaded: ${error instanceof Error ? error.message : error}.`);
      throw error;
    });
    return this.#viewer;
  }

  /** Starts to load it; says in its place if that fails. */
  async start(): Promise<void> {
    await this.viewer().catch(() => undefined);
  }

  /** Shows a visitor's mesh, whose lengths are multiples of a scale in m. */
  async addMesh(file: File, scale: number): Promise<void> {
    this.error("");
    // A view that cannot be loaded says so itself.
    await (await this.viewer().catch(() => undefined))?.addMesh(file, scale);
  }

  /** Sets what is seen behind the snow. */
  backdrop(backdrop: Backdrop): void {
    this.#backdrop = backdrop;
    void this.#viewer?.then((viewer) => viewer.setBackdrop(backdrop), () => undefined);
  }

  /** Marks places of the snow; `ringed` is called with their light when it is known. */
  ring(places: readonly Vector[], ringed: (lights: Ringed) => void): void {
    [this.#rings, this.#ringed] = [places, ringed];
    void this.#viewer?.then((viewer) => viewer.setRings(places), () => undefined);
  }

  /** Takes away the picture that stands for the first view of the story. */
  endPoster(): void {
    byId("poster").classList.add("gone");
  }

  /** Says what is wrong, with a button for what to do about it, if that is known. */
  error(text: string, label = "", run?: () => void): void {
    say(byId("view-error"), text);
    this.#offer.hidden = run === undefined;
    this.#offer.textContent = label;
    this.#offer.onclick = () => {
      this.error("");
      run?.();
    };
  }

  /** A lamp or the camera moves at once; the snow follows when its control is at rest, as all light is solved again. */
  #follow(viewer: Viewer, state: State, before: State): void {
    clearTimeout(this.#rest);
    this.#rest = undefined;
    const set = () => {
      this.#rest = undefined;
      viewer.set(this.#store.state.layers[0]!, this.#store.state.view);
    };
    if (state === before || state.view !== before.view) set();
    else this.#rest = setTimeout(set, REST_MS);
  }

  /** There is no view, until it is loaded again. */
  #fail(text: string): void {
    this.#shown?.dispose();
    this.#field?.dispose();
    this.#viewer = this.#shown = this.#field = undefined;
    byId("view-wait").hidden = true;
    this.error(text, "Try again", () => void this.start());
    this.#open();
  }

  async #load(): Promise<Viewer> {
    this.error("");
    byId("view-wait").hidden = false;
    const { Viewer } = await this.#script();
    const field = this.#field ?? new FieldClient();
    const viewer: Viewer = new Viewer(byId("view"), field, {
      change: (view: View) => this.#changed(view),
      lit: () => {
        this.endPoster();
        this.#open();
      },
      status: (text: string) => say(byId("view-status"), text),
      // While a control moves, the light is that of the snow before.
      ringed: (lights: Ringed) => {
        if (this.#rest === undefined) this.#ringed(lights);
      },
      error: (text: string, repair?: () => void) => {
        this.error(text, "Repair the mesh", repair);
        if (text !== "") this.#open();
      },
      failed: (text: string) => {
        if (this.#shown === viewer) this.#fail(text);
      },
    });
    this.#field = undefined;
    viewer.setBackdrop(this.#backdrop);
    viewer.setRings(this.#rings);
    byId("view-wait").hidden = true;
    this.#shown = viewer;
    this.#follow(viewer, this.#store.state, this.#store.state);
    return viewer;
  }

  #changed(view: View): void {
    this.#store.update((state: State) => (state.view = structuredClone(view)));
  }
}
