/** Rings at places of the snow, whose light the text beside the picture states. */

import { type PerspectiveCamera, Vector3 } from "three";
import { el } from "../dom";
import type { Vector } from "../state";
import type { Probed, ProbedLight } from "./field-messages";
import type { Place } from "./probe";

/** Rest of the view before its light is asked for, in ms. */
const REST_MS = 100;

/** The light at each ring, as far as it is known. */
export type Ringed = readonly (ProbedLight | undefined)[];

export class Rings {
  private rings: { place: Vector; mark: HTMLElement }[] = [];
  private turn = 0;
  private timer = 0;

  constructor(
    private readonly layer: HTMLElement,
    private readonly camera: PerspectiveCamera,
    private readonly light: (place: Place) => Promise<Probed>,
    private readonly shown: (lights: Ringed) => void,
  ) {}

  set(places: readonly Vector[]): void {
    for (const { mark } of this.rings) mark.remove();
    this.rings = places.map((place) => ({ place, mark: el("div", { class: "sb-probed" }) }));
    this.layer.append(...this.rings.map(({ mark }) => mark));
    this.place();
  }

  /** Puts the rings where the camera sees their places. */
  place(): void {
    for (const { place, mark } of this.rings) {
      const { x, y } = this.seen(place);
      mark.style.left = `${100 * x}%`;
      mark.style.top = `${100 * y}%`;
    }
  }

  /** Asks for the light once the view rests, or forgets it while it is computed. */
  refresh(isLit: boolean): void {
    const turn = (this.turn += 1);
    clearTimeout(this.timer);
    if (!isLit || this.rings.length === 0) return;
    this.timer = setTimeout(async () => {
      const lights = await Promise.all(this.rings.map(({ place }) => this.light(this.seen(place))));
      if (turn === this.turn) this.shown(lights.map((light) => light ?? undefined));
    }, REST_MS);
  }

  dispose(): void {
    clearTimeout(this.timer);
    this.turn += 1;
  }

  private seen(place: Vector): Place {
    const { x, y } = new Vector3(...place).project(this.camera);
    return { x: 0.5 + 0.5 * x, y: 0.5 - 0.5 * y };
  }
}
