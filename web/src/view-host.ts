/** Loads the 3-D view when the page stands, and keeps it and the state the same. */

import { byId, say } from "./dom";
import type { State, View } from "./state";
import type { Store } from "./store";
import type { Backdrop } from "./view/snow-canvas";
import type { Viewer } from "./view/viewer";

/** Time without a change after which a control counts as at rest, in ms. */
const REST_MS = 200;

export class ViewHost {
  /** Resolves when the first light is shown, or cannot be. */
  readonly opened: Promise<void>;
  #open!: () => void;
  readonly #store: Store;
  #viewer: Promise<Viewer> | undefined;
  #rest: ReturnType<typeof setTimeout> | undefined;
  #backdrop: Backdrop = "dark";

  constructor(store: Store) {
    this.#store = store;
    this.opened = new Promise((resolve) => (this.#open = resolve));
  }

  /** The view, loaded once. */
  viewer(): Promise<Viewer> {
    this.#viewer ??= this.#load();
    return this.#viewer;
  }

  /** Starts to load it, and says in its place if it fails. */
  async start(): Promise<void> {
    try {
      const viewer = await this.viewer();
      byId("view-wait").hidden = true;
      this.#store.subscribe((state, before) => this.#follow(viewer, state, before));
    } catch (error) {
      byId("view-wait").hidden = true;
      this.error(error instanceof Error ? error.message : String(error));
      this.#open();
    }
  }

  async addMesh(file: File): Promise<void> {
    this.error("");
    await (await this.viewer()).addMesh(file);
  }

  /** Sets what is seen behind the snow. */
  backdrop(backdrop: Backdrop): void {
    this.#backdrop = backdrop;
    void this.#viewer?.then((viewer) => viewer.setBackdrop(backdrop), () => undefined);
  }

  /** Takes away the picture that stands for the first view of the story. */
  endPoster(): void {
    byId("poster").classList.add("gone");
  }

  error(text: string): void {
    say(byId("view-error"), text);
  }

  /** A lamp or the camera moves at once; the snow follows when its control is at rest, as all light is solved again. */
  #follow(viewer: Viewer, state: State, before: State): void {
    clearTimeout(this.#rest);
    const set = () => viewer.set(this.#store.state.layers[0]!, this.#store.state.view);
    if (state === before || state.view !== before.view) set();
    else this.#rest = setTimeout(set, REST_MS);
  }

  async #load(): Promise<Viewer> {
    const { Viewer } = await import("./view/viewer");
    const viewer = new Viewer(byId("view"), {
      change: (view: View) => this.#changed(view),
      lit: () => {
        this.endPoster();
        this.#open();
      },
      status: (text: string) => say(byId("view-status"), text),
      error: (text: string) => {
        this.error(text);
        if (text !== "") this.#open();
      },
    });
    viewer.setBackdrop(this.#backdrop);
    return viewer;
  }

  #changed(view: View): void {
    this.#store.update((state: State) => (state.view = structuredClone(view)));
  }
}
