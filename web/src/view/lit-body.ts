/** Snow with its light as three.js meshes: a geometry for each object, and attributes for each light. */

import { BufferAttribute, BufferGeometry, type Data3DTexture, Group, Mesh, Sphere, Vector3 } from "three";
import type { FieldAnswer, LightOnObject, Rgb } from "./field-messages";
import type { Light, Wanted } from "./lights";
import { attributesOf, type Output, reflectionTexture, SnowMaterial } from "./snow-material";

type BodyAnswer = Extract<FieldAnswer, { kind: "body" }>;
type LightAnswer = Extract<FieldAnswer, { kind: "light" }>;

/** A light that the field was solved for. */
export interface SolvedLight {
  json: string;
  light: Light;
  /** Where a lamp is, or the direction towards the sun. */
  place: [number, number, number];
  /** Linear sRGB of a lamp of 1 W/sr, or of the irradiance by the sun. */
  rgb: Rgb;
  /** Radiance of a sky from each of some directions. */
  dome: Float32Array;
  milliseconds: number;
  objects: LightOnObject[];
}

export class LitBody {
  readonly group = new Group();
  readonly key: string;
  /** The same of the coarse and the fine body of some snow. */
  readonly number: string;
  readonly nodes: number;
  readonly lights: SolvedLight[] = [];
  /** The automatic exposure in stops; none without light. */
  stops: number | undefined;
  private readonly reflection: Data3DTexture;
  private readonly escapes: number[][];
  private readonly geometries: BufferGeometry[];
  private materials: SnowMaterial[] = [];
  /** Types of the lights that the materials are for. */
  private types: Light["type"][] = [];

  constructor({ bodyKey, nodes, objects, reflection }: BodyAnswer) {
    this.key = bodyKey;
    this.number = bodyKey.split(" ")[1]!;
    this.nodes = nodes;
    this.reflection = reflectionTexture(reflection);
    this.escapes = objects.map(({ escape }) => escape);
    this.geometries = objects.map(({ positions, normals, triangles }) => {
      const geometry = new BufferGeometry();
      geometry.setAttribute("position", new BufferAttribute(positions, 3));
      geometry.setAttribute("normal", new BufferAttribute(normals, 3));
      geometry.setIndex(new BufferAttribute(triangles, 1));
      geometry.boundingSphere = new Sphere(new Vector3(), Infinity);
      return geometry;
    });
  }

  /** Takes the light of a lamp, the sun or a sky. */
  light({ light: number, json, objects, rgb, dome, milliseconds, stops }: LightAnswer): void {
    this.stops = stops;
    const light = JSON.parse(json) as Light;
    const place = light.type === "point" ? light.position : light.type === "sun" ? light.towards : NOWHERE;
    this.lights[number] = { json, light, place, rgb, dome, milliseconds, objects };
    const attributes = attributesOf(number, light.type);
    objects.forEach(({ flux, irradiance, sky }, object) => {
      const values = [flux, irradiance, sky];
      attributes.forEach(([name, size], at) => replace(this.geometries[object]!, name, values[at]!, size));
    });
  }

  /** Whether every light is solved for. */
  hasAll(lights: readonly string[]): boolean {
    return lights.every((json, number) => this.lights[number]?.json === json);
  }

  /** The strengths of lights; one is dark until there is a solution for a light of its type. */
  strengths(wanted: readonly Wanted[]): number[] {
    return wanted.map(({ type, strength }, number) => (this.lights[number]?.light.type === type ? strength : 0));
  }

  /** Sets the lights, the factor of the display, and what is written. */
  show(wanted: readonly Wanted[], exposure: number, output: Output): void {
    const strengths = this.strengths(wanted);
    const types = wanted.map(({ type }, number) => this.lights[number]?.light.type ?? type);
    if (this.materials.length === 0 || this.types.join() !== types.join()) this.assemble(types);
    for (const material of this.materials) {
      material.exposure = exposure;
      material.output = output;
      strengths.forEach((strength, number) => {
        const solved = this.lights[number];
        if (solved !== undefined) material.setLight(number, { ...solved, strength });
      });
    }
  }

  dispose(): void {
    this.reflection.dispose();
    for (const geometry of this.geometries) geometry.dispose();
    for (const material of this.materials) material.dispose();
  }

  /** Makes the meshes for some lights. */
  private assemble(types: Light["type"][]): void {
    for (const material of this.materials) material.dispose();
    this.group.clear();
    this.types = types;
    this.materials = this.escapes.map((escape) => new SnowMaterial(types, escape, this.reflection));
    this.geometries.forEach((geometry, object) => {
      types.forEach((type, number) => darken(geometry, number, type));
      this.group.add(new Mesh(geometry, this.materials[object]));
    });
  }
}

/** Of a sky, which is everywhere. */
const NOWHERE: SolvedLight["place"] = [0, 0, 0];

/** A light that is not solved for yet is dark. */
function darken(geometry: BufferGeometry, number: number, type: Light["type"]): void {
  const vertices = geometry.getAttribute("position").count;
  for (const [name, size] of attributesOf(number, type)) {
    if (!geometry.hasAttribute(name)) replace(geometry, name, new Float32Array(size * vertices), size);
  }
}

function replace(geometry: BufferGeometry, name: string, values: Float32Array, size: number): void {
  const present = geometry.getAttribute(name) as BufferAttribute | undefined;
  if (present === undefined) {
    geometry.setAttribute(name, new BufferAttribute(values, size));
  } else {
    present.array = values;
    present.needsUpdate = true;
  }
}
