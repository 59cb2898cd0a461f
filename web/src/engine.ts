/** A worker that answers one question after another. */

import type { Name, Question, Questions, Result } from "./workers/spectrum";

interface Job {
  question: Question;
  signal: AbortSignal | undefined;
  resolve(answer: Questions[Name][1]): void;
  reject(reason: unknown): void;
}

export class Engine {
  readonly #module: () => Promise<WebAssembly.Module>;
  readonly #queue: Job[] = [];
  #worker: Worker | undefined;
  #running: Job | undefined;

  /** `module` compiles the module `spectrum`, when there is a question. */
  constructor(module: () => Promise<WebAssembly.Module>) {
    this.#module = module;
  }

  /** The answer, after all that were asked for before. Rejects in the words of the engine, or when it is aborted. */
  ask<One extends Name>(name: One, request: Questions[One][0], signal?: AbortSignal): Promise<Questions[One][1]> {
    return new Promise((resolve, reject) => {
      const job = { question: { name, request }, signal, resolve: resolve as Job["resolve"], reject };
      signal?.addEventListener("abort", () => this.#abort(job), { once: true });
      this.#queue.push(job);
      void this.#next();
    });
  }

  async #next(): Promise<void> {
    if (this.#running !== undefined) return;
    const job = this.#queue.shift();
    if (job === undefined) return;
    this.#running = job;
    try {
      const module = await this.#module();
      if (this.#running === job) this.#work(module).postMessage(job.question);
    } catch (reason) {
      this.#end(job, () => job.reject(reason));
    }
  }

  #work(module: WebAssembly.Module): Worker {
    if (this.#worker !== undefined) return this.#worker;
    const worker = new Worker(new URL("spectrum.js", import.meta.url), { type: "module" });
    worker.onmessage = ({ data }: MessageEvent<Result>) => {
      const job = this.#running!;
      this.#end(job, () => ("error" in data ? job.reject(new Error(data.error)) : job.resolve(data.answer)));
    };
    worker.onerror = ({ message }) => {
      const job = this.#running;
      this.#worker = undefined;
      const why = message ?? "its worker could not be loaded";
      if (job !== undefined) this.#end(job, () => job.reject(new Error(`The computation stopped: ${why}`)));
    };
    worker.postMessage(module);
    this.#worker = worker;
    return worker;
  }

  #end(job: Job, settle: () => void): void {
    if (this.#running === job) this.#running = undefined;
    settle();
    void this.#next();
  }

  /** A computation cannot be interrupted: its worker ends, and a new one goes on. */
  #abort(job: Job): void {
    const waiting = this.#queue.indexOf(job);
    if (waiting >= 0) this.#queue.splice(waiting, 1);
    else if (this.#running !== job) return;
    else {
      this.#worker?.terminate();
      this.#worker = undefined;
    }
    this.#end(job, () => job.reject(job.signal!.reason));
  }
}
