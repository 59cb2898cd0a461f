/** Computes one spectrum after another. */

import init, { spectrum } from "native:spectrum";
import type { SpectrumAnswer, SpectrumRequest } from "../native";

export type SpectrumResult = { answer: SpectrumAnswer } | { error: string };

let ready: Promise<unknown> | undefined;

/** The first message is the compiled module, all others are requests. */
self.onmessage = async ({ data }: MessageEvent<WebAssembly.Module | SpectrumRequest>) => {
  if (data instanceof WebAssembly.Module) ready = init({ module_or_path: data });
  else self.postMessage(await solve(data));
};

async function solve(request: SpectrumRequest): Promise<SpectrumResult> {
  try {
    await ready;
    return { answer: JSON.parse(spectrum(JSON.stringify(request))) };
  } catch (error) {
    return { error: error instanceof Error ? error.message : String(error) };
  }
}
