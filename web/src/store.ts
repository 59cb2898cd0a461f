/** The state of the page and its listeners. */

import type { State } from "./state";

export class Store {
  #state: State;
  readonly #listeners: ((state: State, before: State) => void)[] = [];

  constructor(state: State) {
    this.#state = state;
  }

  get state(): State {
    return this.#state;
  }

  /** Changes a copy of the state. */
  update(change: (state: State) => void): void {
    const next = structuredClone(this.#state);
    change(next);
    this.replace(next);
  }

  /** Parts that are equal stay the same objects, so that listeners can compare them. */
  replace(wanted: State): void {
    const before = this.#state;
    const next = merged(before, wanted);
    if (next === before) return;
    this.#state = next;
    for (const listener of this.#listeners) listener(next, before);
  }

  /** Calls the listener now and after every change. */
  subscribe(listener: (state: State, before: State) => void): void {
    this.#listeners.push(listener);
    listener(this.#state, this.#state);
  }
}

function merged(before: State, wanted: State): State {
  const next = { ...wanted };
  let isSame = true;
  for (const key of Object.keys(wanted) as (keyof State)[]) {
    const isEqual = JSON.stringify(before[key]) === JSON.stringify(wanted[key]);
    if (isEqual) Object.assign(next, { [key]: before[key] });
    isSame &&= isEqual;
  }
  return isSame ? before : next;
}
