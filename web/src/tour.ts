/** Why is snow blue? Four steps that set the controls and say what to look at, with figures of the engine. */

import { byId, el, say } from "./dom";
import type { SpectrumAnswer } from "./native";
import { figure, short } from "./numbers";
import { defaultState } from "./request";
import type { Asked, Spectra } from "./spectra";
import type { Layer, State } from "./state";
import type { Store } from "./store";

interface Step {
  title: string;
  /** The layer that the step shows. */
  layer: Layer;
  /** Layers whose figures the text needs besides. */
  others: Layer[];
  text(shown: SpectrumAnswer, others: SpectrumAnswer[]): string;
}

const at = (answer: SpectrumAnswer, key: "reflectance" | "transmittance", nm: number) =>
  answer[key][answer.wavelengths_nm.indexOf(nm)]!;
const percent = (value: number, digits: number) => `${figure(100 * value, digits)} %`;
const blue = (answer: SpectrumAnswer) => percent(at(answer, "transmittance", 450), 2);
const red = (answer: SpectrumAnswer) => percent(at(answer, "transmittance", 650), 2);
/** How many times as much blue as red light passes. */
const blueness = (answer: SpectrumAnswer) =>
  short(at(answer, "transmittance", 450) / at(answer, "transmittance", 650), 2);

const STEPS: Step[] = [
  {
    title: "From outside, snow is white",
    layer: { thickness_cm: 15 },
    others: [],
    text: (shown) =>
      `15 cm of snow reflect ${percent(at(shown, "reflectance", 450), 3)} of blue light (450 nm) and ` +
      `${percent(at(shown, "reflectance", 650), 3)} of red light (650 nm). The difference is too small to see. ` +
      `Look at the swatch “Reflected” and at the curve R.`,
  },
  {
    title: "The light that passes through is blue",
    layer: { thickness_cm: 40 },
    others: [{ thickness_cm: 15 }],
    text: (shown, [thin]) =>
      `Of blue light 40 cm transmit ${blue(shown)}, of red light ${red(shown)}: ${blueness(shown)} times as much ` +
      `blue as red. For 15 cm the ratio is ${blueness(thin!)}. Each further centimetre removes more red. ` +
      `Look at the swatch “Transmitted” and at the curve T.`,
  },
  {
    title: "The blue is made inside the grains",
    layer: { thickness_cm: 40, grain_size_um: 1500 },
    others: [{ thickness_cm: 40 }],
    text: (shown, [fine]) =>
      "Ice absorbs light of 650 nm about a hundred times as strongly as light of 450 nm. In coarse grains the paths " +
      `through ice between two scatterings are longer. Grains of 1500 µm transmit ${blue(shown)} of blue light, ` +
      `grains of 400 µm ${blue(fine!)}. Move “Grain size” and watch the light.`,
  },
  {
    title: "A little soot takes the blue away",
    layer: { thickness_cm: 40, impurities_ng_g: { "black-carbon": 50 } },
    others: [{ thickness_cm: 40 }],
    text: (shown, [clean]) =>
      `50 ng of soot in a gram of snow reduce the blue light that passes from ${blue(clean!)} to ${blue(shown)}. ` +
      `The ratio of blue to red falls from ${blueness(clean!)} to ${blueness(shown)}. ` +
      `Open “Impurities” and set black carbon to 0: the blue returns.`,
  },
];

export class Tour {
  readonly #store: Store;
  readonly #spectra: Spectra;
  readonly #box = byId("tour");
  readonly #title = el("h2", { tabindex: -1 });
  readonly #text = el("p", { "aria-live": "polite" });
  readonly #transmitted = el("div", { class: "color" });
  readonly #reflected = el("div", { class: "color" });
  readonly #colors = el("div", { class: "tiles", hidden: true },
    tile("Reflected", this.#reflected), tile("Transmitted", this.#transmitted));
  readonly #count = el("span", { class: "note" });
  readonly #back: HTMLButtonElement;
  readonly #next: HTMLButtonElement;
  #step = 0;
  #abort = new AbortController();

  constructor(store: Store, spectra: Spectra) {
    this.#store = store;
    this.#spectra = spectra;
    this.#back = el("button", { type: "button", class: "button", click: () => this.#go(this.#step - 1) }, "Back");
    this.#next = el("button", {
      type: "button", class: "button main",
      click: () => (this.#step === STEPS.length - 1 ? this.#end() : this.#go(this.#step + 1)),
    });
    const end = el("button", { type: "button", class: "quiet", click: () => this.#end() }, "End tour");
    const buttons = el("div", { class: "row" }, this.#back, this.#next, end);
    this.#box.append(this.#count, this.#title, this.#text, this.#colors, buttons);
    this.#box.addEventListener("keydown", ({ key }) => {
      if (key === "Escape") this.#end();
    });
    byId("tour-start").addEventListener("click", () => {
      this.#box.hidden = false;
      this.#go(0);
    });
  }

  #go(index: number): void {
    const step = STEPS[index]!;
    this.#step = index;
    this.#count.textContent = `Why is snow blue? ${index + 1} of ${STEPS.length}`;
    this.#title.textContent = step.title;
    this.#back.disabled = index === 0;
    this.#next.textContent = index === STEPS.length - 1 ? "Finish" : "Next";
    this.#title.focus();
    this.#store.update((state) => Object.assign(state, this.#sample(step.layer)));
    this.#abort.abort();
    this.#abort = new AbortController();
    void this.#explain(step, this.#abort.signal);
  }

  async #explain(step: Step, signal: AbortSignal): Promise<void> {
    this.#text.textContent = "Computing…";
    try {
      const asked = [step.layer, ...step.others].map((layer) => this.#spectra.fine(this.#sample(layer), signal));
      const [shown, ...others] = await Promise.all(asked);
      if (signal.aborted) return;
      say(this.#text, step.text(shown!, others));
      this.#colors.hidden = false;
      this.#reflected.style.background = shown!.reflected.hex;
      this.#transmitted.style.background = shown!.transmitted.hex;
    } catch (error) {
      if (!signal.aborted) say(this.#text, error instanceof Error ? error.message : String(error));
    }
  }

  /** The default sample with one layer. */
  #sample(layer: Layer): Asked {
    const { ground_albedo, angle_deg, illuminant, observer, swatch_exposure }: State = defaultState();
    return { layers: [structuredClone(layer)], ground_albedo, angle_deg, illuminant, observer, swatch_exposure };
  }

  #end(): void {
    this.#abort.abort();
    this.#box.hidden = true;
    byId("tour-start").focus();
  }
}

function tile(title: string, color: HTMLElement): HTMLElement {
  return el("figure", { class: "tile" }, color, el("figcaption", {}, el("span", { class: "title" }, title)));
}
