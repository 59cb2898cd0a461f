/** Axes: from values to pixels, with ticks at round values. */

import { minus, superscript } from "../numbers";

/** How the vertical axes fit: from 0 to 1, close around the curves, or by powers of ten. */
export type Fit = "full" | "close" | "log";

export interface Scale {
  /** Position of a value on an axis of length 1. */
  place(value: number): number;
  ticks: { value: number; label: string }[];
}

const MOST_DECADES = 12;

export function scaleOf(fit: Fit, values: readonly number[], count: number): Scale {
  const shown = values.filter(Number.isFinite);
  if (fit === "full" || shown.length === 0) return linear(0, 1, count);
  const [least, greatest] = [Math.min(...shown), Math.max(...shown)];
  return fit === "log" ? logarithmic(least, greatest, count) : close(least, greatest, count);
}

/** Starts at 0 if the curves are not all far from it. */
function close(least: number, greatest: number, count: number): Scale {
  const bottom = least < 0.6 * greatest ? 0 : least;
  const room = greatest > bottom ? greatest - bottom : Math.max(greatest, 1e-12);
  const step = niceStep(room / count);
  return linear(Math.floor(bottom / step + 1e-9) * step, Math.ceil(greatest / step - 1e-9) * step || step, count);
}

function linear(low: number, high: number, count: number): Scale {
  const top = high > low ? high : low + 1;
  const step = niceStep((top - low) / count);
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const ticks = [];
  for (let index = Math.ceil(low / step - 1e-9); index * step <= top + 1e-9 * step; index += 1) {
    const value = index * step;
    const label = decimals > 4 ? (value === 0 ? "0" : value.toExponential(1)) : value.toFixed(decimals);
    ticks.push({ value, label: minus(label) });
  }
  return { place: (value) => (value - low) / (top - low), ticks };
}

function logarithmic(least: number, greatest: number, count: number): Scale {
  const [first, last] = [least, greatest].map((value) => Math.log10(Math.max(value, 1e-300))) as [number, number];
  const top = Math.ceil(last - 1e-9);
  const bottom = Math.max(Math.min(Math.floor(first + 1e-9), top - 1), top - MOST_DECADES);
  const step = Math.max(1, Math.ceil((top - bottom) / count));
  const ticks = [];
  for (let power = bottom; power <= top; power += step) {
    ticks.push({ value: 10 ** power, label: power === 0 ? "1" : `10${superscript(power)}` });
    // Lines without labels at 2 to 9.
    if (step > 1 || power === top) continue;
    for (let digit = 2; digit <= 9; digit += 1) ticks.push({ value: digit * 10 ** power, label: "" });
  }
  const place = (value: number) => (Math.log10(Math.max(value, 10 ** bottom)) - bottom) / (top - bottom);
  return { place, ticks };
}

/** The next step of 1, 2 or 5 times a power of ten. */
export function niceStep(rough: number): number {
  const power = 10 ** Math.floor(Math.log10(rough));
  const mantissa = rough / power;
  return power * (mantissa <= 1 ? 1 : mantissa <= 2 ? 2 : mantissa <= 5 ? 5 : 10);
}
