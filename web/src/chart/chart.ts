/** The chart on the page, and its reading at one wavelength by pointer or keyboard. */

import { byId, el, svg } from "../dom";
import type { SpectrumAnswer } from "../native";
import { decimal, figure, superscript } from "../numbers";
import { Radio } from "../panel/choice";
import { FIRST_NM, LAST_NM, QUANTITIES, across, down, drawChart, type Curve, type Plot } from "./draw";
import type { Fit } from "./scale";

const STEP_NM = 10;
const KEYS: Record<string, (wavelength_nm: number) => number> = {
  ArrowLeft: (at) => at - STEP_NM,
  ArrowRight: (at) => at + STEP_NM,
  ArrowDown: (at) => at - STEP_NM,
  ArrowUp: (at) => at + STEP_NM,
  PageDown: (at) => at - 5 * STEP_NM,
  PageUp: (at) => at + 5 * STEP_NM,
  Home: () => FIRST_NM,
  End: () => LAST_NM,
};
/** The pointer may be so far outside a panel, in px. */
const REACH = 24;
/** Below this the frame is not laid out yet, in px. */
const NARROWEST = 160;
/** Three panels in a row need so much width, in px. */
const WIDE = 620;

export class Chart {
  readonly #frame: HTMLElement;
  readonly #readings = el("table", { class: "figures", "aria-labelledby": "chart-at" });
  readonly #at = el("p", { id: "chart-at", class: "note" });
  readonly #all = el("table", { class: "figures" });
  #curves: readonly Curve[] = [];
  #fit: Fit = "close";
  #at_nm = 450;
  #plots: Plot[] = [];
  #cursor: SVGGElement | undefined;

  constructor() {
    this.#frame = el("div", {
      class: "chart-frame", tabindex: 0, role: "slider", "aria-label": "Reading of the spectrum at a wavelength",
      "aria-valuemin": FIRST_NM, "aria-valuemax": LAST_NM, "aria-describedby": "chart-help",
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
    fit.element.classList.add("inline");
    byId("chart").append(
      fit.element, this.#frame, this.#at, scrolled("Reading", this.#readings),
      el("p", { id: "chart-help", class: "note" },
        "Move the pointer over the curves, or use the arrow keys, to read their values. R + T + A = 1. Without a " +
        "ground, A is what the snow absorbs."),
      el("details", { class: "fold" }, el("summary", {}, "All values as a table"), scrolled("All values", this.#all)),
    );
    new ResizeObserver(() => this.#draw()).observe(this.#frame);
  }

  /** The first curve is the current sample. */
  set(curves: readonly Curve[]): void {
    this.#curves = curves;
    this.#draw();
    this.#all.replaceChildren(...tableOf(curves[0]?.answer));
  }

  /** The chart for a file, in the colours of the light scheme. */
  picture(width: number): SVGSVGElement {
    const { chart } = drawChart(this.#curves, this.#fit, { width, columns: 3 });
    return chart;
  }

  #draw(): void {
    const width = this.#frame.clientWidth;
    if (width < NARROWEST) return;
    const { chart, plots } = drawChart(this.#curves, this.#fit, { width, columns: width < WIDE ? 1 : 3 });
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
    this.#read(Math.min(LAST_NM, Math.max(FIRST_NM, move(this.#at_nm))));
  }

  #pointed({ clientX, clientY }: PointerEvent): void {
    const { left, top } = this.#frame.getBoundingClientRect();
    const [x, y] = [clientX - left, clientY - top];
    const plot = this.#plots.find(({ left, right, top, bottom }) =>
      x >= left - REACH && x <= right + REACH && y >= top - REACH && y <= bottom + REACH);
    if (plot === undefined) return;
    const way = Math.min(1, Math.max(0, (x - plot.left) / (plot.right - plot.left)));
    this.#read(FIRST_NM + STEP_NM * Math.round((way * (LAST_NM - FIRST_NM)) / STEP_NM));
  }

  #read(wavelength_nm: number): void {
    this.#at_nm = wavelength_nm;
    const index = (wavelength_nm - FIRST_NM) / STEP_NM;
    this.#cursor?.replaceChildren(...this.#plots.flatMap((plot) => {
      const x = across(plot, wavelength_nm);
      const dots = this.#curves.map(({ place, answer }) => svg("circle", {
        cx: x, cy: down(plot, answer[plot.key][index]!), r: 4, fill: `var(--curve-${place})`, stroke: "var(--card)",
        "stroke-width": 2,
      }));
      return [svg("line", { x1: x, x2: x, y1: plot.top, y2: plot.bottom, stroke: "var(--edge)" }), ...dots.reverse()];
    }));
    const rows = this.#curves.map(({ name, place, answer }) => el("tr", {},
      el("th", { scope: "row" }, el("span", { class: "key", style: `--key: var(--curve-${place})` }), name),
      ...QUANTITIES.map(({ key, error }) => el("td", {}, reading(answer[key][index], answer[error]?.[index])))));
    const at = el("strong", {}, `${wavelength_nm} nm`);
    this.#at.replaceChildren("At ", at, ", ± one standard error of the rays through grains");
    this.#readings.replaceChildren(
      el("thead", {}, el("tr", {}, el("th", { scope: "col" }, "Sample"), ...QUANTITIES.map(({ sign, name }) =>
        el("th", { scope: "col" }, `${sign} `, el("span", { class: "long" }, name.toLowerCase()))))),
      el("tbody", {}, ...rows),
    );
    const current = this.#curves[0]?.answer;
    this.#frame.setAttribute("aria-valuenow", String(wavelength_nm));
    this.#frame.setAttribute("aria-valuetext", current === undefined ? `${wavelength_nm} nanometres` : [
      `${wavelength_nm} nanometres`,
      ...QUANTITIES.map(({ key, name }) => `${name.toLowerCase()} ${figure(current[key][index]!)}`),
    ].join(", "));
  }
}

/** A table that may be wider than the page. */
function scrolled(label: string, table: HTMLElement): HTMLElement {
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

function tableOf(answer: SpectrumAnswer | undefined): HTMLElement[] {
  if (answer === undefined) return [];
  const head = el("tr", {}, el("th", { scope: "col" }, "Wavelength (nm)"),
    ...QUANTITIES.map(({ sign, name }) => el("th", { scope: "col" }, `${name} ${sign}`)));
  const rows = answer.wavelengths_nm.map((wavelength_nm, index) => el("tr", {},
    el("th", { scope: "row" }, String(wavelength_nm)),
    ...QUANTITIES.map(({ key, error }) => el("td", {}, reading(answer[key][index], answer[error]?.[index])))));
  return [el("caption", {}, "Current sample"), el("thead", {}, head), el("tbody", {}, ...rows)];
}
