/** Handles of lamps over the picture: buttons that are dragged, or moved by keys. */

import { type PerspectiveCamera, Plane, Raycaster, Vector2, Vector3 } from "three";
import type { Lamp } from "../state";

type Position = Lamp["position"];

const KEY_STEP_M = 0.01;
const REACH_M = 3;

export class LampHandles {
  private readonly buttons: HTMLButtonElement[] = [];
  private lamps: readonly Lamp[] = [];

  constructor(
    private readonly layer: HTMLElement,
    private readonly camera: PerspectiveCamera,
    private readonly isHidden: (place: Vector3) => boolean,
    private readonly move: (lamp: number, position: Position) => void,
  ) {}

  set(lamps: readonly Lamp[]): void {
    this.lamps = lamps;
    while (this.buttons.length > lamps.length) this.buttons.pop()!.remove();
    while (this.buttons.length < lamps.length) this.buttons.push(this.button(this.buttons.length));
    lamps.forEach(({ position }, lamp) => {
      const [x, y, z] = position.map((metres) => Math.round(100 * metres)) as Position;
      this.buttons[lamp]!.setAttribute("aria-label", `Lamp ${lamp + 1} at x ${x} cm, y ${y} cm, z ${z} cm`);
    });
    this.place();
  }

  /** Puts the buttons where the camera sees the lamps; behind snow or in it, a lamp is a ring without glow. */
  place(): void {
    this.lamps.forEach(({ position }, lamp) => {
      const place = new Vector3(...position);
      const { classList, style } = this.buttons[lamp]!;
      classList.toggle("sb-behind", this.isHidden(place));
      const seen = place.project(this.camera);
      style.left = `${50 + 50 * seen.x}%`;
      style.top = `${50 - 50 * seen.y}%`;
    });
  }

  private button(lamp: number): HTMLButtonElement {
    const button = document.createElement("button");
    button.type = "button";
    button.className = "sb-lamp";
    button.title = "Drag the lamp. Shift keeps its height. Arrow keys, Page Up and Page Down move it by 1 cm.";
    button.addEventListener("pointerdown", (event) => this.drag(lamp, button, event));
    button.addEventListener("keydown", (event) => this.key(lamp, event));
    this.layer.append(button);
    return button;
  }

  private drag(lamp: number, button: HTMLButtonElement, down: PointerEvent): void {
    if (down.button !== 0) return;
    button.setPointerCapture(down.pointerId);
    const move = (event: PointerEvent) => {
      const position = this.under(event, this.lamps[lamp]!.position);
      if (position !== undefined) this.move(lamp, position);
    };
    const end = () => {
      button.removeEventListener("pointermove", move);
      button.removeEventListener("pointerup", end);
      button.removeEventListener("pointercancel", end);
    };
    button.addEventListener("pointermove", move);
    button.addEventListener("pointerup", end);
    button.addEventListener("pointercancel", end);
  }

  /** Where the pointer meets the plane of a lamp that faces the camera, or with shift the level of the lamp. */
  private under(event: PointerEvent, position: Position): Position | undefined {
    const { left, top, width, height } = this.layer.getBoundingClientRect();
    const pointer = new Vector2((2 * (event.clientX - left)) / width - 1, 1 - (2 * (event.clientY - top)) / height);
    const ray = new Raycaster();
    ray.setFromCamera(pointer, this.camera);
    const normal = event.shiftKey ? new Vector3(0, 0, 1) : this.camera.getWorldDirection(new Vector3());
    const plane = new Plane().setFromNormalAndCoplanarPoint(normal, new Vector3(...position));
    const hit = ray.ray.intersectPlane(plane, new Vector3());
    return hit === null ? undefined : within([hit.x, hit.y, hit.z]);
  }

  /** Arrows move to the right and away from the camera. */
  private key(lamp: number, event: KeyboardEvent): void {
    const forward = this.camera.getWorldDirection(new Vector3());
    // The nearest axis, so that each step is 1 cm along it.
    const isAlongX = Math.abs(forward.x) > Math.abs(forward.y);
    const sign = Math.sign(isAlongX ? forward.x : forward.y);
    const away: Position = isAlongX ? [sign, 0, 0] : [0, sign, 0];
    const right: Position = [away[1], -away[0], 0];
    const steps: Record<string, [Position, number]> = {
      ArrowUp: [away, 1],
      ArrowDown: [away, -1],
      ArrowRight: [right, 1],
      ArrowLeft: [right, -1],
      PageUp: [[0, 0, 1], 1],
      PageDown: [[0, 0, 1], -1],
    };
    const step = steps[event.key];
    if (step === undefined || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    const [direction, factor] = step;
    const position = this.lamps[lamp]!.position;
    this.move(lamp, within(position.map((value, axis) => value + factor * KEY_STEP_M * direction[axis]!) as Position));
  }
}

/** In whole millimetres, within reach. */
function within(position: Position): Position {
  return position.map((value) => Number(Math.min(Math.max(value, -REACH_M), REACH_M).toFixed(3))) as Position;
}
