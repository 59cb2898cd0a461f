/** Blue and red light beside each other, in words. */

import { short } from "./numbers";

export const BLUE_NM = 450;
export const RED_NM = 650;
/** Beyond this the darker light is not seen at all. */
const MOST_TIMES = 10_000;
/** A part of light below which hardly any is left. */
const HARDLY_ANY = 1e-9;

interface Wavelengths {
  wavelengths_nm: readonly number[];
}

/** A value at a wavelength. */
export function at(values: readonly number[], { wavelengths_nm }: Wavelengths, nm: number): number {
  return values[wavelengths_nm.indexOf(nm)]!;
}

/**
 * How many times as bright as the other of both lights one is, in a clause. Nothing where hardly any light is left of a
 * whole.
 */
export function compared(values: readonly number[], wavelengths: Wavelengths, whole = 0): string | undefined {
  const [blue, red] = [at(values, wavelengths, BLUE_NM), at(values, wavelengths, RED_NM)];
  if (!(Math.max(blue, red) > HARDLY_ANY * whole)) return undefined;
  const [one, other, times] = blue >= red ? ["blue", "red", blue / red] : ["red", "blue", red / blue];
  const words = times > 0 && times < MOST_TIMES ? short(times, 2) : `more than ${MOST_TIMES.toLocaleString("en")}`;
  return `${one} is ${words} times as bright as ${other}`;
}
