/** A choice: a list to select from, or a row of buttons of which one is pressed. */

import { el, fresh } from "../dom";
import { hint } from "./hint";

export interface Option<Value extends string> {
  value: Value;
  label: string;
}

interface Meaning {
  label: string;
  sentence?: string;
  source?: string;
}

/** A list to select from. */
export class Select<Value extends string> {
  readonly element: HTMLElement;
  readonly #select: HTMLSelectElement;

  constructor(meaning: Meaning, options: readonly Option<Value>[], change: (value: Value) => void) {
    const id = fresh("select");
    this.#select = el("select", { id, change: () => change(this.#select.value as Value) },
      ...options.map(({ value, label }) => el("option", { value }, label)));
    this.element = el("div", { class: "field choice" }, el("label", { for: id }, meaning.label));
    if (meaning.sentence !== undefined) {
      const { button, sentence } = hint(meaning.label, meaning.sentence, meaning.source ?? "");
      this.#select.setAttribute("aria-describedby", sentence.id);
      this.element.append(button, this.#select, sentence);
    } else {
      this.element.append(this.#select);
    }
  }

  set(value: Value): void {
    this.#select.value = value;
  }
}

/** A row of radio buttons. */
export class Radio<Value extends string> {
  readonly element: HTMLFieldSetElement;
  readonly #inputs = new Map<Value, HTMLInputElement>();

  constructor(
    meaning: Meaning,
    options: readonly (Option<Value> & { icon?: SVGElement })[],
    change: (value: Value) => void,
  ) {
    const name = fresh("radio");
    const row = el("div", { class: "segments" });
    for (const { value, label, icon } of options) {
      const input = el("input", { type: "radio", name, value, change: () => change(value) });
      this.#inputs.set(value, input);
      row.append(el("label", {}, input, el("span", {}, ...(icon === undefined ? [] : [icon]), label)));
    }
    this.element = el("fieldset", { class: "radio" }, el("legend", {}, meaning.label));
    if (meaning.sentence !== undefined) {
      const { button, sentence } = hint(meaning.label, meaning.sentence, meaning.source ?? "");
      this.element.append(button, row, sentence);
    } else {
      this.element.append(row);
    }
  }

  set(value: Value): void {
    const input = this.#inputs.get(value);
    if (input !== undefined) input.checked = true;
  }
}
