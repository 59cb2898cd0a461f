/** The chart on the page, and its reading at one wavelength by pointer or keyboard. */

import { byId, el, svg } from "../dom";
import type { Spectrum } from "../native";
import { decimal, figure, superscript } from "../numbers";
import { Radio } from "../panel/choice";
import type { Range } from "../state";
import { RANGE_ENDS, QUANTITIES, across, down, drawChart, type Content, type Plot } from "./draw";
import type { Fit } from "./scale";

/** Changes of the place among the wavelengths. */
export const KEYS: Record<string, number> = {
  ArrowLeft: -1,
  ArrowRight: 1,
  ArrowDown: -1,
  ArrowUp: 1,
  PageDown: -5,
  PageUp: 5,
  Home: -Infinity,
  End: Infinity,
};
/** The pointer may be so far outside a panel, in px. */
const REACH = 24;
/** Below this the frame is not laid out yet, in px. */
const NARROWEST = 160;
/** Three panels in a row need so much width, in px. */
const WIDE = 620;

export class Chart {
  readonly #frame: HTMLElement;
  readonly #range: Radio<Range>;
  readonly #readings = el("table", { class: "figures", "aria-labelledby": "chart-at" });
  readonly #at = el("p", { id: "chart-at", class: "note" });
  readonly #all = el("table", { class: "figures" });
  #content: Content = { curves: [], measured: undefined, range: "visible" };
  #fit: Fit = "close";
  #at_nm = 450;
  #plots: Plot[] = [];
  #cursor: SVGGElement | undefined;

  /** `change` is called when the visitor chooses a range. */
  constructor(change: (range: Range) => void) {
    this.#range = new Radio<Range>(
      { label: "Range" },
      [{ value: "visible", label: "Visible" }, { value: "solar", label: "300–2500 nm" }],
      change,
    );
    this.#frame = el("div", {
      class: "chart-frame", tabindex: 0, role: "slider", "aria-label": "Reading of the spectrum at a wavelength",
      "aria-describedby": "chart-help",
      keydown: (event: KeyboardEvent) => this.#pressed(event),
      pointermove: (event: PointerEvent) => this.#pointed(event),
      pointerdown: (event: PointerEvent) => this.#pointed(event),
    });
    const fit = new Radio<Fit>(
      { label: "Vertical axes" },
      [{ value: "close", label: "Close" }, { value: "full", label: "0 to 1" }, { value: "log", label: "Logarithmic" }],
      (value) => {
        this.#fit = value;
        this.#draw();
      },
    );
    fit.set(this.#fit);
    for (const one of [fit, this.#range]) one.element.classList.add("inline");
    byId("chart").append(
      el("div", { class: "choices" }, this.#range.element, fit.element),
      this.#frame, this.#at, scrolled("Reading", this.#readings),
      el("p", { id: "chart-help", class: "note" },
        "Move the pointer over the curves, or use the arrow keys, to read their values. A is what the snow " +
        "absorbs: A = 1 − R − (1 − ground albedo) T."),
      el("details", { class: "fold" }, el("summary", {}, "All values as a table"), scrolled("All values", this.#all)),
    );
    new ResizeObserver(() => this.#draw()).observe(this.#frame);
  }

  set(content: Content): void {
    this.#content = content;
    this.#range.set(content.range);
    this.#draw();
    this.#all.replaceChildren(...tableOf(content.curves[0]?.spectrum));
  }

  /** The chart for a file, in the colours of the light scheme. */
  picture(width: number): SVGSVGElement {
    const { chart } = drawChart(this.#content, this.#fit, { width, columns: 3 });
    return chart;
  }

  #draw(): void {
    const width = this.#frame.clientWidth;
    if (width < NARROWEST) return;
    const { chart, plots } = drawChart(this.#content, this.#fit, { width, columns: width < WIDE ? 1 : 3 });
    chart.setAttribute("aria-hidden", "true");
    this.#cursor = svg("g");
    chart.append(this.#cursor);
    this.#plots = plots;
    this.#frame.replaceChildren(chart);
    this.#read(this.#at_nm);
  }

  #pressed(event: KeyboardEvent): void {
    const move = KEYS[event.key];
    if (move === undefined) return;
    event.preventDefault();
    const wavelengths_nm = this.#wavelengths_nm();
    const place = nearest(wavelengths_nm, this.#at_nm) + move;
    this.#read(wavelengths_nm[Math.min(wavelengths_nm.length - 1, Math.max(0, place))]!);
  }

  #pointed({ clientX, clientY }: PointerEvent): void {
    const { left, top } = this.#frame.getBoundingClientRect();
    const [x, y] = [clientX - left, clientY - top];
    const plot = this.#plots.find(({ left, right, top, bottom }) =>
      x >= left - REACH && x <= right + REACH && y >= top - REACH && y <= bottom + REACH);
    if (plot === undefined) return;
    const { first_nm, last_nm } = plot.ends;
    this.#read(first_nm + ((x - plot.left) / (plot.right - plot.left)) * (last_nm - first_nm));
  }

  /** Those of the current sample. */
  #wavelengths_nm(): readonly number[] {
    return this.#content.curves[0]?.spectrum.wavelengths_nm ?? Object.values(RANGE_ENDS[this.#content.range]);
  }

  /** Reads the values at the wavelength of the current sample that is nearest. */
  #read(wanted_nm: number): void {
    const wavelengths_nm = this.#wavelengths_nm();
    const wavelength_nm = wavelengths_nm[nearest(wavelengths_nm, wanted_nm)]!;
    this.#at_nm = wavelength_nm;
    const { curves, range } = this.#content;
    this.#cursor?.replaceChildren(...this.#plots.flatMap((plot) => {
      const x = across(plot, wavelength_nm);
      const dots = curves.flatMap(({ place, spectrum }) => {
        const value = valueAt(spectrum, plot.key, wavelength_nm);
        return value === undefined ? [] : [svg("circle", {
          cx: x, cy: down(plot, value), r: 4, fill: `var(--curve-${place})`, stroke: "var(--card)", "stroke-width": 2,
        })];
      });
      return [svg("line", { x1: x, x2: x, y1: plot.top, y2: plot.bottom, stroke: "var(--edge)" }), ...dots.reverse()];
    }));
    const rows = curves.map(({ name, place, spectrum }) => el("tr", {},
      el("th", { scope: "row" }, el("span", { class: "key", style: `--key: var(--curve-${place})` }), name),
      ...QUANTITIES.map(({ key, error }) => el("td", {}, reading(
        valueAt(spectrum, key, wavelength_nm), spectrum[error]?.[spectrum.wavelengths_nm.indexOf(wavelength_nm)])))));
    const current = curves[0]?.spectrum;
    const at = el("strong", {}, `${wavelength_nm} nm`);
    const hasErrors = current?.reflectance_se !== undefined;
    this.#at.replaceChildren("At ", at, hasErrors ? ", ± one standard error of the rays through grains" : "");
    this.#readings.replaceChildren(
      el("thead", {}, el("tr", {}, el("th", { scope: "col" }, "Sample"), ...QUANTITIES.map(({ sign, name }) =>
        el("th", { scope: "col" }, `${sign} `, el("span", { class: "long" }, name.toLowerCase()))))),
      el("tbody", {}, ...rows),
    );
    this.#frame.setAttribute("aria-valuemin", String(RANGE_ENDS[range].first_nm));
    this.#frame.setAttribute("aria-valuemax", String(RANGE_ENDS[range].last_nm));
    this.#frame.setAttribute("aria-valuenow", String(wavelength_nm));
    this.#frame.setAttribute("aria-valuetext", current === undefined ? `${wavelength_nm} nanometres` : [
      `${wavelength_nm} nanometres`,
      ...QUANTITIES.map(({ key, name }) => `${name.toLowerCase()} ${figure(valueAt(current, key, wavelength_nm)!)}`),
    ].join(", "));
  }
}

/** The place of the wavelength that is nearest to another. */
function nearest(wavelengths_nm: readonly number[], wanted_nm: number): number {
  const distances = wavelengths_nm.map((wavelength_nm) => Math.abs(wavelength_nm - wanted_nm));
  return distances.indexOf(Math.min(...distances));
}

/** The height of a line of the chart at a wavelength; none beyond its ends. */
function valueAt(spectrum: Spectrum, key: Plot["key"], wavelength_nm: number): number | undefined {
  const { wavelengths_nm, [key]: values } = spectrum;
  const right = wavelengths_nm.findIndex((one) => one >= wavelength_nm);
  const [above, upper] = [wavelengths_nm[right], values[right]];
  if (above === undefined || upper === undefined || above === wavelength_nm) return upper;
  const [below, lower] = [wavelengths_nm[right - 1], values[right - 1]];
  if (below === undefined || lower === undefined) return undefined;
  return lower + ((wavelength_nm - below) / (above - below)) * (upper - lower);
}

/** A table that may be wider than the page. */
export function scrolled(label: string, table: HTMLElement): HTMLElement {
  return el("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": label }, table);
}

/** A value as precise as its error allows, with this error. */
function reading(value: number | undefined, error: number | undefined): string {
  if (value === undefined) return "";
  if (error === undefined || error === 0 || value === 0) return figure(value, 4);
  const power = Math.floor(Math.log10(Math.abs(value)));
  /** Two digits of the error. */
  const place = 1 - Math.floor(Math.log10(error));
  const decimals = Math.min(10, Math.max(1, place));
  if (power >= -3) return `${decimal(value, decimals)} ± ${decimal(error, decimals)}`;
  const unit = 10 ** power;
  const fewer = Math.min(8, Math.max(1, place + power));
  return `(${decimal(value / unit, fewer)} ± ${decimal(error / unit, fewer)}) × 10${superscript(power)}`;
}

function tableOf(answer: Spectrum | undefined): HTMLElement[] {
  if (answer === undefined) return [];
  const head = el("tr", {}, el("th", { scope: "col" }, "Wavelength (nm)"),
    ...QUANTITIES.map(({ sign, name }) => el("th", { scope: "col" }, `${name} ${sign}`)));
  const rows = answer.wavelengths_nm.map((wavelength_nm, index) => el("tr", {},
    el("th", { scope: "row" }, String(wavelength_nm)),
    ...QUANTITIES.map(({ key, error }) => el("td", {}, reading(answer[key][index], answer[error]?.[index])))));
  return [el("caption", {}, "Current sample"), el("thead", {}, head), el("tbody", {}, ...rows)];
}
