/** The light of one place of the snow: where it is asked for, and a card that shows it. */

import { BLUE_NM, RED_NM, at, compared } from "../brightness";
import { el, svg } from "../dom";
import { colorOf } from "../story/drawings";
import type { Probed, ProbedLight } from "./field-messages";

/** Greatest way of a finger or a pen that taps, in px. */
const TAP_PX = 8;
/** The card goes to the other side when the place comes nearer to it than this, as a part of the view. */
const NEAR_SIDE = 0.45;
/** Of the curve, in px. */
const HEIGHT = 32;

/** A place in the view, 0 to 1 from the left and from above. */
export interface Place {
  x: number;
  y: number;
}

export class Probe {
  private readonly color = el("span", { class: "sb-probe-color" });
  private readonly curve = el("div", { class: "sb-probe-curve" });
  private readonly words = el("p");
  private readonly card = el("div", { class: "sb-probe", hidden: true },
    el("div", {}, this.color, this.words), this.curve);
  private readonly mark = el("div", { class: "sb-probed", hidden: true });
  private readonly said = el("p", { class: "hidden", role: "status" });
  private place: Place | undefined;
  /** Whether the place stays without a pointer. */
  private isKept = false;
  private isAsking = false;
  private isStale = false;
  /** Where a pointer came down. */
  private down: { x: number; y: number } | undefined;

  /** `light` answers what leaves the snow at a place of the view; it is asked one question at a time. */
  constructor(
    private readonly element: HTMLElement,
    layer: HTMLElement,
    private readonly light: (place: Place) => Promise<Probed>,
  ) {
    layer.append(this.mark, this.card, this.said);
    element.addEventListener("pointermove", this.move);
    element.addEventListener("pointerdown", this.press);
    element.addEventListener("pointerup", this.release);
    element.addEventListener("pointerleave", this.leave);
    element.addEventListener("keydown", this.key);
  }

  /** Asks again, as the light or the view has changed. */
  refresh(): void {
    if (this.place === undefined) return;
    this.isStale = true;
    if (!this.isAsking) void this.ask();
  }

  private readonly move = (event: PointerEvent): void => {
    if (event.pointerType !== "touch" && event.buttons === 0) this.look(this.placeOf(event), false);
  };

  /** The view turns with the pointer. */
  private readonly press = (event: PointerEvent): void => {
    this.down = { x: event.clientX, y: event.clientY };
    if (event.pointerType !== "touch") this.clear();
  };

  private readonly release = (event: PointerEvent): void => {
    const isTap = this.down !== undefined &&
      Math.hypot(event.clientX - this.down.x, event.clientY - this.down.y) < TAP_PX;
    this.down = undefined;
    // A pen leaves when it is lifted, unless it is one that hovers.
    if (event.pointerType === "mouse") this.look(this.placeOf(event), false);
    else if (isTap) this.look(this.placeOf(event), true);
  };

  private readonly leave = (event: PointerEvent): void => {
    if (event.pointerType !== "touch" && !this.isKept) this.clear();
  };

  private readonly key = (event: KeyboardEvent): void => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === "p" || event.key === "P") this.look({ x: 0.5, y: 0.5 }, true);
    else if (event.key === "Escape") this.clear();
  };

  private placeOf(event: PointerEvent): Place {
    const { left, top, width, height } = this.element.getBoundingClientRect();
    return { x: (event.clientX - left) / width, y: (event.clientY - top) / height };
  }

  private look(place: Place, isKept: boolean): void {
    [this.place, this.isKept] = [place, isKept];
    this.said.textContent = "";
    this.refresh();
  }

  private clear(): void {
    this.place = undefined;
    this.card.hidden = this.mark.hidden = true;
    this.said.textContent = "";
  }

  private async ask(): Promise<void> {
    this.isAsking = true;
    while (this.isStale && this.place !== undefined) {
      this.isStale = false;
      const place = this.place;
      const answer = await this.light(place);
      // A newer question follows at once, but a pointer that moves on has an answer too. Light that is not known yet
      // is asked for again when it is.
      if (this.place !== undefined && answer !== null) this.show(place, answer);
    }
    this.isAsking = false;
  }

  private show(place: Place, answer: ProbedLight | undefined): void {
    const { x, y } = place;
    const isKept = this.isKept && place === this.place;
    this.card.hidden = answer === undefined;
    this.mark.hidden = !isKept;
    this.mark.style.left = `${100 * x}%`;
    this.mark.style.top = `${100 * y}%`;
    const words = answer === undefined ? "There is no lit snow here." : sentence(answer);
    if (isKept && this.said.textContent !== words) this.said.textContent = words;
    if (answer === undefined) return;
    if (x < NEAR_SIDE) this.card.classList.add("sb-right");
    else if (x > 1 - NEAR_SIDE) this.card.classList.remove("sb-right");
    this.color.style.background = `rgb(${answer.srgb})`;
    this.words.textContent = words;
    this.curve.replaceChildren(curve(answer, this.curve.clientWidth));
  }
}

/** How blue the light is, in words. */
function sentence(answer: ProbedLight): string {
  const words = compared(answer.radiance, answer);
  return words === undefined ? "Hardly any light leaves the snow here." : `Here ${words}.`;
}

/** The spectrum relative to its greatest value, with blue and red. */
function curve(answer: ProbedLight, width: number): SVGSVGElement {
  const { radiance, wavelengths_nm } = answer;
  const greatest = Math.max(...radiance);
  const [first, last] = [wavelengths_nm[0]!, wavelengths_nm.at(-1)!];
  const x = (nm: number) => 3 + ((width - 6) * (nm - first)) / (last - first);
  const y = (value: number) => 4 + (HEIGHT - 8) * (1 - Math.max(0, value) / (greatest || 1));
  const points = radiance.map((value, index) => `${x(wavelengths_nm[index]!).toFixed(1)} ${y(value).toFixed(1)}`);
  const dot = (nm: number) =>
    svg("circle", { cx: x(nm), cy: y(at(radiance, answer, nm)), r: 3.5, fill: colorOf(nm), stroke: "#070b10" });
  const label = (nm: number) =>
    svg("text", { x: x(nm), y: HEIGHT + 12, "text-anchor": "middle" }, `${nm}\u00a0nm`);
  return svg("svg", {
    width, height: HEIGHT + 16, viewBox: `0 0 ${width} ${HEIGHT + 16}`, "font-size": 11, fill: "#b5c4d1",
    "aria-hidden": "true",
  },
    svg("path", { d: `M3 ${HEIGHT - 3.5}H${width - 3}`, stroke: "#5b6b7a" }),
    svg("path", { d: `M${points.join("L")}`, fill: "none", stroke: "#dbe6ef", "stroke-width": 1.75,
      "stroke-linejoin": "round" }),
    dot(BLUE_NM), dot(RED_NM), label(BLUE_NM), label(RED_NM));
}
