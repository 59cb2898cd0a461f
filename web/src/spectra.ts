/** The spectrum of the latest sample: a coarse one at once, a fine one when the sample stops changing. */

import { Engine } from "./engine";
import { encodeSample } from "./fragment";
import type { SpectrumAnswer } from "./native";
import { coarseRequest, defaultState, fineRequest } from "./request";
import type { Sample, State } from "./state";
import firstAnswer from "virtual:first-answer";

/** Time without a change before the fine computation starts, in ms. */
const REST_MS = 300;
/** So many fine answers are kept. */
const MOST_KEPT = 64;

export type Asked = Sample & Pick<State, "swatch_exposure">;
export type Shown = { sample: Asked; fine: boolean } & ({ answer: SpectrumAnswer } | { error: string });

export class Spectra {
  readonly #quick: Engine;
  readonly #fine: Engine;
  readonly #kept = new Map<string, SpectrumAnswer>();
  readonly #show: (shown: Shown) => void;
  readonly #wait: () => void;
  #wanted: Asked | undefined;
  #isQuickBusy = false;
  #rest: ReturnType<typeof setTimeout> | undefined;
  #abort = new AbortController();

  /** `wait` is called when a sample is wanted whose spectrum is not known yet. */
  constructor(module: Promise<WebAssembly.Module>, show: (shown: Shown) => void, wait: () => void) {
    this.#quick = new Engine(module);
    this.#fine = new Engine(module);
    this.#show = show;
    this.#wait = wait;
    this.#kept.set(keyOf(defaultState()), firstAnswer);
  }

  /** Shows the spectrum of a sample; what was asked for before no longer matters. */
  want(sample: Asked): void {
    this.#abort.abort();
    this.#abort = new AbortController();
    clearTimeout(this.#rest);
    this.#wanted = undefined;
    const kept = this.#kept.get(keyOf(sample));
    if (kept !== undefined) {
      this.#show({ sample, fine: true, answer: kept });
      return;
    }
    this.#wanted = sample;
    this.#wait();
    void this.#showCoarse();
    const { signal } = this.#abort;
    this.#rest = setTimeout(() => void this.#showFine(sample, signal), REST_MS);
  }

  /** Makes the coarse answer to a sample ready, so that the first change is quick. */
  warm(sample: Asked): void {
    void outcome(this.#quick.ask(coarseRequest(sample)));
  }

  /** The fine spectrum of a sample. */
  async fine(sample: Asked, signal?: AbortSignal): Promise<SpectrumAnswer> {
    const key = keyOf(sample);
    const kept = this.#kept.get(key);
    if (kept !== undefined) return kept;
    const answer = await this.#fine.ask(fineRequest(sample), signal);
    this.#kept.set(key, answer);
    const [oldest] = this.#kept.keys();
    if (this.#kept.size > MOST_KEPT) this.#kept.delete(oldest!);
    return answer;
  }

  async #showCoarse(): Promise<void> {
    if (this.#isQuickBusy) return;
    this.#isQuickBusy = true;
    while (this.#wanted !== undefined) {
      const sample = this.#wanted;
      const result = await outcome(this.#quick.ask(coarseRequest(sample)));
      if (this.#wanted !== sample) continue;
      this.#wanted = undefined;
      this.#show({ sample, fine: false, ...result });
    }
    this.#isQuickBusy = false;
  }

  async #showFine(sample: Asked, signal: AbortSignal): Promise<void> {
    const result = await outcome(this.fine(sample, signal));
    if (signal.aborted) return;
    this.#wanted = undefined;
    this.#show({ sample, fine: true, ...result });
  }
}

/** Equal for samples with equal answers. */
export function keyOf(sample: Asked): string {
  return `${encodeSample(sample)}&exposure=${sample.swatch_exposure}`;
}

async function outcome(answer: Promise<SpectrumAnswer>): Promise<{ answer: SpectrumAnswer } | { error: string }> {
  try {
    return { answer: await answer };
  } catch (error) {
    return { error: error instanceof Error ? error.message : String(error) };
  }
}
