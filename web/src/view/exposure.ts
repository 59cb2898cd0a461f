/** Automatic exposure of the view: it fits the light that comes through the snow, from wherever it is seen. */

import type { LitBody } from "./lit-body";

/** A part of the vertices, and the level of the brightest channel below which it is; 1 is a display's brightest. */
interface Rule {
  part: number;
  level: number;
}

/** Lamps outside: the places near them may clip, so that the light through the snow is bright enough. */
const OUTSIDE: Rule = { part: 0.9, level: 2.8 };
/** Lamps inside: all light has come through the snow. */
const INSIDE: Rule = { part: 0.98, level: 0.95 };
/** Greatest share of the net flux that enters where lamps are inside. */
const ENTERING = 0.1;
/** Cosine of exit. */
const MU = 0.8;

/**
 * Stops at which a quantile of the vertices where more light leaves than enters has a level; undefined without light.
 * Bright snow around them clips to white.
 */
export function automaticStops(body: LitBody, strengths: readonly number[]): number | undefined {
  const levels: number[] = [];
  let [entering, leaving] = [0, 0];
  body.escape.forEach(([k0, k1, k2, k3], object) => {
    const k = k0! + MU * (k1! + MU * (k2! + MU * k3!));
    const lamps = body.lamps.slice(0, strengths.length).map((lamp) => lamp?.objects[object]);
    const vertices = body.geometryOf(object)?.getAttribute("position").count ?? 0;
    for (let vertex = 0; vertex < vertices; vertex++) {
      let brightest = 0;
      let net = 0;
      for (const channel of [0, 1, 2]) {
        let [flux, irradiance] = [0, 0];
        lamps.forEach((lamp, number) => {
          flux += strengths[number]! * (lamp?.flux[4 * vertex + channel] ?? 0);
          irradiance += strengths[number]! * (lamp?.irradiance[3 * vertex + channel] ?? 0);
        });
        if (channel === 1) net = flux;
        brightest = Math.max(brightest, (k * flux + irradiance) / Math.PI);
      }
      if (net > 0) levels.push(brightest);
      entering += Math.max(-net, 0);
      leaving += Math.max(net, 0);
    }
  });
  if (levels.length === 0) return undefined;
  levels.sort((one, other) => one - other);
  const { part, level } = entering < ENTERING * leaving ? INSIDE : OUTSIDE;
  return Math.log2(level / levels[Math.floor(part * levels.length)]!);
}
