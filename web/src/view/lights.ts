/** Lights that the field is solved for one by one: lamps, the sun, and the sky without it. */

import type { Vector, View } from "../state";
import { skyTable, towardsSun } from "./sky";

/** A lamp of 1 W/sr with the keys of a scene file, or a part of a sky. */
export type Light =
  | { type: "point"; position: Vector; illuminant: string; radiant_intensity_w_sr: number }
  | { type: "sun"; sky: ReturnType<typeof skyTable>; towards: Vector }
  | { type: "dome"; sky: ReturnType<typeof skyTable> };

/** The lights of a view as JSON, the key by which their solutions are known. */
export function lightsOf({ lamps, sky }: Pick<View, "lamps" | "sky">): string[] {
  let lights: Light[];
  if (sky === undefined) {
    lights = lamps.map(({ position, illuminant }) => (
      { type: "point", position, illuminant, radiant_intensity_w_sr: 1 }
    ));
  } else {
    const table = skyTable(sky);
    lights = [{ type: "dome", sky: table }];
    if (sky.type === "clear") lights.unshift({ type: "sun", sky: table, towards: towardsSun(sky) });
  }
  return lights.map((light) => JSON.stringify(light));
}

/** What a light is, and by what its solution is multiplied: W/sr of lamps; skies have their own strength. */
export interface Wanted {
  type: Light["type"];
  strength: number;
}

/** The lights of a view in the order of `lightsOf`. */
export function wantedOf({ lamps, sky }: Pick<View, "lamps" | "sky">): Wanted[] {
  if (sky === undefined) return lamps.map((lamp) => ({ type: "point", strength: lamp.radiant_intensity_w_sr }));
  const dome: Wanted = { type: "dome", strength: 1 };
  return sky.type === "clear" ? [{ type: "sun", strength: 1 }, dome] : [dome];
}

/** Directions evenly over the upper half of the sphere, in rings of equal solid angle; three numbers each. */
export const DOME_DIRECTIONS: Float32Array = domeDirections(8, 16);

function domeDirections(rings: number, around: number): Float32Array {
  const directions: number[] = [];
  for (let ring = 0; ring < rings; ring++) {
    const z = (ring + 0.5) / rings;
    for (let place = 0; place < around; place++) {
      const angle = (2 * Math.PI * (place + 0.5 * (ring % 2))) / around;
      const across = Math.sqrt(1 - z * z);
      directions.push(across * Math.cos(angle), across * Math.sin(angle), z);
    }
  }
  return Float32Array.from(directions);
}
