/** Up to four samples pinned beside the current one. */

import { delta_e } from "native:spectrum";
import type { Answers, Asked } from "./answers";
import { curve, type Curve } from "./chart/draw";
import { describe } from "./describe";
import { byId, el, say } from "./dom";
import { icon } from "./icons/icons";
import type { Color, SpectrumAnswer } from "./native";
import { figure, short } from "./numbers";
import { PinnedAnswers } from "./pinned-answers";
import { MOST_PINNED, sampleOf, type Sample, type State } from "./state";
import type { Store } from "./store";
import { labText } from "./swatch";

/** Wavelengths of the figures, in nm. */
const SHOWN_NM = [450, 550, 650];
const HEADS = ["Sample", "Transmitted", "Lab", "ΔE*ab", ...SHOWN_NM.map((nm) => `T ${nm} nm`)];
/** Columns of figures of a sample. */
const FIGURES = HEADS.length - 1;

interface Pinned {
  sample: Asked;
  answer: SpectrumAnswer | undefined;
  failure: string | undefined;
}

export class Compare {
  readonly #store: Store;
  readonly #changed: () => void;
  readonly #pin = byId("pin") as HTMLButtonElement;
  readonly #answers: PinnedAnswers<SpectrumAnswer>;
  #current: SpectrumAnswer | undefined;

  /** `ready` starts the module `spectrum`; `changed` is called when a pinned sample is ready, fails or is gone. */
  constructor(store: Store, spectra: Answers<"spectrum">, ready: () => Promise<unknown>, changed: () => void) {
    this.#store = store;
    this.#changed = changed;
    const fine = async (asked: Asked) => {
      await ready();
      return spectra.fine(asked);
    };
    this.#answers = new PinnedAnswers(fine, byId("compare-error"), "spectrum", () => {
      this.#show();
      changed();
    });
    this.#pin.addEventListener("click", () => store.update((state) => state.pinned.push(sampleOf(state))));
  }

  set(current: SpectrumAnswer): void {
    this.#current = current;
    this.#show();
  }

  /** Computes the pinned samples that have no answer. */
  update(state: State): void {
    this.#answers.want(pinnedOf(state));
    this.#show();
  }

  /** Waits for all pinned samples; fails if one of them has no answer. */
  async settle(): Promise<void> {
    await this.#answers.all(pinnedOf(this.#store.state));
  }

  /** The curves of the pinned samples that are ready. */
  curves(): Curve[] {
    return this.#pinned().flatMap(({ sample, answer }, index) =>
      answer === undefined ? [] : [curve(sample, index + 1, answer)]);
  }

  #pinned(): Pinned[] {
    return pinnedOf(this.#store.state).map((sample) =>
      ({ sample, answer: this.#answers.get(sample), failure: this.#answers.failure(sample) }));
  }

  #show(): void {
    const pinned = this.#pinned();
    const isFull = pinned.length >= MOST_PINNED;
    this.#pin.disabled = isFull;
    say(byId("pin-note"), isFull ? `${MOST_PINNED} samples are pinned; remove one to pin another.` : "");
    byId("compare-empty").hidden = pinned.length > 0;
    const table = byId("compare-table");
    table.hidden = pinned.length === 0;
    if (pinned.length === 0) return table.replaceChildren();
    const rows = pinned.map((one, index) => this.#row(one, index));
    const current = this.#store.state;
    table.replaceChildren(
      el("caption", { class: "hidden" }, "Pinned samples and the current one"),
      el("thead", {}, el("tr", {}, ...HEADS.map((text) => el("th", { scope: "col" }, text)), el("td"))),
      el("tbody", {}, ...(this.#current === undefined ? [] : [el("tr", {},
        ...cells("Current", current, 0, figures(this.#current, undefined)), el("td", {}))]), ...rows),
    );
  }

  #row({ sample, answer, failure }: Pinned, index: number): HTMLElement {
    const name = `Pin ${index + 1}`;
    const remove = el("button", {
      type: "button", class: "quiet icon", "aria-label": `Remove ${name}`,
      click: () => {
        this.#store.update((state) => state.pinned.splice(index, 1));
        this.#changed();
        this.#pin.focus();
      },
    }, icon("cross"));
    const use = el("button", {
      type: "button", class: "quiet", "aria-label": `Use ${name}`,
      click: () => this.#store.update((state) => Object.assign(state, structuredClone(sample))),
    }, "Use");
    const actions = el("td", { class: "actions" }, use, remove);
    const state = failure === undefined ? "Computing…" : `No spectrum: ${failure}`;
    const result = answer === undefined ? [el("td", { colspan: FIGURES }, state)] : figures(answer, this.#current);
    return el("tr", {}, ...cells(name, sample, index + 1, result), actions);
  }
}

function pinnedOf({ pinned, swatch_exposure }: State): Asked[] {
  return pinned.map((sample) => ({ ...sample, swatch_exposure }));
}

/** The name of a sample and what is known of it. */
function cells(name: string, sample: Sample, place: number, figures: HTMLElement[]): HTMLElement[] {
  const head = el("th", { scope: "row" }, el("span", { class: "key", style: `--key: var(--curve-${place})` }),
    el("strong", {}, name), el("span", { class: "words" }, describe(sample)));
  return [head, ...figures];
}

function figures(answer: SpectrumAnswer, current: SpectrumAnswer | undefined): HTMLElement[] {
  const { transmitted } = answer;
  return [
    el("td", {}, el("span", { class: "dot", style: `background: ${transmitted.hex}` }), transmitted.hex),
    el("td", {}, labText(transmitted.lab)),
    el("td", {}, current === undefined ? "–" : short(difference(transmitted, current.transmitted), 2)),
    ...SHOWN_NM.map((nm) => el("td", {}, figure(answer.transmittance[answer.wavelengths_nm.indexOf(nm)]!, 3))),
  ];
}

/** ΔE*ab. */
function difference(one: Color, other: Color): number {
  return delta_e(JSON.stringify([one.lab, other.lab]));
}
