/** What is loaded when the results come near the window: infrared light, light at depth, and a measured curve. */

import { Answers, keyOf, type Asked, type Shown } from "../answers";
import type { Curve, Measured } from "../chart/draw";
import { describe } from "../describe";
import { byId } from "../dom";
import { Engine } from "../engine";
import type { SunlightAnswer } from "../native";
import { PinnedAnswers } from "../pinned-answers";
import { COARSE_RAYS, FINE_RAYS, sampleRequest } from "../request";
import type { Store } from "../store";
import { Bands } from "./bands";
import { bare } from "./bare";
import { DepthChart, depthRequest } from "./depth-chart";
import { Measurement } from "./measurement";

export class Sunlight {
  readonly #store: Store;
  readonly #redraw: () => void;
  readonly #spectra: Answers<"sunlight">;
  readonly #bands = new Bands(byId("bands"));
  readonly #measurement: Measurement;
  readonly #pinned: PinnedAnswers<SunlightAnswer>;
  /** The sample whose spectrum was last asked for. */
  #asked = "";
  /** The current sample, or the one before it while it is computed. */
  #latest: { sample: Asked; answer: SunlightAnswer } | undefined;

  /** `redraw` is called when a spectrum or the measured curve has changed. */
  constructor(store: Store, module: () => Promise<WebAssembly.Module>, redraw: () => void) {
    this.#store = store;
    this.#redraw = redraw;
    const engines = [new Engine(module), new Engine(module)] as const;
    this.#spectra = new Answers(engines, {
      name: "sunlight",
      coarse: (sample) => sampleRequest(sample, COARSE_RAYS),
      fine: (sample) => sampleRequest(sample, FINE_RAYS),
    }, (shown) => this.#show(shown), () => undefined);
    const fine = (asked: Asked) => this.#spectra.fine(asked);
    this.#pinned = new PinnedAnswers(fine, byId("sunlight-error"), "solar spectrum", redraw);
    const chart = new DepthChart(byId("depth-chart"), store);
    const depths = new Answers(engines, {
      name: "light_at_depth",
      coarse: (sample) => depthRequest(sample, COARSE_RAYS),
      fine: (sample) => depthRequest(sample, FINE_RAYS),
    }, (shown) => chart.show(shown), () => undefined);
    this.#measurement = new Measurement(byId("measured"), store, engines, redraw);

    const [spectrum, bands, deep, share] = [byId("chart"), byId("sunlight"), byId("depths"), byId("share")];
    const inView = new Set<Element>();
    /** The sample whose light at depth was last asked for. */
    let askedDepths = "";
    const follow = () => {
      const { state } = store;
      const sample = bare(state);
      const key = keyOf(sample);
      // The commands below "Share" are those of the solar spectrum.
      const isSolar = state.range === "solar" && (inView.has(spectrum) || inView.has(share));
      if (this.#asked !== key) {
        this.#bands.wait();
        if (isSolar || inView.has(bands)) this.#want(sample);
      }
      if (askedDepths !== key) {
        chart.wait();
        if (inView.has(deep)) {
          askedDepths = key;
          depths.want(sample);
        }
      }
      if (isSolar) this.#pinned.want(state.pinned.map(bare));
    };
    const observer = new IntersectionObserver((entries) => {
      for (const { target, isIntersecting } of entries) {
        if (isIntersecting) inView.add(target);
        else inView.delete(target);
      }
      follow();
    }, { rootMargin: "100px" });
    for (const part of [spectrum, bands, deep, share]) observer.observe(part);
    store.subscribe(follow);
    redraw();
  }

  get measured(): Measured | undefined {
    return this.#measurement.curve;
  }

  /** A curve over all wavelengths, or as it is where that is not known. The current one follows its sample. */
  extended(curve: Curve): Curve {
    if (curve.place > 0) return { ...curve, spectrum: this.#pinned.get(bare(curve.sample)) ?? curve.spectrum };
    if (this.#latest === undefined) return curve;
    const { sample: { layers, ground_albedo, angle_deg }, answer } = this.#latest;
    const sample = { ...curve.sample, layers, ground_albedo, angle_deg };
    return { ...curve, name: describe(sample), sample, spectrum: answer };
  }

  /** Its wavelengths, if the spectrum of the current sample is known. */
  get wavelengths_nm(): readonly number[] | undefined {
    if (this.#latest === undefined || keyOf(this.#latest.sample) !== keyOf(bare(this.#store.state))) return undefined;
    return this.#latest.answer.wavelengths_nm;
  }

  /** Shows the final spectra of the current and the pinned samples, also out of view; fails if there is none of one. */
  async settle(): Promise<void> {
    const { state } = this.#store;
    const sample = bare(state);
    await Promise.all([this.#spectra.fine(sample), this.#pinned.all(state.pinned.map(bare))]);
    this.#want(sample);
  }

  #want(sample: Asked): void {
    this.#asked = keyOf(sample);
    this.#spectra.want(sample);
  }

  #show(shown: Shown<SunlightAnswer>): void {
    this.#bands.show(shown);
    if ("error" in shown) return;
    this.#latest = shown;
    this.#redraw();
  }
}
