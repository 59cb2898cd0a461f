/**
 * Solves for the light field of a body, light by light. The newest request counts: an older one is given up between two
 * lights. Lights that did not move are not solved for again.
 */

import init, { Files, LightField } from "native:scene";
import { addCoefficients } from "../view/coefficients";
import type {
  FieldAnswer, FieldRequest, LightOnObject, Probed, ProbedLight, ProbeRequest, SurfaceGeometry,
} from "../view/field-messages";
import { DOME_DIRECTIONS, type Light } from "../view/lights";
import { TABLE_SIZE } from "../view/table-size";

interface Body {
  key: string;
  field: LightField;
  /** Lights solved for, by their place. */
  lights: string[];
}

let loaded: Promise<unknown> | undefined;
let body: Body | undefined;
/** Of skies. */
let files: Files | undefined;
let newest: FieldRequest | undefined;
let isBusy = false;

/** The first message is the compiled module, all others are requests; some of these may come before it. */
self.onmessage = ({ data }: MessageEvent<WebAssembly.Module | FieldRequest | ProbeRequest>) => {
  if (data instanceof WebAssembly.Module) loaded = init({ module_or_path: data });
  else if ("probe" in data) return post({ kind: "probe", probe: data.probe, light: probed(data) });
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
      if (place >= 0) {
        await solve(lit, request, place);
      } else {
        post({ kind: "exposure", bodyKey: request.bodyKey, stops: stopsOf(lit, request) });
        if (newest === request) newest = undefined;
      }
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
function prepare({ version, bodyKey, scene, mesh, grain_rays, cells_per_edge }: FieldRequest): Body {
  if (body?.key === bodyKey) return body;
  const before = body;
  body = undefined;
  before?.field.free();
  const meshes = new Files();
  try {
    if (mesh !== undefined) meshes.add(mesh.name, mesh.bytes);
    const field = new LightField(scene, meshes, grain_rays, cells_per_edge);
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

/** The light at a place of the body; not known if that is no longer the present one. */
function probed({ bodyKey, ray, strengths, exposure, tone }: ProbeRequest): Probed {
  if (body?.key !== bodyKey) return null;
  const [along, factors] = [Float32Array.from(ray), Float64Array.from(strengths)];
  const json = body.field.probe(along, factors, DOME_DIRECTIONS, exposure, tone);
  return json === undefined ? undefined : (JSON.parse(json) as ProbedLight);
}

async function solve(body: Body, request: FieldRequest, place: number) {
  const { field, lights } = body;
  const { version, bodyKey } = request;
  const json = request.lights[place]!;
  const light = JSON.parse(json) as Light;
  files ??= new Files();
  if (light.type !== "point" && light.sky.type === "clear") await addCoefficients(files);
  const start = performance.now();
  if (light.type === "point") field.light(place, json);
  else field.light_sky(place, JSON.stringify(light.sky), light.type === "sun", files);
  lights[place] = json;
  const objects: LightOnObject[] = range(field.object_count()).map((object) => ({
    flux: field.flux_and_visibility(object),
    irradiance: field.diffuse_irradiance(object),
    sky: field.sky_irradiance(object),
  }));
  const [red, green, blue] = field.strength_rgb() as unknown as [number, number, number];
  const dome = light.type === "dome" ? field.sky_radiance(DOME_DIRECTIONS) : new Float32Array();
  const [milliseconds, stops] = [performance.now() - start, stopsOf(body, request)];
  post(
    {
      kind: "light", version, bodyKey, light: place, json, objects, rgb: [red, green, blue], dome, milliseconds, stops,
    },
    objects.flatMap((one) => [one.flux.buffer, one.irradiance.buffer, one.sky.buffer]),
  );
}

/** The automatic exposure; a light is dark until there is a solution for one of its type. */
function stopsOf({ field, lights }: Body, { lights: wanted, strengths }: FieldRequest): number | undefined {
  const type = (json: string | undefined) => (json === undefined ? undefined : (JSON.parse(json) as Light).type);
  const factors = strengths.map((strength, place) => (type(lights[place]) === type(wanted[place]) ? strength : 0));
  return field.exposure_stops(Float64Array.from(factors));
}

function range(count: number): number[] {
  return Array.from({ length: count }, (_, number) => number);
}

function post(answer: FieldAnswer, transfer: ArrayBufferLike[] = []): void {
  self.postMessage(answer, { transfer: transfer as ArrayBuffer[] });
}
