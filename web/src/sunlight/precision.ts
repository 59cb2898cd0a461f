/** How exact figures are that have no standard error. */

import { COARSE_RAYS, FINE_RAYS } from "../request";

export function precision(isFine: boolean): string {
  const [name, rays] = isFine ? ["Final", FINE_RAYS] : ["Preview", COARSE_RAYS];
  return `${name}: ${rays.toLocaleString("en")} rays through grains.`;
}
