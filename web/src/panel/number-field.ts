/** A number: a field, a slider and a sentence. */

import { el, fresh, say } from "../dom";
import type { Range } from "../native";
import { between, outside, read, short, withUnit } from "../numbers";
import { hint } from "./hint";
import type { Control } from "./parameters";

/** Positions of a slider that is not linear. */
const POSITIONS = 200;

export class NumberField {
  readonly element: HTMLElement;
  readonly #control: Control;
  readonly #entry: HTMLInputElement;
  readonly #slider: HTMLInputElement;
  readonly #error: HTMLElement;
  #range: Range;

  constructor(control: Control, change: (value: number) => void) {
    this.#control = control;
    this.#range = control.range;
    const { label, range, sentence, source } = control;
    const id = fresh("field");
    const { button, sentence: text } = hint(label, sentence, source);
    this.#error = el("p", { id: `${id}-error`, class: "error", role: "alert", hidden: true });
    const described = `${text.id} ${this.#error.id}`;
    // Not of type number, which drops a decimal comma in most languages of browsers: 2,5 would be 25.
    this.#entry = el("input", {
      id, type: "text", inputmode: "decimal", "aria-describedby": described, autocomplete: "off",
      input: () => this.#entered(change),
    });
    const linear = control.scale === "linear";
    const [least, greatest] = this.#ends();
    this.#slider = el("input", {
      type: "range", "aria-label": `${label}, slider`, "aria-describedby": text.id,
      min: linear ? least : 0, max: linear ? greatest : POSITIONS, step: linear ? control.step! : 1,
      input: () => {
        const value = this.#fromSlider();
        this.#entry.value = short(value);
        this.#refuse(undefined);
        this.#describe(value);
        change(value);
      },
    });
    this.element = el(
      "div", { class: "field" },
      el("label", { for: id }, label), button,
      el("span", { class: "entry" }, this.#entry, el("span", { class: "unit" }, range.unit)),
      this.#slider, text, this.#error,
    );
  }

  /** Shows a value, unless its entry is being typed. */
  set(value: number, range: Range = this.#control.range): void {
    this.#range = range;
    const typing = document.activeElement === this.#entry;
    if (!typing || read(this.#entry.value) !== value) {
      this.#entry.value = short(value);
      this.#refuse(undefined);
    }
    this.#slide(value);
  }

  #slide(value: number): void {
    this.#slider.value = String(this.#toSlider(value));
    this.#describe(value);
  }

  #entered(change: (value: number) => void): void {
    const { least, greatest, unit } = this.#range;
    const value = read(this.#entry.value);
    const reason = typeof value === "number"
      ? outside(this.#control.quantity, value, this.#range)
      : value ?? `enter a number in ${withUnit(between(least, greatest), unit)}`;
    this.#refuse(reason);
    if (reason !== undefined) return;
    this.#slide(value as number);
    change(value as number);
  }

  #refuse(reason: string | undefined): void {
    this.#entry.setAttribute("aria-invalid", String(reason !== undefined));
    say(this.#error, reason === undefined ? "" : `${reason[0]!.toUpperCase()}${reason.slice(1)}.`);
  }

  #describe(value: number): void {
    this.#slider.setAttribute("aria-valuetext", withUnit(short(value), this.#control.range.unit));
    const { min, max } = this.#slider;
    const way = (Number(this.#slider.value) - Number(min)) / (Number(max) - Number(min));
    this.#slider.style.setProperty("--way", `${100 * way}%`);
  }

  #ends(): readonly [number, number] {
    const { least, greatest } = this.#control.range;
    return this.#control.slider ?? [least, greatest];
  }

  #fromSlider(): number {
    const [least, greatest] = this.#ends();
    const position = Number(this.#slider.value);
    const way = position / POSITIONS;
    switch (this.#control.scale) {
      case "linear": return position;
      case "log": return inside(Number((least * (greatest / least) ** way).toPrecision(3)), this.#range);
      case "cubic": return inside(Number((greatest * way ** 3).toPrecision(2)), this.#range);
    }
  }

  #toSlider(value: number): number {
    const [least, greatest] = this.#ends();
    switch (this.#control.scale) {
      case "linear": return value;
      case "log": return POSITIONS * Math.log(Math.max(value, least) / least) / Math.log(greatest / least);
      case "cubic": return POSITIONS * Math.cbrt(value / greatest);
    }
  }
}

function inside(value: number, { least, greatest }: Range): number {
  return Math.min(Math.max(value, least), greatest);
}
