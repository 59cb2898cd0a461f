/** Draws reflectance, transmittance and absorptance against wavelength. */

import { wavelengthColors } from "../catalog";
import { svg } from "../dom";
import type { SpectrumAnswer } from "../native";
import { scaleOf, type Fit, type Scale } from "./scale";

export const QUANTITIES = [
  { key: "reflectance", error: "reflectance_se", sign: "R", name: "Reflectance" },
  { key: "transmittance", error: "transmittance_se", sign: "T", name: "Transmittance" },
  { key: "absorptance", error: "absorptance_se", sign: "A", name: "Absorptance" },
] as const;

/** A sample in the chart. `place` selects colour and dashes: 0 is the current one. */
export interface Curve {
  name: string;
  place: number;
  answer: SpectrumAnswer;
}

export interface Size {
  width: number;
  /** Panels in a row: 3 or 1. */
  columns: number;
}

/** What a panel shows, and where it lies in pixels. */
export interface Plot {
  key: (typeof QUANTITIES)[number]["key"];
  scale: Scale;
  left: number;
  right: number;
  top: number;
  bottom: number;
}

const MARGIN = { left: 54, right: 14, top: 30, bottom: 54 };
const STRIP = 5;
const DASHES = ["", "6 3", "2 3", "9 3 2 3", "4 4"];
export const FIRST_NM = 400;
export const LAST_NM = 700;

export function drawChart(curves: readonly Curve[], fit: Fit, { width, columns }: Size) {
  const rows = QUANTITIES.length / columns;
  const cell = { width: width / columns, height: columns === 1 ? 210 : Math.min(300, Math.max(230, width / 4)) };
  const chart = svg("svg", {
    width, height: rows * cell.height, viewBox: `0 0 ${width} ${rows * cell.height}`, class: "chart",
    "font-family": "system-ui, sans-serif", "font-size": 12,
  });
  chart.append(svg("defs", {}, gradient()));
  const plots = QUANTITIES.map((quantity, index): Plot => {
    const [column, row] = [index % columns, Math.floor(index / columns)];
    const values = curves.flatMap(({ answer }) => answer[quantity.key]);
    const plot = {
      key: quantity.key,
      scale: scaleOf(fit === "log" && quantity.key === "reflectance" ? "close" : fit, values, 4),
      left: column * cell.width + MARGIN.left,
      right: (column + 1) * cell.width - MARGIN.right,
      top: row * cell.height + MARGIN.top,
      bottom: (row + 1) * cell.height - MARGIN.bottom,
    };
    const shown = [...curves].sort((a, b) => b.place - a.place);
    const lines = shown.flatMap((curve) => line(plot, curve, quantity));
    chart.append(axes(plot, `${quantity.name} ${quantity.sign}`), ...lines);
    return plot;
  });
  return { chart, plots };
}

export function across(plot: Plot, wavelength_nm: number): number {
  return plot.left + ((wavelength_nm - FIRST_NM) / (LAST_NM - FIRST_NM)) * (plot.right - plot.left);
}

/** Height of a value, within the panel. */
export function down({ top, bottom, scale }: Plot, value: number): number {
  return round(bottom - Math.min(1, Math.max(0, scale.place(value))) * (bottom - top));
}

function axes(plot: Plot, title: string): SVGElement {
  const { left, right, top, bottom, scale } = plot;
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
  const every = right - left < 260 ? 100 : 50;
  for (let wavelength_nm = FIRST_NM; wavelength_nm <= LAST_NM; wavelength_nm += every) {
    const x = round(across(plot, wavelength_nm));
    group.append(
      svg("line", { x1: x, x2: x, y1: bottom + STRIP, y2: bottom + STRIP + 4, stroke: "var(--muted)" }),
      svg("text", { x, y: bottom + 23, "text-anchor": "middle" }, String(wavelength_nm)),
    );
  }
  group.append(
    svg("rect", { x: left, y: bottom, width: right - left, height: STRIP, fill: "url(#spectrum)" }),
    svg("text", { x: (left + right) / 2, y: bottom + 42, "text-anchor": "middle" }, "Wavelength (nm)"),
  );
  return group;
}

/** The curve, and a band of one standard error on either side. */
function line(plot: Plot, { place, answer }: Curve, { key, error }: (typeof QUANTITIES)[number]): SVGElement[] {
  const point = (index: number, value: number) =>
    `${round(across(plot, answer.wavelengths_nm[index]!))} ${down(plot, value)}`;
  const values = answer[key];
  const elements: SVGElement[] = [];
  const errors = answer[error];
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
