/** What the page computes: the default state, and requests to the engine. */

import { parameters } from "./catalog";
import type { SpectrumRequest } from "./native";
import { impurity, plain } from "./snow";
import { sampleOf, type Sample, type State } from "./state";
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
    view: { shape: "block", method: "field", exposure: "auto", sky: undefined, ...structuredClone(defaults("block")) },
    pinned: [],
  };
}

/** Above this angle, and in wet snow and with algae, the engine uses many streams, and errors take it a second. */
const STEEPEST_DEG = 80;

export function coarseRequest(state: Sample & Pick<State, "swatch_exposure">): SpectrumRequest {
  const hasManyStreams = (state.angle_deg !== "diffuse" && state.angle_deg > STEEPEST_DEG)
    || state.layers.some((layer) => plain(layer, "water_saturation") > 0 || impurity(layer, "snow-algae") > 0);
  return {
    ...sampleOf(state), exposure: state.swatch_exposure, tally_rays: COARSE_RAYS, standard_errors: !hasManyStreams,
  };
}

export function fineRequest(state: Sample & Pick<State, "swatch_exposure">): SpectrumRequest {
  return { ...coarseRequest(state), tally_rays: FINE_RAYS, standard_errors: true };
}
