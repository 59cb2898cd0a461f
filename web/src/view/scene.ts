/** Scenes as JSON for the module `scene`, and as TOML for `snowblue render`. */

import type { Snow } from "../native";
import type { Method, Vector, View } from "../state";
import { toml } from "../toml";
import type { Body, Size, Surface } from "./shapes";
import { skyTable } from "./sky";

/** What a camera needs to know of the picture. */
export interface Film {
  width: number;
  height: number;
  /** In stops. */
  exposure: number;
}

/** Nodes of the light field: some follow moving lights, many look as those of the command. */
const NODES: Record<Size, number> = { coarse: 5000, fine: 40_000 };
const NARROWER_FIELD_OF_VIEW_DEG = 30;
const MATERIAL = "snow";

/** Vertical field of view. The narrower side of the picture has 30°. */
export function verticalFieldOfView(width: number, height: number): number {
  const half = (0.5 * NARROWER_FIELD_OF_VIEW_DEG * Math.PI) / 180;
  return (360 / Math.PI) * Math.atan(Math.tan(half) * Math.max(1, height / width));
}

/** Where the camera is. At azimuth 0 it is in front, at negative y; azimuths count counter-clockwise from above. */
export function cameraPosition({ azimuth_deg, elevation_deg, distance_m }: View["camera"], target: Vector): Vector {
  const [azimuth, elevation] = [(azimuth_deg * Math.PI) / 180, (elevation_deg * Math.PI) / 180];
  const across = distance_m * Math.cos(elevation);
  return [
    target[0] + across * Math.sin(azimuth),
    target[1] - across * Math.cos(azimuth),
    target[2] + distance_m * Math.sin(elevation),
  ];
}

const INTEGRATORS: Record<Method, string> = { field: "diffusion", pcasnow: "pcasnow", hybrid: "hybrid" };

/** A whole scene with the keys of a scene file. */
export function sceneOf(
  { object, target }: Pick<Body, "object" | "target">,
  snow: Snow,
  view: View,
  film: Film,
  size: Size = "fine",
) {
  return {
    camera: {
      position: cameraPosition(view.camera, target).map(micrometres),
      look_at: target,
      vertical_fov_deg: Number(verticalFieldOfView(film.width, film.height).toFixed(6)),
    },
    film: { ...film, exposure: Number(film.exposure.toFixed(3)) },
    integrator: { type: INTEGRATORS[view.method], samples_per_pixel: 64, max_bounces: 8 },
    light_field: { nodes: NODES[size] },
    material: { [MATERIAL]: { type: "snow", ...snow } },
    light: view.sky === undefined ? view.lamps.map((lamp) => ({ type: "point", ...lamp })) : [],
    ...(view.sky === undefined ? {} : { sky: skyTable(view.sky) }),
    object: [{ ...object, material: MATERIAL }],
  };
}

/** A scene for the light field alone, which does not depend on the camera or the lights: its lamp is dark. */
export function fieldScene({ object }: Surface, snow: Snow, size: Size): string {
  const view: View = {
    shape: "own",
    lamps: [{ position: [0, 0, 5], illuminant: "D65", radiant_intensity_w_sr: 0 }],
    sky: undefined,
    method: "field",
    exposure: 0,
    camera: { azimuth_deg: 0, elevation_deg: 0, distance_m: 5 },
  };
  const film = { width: 64, height: 64, exposure: 0 };
  return JSON.stringify(sceneOf({ object, target: [0, 0, 0] }, snow, view, film, size));
}

type Table = Record<string, unknown>;

/** The TOML of a scene, with comment lines above it. */
export function toToml(scene: ReturnType<typeof sceneOf>, comments: string[]): string {
  const { camera, film, integrator, light_field, material, light, sky, object } = scene;
  const blocks = [
    comments.map((line) => `# ${line}`).join("\n"),
    table("[camera]", camera),
    table("[film]", film),
    table("[integrator]", integrator),
    table("[light_field]", light_field),
    ...Object.entries(material).map(([name, keys]) => table(`[material.${name}]`, { ...keys })),
    ...light.map((keys) => table("[[light]]", keys)),
    ...(sky === undefined ? [] : [table("[sky]", sky)]),
    ...object.map((keys) => table("[[object]]", keys)),
  ];
  return `${blocks.join("\n\n")}\n`;
}

function table(header: string, keys: Table): string {
  return [header, ...Object.entries(keys).map(([key, value]) => `${key} = ${toml(value)}`)].join("\n");
}

function micrometres(metres: number): number {
  return Number(metres.toFixed(6));
}
