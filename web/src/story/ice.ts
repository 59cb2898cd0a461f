/** Light on its path through ice. */

import { clearIce, parameters } from "../catalog";

export const FIRST_NM = 400;
export const STEP_NM = 10;
/** Absorption coefficient of ice at 400, 410, … 700 nm, in 1/m (Warren & Brandt 2008). */
export const { absorption_per_m } = clearIce;

/** The same, linear between these wavelengths. */
export function absorptionAt(wavelength_nm: number): number {
  const place = (wavelength_nm - FIRST_NM) / STEP_NM;
  const before = Math.min(Math.floor(place), absorption_per_m.length - 2);
  const [low, high] = [absorption_per_m[before]!, absorption_per_m[before + 1]!];
  return low + (place - before) * (high - low);
}

/** The part of light that is left after a path through clear ice, by Beer's law. */
export function left(wavelength_nm: number, path_m: number): number {
  return Math.exp(-absorptionAt(wavelength_nm) * path_m);
}

/** Thickness of the ice in a layer of snow, if it were without pores, in m. */
export function solidIce_m(thickness_cm: number, density_kg_m3 = parameters.density_kg_m3.default): number {
  return (0.01 * thickness_cm * density_kg_m3) / clearIce.density_kg_m3;
}

/** Surfaces of grains on a path through ice: its straight pieces measure 4/(ρ S) in the mean (Cauchy). */
export function surfacesOn(path_m: number, ssa_m2_kg: number): number {
  return (path_m * clearIce.density_kg_m3 * ssa_m2_kg) / 4;
}
