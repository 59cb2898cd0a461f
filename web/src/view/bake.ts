/** The light field at the vertices as a GLB file, after those of `snowblue bake`. */

import { version } from "../catalog";
import type { Lamp } from "../state";
import { type GlbMesh, writeGlb } from "./glb";
import type { LampLight } from "./field-messages";
import type { LitBody } from "./lit-body";

/**
 * J by each lamp (`_LAMP_0` and so on), H by all (`_IRRADIANCE`), and a preview as `COLOR_0`: all that leaves the surface,
 * J, H and the irradiance F by the lamps, over pi.
 */
export function bakedGlb(body: LitBody, lamps: readonly Lamp[], exposure: number, name: string): Blob {
  const strengths = lamps.map((lamp) => lamp.radiant_intensity_w_sr);
  const meshes = body.escape.map((escape, object): GlbMesh => {
    const geometry = body.geometryOf(object)!;
    const lit = strengths.map((strength, lamp) => ({ strength, light: body.lamps[lamp]!.objects[object]! }));
    const [positions, normals] = ["position", "normal"].map((key) => geometry.getAttribute(key).array as Float32Array);
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
    const direct = lit.map(({ light }, lamp) => visibleIrradiance(body.lamps[lamp]!.position, light, positions!, normals!));
    colour.forEach((flux, place) => {
      const vertex = Math.floor(place / 3);
      const by = (lamp: number) => strengths[lamp]! * body.lamps[lamp]!.rgb[place % 3]! * direct[lamp]![vertex]!;
      const leaving = flux + irradiance[place]! + strengths.reduce((sum, _, lamp) => sum + by(lamp), 0);
      colour[place] = Math.min(Math.max((exposure * leaving) / Math.PI, 0), 1);
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
        radiance:
          "R0 F + (H + K(mu) J) / pi; F is the irradiance by the visible lamps, _LAMP_n J by a lamp, _IRRADIANCE H, " +
          "and K escape_polynomial",
        unit: "W/m2 as linear sRGB",
      },
    };
  });
  return writeGlb(meshes, { lamps }, `snowblue ${version}`);
}

/** The irradiance at each vertex by a visible lamp of 1 W/sr. */
function visibleIrradiance(
  lamp: readonly number[],
  { flux }: LampLight,
  positions: Float32Array,
  normals: Float32Array,
): Float32Array {
  return Float32Array.from({ length: positions.length / 3 }, (_, vertex) => {
    const towards = [0, 1, 2].map((axis) => lamp[axis]! - positions[3 * vertex + axis]!);
    const square = towards.reduce((sum, part) => sum + part * part, 0);
    const along = towards.reduce((sum, part, axis) => sum + part * normals[3 * vertex + axis]!, 0);
    return (flux[4 * vertex + 3]! * Math.max(along, 0)) / square ** 1.5;
  });
}

function yUp(vectors: Float32Array): Float32Array {
  return vectors.map((_, place) => {
    const [axis, vertex] = [place % 3, place - (place % 3)];
    return axis === 0 ? vectors[vertex]! : axis === 1 ? vectors[vertex + 2]! : -vectors[vertex + 1]!;
  });
}
