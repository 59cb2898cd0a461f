/** The light field at the vertices as a GLB file, with the attributes of `snowblue bake`. */

import { version } from "../catalog";
import type { Lamp } from "../state";
import { type GlbMesh, writeGlb } from "./glb";
import type { LitBody } from "./lit-body";

/** J by each lamp (`_LAMP_0` and so on), H by all (`_IRRADIANCE`), and a preview as `COLOR_0`. */
export function bakedGlb(body: LitBody, lamps: readonly Lamp[], exposure: number, name: string): Blob {
  const strengths = lamps.map((lamp) => lamp.radiant_intensity_w_sr);
  const meshes = body.escape.map((escape, object): GlbMesh => {
    const geometry = body.geometryOf(object)!;
    const lit = strengths.map((strength, lamp) => ({ strength, light: body.lamps[lamp]!.objects[object]! }));
    const count = geometry.getAttribute("position").count;
    const [irradiance, colour] = [new Float32Array(3 * count), new Float32Array(3 * count)];
    const fluxes = lit.map(({ strength, light }) =>
      Float32Array.from({ length: 3 * count }, (_, place) => {
        const flux = strength * light.flux[4 * Math.floor(place / 3) + (place % 3)]!;
        irradiance[place]! += strength * light.irradiance[place]!;
        colour[place]! += flux;
        return flux;
      }),
    );
    colour.forEach((flux, place) => {
      colour[place] = Math.min(Math.max((exposure * (flux + irradiance[place]!)) / Math.PI, 0), 1);
    });
    return {
      name: body.escape.length === 1 ? name : `${name} ${object}`,
      attributes: {
        POSITION: yUp(geometry.getAttribute("position").array as Float32Array),
        NORMAL: yUp(geometry.getAttribute("normal").array as Float32Array),
        COLOR_0: colour,
        ...Object.fromEntries(fluxes.map((flux, lamp) => [`_LAMP_${lamp}`, flux])),
        _IRRADIANCE: irradiance,
      },
      triangles: geometry.getIndex()!.array as Uint32Array,
      extras: {
        escape_polynomial: escape,
        radiance: "R0 F + (H + K(mu) J) / pi; _LAMP_n is J by a lamp, _IRRADIANCE is H, K is escape_polynomial",
        unit: "W/m2 as linear sRGB",
      },
    };
  });
  return writeGlb(meshes, { lamps }, `snowblue ${version}`);
}

function yUp(vectors: Float32Array): Float32Array {
  return vectors.map((_, place) => {
    const [axis, vertex] = [place % 3, place - (place % 3)];
    return axis === 0 ? vectors[vertex]! : axis === 1 ? vectors[vertex + 2]! : -vectors[vertex + 1]!;
  });
}
