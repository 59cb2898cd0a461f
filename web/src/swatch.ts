/** The colours of the light: transmitted, by 31 and by three wavelengths, and reflected. */

import { byId, el } from "./dom";
import type { Color, SpectrumAnswer } from "./native";
import { decimal, short } from "./numbers";
import { Radio } from "./panel/choice";
import { NumberField } from "./panel/number-field";
import { control } from "./panel/parameters";
import type { Store } from "./store";

const EXPOSURE = control("exposure", { slider: [-2, 20], scale: "linear", step: 0.5 });

class Tile {
  readonly element: HTMLElement;
  readonly #color = el("div", { class: "color" });
  readonly #hex = el("span", { class: "hex" });
  readonly #lab = el("span", { class: "lab" });
  readonly #note = el("span", { class: "note" });

  constructor(title: string) {
    this.element = el("figure", { class: "tile" }, this.#color,
      el("figcaption", {}, el("span", { class: "title" }, title), this.#hex, this.#lab, this.#note));
  }

  set({ hex, lab, linear_rgb }: Color, note = ""): void {
    this.#color.style.background = hex;
    this.#hex.textContent = hex;
    this.#lab.textContent = `Lab ${labText(lab)}`;
    const isOutside = linear_rgb.some((channel) => channel < 0);
    this.#note.textContent = [note, isOutside ? "Outside sRGB; shown by the nearest colour of equal luminance." : ""]
      .filter((text) => text !== "").join(" ");
  }
}

export class Swatches {
  readonly #transmitted = new Tile("Transmitted");
  readonly #three = new Tile("By 3 wavelengths");
  readonly #reflected = new Tile("Reflected");

  constructor(store: Store) {
    const mode = new Radio<"auto" | "stops">(
      { label: "Exposure of the swatches" },
      [{ value: "auto", label: "Automatic" }, { value: "stops", label: "Fixed" }],
      (value) => store.update((state) => (state.swatch_exposure = value === "auto" ? "auto" : 0)),
    );
    mode.element.classList.add("inline");
    const stops = new NumberField(EXPOSURE, (value) => store.update((state) => (state.swatch_exposure = value)));
    byId("swatches").append(
      el("div", { class: "tiles" }, this.#transmitted.element, this.#three.element, this.#reflected.element),
      el("div", { class: "exposure" }, mode.element, stops.element),
    );
    store.subscribe(({ swatch_exposure }) => {
      mode.set(swatch_exposure === "auto" ? "auto" : "stops");
      stops.element.hidden = swatch_exposure === "auto";
      if (swatch_exposure !== "auto") stops.set(swatch_exposure);
    });
  }

  set({ transmitted, transmitted_3, transmitted_3_delta_e, reflected }: SpectrumAnswer): void {
    this.#transmitted.set(transmitted, "By 31 wavelengths, 400–700 nm.");
    this.#three.set(transmitted_3, `455, 551, 608 nm: ΔE*ab ${short(transmitted_3_delta_e, 2)} from 31.`);
    this.#reflected.set(reflected);
  }
}

export function labText([l, a, b]: Color["lab"]): string {
  return `${decimal(l, 1)}, ${decimal(a, 1)}, ${decimal(b, 1)}`;
}
