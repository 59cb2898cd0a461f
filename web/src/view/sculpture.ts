/** A sculpture of snow: a column with three rounded lobes that winds about its axis and is slimmest at its waist. */

import type { Triangles } from "./triangles";

const HEIGHT_M = 0.56;
const TURN_RAD = 2.1;

/** Distance of the surface from the axis in m; `up` runs from 0 to 1. */
function radius(up: number, angle: number): number {
  const waist = 0.165 + 0.045 * Math.cos(2 * Math.PI * up) + 0.012 * (1 - 2 * up);
  const lobes = 1 + 0.16 * Math.cos(3 * (angle - TURN_RAD * up));
  // Both ends are rounded.
  const fromEnd = HEIGHT_M * Math.min(up, 1 - up);
  const rounding = 0.09;
  const end = fromEnd < rounding ? Math.sqrt(1 - (1 - fromEnd / rounding) ** 2) : 1;
  return waist * lobes * end;
}

export function sculpture(stepsUp: number, stepsAround: number): Triangles {
  const positions: number[] = [0, 0, 0];
  for (let ring = 1; ring < stepsUp; ring++) {
    // Rings are close together at the ends.
    const up = 0.5 - 0.5 * Math.cos((Math.PI * ring) / stepsUp);
    for (let around = 0; around < stepsAround; around++) {
      const angle = (2 * Math.PI * around) / stepsAround;
      const distance = radius(up, angle);
      positions.push(distance * Math.cos(angle), distance * Math.sin(angle), HEIGHT_M * up);
    }
  }
  positions.push(0, 0, HEIGHT_M);
  const top = positions.length / 3 - 1;
  const at = (ring: number, around: number) => 1 + (ring - 1) * stepsAround + (around % stepsAround);
  const triangles: number[] = [];
  for (let around = 0; around < stepsAround; around++) {
    triangles.push(0, at(1, around + 1), at(1, around), top, at(stepsUp - 1, around), at(stepsUp - 1, around + 1));
    for (let ring = 1; ring < stepsUp - 1; ring++) {
      const [a, b, c, d] = [at(ring, around), at(ring, around + 1), at(ring + 1, around + 1), at(ring + 1, around)];
      triangles.push(a, b, c, a, c, d);
    }
  }
  return { positions, triangles };
}
