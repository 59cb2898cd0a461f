/** Answers one question after another. */

import init, * as native from "native:spectrum";
import type {
  CurveFile, DepthProfile, DepthRequest, Difference, DifferenceRequest, MeasuredCurve, SampleRequest, SpectrumAnswer,
  SpectrumRequest, SunlightAnswer,
} from "../native";

/** What can be asked by the name of a function of the module, and what it answers. */
export interface Questions {
  spectrum: [SpectrumRequest, SpectrumAnswer];
  sunlight: [SampleRequest, SunlightAnswer];
  light_at_depth: [DepthRequest, DepthProfile[]];
  measured_curve: [CurveFile, MeasuredCurve];
  difference_from: [DifferenceRequest, Difference];
}

export type Name = keyof Questions;
export interface Question {
  name: Name;
  request: Questions[Name][0];
}
export type Result = { answer: Questions[Name][1] } | { error: string };

let ready: Promise<unknown> | undefined;

/** The first message is the compiled module, all others are questions. */
self.onmessage = async ({ data }: MessageEvent<WebAssembly.Module | Question>) => {
  if (data instanceof WebAssembly.Module) ready = init({ module_or_path: data });
  else self.postMessage(await solve(data));
};

async function solve({ name, request }: Question): Promise<Result> {
  try {
    await ready;
    return { answer: JSON.parse(native[name](JSON.stringify(request))) };
  } catch (error) {
    return { error: error instanceof Error ? error.message : String(error) };
  }
}
