/** Light at depth: fluxes against the depth below the top, at a few wavelengths. */

import { FORMER, type Asked, type Shown } from "../answers";
import { KEYS, scrolled } from "../chart/chart";
import { scaleOf } from "../chart/scale";
import { announce, el, say, svg } from "../dom";
import type { DepthProfile, DepthRequest } from "../native";
import { figure, short } from "../numbers";
import { Radio } from "../panel/choice";
import { sampleRequest } from "../request";
import type { AtDepth, Layer } from "../state";
import type { Store } from "../store";
import { precision } from "./precision";
import { ticksOf } from "./ticks";

/** The wavelengths, and the place of each among the colours of curves. */
const LINES = [
  { wavelength_nm: 450, place: 0, dashes: "" },
  { wavelength_nm: 550, place: 2, dashes: "6 3" },
  { wavelength_nm: 650, place: 1, dashes: "2 3" },
  { wavelength_nm: 850, place: 4, dashes: "9 3 2 3" },
];
const QUANTITIES: Record<AtDepth, string> = { down: "Flux downwards", fluence: "Fluence rate" };
/** Equal steps from the top to the bottom. */
const STEPS = 60;
const MARGIN = { left: 50, right: 16, top: 48, bottom: 10 };
const HEIGHT = 340;
/** Below this the frame is not laid out yet, in px. */
const NARROWEST = 160;

type Solved = { layers: Layer[]; depths_cm: number[]; profiles: DepthProfile[] };

export function depthRequest(sample: Asked, rays: number): DepthRequest {
  return {
    sample: sampleRequest(sample, rays),
    depths_cm: depthsOf(sample.layers),
    wavelengths_nm: LINES.map(({ wavelength_nm }) => wavelength_nm),
  };
}

/** Equal steps, and the tops of layers among them. */
function depthsOf(layers: readonly Layer[]): number[] {
  const bottom_cm = topsOf(layers).at(-1)!;
  const steps = Array.from({ length: STEPS }, (_, step) => (bottom_cm * step) / STEPS);
  return [...new Set([...steps, ...topsOf(layers)])].sort((one, other) => one - other);
}

/** Depths of the top of each layer, and of the bottom. */
function topsOf(layers: readonly Layer[]): number[] {
  return layers.reduce((tops, { thickness_cm }) => [...tops, tops.at(-1)! + thickness_cm], [0]);
}

export class DepthChart {
  readonly #store: Store;
  readonly #frame: HTMLElement;
  readonly #precision = el("p", { class: "note precision" });
  readonly #error = el("p", { class: "error", role: "alert", hidden: true });
  readonly #lead = el("p", { class: "lead", hidden: true });
  readonly #at = el("p", { id: "depth-at", class: "note" });
  readonly #readings = el("table", { class: "figures at-depth", "aria-labelledby": "depth-at" });
  #solved: Solved | undefined;
  #at_cm = 5;
  #plot: { top: number; bottom: number; bottom_cm: number; x(value: number): number } | undefined;
  #cursor: SVGGElement | undefined;

  constructor(parent: HTMLElement, store: Store) {
    this.#store = store;
    this.#frame = el("div", {
      class: "chart-frame depth-frame", tabindex: 0, role: "slider", "aria-label": "Reading of the light at a depth",
      "aria-orientation": "vertical", "aria-describedby": "depth-help",
      keydown: (event: KeyboardEvent) => this.#pressed(event),
      pointermove: (event: PointerEvent) => this.#pointed(event),
      pointerdown: (event: PointerEvent) => this.#pointed(event),
    });
    const quantity = new Radio<AtDepth>(
      { label: "Shown" },
      [{ value: "down", label: QUANTITIES.down }, { value: "fluence", label: QUANTITIES.fluence }],
      (value) => store.update((state) => (state.at_depth = value)),
    );
    quantity.element.classList.add("inline");
    parent.append(
      this.#precision, this.#error, this.#lead, quantity.element,
      el("div", { class: "depth-parts" },
        this.#frame,
        el("div", {}, this.#at, scrolled("Light at the depth", this.#readings),
          el("p", { id: "depth-help", class: "note" },
            "Move the pointer over the curves, or use the arrow keys, to read another depth. All values are over the " +
            "incident flux. The fluence rate counts light from all directions. The e-folding depth is the distance " +
            "over which light far from all faces decays by e, in the snow below this depth."))),
    );
    store.subscribe((state, before) => {
      quantity.set(state.at_depth);
      if (state.at_depth !== before.at_depth) this.#draw();
    });
    new ResizeObserver(() => this.#draw()).observe(this.#frame);
  }

  wait(): void {
    this.#precision.textContent = "Computing a preview.";
  }

  show(shown: Shown<DepthProfile[]>): void {
    say(this.#error, "error" in shown ? `${shown.error}.` : "");
    if ("error" in shown) {
      this.#precision.textContent = this.#solved === undefined ? "" : FORMER;
      return;
    }
    const { layers } = shown.sample;
    this.#solved = { layers, depths_cm: depthsOf(layers), profiles: shown.answer };
    this.#precision.textContent = precision(shown.fine);
    this.#lead.hidden = false;
    this.#lead.replaceChildren(...this.#summary(this.#solved));
    if (shown.fine) announce("depths", `Light at depth: ${this.#lead.textContent}`);
    this.#draw();
  }

  /** The e-folding depth of each layer in the blue. */
  #summary({ layers, depths_cm, profiles: [blue] }: Solved): (Node | string)[] {
    const tops = topsOf(layers);
    const depths = layers.map((_, layer) => blue!.e_folding_depth_cm[depths_cm.indexOf(tops[layer]!)]!);
    const start = `e-folding depth at ${blue!.wavelength_nm} nm`;
    if (depths.length === 1) {
      return [
        el("strong", {}, `${figure(depths[0]!)} cm`),
        ` ${start}: over this distance deep snow of this kind dims blue light to 37 %.`,
      ];
    }
    const all = depths.map((depth_cm) => figure(depth_cm)).join(", ");
    return [el("strong", {}, all), ` cm ${start} in the layers, top first.`];
  }

  #draw(): void {
    const width = this.#frame.clientWidth;
    if (width < NARROWEST || this.#solved === undefined) return;
    const { layers, profiles } = this.#solved;
    const quantity = this.#store.state.at_depth;
    const bottom_cm = topsOf(layers).at(-1)!;
    const [left, right, top, bottom] = [MARGIN.left, width - MARGIN.right, MARGIN.top, HEIGHT - MARGIN.bottom];
    const scale = scaleOf("log", profiles.flatMap((profile) => profile[quantity]), 6);
    const x = (value: number) => round(left + Math.min(1, Math.max(0, scale.place(value))) * (right - left));
    const y = (depth_cm: number) => round(top + (bottom_cm > 0 ? depth_cm / bottom_cm : 0) * (bottom - top));
    const chart = svg("svg", {
      width, height: HEIGHT, viewBox: `0 0 ${width} ${HEIGHT}`, class: "chart", "aria-hidden": "true",
      "font-family": "system-ui, sans-serif", "font-size": 12,
    });
    const axes = svg("g", { fill: "var(--muted)" },
      svg("text", { x: 4, y: 14, fill: "var(--ink)", "font-weight": 600, "font-size": 13 },
        `${QUANTITIES[quantity]} over the incident flux`));
    for (const { value, label } of scale.ticks) {
      axes.append(
        svg("line", { x1: x(value), x2: x(value), y1: top, y2: bottom, stroke: "var(--line)",
          "stroke-opacity": label === "" ? 0.4 : 1 }),
        svg("text", { x: x(value), y: top - 8, "text-anchor": "middle" }, label));
    }
    for (const depth_cm of ticksOf(bottom_cm, 6)) {
      axes.append(svg("line", { x1: left, x2: right, y1: y(depth_cm), y2: y(depth_cm), stroke: "var(--line)" }));
      const label = depth_cm === 0 ? "0 cm" : short(depth_cm);
      axes.append(svg("text", { x: left - 7, y: y(depth_cm) + 4, "text-anchor": "end" }, label));
    }
    for (const depth_cm of topsOf(layers).slice(1, -1)) {
      axes.append(svg("line", { x1: left, x2: right, y1: y(depth_cm), y2: y(depth_cm), stroke: "var(--edge)",
        "stroke-dasharray": "4 3" }));
    }
    chart.append(axes, ...profiles.map((profile, index) => svg("path", {
      d: `M${profile[quantity].map((value, at) => `${x(value)} ${y(this.#solved!.depths_cm[at]!)}`).join("L")}`,
      fill: "none", stroke: `var(--curve-${LINES[index]!.place})`, "stroke-width": 2, "stroke-linejoin": "round",
      "stroke-dasharray": LINES[index]!.dashes,
    })).reverse());
    this.#cursor = svg("g");
    chart.append(this.#cursor);
    this.#plot = { top, bottom, bottom_cm, x };
    this.#frame.replaceChildren(chart);
    this.#read(this.#at_cm);
  }

  #pressed(event: KeyboardEvent): void {
    const move = KEYS[event.key];
    if (move === undefined || this.#solved === undefined) return;
    event.preventDefault();
    // Down goes deeper, as the curves do.
    const isVertical = /^(Arrow(Up|Down)|Page)/.test(event.key);
    const { depths_cm } = this.#solved;
    const place = nearest(depths_cm, this.#at_cm) + (isVertical ? -move : move);
    this.#read(depths_cm[Math.min(depths_cm.length - 1, Math.max(0, place))]!);
  }

  #pointed({ clientY }: PointerEvent): void {
    if (this.#plot === undefined) return;
    const { top, bottom, bottom_cm } = this.#plot;
    const down = clientY - this.#frame.getBoundingClientRect().top;
    this.#read((bottom_cm * (down - top)) / (bottom - top));
  }

  /** Reads the values at the depth that is nearest. */
  #read(wanted_cm: number): void {
    if (this.#solved === undefined || this.#plot === undefined) return;
    const { depths_cm, profiles } = this.#solved;
    const { top, bottom, bottom_cm, x } = this.#plot;
    const index = nearest(depths_cm, wanted_cm);
    const depth_cm = depths_cm[index]!;
    this.#at_cm = depth_cm;
    const quantity = this.#store.state.at_depth;
    const y = round(top + (bottom_cm > 0 ? depth_cm / bottom_cm : 0) * (bottom - top));
    this.#cursor?.replaceChildren(
      svg("line", { x1: x(0), x2: x(Infinity), y1: y, y2: y, stroke: "var(--edge)" }),
      ...profiles.map((profile, line) => svg("circle", {
        cx: x(profile[quantity][index]!), cy: y, r: 4, fill: `var(--curve-${LINES[line]!.place})`,
        stroke: "var(--card)", "stroke-width": 2,
      })));
    this.#at.replaceChildren("At a depth of ", el("strong", {}, `${short(depth_cm, 4)} cm`));
    this.#readings.replaceChildren(
      el("thead", {}, el("tr", {}, ...["Wavelength", "Down", "Up", "Fluence", "E-folding"].map((head) =>
        el("th", { scope: "col" }, head)))),
      el("tbody", {}, ...profiles.map((profile, line) => el("tr", {},
        el("th", { scope: "row" }, el("span", { class: "key", style: `--key: var(--curve-${LINES[line]!.place})` }),
          `${profile.wavelength_nm} nm`),
        ...[profile.down, profile.up, profile.fluence].map((values) => el("td", {}, figure(values[index]!))),
        el("td", {}, `${figure(profile.e_folding_depth_cm[index]!)} cm`)))),
    );
    const frame = this.#frame;
    frame.setAttribute("aria-valuemin", "0");
    frame.setAttribute("aria-valuemax", short(bottom_cm));
    frame.setAttribute("aria-valuenow", short(depth_cm));
    frame.setAttribute("aria-valuetext", [
      `${short(depth_cm, 4)} centimetres`,
      ...profiles.map((profile) => `${profile.wavelength_nm} nanometres ${figure(profile[quantity][index]!)}`),
    ].join(", "));
  }
}

function nearest(depths_cm: readonly number[], wanted_cm: number): number {
  const distances = depths_cm.map((depth_cm) => Math.abs(depth_cm - wanted_cm));
  return distances.indexOf(Math.min(...distances));
}

function round(value: number): number {
  return Math.round(100 * value) / 100;
}
