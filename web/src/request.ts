/** What the page computes: the default state, and requests to the engine. */

import { impurities, parameters } from "./catalog";
import type { SampleRequest, SpectrumRequest } from "./native";
import { impurity, plain } from "./snow";
import type { Sample, State } from "./state";
import { defaults } from "./view/shapes";

/** Rays through grains of the answer while a control moves. */
export const COARSE_RAYS = 16_384;
/** Rays of the final answer, those of the command. */
export const FINE_RAYS = 262_144;

export function defaultState(): State {
  return {
    layers: [{ thickness_cm: parameters.thickness_cm.default }],
    ground_albedo: parameters.ground_albedo.default,
    angle_deg: parameters.angle_deg.default,
    illuminant: "D65",
    observer: "1931",
    swatch_exposure: "auto",
    range: "visible",
    at_depth: "down",
    view: { shape: "block", method: "field", exposure: "auto", sky: undefined, ...structuredClone(defaults("block")) },
    pinned: [],
  };
}

/** What a spectrum and its colours depend on. */
type Asked = Sample & Pick<State, "swatch_exposure">;

/** Above this angle, and in wet snow and with algae, the engine uses many streams, and errors take it a second. */
const STEEPEST_DEG = 80;

export function coarseRequest(state: Asked): SpectrumRequest {
  const hasManyStreams = (state.angle_deg !== "diffuse" && state.angle_deg > STEEPEST_DEG)
    || state.layers.some((layer) => plain(layer, "water_saturation") > 0
      || impurities.some(({ name, has_sharp_peak }) => has_sharp_peak && impurity(layer, name) > 0));
  return spectrumRequest(state, COARSE_RAYS, !hasManyStreams);
}

export function fineRequest(state: Asked): SpectrumRequest {
  return spectrumRequest(state, FINE_RAYS, true);
}

function spectrumRequest(state: Asked, tally_rays: number, standard_errors: boolean): SpectrumRequest {
  const { illuminant, observer, swatch_exposure: exposure } = state;
  return { sample: sampleRequest(state, tally_rays), illuminant, observer, exposure, standard_errors };
}

/** The snow and its light, and how many rays go through grains. */
export function sampleRequest({ layers, ground_albedo, angle_deg }: Sample, tally_rays: number): SampleRequest {
  return { layers, ground_albedo, angle_deg, tally_rays };
}
