/** The layers, top first, of which the controls show one. */

import { el } from "../dom";
import { icon } from "../icons/icons";
import { short } from "../numbers";
import { MOST_LAYERS, type Layer, type State } from "../state";
import type { Store } from "../store";

export class LayerList {
  /** Buttons that add and remove a layer. */
  readonly buttons: HTMLElement;
  /** Buttons that choose a layer. */
  readonly rows = el("div", { class: "layer-rows", role: "group", "aria-label": "Layers, top first" });
  readonly #store: Store;
  readonly #add: HTMLButtonElement;
  readonly #remove: HTMLButtonElement;
  readonly #listeners: (() => void)[] = [];
  #chosen = 0;

  constructor(store: Store) {
    this.#store = store;
    this.#add = el("button", { type: "button", class: "quiet", click: () => this.#addLayer() },
      icon("plus"), "Layer below");
    this.#remove = el("button", { type: "button", class: "quiet", click: () => this.#removeLayer() }, "Remove layer");
    this.buttons = el("div", { class: "row" }, this.#remove, this.#add);
    store.subscribe((state) => this.#show(state));
  }

  /** The layer that the controls show. */
  get layer(): Layer {
    return this.#store.state.layers[this.#chosen]!;
  }

  change(change: (layer: Layer) => void): void {
    this.#store.update(({ layers }) => change(layers[this.#chosen]!));
  }

  /** Calls the listener now and whenever the layer or the choice changes. */
  subscribe(listener: () => void): void {
    this.#listeners.push(listener);
    listener();
  }

  #choose(index: number): void {
    this.#chosen = index;
    this.#show(this.#store.state);
  }

  #addLayer(): void {
    const at = this.#chosen + 1;
    this.#chosen = at;
    this.#store.update(({ layers }) => layers.splice(at, 0, structuredClone(layers[at - 1]!)));
  }

  #removeLayer(): void {
    const at = this.#chosen;
    this.#chosen = Math.max(0, at - 1);
    this.#store.update(({ layers }) => layers.splice(at, 1));
    this.rows.querySelector<HTMLElement>("[aria-pressed=true]")?.focus();
  }

  #show({ layers }: State): void {
    this.#chosen = Math.min(this.#chosen, layers.length - 1);
    this.rows.hidden = layers.length === 1;
    const titles = layers.map(({ thickness_cm }, index) => `Layer ${index + 1}: ${short(thickness_cm)} cm`);
    if (this.rows.childElementCount !== layers.length) {
      this.rows.replaceChildren(...layers.map((_, index) =>
        el("button", { type: "button", class: "layer", click: () => this.#choose(index) })));
    }
    [...this.rows.children].forEach((row, index) => {
      row.textContent = titles[index]!;
      row.setAttribute("aria-pressed", String(index === this.#chosen));
    });
    this.#add.disabled = layers.length >= MOST_LAYERS;
    this.#remove.hidden = layers.length === 1;
    for (const listener of this.#listeners) listener();
  }
}
