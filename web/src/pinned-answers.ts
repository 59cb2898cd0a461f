/** Fine answers for pinned samples. */

import { keyOf, type Asked } from "./answers";
import { describe } from "./describe";
import { say } from "./dom";

export class PinnedAnswers<Answer> {
  readonly #fine: (asked: Asked) => Promise<Answer>;
  readonly #note: HTMLElement;
  readonly #what: string;
  readonly #changed: () => void;
  readonly #known = new Map<string, Answer>();
  /** Why an answer could not be computed. */
  readonly #failed = new Map<string, string>();
  readonly #computing = new Map<string, Promise<void>>();
  #wanted: Asked[] = [];

  /**
   * `changed` is called when an answer is known or cannot be. `note` says which samples have no `what`, and why.
   */
  constructor(fine: (asked: Asked) => Promise<Answer>, note: HTMLElement, what: string, changed: () => void) {
    this.#fine = fine;
    this.#note = note;
    this.#what = what;
    this.#changed = changed;
  }

  get(asked: Asked): Answer | undefined {
    return this.#known.get(keyOf(asked));
  }

  /** Why the last computation of an answer failed, until the next one starts. */
  failure(asked: Asked): string | undefined {
    return this.#failed.get(keyOf(asked));
  }

  /** Computes the answers that are not known. What has failed is computed again. The page says which ones fail. */
  want(asked: Asked[]): void {
    this.all(asked).catch(() => undefined);
  }

  /** Waits until all answers are known; fails if one fails. */
  async all(asked: Asked[]): Promise<void> {
    this.#wanted = asked;
    const all = asked.map((one) => this.#one(one));
    this.#report();
    await Promise.all(all);
  }

  #one(asked: Asked): Promise<void> {
    const key = keyOf(asked);
    if (this.#known.has(key)) return Promise.resolve();
    const computing = this.#computing.get(key) ?? this.#compute(asked).finally(() => this.#computing.delete(key));
    this.#computing.set(key, computing);
    return computing;
  }

  async #compute(asked: Asked): Promise<void> {
    const key = keyOf(asked);
    this.#failed.delete(key);
    try {
      this.#known.set(key, await this.#fine(asked));
    } catch (error) {
      this.#failed.set(key, error instanceof Error ? error.message : String(error));
      throw error;
    } finally {
      this.#report();
      this.#changed();
    }
  }

  #report(): void {
    const sentences = this.#wanted.flatMap((asked) => {
      const reason = this.failure(asked);
      return reason === undefined ? [] : [`The pinned sample ${describe(asked)} has no ${this.#what}: ${reason}.`];
    });
    say(this.#note, sentences.join(" "));
  }
}
