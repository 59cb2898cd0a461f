/** Skies: what scene files say of them, and where the sun is. */

import type { Range } from "../native";
import type { Sky, Vector } from "../state";

/** From north by way of east. */
export const AZIMUTH: Range = { least: 0, greatest: 360, default: 10, unit: "°" };

/** Reflectance of the land around, which brightens a clear sky: snow with some trees and rocks. */
const GROUND_ALBEDO = 0.8;

/** The table `[sky]` of a scene file. The backdrop stays that of the page. */
export function skyTable(sky: Sky) {
  if (sky.type === "overcast") return { type: sky.type, sun: { elevation_deg: sky.elevation_deg }, visible: false };
  const { type, elevation_deg, azimuth_deg, turbidity } = sky;
  return { type, sun: { elevation_deg, azimuth_deg }, turbidity, ground_albedo: GROUND_ALBEDO, visible: false };
}

/** The unit vector towards the sun: y points north, x east. */
export function towardsSun({ elevation_deg, azimuth_deg }: { elevation_deg: number; azimuth_deg: number }): Vector {
  const [elevation, azimuth] = [(elevation_deg * Math.PI) / 180, (azimuth_deg * Math.PI) / 180];
  const across = Math.cos(elevation);
  return [across * Math.sin(azimuth), across * Math.cos(azimuth), Math.sin(elevation)];
}
