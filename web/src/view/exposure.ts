/** Automatic exposure of the view: it fits the light that comes through the snow, from wherever it is seen. */

import type { LitBody } from "./lit-body";

/** A part of the vertices, and the level of the brightest channel below which it is; 1 is a display's brightest. */
interface Rule {
  part: number;
  level: number;
}

/** Lamps outside: the places near them may clip, so that the light through the snow is bright enough. */
const OUTSIDE: Rule = { part: 0.9, level: 2.8 };
/** Under a sky: half of the snow is darker than half of white, so that what is lit keeps its shades. */
const SKY: Rule = { part: 0.5, level: 0.5 };
/** Lamps inside: all light has come through the snow. */
const INSIDE: Rule = { part: 0.98, level: 0.95 };
/** Greatest share of the net flux that enters where lamps are inside. */
const ENTERING = 0.1;
/** Cosine of exit. */
const MU = 0.8;

/**
 * Stops at which a quantile of the vertices has a level; undefined without light. By lamps, only vertices count where
 * more light leaves than enters, and bright snow around them clips to white.
 */
export function automaticStops(body: LitBody, strengths: readonly number[]): number | undefined {
  const levels: number[] = [];
  let [entering, leaving] = [0, 0];
  const lit = body.lights.slice(0, strengths.length);
  const isSky = lit.some((one) => one !== undefined && one.light.type !== "point");
  body.escape.forEach(([k0, k1, k2, k3], object) => {
    const k = k0! + MU * (k1! + MU * (k2! + MU * k3!));
    const lights = lit.map((one) => one?.objects[object]);
    const geometry = body.geometryOf(object);
    const vertices = geometry?.getAttribute("position").count ?? 0;
    const normals = geometry?.getAttribute("normal").array;
    const facing = (vertex: number, [x, y, z]: readonly number[]) =>
      Math.max(0, x! * normals![3 * vertex]! + y! * normals![3 * vertex + 1]! + z! * normals![3 * vertex + 2]!);
    for (let vertex = 0; vertex < vertices; vertex++) {
      let brightest = 0;
      let net = 0;
      for (const channel of [0, 1, 2] as const) {
        let [flux, irradiance] = [0, 0];
        lights.forEach((light, number) => {
          const strength = strengths[number]!;
          flux += strength * (light?.flux[4 * vertex + channel] ?? 0);
          irradiance += strength * (light?.irradiance[3 * vertex + channel] ?? 0);
          if (!isSky || light === undefined) return;
          const { light: { type }, place, rgb } = lit[number]!;
          if (type === "sun") irradiance += rgb[channel]! * light.flux[4 * vertex + 3]! * facing(vertex, place);
          else if (type === "dome") irradiance += light.sky[3 * vertex + channel]!;
        });
        if (channel === 1) net = flux;
        brightest = Math.max(brightest, (k * flux + irradiance) / Math.PI);
      }
      if (isSky || net > 0) levels.push(brightest);
      entering += Math.max(-net, 0);
      leaving += Math.max(net, 0);
    }
  });
  if (levels.length === 0) return undefined;
  levels.sort((one, other) => one - other);
  const { part, level } = isSky ? SKY : entering < ENTERING * leaving ? INSIDE : OUTSIDE;
  const found = levels[Math.floor(part * levels.length)]!;
  return found > 0 ? Math.log2(level / found) : undefined;
}
