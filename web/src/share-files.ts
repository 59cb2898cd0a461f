/** Files of the figures on the page. */

import { QUANTITIES, RANGE_ENDS, marks, stroke, within, type Content, type Curve, type Measured } from "./chart/draw";
import { svg } from "./dom";
import type { Rgb } from "./view/field-messages";

/** The light colour scheme, for files. */
const INK = {
  "--ink": "#16212b", "--card": "#ffffff", "--muted": "#51606d", "--line": "#dde3e8",
  "--curve-0": "#0b63ad", "--curve-1": "#b3541e", "--curve-2": "#2f7d4f",
  "--curve-3": "#8a4a9e", "--curve-4": "#6b6f76",
};
/** Pixels of a PNG for each unit of the SVG. */
const SCALE = 2;
/** Height of a row of the legend, and where it begins. */
const ROW = 24;
const LEFT = 54;

/** Spectra as comma-separated values: one row for each sample and wavelength. The current
 * sample has place 0, pinned ones have 1 to 4. */
export function csv(curves: readonly Curve[]): string {
  const header = ["place", "sample", "wavelength_nm", ...QUANTITIES.flatMap(({ key, error }) => [key, error])];
  const rows = curves.flatMap(({ name, place, spectrum }) => spectrum.wavelengths_nm.map((wavelength_nm, index) => [
    place, `"${name}"`, wavelength_nm,
    ...QUANTITIES.flatMap(({ key, error }) => [spectrum[key][index], spectrum[error]?.[index] ?? ""]),
  ]));
  return `${[header, ...rows].map((row) => row.join(",")).join("\n")}\n`;
}

/**
 * A chart of a range as a file that stands alone, with its curves, their transmitted colours and the measured curve
 * named below it.
 */
export function svgFile(chart: SVGSVGElement, { curves, measured, range }: Content, about: string): string {
  const [width, height] = [Number(chart.getAttribute("width")), Number(chart.getAttribute("height"))];
  const points = measured === undefined ? 0 : within(measured, RANGE_ENDS[range]).length;
  const names = [
    ...curves.map((curve) => (y: number) => legend(curve, y)),
    ...(measured === undefined || points === 0 ? [] : [(y: number) => measuredLegend(measured, points, y)]),
  ];
  const rows = names.flatMap((name, index) => name(height + ROW * (index + 0.5)));
  const taller = height + ROW * (names.length + 1.5);
  chart.setAttribute("height", String(taller));
  chart.setAttribute("viewBox", `0 0 ${width} ${taller}`);
  chart.setAttribute("style", Object.entries(INK).map(([name, color]) => `${name}: ${color}`).join("; "));
  chart.prepend(svg("rect", { width, height: taller, fill: "#ffffff" }));
  chart.append(...rows, svg("text", { x: LEFT, y: taller - 12, fill: "var(--muted)", "font-size": 11 }, about));
  return new XMLSerializer().serializeToString(chart);
}

function legend({ name, place, hex }: Curve, y: number): SVGElement[] {
  return [
    svg("line", { x1: LEFT, x2: LEFT + 24, y1: y, y2: y, ...stroke(place) }),
    svg("rect", { x: LEFT + 34, y: y - 8, width: 16, height: 16, rx: 3, fill: hex }),
    svg("text", { x: LEFT + 60, y: y + 4, fill: "var(--ink)" }, `${name}; transmitted ${hex}`),
  ];
}

function measuredLegend({ name, quantity }: Measured, points: number, y: number): SVGElement[] {
  return [
    ...marks(points, [[LEFT, y], [LEFT + 12, y], [LEFT + 24, y]]),
    svg("text", { x: LEFT + 60, y: y + 4, fill: "var(--ink)" }, `${name}; measured ${quantity}`),
  ];
}

/** An SVG file as a PNG file. */
export async function pngFile(file: string): Promise<Blob> {
  const url = URL.createObjectURL(new Blob([file], { type: "image/svg+xml" }));
  try {
    const image = new Image();
    image.src = url;
    await image.decode();
    const canvas = new OffscreenCanvas(SCALE * image.width, SCALE * image.height);
    canvas.getContext("2d")!.drawImage(image, 0, 0, canvas.width, canvas.height);
    return await canvas.convertToBlob({ type: "image/png" });
  } finally {
    URL.revokeObjectURL(url);
  }
}

/** A line that is not wider than some pixels: its middle is left out if it is. */
function fitting(context: OffscreenCanvasRenderingContext2D, line: string, width: number): string {
  if (context.measureText(line).width <= width) return line;
  // The greatest number of letters that fits, by bisection.
  let [most, none] = [0, line.length];
  const cut = (letters: number) =>
    `${line.slice(0, Math.ceil(letters / 2))}…${line.slice(line.length - Math.floor(letters / 2))}`;
  while (none - most > 1) {
    const letters = (most + none) >> 1;
    if (context.measureText(cut(letters)).width <= width) most = letters;
    else none = letters;
  }
  return cut(most);
}

/** A picture with a strip below it: lines of text, beside a swatch of a colour of the picture if it has one. */
export async function captioned(picture: Blob, srgb: Rgb | undefined, lines: readonly string[]): Promise<Blob> {
  const image = await createImageBitmap(picture);
  const { width, height } = image;
  const em = Math.max(14, Math.round(width / 48));
  const strip = Math.ceil(1.5 * em * (lines.length + 1));
  const canvas = new OffscreenCanvas(width, height + strip);
  const context = canvas.getContext("2d")!;
  context.fillStyle = "#0b1118";
  context.fillRect(0, 0, width, height + strip);
  context.drawImage(image, 0, 0);
  const margin = srgb === undefined ? em : strip;
  if (srgb !== undefined) {
    context.fillStyle = `rgb(${srgb})`;
    context.fillRect(em, height + em, strip - 2 * em, strip - 2 * em);
  }
  context.fillStyle = "#dbe6ef";
  context.font = `${em}px system-ui, sans-serif`;
  lines.forEach((line, row) =>
    context.fillText(fitting(context, line, width - margin - em), margin, height + 1.5 * em * (row + 1.2)));
  return canvas.convertToBlob({ type: "image/png" });
}

export function save(name: string, content: Blob | string, type = "text/plain"): void {
  const url = URL.createObjectURL(content instanceof Blob ? content : new Blob([content], { type }));
  const link = document.createElement("a");
  link.href = url;
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}
