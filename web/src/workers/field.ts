/**
 * Solves for the light field of a body, lamp by lamp. The newest request counts: an older one is given up between two
 * lamps. Lamps that did not move are not solved for again.
 */

import init, { LightField, Meshes } from "native:scene";
import type { LightField as Field } from "../native";
import type { FieldRequest, FieldAnswer, LampLight, SurfaceGeometry } from "../view/field-messages";
import { TABLE_SIZE } from "../view/table-size";

interface Body {
  key: string;
  field: Field;
  /** Lamps solved for, by their place. */
  lamps: string[];
}

let loaded: Promise<unknown> | undefined;
let body: Body | undefined;
let newest: FieldRequest | undefined;
let isBusy = false;

/** The first message is the compiled module, all others are requests; some of these may come before it. */
self.onmessage = ({ data }: MessageEvent<WebAssembly.Module | FieldRequest>) => {
  if (data instanceof WebAssembly.Module) loaded = init({ module_or_path: data });
  else newest = data;
  if (loaded !== undefined && newest !== undefined && !isBusy) void work();
};

async function work(): Promise<void> {
  isBusy = true;
  await loaded;
  while (newest !== undefined) {
    const request = newest;
    try {
      const lit = prepare(request);
      const lamp = request.lamps.findIndex((wanted, place) => lit.lamps[place] !== wanted);
      if (lamp >= 0) solve(lit, request, lamp);
      else if (newest === request) newest = undefined;
    } catch (error) {
      if (newest === request) newest = undefined;
      post({ kind: "error", version: request.version, text: error instanceof Error ? error.message : String(error) });
    }
    // Messages that arrived meanwhile come first.
    await new Promise((resolve) => setTimeout(resolve));
  }
  isBusy = false;
}

/** The body of a request, made anew if it is another one. */
function prepare({ version, bodyKey, scene, mesh, grain_rays, edge_mm }: FieldRequest): Body {
  if (body?.key === bodyKey) return body;
  const before = body;
  body = undefined;
  before?.field.free();
  const meshes = new Meshes();
  try {
    if (mesh !== undefined) meshes.add(mesh.name, mesh.positions, mesh.triangles);
    const field = new LightField(scene, meshes, grain_rays, edge_mm);
    body = { key: bodyKey, field, lamps: [] };
    const objects: SurfaceGeometry[] = range(field.object_count()).map((object) => ({
      positions: field.positions(object),
      normals: field.normals(object),
      triangles: field.triangles(object),
      escape: [...field.escape_polynomial(object)],
    }));
    const reflection = field.reflection_table(TABLE_SIZE);
    const answer: FieldAnswer = { kind: "body", version, bodyKey, objects, reflection, nodes: field.node_count() };
    post(answer, [reflection.buffer, ...objects.flatMap((one) => [one.positions.buffer, one.normals.buffer])]);
    return body;
  } finally {
    meshes.free();
  }
}

function solve(lit: Body, { version, bodyKey, lamps }: FieldRequest, lamp: number): void {
  const start = performance.now();
  lit.field.light(lamps[lamp]!);
  lit.lamps[lamp] = lamps[lamp]!;
  const objects: LampLight[] = range(lit.field.object_count()).map((object) => ({
    flux: interleaved(lit.field.flux(object), lit.field.visibility(object)),
    irradiance: lit.field.diffuse_irradiance(object),
  }));
  const [red, green, blue] = lit.field.lamp_rgb() as unknown as [number, number, number];
  const milliseconds = performance.now() - start;
  post(
    { kind: "light", version, bodyKey, lamp, json: lamps[lamp]!, objects, rgb: [red, green, blue], milliseconds },
    objects.flatMap((one) => [one.flux.buffer, one.irradiance.buffer]),
  );
}

/** J and V of each vertex. */
function interleaved(flux: Float32Array, visibility: Float32Array): Float32Array {
  const both = new Float32Array(4 * visibility.length);
  visibility.forEach((visible, vertex) => {
    both.set(flux.subarray(3 * vertex, 3 * vertex + 3), 4 * vertex);
    both[4 * vertex + 3] = visible;
  });
  return both;
}

function range(count: number): number[] {
  return Array.from({ length: count }, (_, number) => number);
}

function post(answer: FieldAnswer, transfer: ArrayBufferLike[] = []): void {
  self.postMessage(answer, { transfer: transfer as ArrayBuffer[] });
}
