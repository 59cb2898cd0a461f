/** Snow with its light as three.js meshes: a geometry for each object, and attributes for each lamp. */

import { BufferAttribute, BufferGeometry, type Data3DTexture, Group, Mesh, Sphere, Vector3 } from "three";
import type { FieldAnswer, LampLight, Rgb } from "./field-messages";
import { attributeNames, reflectionTexture, SnowMaterial } from "./snow-material";

type BodyAnswer = Extract<FieldAnswer, { kind: "body" }>;
type LightAnswer = Extract<FieldAnswer, { kind: "light" }>;

/** A lamp that the field was solved for. */
export interface SolvedLamp {
  json: string;
  position: [number, number, number];
  /** Linear sRGB of 1 W/sr. */
  rgb: Rgb;
  milliseconds: number;
  objects: LampLight[];
}

export class LitBody {
  readonly group = new Group();
  readonly key: string;
  readonly nodes: number;
  readonly lamps: SolvedLamp[] = [];
  private readonly reflection: Data3DTexture;
  private readonly escapes: number[][];
  private readonly geometries: BufferGeometry[];
  private materials: SnowMaterial[] = [];

  constructor({ bodyKey, nodes, objects, reflection }: BodyAnswer) {
    this.key = bodyKey;
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

  /** Takes the light of a lamp. */
  light({ lamp, json, objects, rgb, milliseconds }: LightAnswer): void {
    const { position } = JSON.parse(json) as { position: [number, number, number] };
    this.lamps[lamp] = { json, position, rgb, milliseconds, objects };
    const [fluxName, irradianceName] = attributeNames(lamp);
    objects.forEach(({ flux, irradiance }, object) => {
      replace(this.geometries[object]!, fluxName, flux, 4);
      replace(this.geometries[object]!, irradianceName, irradiance, 3);
    });
  }

  /** Whether every lamp is solved for. */
  hasAll(lamps: readonly string[]): boolean {
    return lamps.every((json, lamp) => this.lamps[lamp]?.json === json);
  }

  /** Sets strengths in W/sr, the factor of the display, and whether radiance is written instead. */
  show(strengths: readonly number[], exposure: number, isLinear: boolean): void {
    if (this.materials.length === 0 || this.group.userData.lamps !== strengths.length) this.assemble(strengths.length);
    for (const material of this.materials) {
      material.exposure = exposure;
      material.isLinear = isLinear;
      strengths.forEach((strength, lamp) => {
        const solved = this.lamps[lamp];
        if (solved !== undefined) material.setLamp(lamp, { ...solved, strength });
      });
    }
  }

  geometryOf(object: number): BufferGeometry | undefined {
    return this.geometries[object];
  }

  get escape(): readonly number[][] {
    return this.escapes;
  }

  dispose(): void {
    this.reflection.dispose();
    for (const geometry of this.geometries) geometry.dispose();
    for (const material of this.materials) material.dispose();
  }

  /** Makes the meshes for a number of lamps. */
  private assemble(lamps: number): void {
    for (const material of this.materials) material.dispose();
    this.group.clear();
    this.group.userData.lamps = lamps;
    this.materials = this.escapes.map((escape) => new SnowMaterial(lamps, escape, this.reflection));
    this.geometries.forEach((geometry, object) => {
      for (let lamp = 0; lamp < lamps; lamp++) this.darken(geometry, lamp);
      this.group.add(new Mesh(geometry, this.materials[object]));
    });
  }

  /** A lamp that is not solved for yet is dark. */
  private darken(geometry: BufferGeometry, lamp: number): void {
    const vertices = geometry.getAttribute("position").count;
    attributeNames(lamp).forEach((name, number) => {
      const size = 4 - number;
      if (!geometry.hasAttribute(name)) replace(geometry, name, new Float32Array(size * vertices), size);
    });
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
