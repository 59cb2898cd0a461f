/** What the eye needs besides snow: a grid on the ground, lamps with lines to their feet, and where the sun stands. */

import {
  BufferGeometry,
  Float32BufferAttribute,
  Group,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshBasicMaterial,
  SphereGeometry,
} from "three";
import type { Lamp, Sky } from "../state";
import { towardsSun } from "./sky";

const GRID_STEP_M = 0.1;
const GRID_LINES = 8;
const LAMP_RADIUS_M = 0.008;
/** Linear colours of lines, near and far from the middle; far away they are as dark as the backdrop. */
const NEAR = [0.034, 0.057, 0.085] as const;
const FAR = [0.0033, 0.0056, 0.0091] as const;

/** Lines every 10 cm that fade with the distance from the middle. */
export function grid(): LineSegments {
  const positions: number[] = [];
  const colours: number[] = [];
  const end = GRID_STEP_M * GRID_LINES;
  const add = (x: number, y: number) => {
    positions.push(x, y, 0);
    const fade = Math.max(0, 1 - Math.hypot(x, y) / end) ** 1.5;
    colours.push(...NEAR.map((value, channel) => FAR[channel]! + fade * (value - FAR[channel]!)));
  };
  for (let line = -GRID_LINES; line <= GRID_LINES; line++) {
    for (let part = -GRID_LINES; part < GRID_LINES; part++) {
      const [across, from] = [line * GRID_STEP_M, part * GRID_STEP_M];
      add(across, from);
      add(across, from + GRID_STEP_M);
      add(from, across);
      add(from + GRID_STEP_M, across);
    }
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new Float32BufferAttribute(positions, 3));
  geometry.setAttribute("color", new Float32BufferAttribute(colours, 3));
  return new LineSegments(geometry, new LineBasicMaterial({ vertexColors: true, toneMapped: false }));
}

/** Small bright balls where lamps are, and lines from them to the ground. */
export class LampMarks {
  readonly group = new Group();
  private readonly ball = new SphereGeometry(LAMP_RADIUS_M, 16, 12);
  private readonly bright = new MeshBasicMaterial({ color: 0xfff6dc, toneMapped: false });
  readonly lines = new LineSegments(
    new BufferGeometry(),
    new LineBasicMaterial({ color: 0x5b7185, toneMapped: false }),
  );

  set(lamps: readonly Lamp[]): void {
    this.group.clear();
    const feet: number[] = [];
    for (const { position } of lamps) {
      const mark = new Mesh(this.ball, this.bright);
      mark.position.set(...position);
      this.group.add(mark);
      const [x, y, z] = position;
      const arm = 0.02;
      feet.push(x, y, z, x, y, 0, x - arm, y, 0, x + arm, y, 0, x, y - arm, 0, x, y + arm, 0);
    }
    this.lines.geometry.dispose();
    this.lines.geometry = new BufferGeometry();
    this.lines.geometry.setAttribute("position", new Float32BufferAttribute(feet, 3));
    this.group.add(this.lines);
  }
}

const SUN_DISTANCE_M = 0.62;
const SUN_RADIUS_M = 0.016;

/** A ball in the direction of the sun, with a line to its foot and one on the ground, along which the light comes. */
export class SunMark {
  readonly group = new Group();
  private readonly ball = new Mesh(
    new SphereGeometry(SUN_RADIUS_M, 24, 16),
    new MeshBasicMaterial({ color: 0xffe9a8, toneMapped: false }),
  );
  readonly lines = new LineSegments(
    new BufferGeometry(),
    new LineBasicMaterial({ color: 0x8a7a4c, toneMapped: false }),
  );

  constructor() {
    this.group.add(this.ball, this.lines);
    this.group.visible = false;
  }

  set(sky: Sky | undefined): void {
    this.group.visible = sky?.type === "clear";
    if (sky?.type !== "clear") return;
    const [x, y, z] = towardsSun(sky).map((part) => SUN_DISTANCE_M * part) as [number, number, number];
    this.ball.position.set(x, y, z);
    this.lines.geometry.dispose();
    this.lines.geometry = new BufferGeometry();
    this.lines.geometry.setAttribute("position", new Float32BufferAttribute([x, y, z, x, y, 0, x, y, 0, 0, 0, 0], 3));
  }
}
