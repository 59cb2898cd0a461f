/** What infrared light and light at depth depend on. */

import type { Asked } from "../answers";
import type { Sample } from "../state";

/** A sample with all else as usual, so that equal answers have equal keys. */
export function bare({ layers, ground_albedo, angle_deg }: Sample): Asked {
  return { layers, ground_albedo, angle_deg, illuminant: "D65", observer: "1931", swatch_exposure: "auto" };
}
