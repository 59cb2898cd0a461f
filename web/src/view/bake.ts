/** The light field at the vertices as a GLB file, after those of `snowblue bake`. */

import { version } from "../catalog";
import type { View } from "../state";
import { type GlbMesh, writeGlb } from "./glb";
import type { LightOnObject } from "./field-messages";
import { wantedOf } from "./lights";
import type { LitBody, SolvedLight } from "./lit-body";
import { skyTable } from "./sky";

/**
 * J by each lamp and the sun (`_LAMP_0` and so on) and by a sky (`_SKY`), H by all with the irradiance by a sky
 * (`_IRRADIANCE`), and a preview as `COLOR_0`: all that leaves the surface, J, H and the irradiance F by lamps and the
 * sun, over pi.
 */
export function bakedGlb(body: LitBody, view: View, exposure: number): Blob {
  const [strengths, name] = [body.strengths(wantedOf(view)), view.shape];
  const attribute = (light: number) => (body.lights[light]!.light.type === "dome" ? "_SKY" : `_LAMP_${light}`);
  const meshes = body.escape.map((escape, object): GlbMesh => {
    const geometry = body.geometryOf(object)!;
    const lit = strengths.map((strength, light) => ({ strength, light: body.lights[light]!.objects[object]! }));
    const [positions, normals] = ["position", "normal"].map((key) => geometry.getAttribute(key).array as Float32Array);
    const count = geometry.getAttribute("position").count;
    const [irradiance, colour] = [new Float32Array(3 * count), new Float32Array(3 * count)];
    const fluxes = lit.map(({ strength, light }) =>
      Float32Array.from({ length: 3 * count }, (_, place) => {
        const flux = strength * light.flux[4 * Math.floor(place / 3) + (place % 3)]!;
        irradiance[place]! += strength * (light.irradiance[place]! + (light.sky[place] ?? 0));
        colour[place]! += flux;
        return flux;
      }),
    );
    const direct = lit.map(({ light }, number) => visibleIrradiance(body.lights[number]!, light, positions!, normals!));
    colour.forEach((flux, place) => {
      const vertex = Math.floor(place / 3);
      const by = (light: number) => strengths[light]! * body.lights[light]!.rgb[place % 3]! * direct[light]![vertex]!;
      const leaving = flux + irradiance[place]! + strengths.reduce((sum, _, light) => sum + by(light), 0);
      colour[place] = Math.min(Math.max((exposure * leaving) / Math.PI, 0), 1);
    });
    return {
      name: body.escape.length === 1 ? name : `${name} ${object}`,
      attributes: {
        POSITION: yUp(geometry.getAttribute("position").array as Float32Array),
        NORMAL: yUp(geometry.getAttribute("normal").array as Float32Array),
        COLOR_0: colour,
        ...Object.fromEntries(fluxes.map((flux, light) => [attribute(light), flux])),
        _IRRADIANCE: irradiance,
      },
      triangles: geometry.getIndex()!.array as Uint32Array,
      extras: {
        escape_polynomial: escape,
        radiance:
          "R0 F + (H + K(mu) J) / pi; F is the irradiance by the visible lamps and the sun, _LAMP_n J by one of " +
          "them, _SKY J by a sky, _IRRADIANCE H and the irradiance by a sky, and K escape_polynomial",
        unit: "W/m2 as linear sRGB",
      },
    };
  });
  const light = view.sky === undefined ? { lamps: view.lamps } : { sky: skyTable(view.sky) };
  return writeGlb(meshes, light, `snowblue ${version}`);
}

/** The irradiance at each vertex by a visible lamp of 1 W/sr, or relative to that of a surface that faces the sun. */
function visibleIrradiance(
  { light: { type }, place }: SolvedLight,
  { flux }: LightOnObject,
  positions: Float32Array,
  normals: Float32Array,
): Float32Array {
  return Float32Array.from({ length: positions.length / 3 }, (_, vertex) => {
    const towards = [0, 1, 2].map((axis) => place[axis]! - (type === "point" ? positions[3 * vertex + axis]! : 0));
    const square = towards.reduce((sum, part) => sum + part * part, 0);
    const along = towards.reduce((sum, part, axis) => sum + part * normals[3 * vertex + axis]!, 0);
    return type === "dome" ? 0 : (flux[4 * vertex + 3]! * Math.max(along, 0)) / square ** 1.5;
  });
}

function yUp(vectors: Float32Array): Float32Array {
  return vectors.map((_, place) => {
    const [axis, vertex] = [place % 3, place - (place % 3)];
    return axis === 0 ? vectors[vertex]! : axis === 1 ? vectors[vertex + 2]! : -vectors[vertex + 1]!;
  });
}
