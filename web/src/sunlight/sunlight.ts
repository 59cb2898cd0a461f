/** What is loaded when the results come near the window: infrared light, light at depth, and a measured curve. */

import { Answers, keyOf, type Asked, type Shown } from "../answers";
import type { Curve, Measured } from "../chart/draw";
import { describe } from "../describe";
import { byId, say } from "../dom";
import { Engine } from "../engine";
import type { SunlightAnswer } from "../native";
import { COARSE_RAYS, FINE_RAYS, sampleRequest } from "../request";
import type { Sample } from "../state";
import type { Store } from "../store";
import { Bands } from "./bands";
import { bare } from "./bare";
import { DepthChart, depthRequest } from "./depth-chart";
import { Measurement } from "./measurement";

export class Sunlight {
  readonly #redraw: () => void;
  readonly #spectra: Answers<"sunlight">;
  readonly #bands = new Bands(byId("bands"));
  readonly #measurement: Measurement;
  /** Answers for pinned samples; undefined while they are computed, or if that failed. */
  readonly #pinned = new Map<string, SunlightAnswer | undefined>();
  /** The current sample, or the one before it while it is computed. */
  #latest: { sample: Asked; answer: SunlightAnswer } | undefined;

  /** `redraw` is called when a spectrum or the measured curve has changed. */
  constructor(store: Store, module: Promise<WebAssembly.Module>, redraw: () => void) {
    this.#redraw = redraw;
    const engines = [new Engine(module), new Engine(module)] as const;
    this.#spectra = new Answers(engines, {
      name: "sunlight",
      coarse: (sample) => sampleRequest(sample, COARSE_RAYS),
      fine: (sample) => sampleRequest(sample, FINE_RAYS),
    }, (shown) => this.#show(shown), () => undefined);
    const chart = new DepthChart(byId("depth-chart"), store);
    const depths = new Answers(engines, {
      name: "light_at_depth",
      coarse: (sample) => depthRequest(sample, COARSE_RAYS),
      fine: (sample) => depthRequest(sample, FINE_RAYS),
    }, (shown) => chart.show(shown), () => undefined);
    this.#measurement = new Measurement(byId("measured"), store, engines, redraw);

    const [spectrum, bands, deep] = [byId("chart"), byId("sunlight"), byId("depths")];
    /** Parts in view, and the samples that they last asked for. */
    const inView = new Set<Element>();
    const asked = { bands: "", depths: "" };
    const follow = () => {
      const { state } = store;
      const sample = bare(state);
      const key = keyOf(sample);
      const isSolar = state.range === "solar" && inView.has(spectrum);
      if (asked.bands !== key) {
        this.#bands.wait();
        if (isSolar || inView.has(bands)) {
          asked.bands = key;
          this.#spectra.want(sample);
        }
      }
      if (asked.depths !== key) {
        chart.wait();
        if (inView.has(deep)) {
          asked.depths = key;
          depths.want(sample);
        }
      }
      if (isSolar) for (const pin of state.pinned) void this.#learn(pin);
    };
    const observer = new IntersectionObserver((entries) => {
      for (const { target, isIntersecting } of entries) {
        if (isIntersecting) inView.add(target);
        else inView.delete(target);
      }
      follow();
    }, { rootMargin: "100px" });
    for (const part of [spectrum, bands, deep]) observer.observe(part);
    store.subscribe(follow);
    redraw();
  }

  get measured(): Measured | undefined {
    return this.#measurement.curve;
  }

  /** A curve over all wavelengths, or as it is where that is not known. The current one follows its sample. */
  extended(curve: Curve): Curve {
    if (curve.place > 0) return { ...curve, spectrum: this.#pinned.get(keyOf(bare(curve.sample))) ?? curve.spectrum };
    if (this.#latest === undefined) return curve;
    const { sample: { layers, ground_albedo, angle_deg }, answer } = this.#latest;
    const sample = { ...curve.sample, layers, ground_albedo, angle_deg };
    return { ...curve, name: describe(sample), sample, spectrum: answer };
  }

  /** Its wavelengths, if the spectrum of the current sample is known. */
  get wavelengths_nm(): readonly number[] | undefined {
    return this.#latest?.answer.wavelengths_nm;
  }

  /** Computes the spectrum of a pinned sample. */
  async #learn(sample: Sample): Promise<void> {
    const asked = bare(sample);
    if (this.#pinned.has(keyOf(asked))) return;
    this.#pinned.set(keyOf(asked), undefined);
    try {
      this.#pinned.set(keyOf(asked), await this.#spectra.fine(asked));
      this.#redraw();
    } catch (error) {
      const why = error instanceof Error ? error.message : error;
      say(byId("sunlight-error"), `A pinned sample has no solar spectrum: ${why}`);
    }
  }

  #show(shown: Shown<SunlightAnswer>): void {
    this.#bands.show(shown);
    if ("error" in shown) return;
    this.#latest = shown;
    this.#redraw();
  }
}
