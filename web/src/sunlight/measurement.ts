/** A measured curve from a file, beside the computed one. */

import { Answers, keyOf, type Asked, type Shown } from "../answers";
import { RANGE_ENDS, type Measured } from "../chart/draw";
import { announce, el, say } from "../dom";
import { acceptDrops } from "../drops";
import type { Engine } from "../engine";
import type { CurveFile, Difference, Measures } from "../native";
import { figure } from "../numbers";
import { Radio } from "../panel/choice";
import { COARSE_RAYS, FINE_RAYS, sampleRequest } from "../request";
import type { Store } from "../store";
import { bare } from "./bare";

/** Greatest size of a file; a curve of all wavelengths in steps of 0.1 nm has less. */
const MOST_BYTES = 1 << 20;

export class Measurement {
  curve: Measured | undefined;
  readonly #store: Store;
  readonly #engines: readonly [Engine, Engine];
  readonly #redraw: () => void;
  readonly #quantity: Radio<Measures>;
  readonly #remove: HTMLButtonElement;
  readonly #choose: HTMLButtonElement;
  readonly #note = el("p", { class: "note" });
  readonly #error = el("p", { class: "error", role: "alert", hidden: true });
  #file: Omit<CurveFile, "quantity"> | undefined;
  #measures: Measures = "reflectance";
  /** Number of the last reading: an answer to an earlier one is dropped. */
  #turn = 0;
  /** The sample that was last asked for. */
  #asked = "";
  #differences: Answers<"difference_from"> | undefined;

  constructor(parent: HTMLElement, store: Store, engines: readonly [Engine, Engine], redraw: () => void) {
    this.#store = store;
    this.#engines = engines;
    this.#redraw = redraw;
    const input = el("input", {
      type: "file", accept: ".csv,.txt,.tsv,.asc,.dat,text/csv,text/plain", class: "hidden", tabindex: -1,
      "aria-label": "File of a measured curve",
      change: () => {
        const [file] = input.files ?? [];
        if (file !== undefined) void this.#take(file);
        input.value = "";
      },
    });
    this.#choose = el("button", { type: "button", class: "button", click: () => input.click() }, "Measured curve…");
    this.#remove = el("button", {
      type: "button", class: "quiet", hidden: true,
      click: () => {
        this.#set(undefined);
        this.#choose.focus();
      },
    }, "Remove");
    this.#quantity = new Radio<Measures>(
      { label: "It is" },
      [{ value: "reflectance", label: "Reflectance" }, { value: "transmittance", label: "Transmittance" }],
      (value) => {
        this.#measures = value;
        void this.#read();
      },
    );
    this.#quantity.element.classList.add("inline");
    parent.append(
      el("div", { class: "row wrap" }, this.#choose, input, this.#quantity.element, this.#remove),
      this.#note, this.#error);
    this.#set(undefined);
    store.subscribe((state, before) => {
      if (state.range !== before.range) this.#compare();
      else this.#want();
    });
    acceptDrops(parent.closest("section")!, (file) => void this.#take(file));
  }

  async #take(file: File): Promise<void> {
    const { name, size } = file;
    const turn = (this.#turn += 1);
    try {
      if (size > MOST_BYTES) throw new Error(`${name}: has ${size} bytes, but may have ${MOST_BYTES}`);
      const text = await textOf(file);
      if (turn !== this.#turn) return;
      this.#file = { name, text };
      await this.#read();
    } catch (error) {
      if (turn === this.#turn) this.#refuse(error);
    }
  }

  /** Reads the file as the chosen quantity. */
  async #read(): Promise<void> {
    const file = this.#file;
    if (file === undefined) return;
    const quantity = this.#measures;
    const turn = (this.#turn += 1);
    try {
      const curve = await this.#engines[0].ask("measured_curve", { ...file, quantity });
      // Another file or quantity was chosen since, or this one removed.
      if (turn !== this.#turn) return;
      say(this.#error, "");
      const { first_nm, last_nm } = RANGE_ENDS.visible;
      const isVisible = curve.wavelengths_nm[0]! >= first_nm && curve.wavelengths_nm.at(-1)! <= last_nm;
      this.#set({ ...curve, name: file.name, quantity });
      if (!isVisible) this.#store.update((state) => (state.range = "solar"));
    } catch (error) {
      if (turn === this.#turn) this.#refuse(error);
    }
  }

  /** Says what is wrong. The file stays, to be read as the other quantity. */
  #refuse(error: unknown): void {
    const file = this.#file;
    this.#set(undefined);
    this.#file = file;
    say(this.#error, `${error instanceof Error ? error.message : error}.`);
  }

  #set(curve: Measured | undefined): void {
    this.curve = curve;
    this.#remove.hidden = curve === undefined;
    this.#quantity.set(this.#measures);
    if (curve === undefined) {
      this.#file = undefined;
      this.#turn += 1;
    }
    say(this.#error, "");
    this.#note.textContent =
      "A text file of wavelengths and values, as instruments write it; or drop it here. It stays in this browser.";
    this.#redraw();
    this.#compare();
  }

  /** Compares the present curve over the present range. */
  #compare(): void {
    const { curve } = this;
    this.#differences?.drop();
    this.#differences = undefined;
    this.#asked = "";
    if (curve === undefined) return;
    const { quantity, wavelengths_nm, values } = curve;
    const ends = RANGE_ENDS[this.#store.state.range];
    const request = (sample: Asked, rays: number) =>
      ({ sample: sampleRequest(sample, rays), quantity, wavelengths_nm, values, ...ends });
    this.#differences = new Answers(this.#engines, {
      name: "difference_from",
      coarse: (sample) => request(sample, COARSE_RAYS),
      fine: (sample) => request(sample, FINE_RAYS),
    }, (shown) => this.#show(curve, shown), () => undefined);
    this.#want();
  }

  #want(): void {
    const sample = bare(this.#store.state);
    if (this.#asked === keyOf(sample)) return;
    this.#asked = keyOf(sample);
    this.#differences?.want(sample);
  }

  #show({ name, quantity, notes }: Measured, shown: Shown<Difference>): void {
    if ("error" in shown) {
      this.#note.textContent = `${name}: ${shown.error}.`;
      return;
    }
    const { count, first_nm, last_nm, root_mean_square, mean } = shown.answer;
    const more = notes.map((note) => ` ${note[0]!.toUpperCase()}${note.slice(1)}.`).join("");
    this.#note.replaceChildren(
      el("span", { class: "ring" }), `${name}, ${quantity}: root-mean-square difference from the current sample `,
      el("strong", {}, figure(root_mean_square)),
      `, mean of measured − computed ${figure(mean)}, over ${count} wavelengths of ${first_nm}–${last_nm} nm` +
      `${shown.fine ? "." : " (preview)."}${more}`);
    if (shown.fine) announce("measured", this.#note.textContent ?? "");
  }
}

/** The text of a file in UTF-8, in UTF-16 with a byte order mark, or else in Latin-1, as instruments write it. */
async function textOf(file: File): Promise<string> {
  const bytes = new Uint8Array(await file.arrayBuffer());
  const marks = new Map([["255,254", "utf-16le"], ["254,255", "utf-16be"]]);
  try {
    return new TextDecoder(marks.get(bytes.slice(0, 2).join()) ?? "utf-8", { fatal: true }).decode(bytes);
  } catch {
    return new TextDecoder("latin1").decode(bytes);
  }
}
