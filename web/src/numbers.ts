/** Numbers as text and in ranges. */

import type { Range } from "./native";

/** A number with some significant digits, without trailing zeros. */
export function short(value: number, digits = 6): string {
  return String(Number(value.toPrecision(digits)));
}

/** A number of fixed significant digits with a true minus sign; below 0.001 as a power of ten. */
export function figure(value: number, digits = 3): string {
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size < 1e-3 || size >= 1e6) {
    const [mantissa, exponent] = value.toExponential(digits - 1).split("e") as [string, string];
    return `${minus(mantissa)} × 10${superscript(Number(exponent))}`;
  }
  const decimals = Math.max(0, digits - 1 - Math.floor(Math.log10(size)));
  return minus(value.toFixed(Math.min(decimals, 8)));
}

/** A number as people type it, with a decimal point or comma; why it has two meanings; or nothing if it is none. */
export function read(text: string): number | string | undefined {
  const typed = text.trim().replace("−", "-");
  if (!/^[+-]?(\d+[.,]?\d*|[.,]\d+)(e[+-]?\d+)?$/i.test(typed)) return undefined;
  if (/^[+-]?[1-9]\d{0,2},\d{3}$/.test(typed)) {
    const meanings = `${Number(typed.replace(",", "."))} or ${typed.replace(",", "")}`;
    return `${typed} may be ${meanings}: enter it without the comma`;
  }
  return Number(typed.replace(",", "."));
}

/** A number with fixed decimals and a true minus sign. */
export function decimal(value: number, decimals: number): string {
  const text = value.toFixed(decimals);
  return minus(Number(text) === 0 ? (0).toFixed(decimals) : text);
}

/** A value with its unit, if it has one. */
export function withUnit(text: string, unit: string): string {
  return unit === "" ? text : unit === "°" ? `${text}°` : `${text} ${unit}`;
}

/** Why a value does not lie in a range, in the words of the command, or nothing. */
export function outside(quantity: string, value: number, range: Range): string | undefined {
  const { least, greatest, unit } = range;
  if (value >= least && value <= greatest) return undefined;
  return `${quantity} is ${withUnit(short(value), unit)}, but must lie in ${withUnit(between(least, greatest), unit)}`;
}

export function between(least: number, greatest: number): string {
  const dash = least < 0 || greatest < 0 ? " to " : "–";
  return `${minus(short(least))}${dash}${minus(short(greatest))}`;
}

export function superscript(exponent: number): string {
  const raised = (sign: string): string => (sign === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(sign)]!);
  return [...String(exponent)].map(raised).join("");
}

export function minus(text: string): string {
  return text.replace("-", "−");
}
