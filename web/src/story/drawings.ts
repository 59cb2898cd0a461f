/** The drawings of the story: spectra over their colours, and walks of light through snow. */

import { wavelengthColors } from "../catalog";
import { scaleOf, type Fit } from "../chart/scale";
import { fresh, svg } from "../dom";
import { absorption_per_m, FIRST_NM, left, STEP_NM } from "./ice";
import type { Walk } from "./walks";

/** Colours of light as bright as a display can show them. */
const VIVID = wavelengthColors.map((hex) => {
  const channels = [1, 3, 5].map((from) => parseInt(hex.slice(from, from + 2), 16));
  return `rgb(${channels.map((value) => Math.round((255 * value) / Math.max(...channels, 1))).join()})`;
});
const LAST_NM = FIRST_NM + STEP_NM * (wavelengthColors.length - 1);
/** Below this width two plots stand one above the other, in px. */
const NARROW = 620;

export function colorOf(wavelength_nm: number): string {
  return VIVID[Math.round((wavelength_nm - FIRST_NM) / STEP_NM)]!;
}

interface Box {
  left: number;
  top: number;
  width: number;
  height: number;
}

function picture(width: number, height: number, ...children: SVGElement[]): SVGSVGElement {
  return svg("svg", { width, height, viewBox: `0 0 ${width} ${height}`, "font-size": 12, "aria-hidden": "true" },
    ...children);
}

/** Values at 400, 410, … 700 nm as an area in the colours of light. */
function area({ left, top, width, height }: Box, values: readonly number[], fit: Fit): SVGElement {
  const scale = scaleOf(fit, values, 4);
  const x = (index: number) => left + (width * index) / (values.length - 1);
  const y = (value: number) => top + height * (1 - Math.min(1, Math.max(0, scale.place(value))));
  const points = values.map((value, index) => `${x(index).toFixed(1)} ${y(value).toFixed(1)}`);
  const id = fresh("colours");
  const group = svg("g", { fill: "var(--muted)" },
    svg("linearGradient", { id }, ...VIVID.map((color, index) =>
      svg("stop", { offset: index / (VIVID.length - 1), "stop-color": color, "stop-opacity": 0.85 }))),
    svg("path", { d: `M${x(0)} ${top + height}L${points.join("L")}L${left + width} ${top + height}Z`,
      fill: `url(#${id})` }),
    svg("path", { d: `M${points.join("L")}`, fill: "none", stroke: "var(--ink)", "stroke-width": 2,
      "stroke-linejoin": "round" }));
  for (const { value, label } of scale.ticks.filter(({ label }) => label !== "")) {
    group.append(
      svg("line", { x1: left, x2: left + width, y1: y(value), y2: y(value), stroke: "var(--line)" }),
      svg("text", { x: left - 7, y: y(value) + 4, "text-anchor": "end" }, label));
  }
  for (let wavelength_nm = FIRST_NM; wavelength_nm <= LAST_NM; wavelength_nm += 100) {
    const unit = wavelength_nm === LAST_NM ? " nm" : "";
    group.append(svg("text", {
      x: x((wavelength_nm - FIRST_NM) / STEP_NM), y: top + height + 18,
      "text-anchor": unit === "" ? "middle" : "end",
    }, `${wavelength_nm}${unit}`));
  }
  return group;
}

/** The title of an `area`. */
function titled({ left, top }: Box, title: string): SVGElement {
  return svg("text", { x: left, y: top - 12, fill: "var(--ink)", "font-weight": 600, "font-size": 13 }, title);
}

/** A spectrum by itself, without a title. */
export function spectrum(width: number, height: number, values: readonly number[], fit: Fit) {
  return picture(width, height, area({ left: 44, top: 8, width: width - 50, height: height - 34 }, values, fit));
}

/** What ice absorbs, and the light that it leaves after a path. */
export function ice(width: number, height: number, path: string, path_m: number): SVGSVGElement {
  const rest = wavelengthColors.map((_, index) => left(FIRST_NM + STEP_NM * index, path_m));
  const isNarrow = width < NARROW;
  const [columns, rows] = isNarrow ? [1, 2] : [2, 1];
  const box = (place: number): Box => ({
    left: 56 + (isNarrow ? 0 : (place * width) / columns), top: 46 + (isNarrow ? (place * height) / rows : 0),
    width: width / columns - 80, height: height / rows - 86,
  });
  return picture(width, height,
    area(box(0), absorption_per_m, "log"), titled(box(0), "Absorption of ice (per metre)"),
    area(box(1), rest, "full"), titled(box(1), `What ${path} of ice leave of white light`));
}

/** Pieces of a walk that have a strength each. */
const PIECES = 16;

/** Walks through a layer; `strength` is what is left of the light after a length. */
export function layer(
  width: number,
  height: number,
  some: readonly Walk[],
  color: string,
  strength: (length: number) => number,
  names: { above: string; below: string },
): SVGSVGElement {
  const [top, bottom] = [0.22 * height, 0.86 * height];
  const unit = bottom - top;
  const at = ([x, z]: [number, number]) => `${(width / 2 + unit * x).toFixed(1)} ${(top + unit * z).toFixed(1)}`;
  const lines = some.flatMap(({ places, lengths, isTransmitted }) => {
    const each = Math.max(1, Math.ceil((places.length - 1) / PIECES));
    const pieces: SVGElement[] = [];
    for (let from = 0; from < places.length - 1; from += each) {
      const piece = places.slice(from, from + each + 1);
      const rest = strength(lengths[Math.min(from + each, lengths.length - 1)]!);
      pieces.push(svg("path", {
        d: `M${piece.map(at).join("L")}`, "stroke-opacity": ((isTransmitted ? 0.9 : 0.45) * rest).toFixed(3),
      }));
    }
    return pieces;
  });
  return picture(width, height,
    svg("rect", { x: 0, y: top, width, height: unit, fill: "#dbe9f5", "fill-opacity": 0.13 }),
    svg("path", { d: `M0 ${top}H${width}M0 ${bottom}H${width}`, stroke: "#dbe9f5", "stroke-opacity": 0.5 }),
    svg("path", { d: `M${width / 2} 0V${top}`, stroke: color, "stroke-width": 5 }),
    svg("g", { fill: "none", stroke: color, "stroke-width": 1.4, "stroke-linejoin": "round" }, ...lines),
    svg("g", { fill: "#dbe6ef", "font-size": 13 },
      svg("text", { x: 16, y: top - 12 }, names.above),
      svg("text", { x: 16, y: bottom + 26 }, names.below)));
}
