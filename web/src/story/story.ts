/** Why snow is blue, in steps that each have one figure and one control. */

import { BLUE_NM, RED_NM, at } from "../brightness";
import { byId, el, say } from "../dom";
import type { SpectrumAnswer } from "../native";
import { figure } from "../numbers";
import { NumberField } from "../panel/number-field";
import { defaultState } from "../request";
import type { Layer, State } from "../state";
import type { Store } from "../store";
import type { ViewHost } from "../view-host";
import type { Ringed } from "../view/rings";
import { colorOf, ice, layer, spectrum } from "./drawings";
import { absorptionAt, left, solidIce_m, surfacesOn } from "./ice";
import { STEPS, length, percent, type Step } from "./steps";
import { absorbing, freePath, meanOf, transmitted, walks, type Walk } from "./walks";

/** Walks whose lengths count, and of these those that are drawn: the first, and the first that get through. */
const WALKS = 6000;
const DRAWN = 30;
const DRAWN_THROUGH = 3;
const SPECTRUM_HEIGHT = 128;

export class Story {
  readonly #store: Store;
  readonly #host: ViewHost;
  readonly #drawing = byId("story-drawing");
  readonly #count = el("p", { class: "note" });
  readonly #title = el("h2", { id: "story-title", tabindex: -1 });
  readonly #text = el("p", { id: "story-text", "aria-live": "polite" });
  readonly #control = byId("story-control");
  readonly #spectrum = el("div", { class: "story-spectrum" });
  readonly #source = el("p", { class: "note" });
  readonly #back = el("button", { type: "button", class: "button", click: () => this.#move(this.#step - 1) }, "Back");
  readonly #next = el("button", { type: "button", class: "button main", click: () => this.#move(this.#step + 1) });
  readonly #buttons: HTMLButtonElement[];
  /** The value of each control. */
  readonly #values = STEPS.map(({ value }) => value);
  #step = 0;
  #answer: SpectrumAnswer | undefined;
  /** The light at the rings of the picture. */
  #lights: Ringed = [];
  #walks: { free_path: number; all: Walk[] } | undefined;

  /**
   * `leave` is called before the visitor goes to another step, `opened` when one is open, and `finish` after the last
   * one.
   */
  constructor(
    store: Store, host: ViewHost, readonly leave: () => void, readonly opened: (step: number) => void,
    readonly finish: () => void,
  ) {
    this.#store = store;
    this.#host = host;
    this.#buttons = STEPS.map(({ name }, index) =>
      el("button", { type: "button", class: "chip", click: () => this.#move(index) }, `${index + 1} ${name}`));
    byId("story-words").append(this.#count, this.#title, this.#text, this.#source);
    byId("story-side").append(
      el("div", { class: "row" }, this.#back, this.#next),
      el("nav", { class: "chips", "aria-label": "Steps of the story" }, ...this.#buttons), this.#spectrum);
    new ResizeObserver(() => this.#draw()).observe(byId("story-figure"));
  }

  /** Shows a step from its start. */
  open(index: number): void {
    const step = STEPS[index]!;
    this.#step = index;
    this.#count.textContent = `Why is snow blue? ${index + 1} of ${STEPS.length}`;
    this.#title.textContent = step.title;
    this.#source.textContent = step.source;
    this.#back.disabled = index === 0;
    this.#next.textContent = index === STEPS.length - 1 ? "To the laboratory" : "Next";
    this.#buttons.forEach((button, place) => {
      if (place === index) button.setAttribute("aria-current", "step");
      else button.removeAttribute("aria-current");
    });
    const field = new NumberField(step.control, (value) => this.#set(value));
    field.set(this.#values[index]!);
    this.#control.replaceChildren(field.element);
    const isSnow = step.figure !== "ice" && step.figure !== "walks";
    byId("story-snow").hidden = !isSnow;
    this.#drawing.hidden = isSnow;
    if (step.figure !== "ice" && step.figure !== "walks") this.#host.backdrop(step.figure);
    this.opened(index);
    this.#store.replace(this.#stateOf(step));
    this.#ring();
  }

  /** Has no control while the laboratory is open. */
  close(): void {
    this.#control.replaceChildren();
    this.#host.ring([], () => undefined);
  }

  /** Takes the spectrum of the present snow. */
  set(answer: SpectrumAnswer): void {
    this.#answer = answer;
    this.#say();
  }

  #move(index: number): void {
    if (index === STEPS.length) return this.finish();
    if (index !== this.#step) this.leave();
    this.open(index);
    this.#title.focus({ preventScroll: true });
    byId("story").scrollIntoView();
  }

  #set(value: number): void {
    this.#values[this.#step] = value;
    this.#store.update((state) => STEPS[this.#step]!.set(state, value));
    this.#ring();
  }

  /** Marks the places of the step; its text states their light once it is known. */
  #ring(): void {
    this.#lights = [];
    this.#host.ring(STEPS[this.#step]!.rings?.(this.#values[this.#step]!) ?? [], (lights) => {
      this.#lights = lights;
      this.#say();
    });
    this.#say();
  }

  /** The default state with the view of a step, and the pins; a drawing keeps the view, so that its light stays. */
  #stateOf(step: Step): State {
    const { view, pinned } = this.#store.state;
    const state = structuredClone({ ...defaultState(), view, pinned });
    step.start(state);
    step.set(state, this.#values[this.#step]!);
    return state;
  }

  #say(): void {
    const [step, value, answer] = [STEPS[this.#step]!, this.#values[this.#step]!, this.#answer];
    if (step.figure !== "walks") say(this.#text, step.text(value, this.#lights));
    else if (answer !== undefined) say(this.#text, this.#ofWalks(answer, value));
    this.#draw();
  }

  #draw(): void {
    const [step, value, answer] = [STEPS[this.#step]!, this.#values[this.#step]!, this.#answer];
    const light = this.#lights.at(-1);
    this.#spectrum.hidden = light === undefined;
    if (light !== undefined) {
      const greatest = Math.max(...light.radiance, Number.MIN_VALUE);
      const width = Math.max(this.#spectrum.clientWidth, 200);
      const title = `The light at the ${this.#lights.length > 1 ? "right " : ""}ring, of its greatest`;
      this.#spectrum.replaceChildren(
        // The text says it in words.
        el("p", { "aria-hidden": "true" }, title),
        spectrum(width, SPECTRUM_HEIGHT, light.radiance.map((value) => value / greatest), "full"));
    }
    const { clientWidth: width, clientHeight: height } = this.#drawing;
    if (this.#drawing.hidden || width === 0) return;
    this.#drawing.setAttribute("aria-label", this.#text.textContent ?? "");
    if (step.figure === "ice") {
      this.#drawing.replaceChildren(ice(width, height, length(value), value));
    } else if (answer !== undefined) {
      const all = this.#walksOf(answer);
      const through = transmitted(all);
      const path = iceOn(through, answer);
      const shown = [...all.filter((one) => !one.isTransmitted).slice(0, DRAWN), ...through.slice(0, DRAWN_THROUGH)];
      const names = {
        above: "Nearly all light turns back: snow is white",
        below: `${DRAWN_THROUGH} of the paths that lead through`,
      };
      this.#drawing.replaceChildren(
        layer(width, height, shown, colorOf(value), (length) => left(value, path * length), names));
    }
  }

  /** Walks with the mean free path of the present snow. */
  #walksOf(answer: SpectrumAnswer): Walk[] {
    const free_path = freePath(at(answer.transmittance, answer, BLUE_NM));
    if (this.#walks?.free_path !== free_path) this.#walks = { free_path, all: walks(WALKS, free_path) };
    return this.#walks.all;
  }

  #ofWalks(answer: SpectrumAnswer, wavelength_nm: number): string {
    const through = transmitted(this.#walksOf(answer));
    const unit = iceOn(through, answer);
    const path = unit * meanOf(through, (length) => length);
    const rest = meanOf(through, (length) => left(wavelength_nm, unit * length));
    const { thickness_cm, ssa_m2_kg } = this.#store.state.layers[0] as Layer & { ssa_m2_kg: number };
    const straight = solidIce_m(thickness_cm);
    const surfaces = Number(surfacesOn(path, ssa_m2_kg).toPrecision(2)).toLocaleString("en");
    return `Straight through, ${thickness_cm} cm of snow hold ${figure(100 * straight, 2)} cm of ice. But light ` +
      `meets some ${surfaces} surfaces of grains before it comes out below, and passes through ` +
      `${figure(path, 2)} m of ice. Of light of ${wavelength_nm} nm, ${percent(rest)} is left of what would come out ` +
      `without absorption.`;
  }
}

/** Path through ice for each thickness that a walk is long, in m, by what snow lets through of blue and red light. */
function iceOn(through: readonly Walk[], answer: SpectrumAnswer): number {
  const part = at(answer.transmittance, answer, RED_NM) / at(answer.transmittance, answer, BLUE_NM);
  return absorbing(through, part) / (absorptionAt(RED_NM) - absorptionAt(BLUE_NM));
}
