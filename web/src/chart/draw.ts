/** Draws reflectance, transmittance and absorptance against wavelength. */

import { wavelengthColors } from "../catalog";
import { describe } from "../describe";
import { svg } from "../dom";
import type { MeasuredCurve, Measures, Spectrum, SpectrumAnswer } from "../native";
import type { Range, Sample } from "../state";
import { niceStep, scaleOf, type Fit, type Scale } from "./scale";

export const QUANTITIES = [
  { key: "reflectance", error: "reflectance_se", sign: "R", name: "Reflectance" },
  { key: "transmittance", error: "transmittance_se", sign: "T", name: "Transmittance" },
  { key: "absorptance", error: "absorptance_se", sign: "A", name: "Absorptance" },
] as const;

/** A sample in the chart. `place` selects colour and dashes: 0 is the current one. */
export interface Curve {
  name: string;
  place: number;
  sample: Sample;
  spectrum: Spectrum;
  /** Of the transmitted light. */
  hex: string;
}

/** A measured curve in the chart. */
export interface Measured extends MeasuredCurve {
  name: string;
  quantity: Measures;
}

export interface Size {
  width: number;
  /** Panels in a row: 3 or 1. */
  columns: number;
}

/** All that a chart shows. */
export interface Content {
  /** The first one is the current sample. */
  curves: readonly Curve[];
  measured: Measured | undefined;
  range: Range;
}

/** What a panel shows, and where it lies in pixels. */
export interface Plot {
  key: (typeof QUANTITIES)[number]["key"];
  ends: Ends;
  scale: Scale;
  left: number;
  right: number;
  top: number;
  bottom: number;
}

const MARGIN = { left: 54, right: 14, top: 30, bottom: 54 };
const STRIP = 5;
const DASHES = ["", "6 3", "2 3", "9 3 2 3", "4 4"];
/** The most points of a measured curve that are drawn as dots. */
const MOST_DOTS = 120;

/** The first and the last wavelength, in nm. */
export interface Ends {
  first_nm: number;
  last_nm: number;
}

export const RANGE_ENDS: Record<Range, Ends> = {
  visible: { first_nm: 400, last_nm: 700 },
  solar: { first_nm: 300, last_nm: 2500 },
};

/** A sample with its spectrum. */
export function curve(sample: Sample, place: number, answer: SpectrumAnswer): Curve {
  return { name: describe(sample), place, sample, spectrum: answer, hex: answer.transmitted.hex };
}

export function drawChart({ curves, measured, range }: Content, fit: Fit, { width, columns }: Size) {
  const ends = RANGE_ENDS[range];
  const rows = QUANTITIES.length / columns;
  const cell = { width: width / columns, height: columns === 1 ? 210 : Math.min(300, Math.max(230, width / 4)) };
  const chart = svg("svg", {
    width, height: rows * cell.height, viewBox: `0 0 ${width} ${rows * cell.height}`, class: "chart",
    "font-family": "system-ui, sans-serif", "font-size": 12,
  });
  chart.append(svg("defs", {}, gradient()));
  const plots = QUANTITIES.map((quantity, index): Plot => {
    const [column, row] = [index % columns, Math.floor(index / columns)];
    const points = measured?.quantity === quantity.key ? within(measured, ends) : [];
    const values = [...curves.flatMap(({ spectrum }) => spectrum[quantity.key]), ...points.map(({ value }) => value)];
    const plot = {
      key: quantity.key,
      ends,
      scale: scaleOf(fit === "log" && quantity.key === "reflectance" ? "close" : fit, values, 4),
      left: column * cell.width + MARGIN.left,
      right: (column + 1) * cell.width - MARGIN.right,
      top: row * cell.height + MARGIN.top,
      bottom: (row + 1) * cell.height - MARGIN.bottom,
    };
    const shown = [...curves].sort((a, b) => b.place - a.place);
    const lines = shown.flatMap((curve) => line(plot, curve, quantity));
    chart.append(axes(plot, `${quantity.name} ${quantity.sign}`), ...lines, ...dots(plot, points));
    return plot;
  });
  return { chart, plots };
}

export function across({ ends: { first_nm, last_nm }, left, right }: Plot, wavelength_nm: number): number {
  return left + ((wavelength_nm - first_nm) / (last_nm - first_nm)) * (right - left);
}

/** Height of a value, within the panel. */
export function down({ top, bottom, scale }: Plot, value: number): number {
  return round(bottom - Math.min(1, Math.max(0, scale.place(value))) * (bottom - top));
}

function axes(plot: Plot, title: string): SVGElement {
  const { left, right, top, bottom, scale } = plot;
  const { first_nm: blue_nm, last_nm: red_nm } = RANGE_ENDS.visible;
  const group = svg("g", { fill: "var(--muted)" });
  group.append(svg("text", { x: left, y: top - 12, fill: "var(--ink)", "font-weight": 600, "font-size": 13 }, title));
  for (const { value, label } of scale.ticks) {
    const y = down(plot, value);
    const opacity = label === "" ? 0.4 : 1;
    group.append(
      svg("line", { x1: left, x2: right, y1: y, y2: y, stroke: "var(--line)", "stroke-opacity": opacity }),
      svg("text", { x: left - 7, y: y + 4, "text-anchor": "end" }, label),
    );
  }
  const { first_nm, last_nm } = plot.ends;
  const every = niceStep((last_nm - first_nm) / (right - left < 260 ? 3 : 6));
  for (let wavelength_nm = every * Math.ceil(first_nm / every); wavelength_nm <= last_nm; wavelength_nm += every) {
    const x = round(across(plot, wavelength_nm));
    group.append(
      svg("line", { x1: x, x2: x, y1: bottom + STRIP, y2: bottom + STRIP + 4, stroke: "var(--muted)" }),
      svg("text", { x, y: bottom + 23, "text-anchor": "middle" }, String(wavelength_nm)),
    );
  }
  group.append(
    svg("rect", { x: left, y: bottom, width: right - left, height: STRIP, fill: "var(--line)" }),
    svg("rect", { x: across(plot, blue_nm), y: bottom, width: across(plot, red_nm) - across(plot, blue_nm),
      height: STRIP, fill: "url(#spectrum)" }),
    svg("text", { x: (left + right) / 2, y: bottom + 42, "text-anchor": "middle" }, "Wavelength (nm)"),
  );
  return group;
}

/** The curve, and a band of one standard error on either side. */
function line(plot: Plot, { place, spectrum }: Curve, { key, error }: (typeof QUANTITIES)[number]): SVGElement[] {
  const point = (index: number, value: number) =>
    `${round(across(plot, spectrum.wavelengths_nm[index]!))} ${down(plot, value)}`;
  const values = spectrum[key];
  const elements: SVGElement[] = [];
  const errors = spectrum[error];
  if (errors !== undefined && place === 0) {
    const over = values.map((value, index) => point(index, value + errors[index]!));
    const under = values.map((value, index) => point(index, value - errors[index]!)).reverse();
    const d = `M${[...over, ...under].join("L")}Z`;
    elements.push(svg("path", { d, fill: `var(--curve-${place})`, "fill-opacity": 0.25 }));
  }
  elements.push(svg("path", {
    d: `M${values.map((value, index) => point(index, value)).join("L")}`, fill: "none", ...stroke(place),
  }));
  return elements;
}

function dots(plot: Plot, points: readonly Point[]): SVGElement[] {
  const place = ({ wavelength_nm, value }: Point) => [round(across(plot, wavelength_nm)), down(plot, value)] as const;
  return marks(points.length, points.map(place));
}

/** How a measured curve of so many points looks along some places: dots, or a line if there are many. */
export function marks(count: number, places: readonly (readonly [number, number])[]): SVGElement[] {
  if (count > MOST_DOTS) {
    return [svg("path", { d: `M${places.join("L")}`, fill: "none", stroke: "var(--ink)" })];
  }
  return places.map(([cx, cy]) => svg("circle", { cx, cy, r: 2.5, fill: "var(--card)", stroke: "var(--ink)" }));
}

interface Point {
  wavelength_nm: number;
  value: number;
}

/** The points of a measured curve in a range. */
export function within({ wavelengths_nm, values }: MeasuredCurve, { first_nm, last_nm }: Ends): Point[] {
  return wavelengths_nm.map((wavelength_nm, index) => ({ wavelength_nm, value: values[index]! }))
    .filter(({ wavelength_nm }) => first_nm <= wavelength_nm && wavelength_nm <= last_nm);
}

/** How the line of a curve looks: pinned samples differ in their dashes too. */
export function stroke(place: number) {
  return {
    stroke: `var(--curve-${place})`, "stroke-width": place === 0 ? 2.25 : 1.5, "stroke-dasharray": DASHES[place]!,
    "stroke-linejoin": "round",
  };
}

function gradient(): SVGElement {
  const last = wavelengthColors.length - 1;
  const stops = wavelengthColors.map((color, index) =>
    svg("stop", { offset: `${(index / last) * 100}%`, "stop-color": color }));
  return svg("linearGradient", { id: "spectrum" }, ...stops);
}

function round(value: number): number {
  return Math.round(100 * value) / 100;
}
