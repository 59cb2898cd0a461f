/** Sizes of the cells of light fields. */

import type { Body, Size } from "./shapes";
import type { SnowMaterial } from "./snow";

/** Wanted unknowns, and about how many there are for each square of the size of a cell at the surface. */
const NODES: Record<Size, number> = { coarse: 5000, fine: 40_000 };
const NODES_PER_CELL = 4.6;
/** Transport mean free path in snow of 400 µm and 300 kg/m³, in mm. */
const MEAN_FREE_PATH_MM = 2;
/** Greatest step in transport mean free paths: 50, with a margin. */
const MOST_PATHS = 40;

/**
 * Distance of vertices in the fine field, in cells. At 0.7 cells half of the pixels of the drift are within 0.4 % of a
 * rendering, here within 0.8 %; but a software GPU draws 8 frames a second instead of 18.
 */
const CELLS_PER_EDGE = 1.5;

/** Size of the cells at the surface of a body, in mm. */
export function stepOf(body: Body, { grain_size_um, density_kg_m3 }: SnowMaterial, size: Size): number {
  const step = 1e3 * Math.sqrt((NODES_PER_CELL * body.area) / NODES[size]);
  const path = MEAN_FREE_PATH_MM * (grain_size_um / 400) * (300 / density_kg_m3);
  return Number(Math.min(step, MOST_PATHS * path).toPrecision(3));
}

/** Greatest distance of vertices in the fine field of a body, in mm. */
export function fineEdge(body: Body, material: SnowMaterial): number {
  return CELLS_PER_EDGE * stepOf(body, material, "fine");
}
