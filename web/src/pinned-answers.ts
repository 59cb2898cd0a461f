/** Fine answers for pinned samples. */

import { keyOf, type Asked } from "./answers";
import { say } from "./dom";

export class PinnedAnswers<Answer> {
  readonly #fine: (asked: Asked) => Promise<Answer>;
  readonly #note: HTMLElement;
  readonly #what: string;
  readonly #changed: () => void;
  readonly #known = new Map<string, Answer>();
  readonly #computing = new Map<string, Promise<void>>();

  /** `changed` is called when an answer is known. `note` says that a sample has no `what` if its computation fails. */
  constructor(fine: (asked: Asked) => Promise<Answer>, note: HTMLElement, what: string, changed: () => void) {
    this.#fine = fine;
    this.#note = note;
    this.#what = what;
    this.#changed = changed;
  }

  get(asked: Asked): Answer | undefined {
    return this.#known.get(keyOf(asked));
  }

  /** Computes the answers that are not known. What has failed is computed again. The page says that one fails. */
  want(asked: Asked[]): void {
    this.all(asked).catch(() => undefined);
  }

  /** Waits until all answers are known; fails if one fails. */
  async all(asked: Asked[]): Promise<void> {
    await Promise.all(asked.map((one) => this.#one(one)));
  }

  #one(asked: Asked): Promise<void> {
    const key = keyOf(asked);
    if (this.#known.has(key)) return Promise.resolve();
    const computing = this.#computing.get(key) ?? this.#compute(asked).finally(() => this.#computing.delete(key));
    this.#computing.set(key, computing);
    return computing;
  }

  async #compute(asked: Asked): Promise<void> {
    say(this.#note, "");
    try {
      this.#known.set(keyOf(asked), await this.#fine(asked));
    } catch (error) {
      const reason = error instanceof Error ? error.message : error;
      say(this.#note, `A pinned sample has no ${this.#what}: ${reason}`);
      throw error;
    }
    this.#changed();
  }
}
