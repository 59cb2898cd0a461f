/** The answer for the latest sample: a coarse one at once, a fine one when the sample stops changing. */

import type { Engine } from "./engine";
import { encodeSample } from "./fragment";
import type { Sample, State } from "./state";
import type { Name, Questions } from "./workers/spectrum";

/** Time without a change before the fine computation starts, in ms. */
const REST_MS = 300;
/** So many fine answers are kept. */
const MOST_KEPT = 64;

export type Asked = Sample & Pick<State, "swatch_exposure">;
/** Said of figures that stay after an error. */
export const FORMER = "The figures are those of the sample before.";

type Outcome<Answer> = { answer: Answer } | { error: string };
export type Shown<Answer> = { sample: Asked; fine: boolean } & Outcome<Answer>;

/** What is asked of a sample, coarsely or finely. */
export interface Subject<One extends Name> {
  name: One;
  coarse(sample: Asked): Questions[One][0];
  fine(sample: Asked): Questions[One][0];
}

export class Answers<One extends Name> {
  readonly #quick: Engine;
  readonly #fine: Engine;
  readonly #subject: Subject<One>;
  readonly #kept = new Map<string, Questions[One][1]>();
  /** Fine answers that are being computed. */
  readonly #computing = new Map<string, Promise<Questions[One][1]>>();
  readonly #show: (shown: Shown<Questions[One][1]>) => void;
  readonly #wait: () => void;
  #wanted: Asked | undefined;
  #isQuickBusy = false;
  #rest: ReturnType<typeof setTimeout> | undefined;
  #abort = new AbortController();

  /**
   * A quick and a fine engine, which others may use too. `wait` is called when a sample is wanted whose answer is not
   * known yet.
   */
  constructor(
    [quick, fine]: readonly [Engine, Engine],
    subject: Subject<One>,
    show: (shown: Shown<Questions[One][1]>) => void,
    wait: () => void,
  ) {
    [this.#quick, this.#fine] = [quick, fine];
    this.#subject = subject;
    this.#show = show;
    this.#wait = wait;
  }

  /** Keeps a fine answer. */
  keep(sample: Asked, answer: Questions[One][1]): void {
    this.#kept.set(keyOf(sample), answer);
    const [oldest] = this.#kept.keys();
    if (this.#kept.size > MOST_KEPT) this.#kept.delete(oldest!);
  }

  /** What was asked for no longer matters. */
  drop(): void {
    this.#abort.abort();
    this.#abort = new AbortController();
    clearTimeout(this.#rest);
    this.#wanted = undefined;
  }

  /** Shows the answer for a sample; what was asked for before no longer matters. */
  want(sample: Asked): void {
    this.drop();
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
    void outcome(this.#coarse(sample));
  }

  /** The fine answer for a sample. */
  async fine(sample: Asked, signal?: AbortSignal): Promise<Questions[One][1]> {
    const key = keyOf(sample);
    // One that is aborted or fails is computed again.
    await this.#computing.get(key)?.catch(() => undefined);
    signal?.throwIfAborted();
    const kept = this.#kept.get(key);
    if (kept !== undefined) return kept;
    const computing = this.#fine.ask(this.#subject.name, this.#subject.fine(sample), signal);
    this.#computing.set(key, computing);
    try {
      const answer = await computing;
      this.keep(sample, answer);
      return answer;
    } finally {
      if (this.#computing.get(key) === computing) this.#computing.delete(key);
    }
  }

  #coarse(sample: Asked): Promise<Questions[One][1]> {
    return this.#quick.ask(this.#subject.name, this.#subject.coarse(sample));
  }

  async #showCoarse(): Promise<void> {
    if (this.#isQuickBusy) return;
    this.#isQuickBusy = true;
    while (this.#wanted !== undefined) {
      const sample = this.#wanted;
      const result = await outcome(this.#coarse(sample));
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

async function outcome<Answer>(answer: Promise<Answer>): Promise<Outcome<Answer>> {
  try {
    return { answer: await answer };
  } catch (error) {
    return { error: error instanceof Error ? error.message : String(error) };
  }
}
