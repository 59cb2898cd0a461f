/**
 * Solves for the light field of a body, light by light. The newest request counts: an older one is given up between two
 * lights. Lights that did not move are not solved for again.
 */

import init, { Files, LightField } from "native:scene";
import type { Files as NamedFiles, LightField as Field } from "../native";
import { addCoefficients } from "../view/coefficients";
import type { FieldRequest, FieldAnswer, LightOnObject, SurfaceGeometry } from "../view/field-messages";
import { DOME_DIRECTIONS, type Light } from "../view/lights";
import { TABLE_SIZE } from "../view/table-size";

interface Body {
  key: string;
  field: Field;
  /** Lights solved for, by their place. */
  lights: string[];
}

let loaded: Promise<unknown> | undefined;
let body: Body | undefined;
/** Of skies. */
let files: NamedFiles | undefined;
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
      const place = request.lights.findIndex((wanted, place) => lit.lights[place] !== wanted);
      if (place >= 0) await solve(lit, request, place);
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
  const meshes = new Files();
  try {
    if (mesh !== undefined) meshes.add_mesh(mesh.name, mesh.positions, mesh.triangles);
    const field = new LightField(scene, meshes, grain_rays, edge_mm);
    body = { key: bodyKey, field, lights: [] };
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

async function solve({ field, lights }: Body, { version, bodyKey, lights: wanted }: FieldRequest, place: number) {
  const json = wanted[place]!;
  const light = JSON.parse(json) as Light;
  files ??= new Files();
  if (light.type !== "point" && light.sky.type === "clear") await addCoefficients(files);
  const start = performance.now();
  if (light.type === "point") field.light(json);
  else field.light_sky(JSON.stringify(light.sky), light.type === "sun", files);
  lights[place] = json;
  const objects: LightOnObject[] = range(field.object_count()).map((object) => ({
    flux: interleaved(field.flux(object), field.visibility(object)),
    irradiance: field.diffuse_irradiance(object),
    sky: field.sky_irradiance(object),
  }));
  const [red, green, blue] = field.strength_rgb() as unknown as [number, number, number];
  const dome = light.type === "dome" ? field.sky_radiance(DOME_DIRECTIONS) : new Float32Array();
  const milliseconds = performance.now() - start;
  post(
    { kind: "light", version, bodyKey, light: place, json, objects, rgb: [red, green, blue], dome, milliseconds },
    objects.flatMap((one) => [one.flux.buffer, one.irradiance.buffer, one.sky.buffer]),
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
