/** Turns the camera around the snow: by pointer, by two fingers, by wheel and by keys. */

import type { View } from "../state";

type Camera = View["camera"];

const DEGREES_PER_PIXEL = 0.4;
const DEGREES_PER_KEY = 5;
const ZOOM_PER_KEY = 1.1;
const LEAST_DISTANCE_M = 0.3;
const GREATEST_DISTANCE_M = 6;
const GREATEST_ELEVATION_DEG = 85;

/** Listens to an element and calls `change` with each new camera. */
export class Orbit {
  private readonly pointers = new Map<number, { x: number; y: number }>();

  constructor(
    private readonly element: HTMLElement,
    private readonly camera: () => Camera,
    private readonly change: (camera: Camera) => void,
  ) {
    element.addEventListener("pointerdown", this.press);
    element.addEventListener("pointermove", this.move);
    element.addEventListener("pointerup", this.release);
    element.addEventListener("pointercancel", this.release);
    element.addEventListener("wheel", this.wheel, { passive: false });
    element.addEventListener("keydown", this.key);
  }

  private readonly press = (event: PointerEvent): void => {
    this.element.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  };

  private readonly move = (event: PointerEvent): void => {
    const before = this.pointers.get(event.pointerId);
    if (before === undefined) return;
    const now = { x: event.clientX, y: event.clientY };
    const other = [...this.pointers].find(([id]) => id !== event.pointerId)?.[1];
    this.pointers.set(event.pointerId, now);
    if (other === undefined) {
      this.turn(-DEGREES_PER_PIXEL * (now.x - before.x), DEGREES_PER_PIXEL * (now.y - before.y), 1);
    } else {
      const apart = ({ x, y }: typeof now) => Math.max(Math.hypot(x - other.x, y - other.y), 1);
      this.turn(0, 0, apart(before) / apart(now));
    }
  };

  private readonly release = (event: PointerEvent): void => {
    this.pointers.delete(event.pointerId);
  };

  /** The wheel scrolls the page unless the view has the focus. */
  private readonly wheel = (event: WheelEvent): void => {
    if (!event.ctrlKey && document.activeElement !== this.element) return;
    event.preventDefault();
    this.turn(0, 0, Math.exp(0.001 * Math.min(Math.max(event.deltaY, -200), 200)));
  };

  private readonly key = (event: KeyboardEvent): void => {
    const turns: Record<string, [number, number, number]> = {
      ArrowLeft: [-DEGREES_PER_KEY, 0, 1],
      ArrowRight: [DEGREES_PER_KEY, 0, 1],
      ArrowUp: [0, DEGREES_PER_KEY, 1],
      ArrowDown: [0, -DEGREES_PER_KEY, 1],
      "+": [0, 0, 1 / ZOOM_PER_KEY],
      "=": [0, 0, 1 / ZOOM_PER_KEY],
      "-": [0, 0, ZOOM_PER_KEY],
    };
    const turn = turns[event.key];
    if (turn === undefined || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    this.turn(...turn);
  };

  private turn(azimuth_deg: number, elevation_deg: number, zoom: number): void {
    const before = this.camera();
    const wrapped = (((before.azimuth_deg + azimuth_deg + 180) % 360) + 360) % 360;
    const within = (value: number, least: number, greatest: number) => Math.min(Math.max(value, least), greatest);
    const rounded = (value: number, digits: number) => Number(value.toFixed(digits));
    this.change({
      azimuth_deg: rounded(wrapped - 180, 1),
      elevation_deg: rounded(
        within(before.elevation_deg + elevation_deg, -GREATEST_ELEVATION_DEG, GREATEST_ELEVATION_DEG), 1,
      ),
      distance_m: rounded(within(before.distance_m * zoom, LEAST_DISTANCE_M, GREATEST_DISTANCE_M), 3),
    });
  }
}
