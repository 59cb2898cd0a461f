/** Ticks of an axis from 0. */

import { niceStep } from "../chart/scale";

/** At most about `count` round values from 0 to the greatest. */
export function ticksOf(greatest: number, count: number): number[] {
  if (greatest <= 0) return [0];
  const step = niceStep(greatest / count);
  return Array.from({ length: Math.floor(greatest / step + 1e-9) + 1 }, (_, index) => index * step);
}
