/** The snow of a scene: keys of `[material.NAME]` in a scene file. */

import { kinds } from "../catalog";
import type { Snow } from "../native";

export interface SnowMaterial {
  type: "pca_snow";
  grain_size_um: number;
  facetness: number;
  density_kg_m3: number;
  water_saturation?: number;
  temperature_c?: number;
  impurities_ng_g?: Record<string, number>;
}

/** Greatest extension of grains of default shape, relative to other diameters with the same transmittance of 5 cm. */
const EXTENSIONS = { "greatest-extension": 1, "volume-diameter": 1.322, "optical-diameter": 1.369 } as const;
const ICE_DENSITY_KG_M3 = 917;
const DEFAULT_TEMPERATURE_C = -5;
/** Least and greatest mean grain size of a scene, whose grains have sizes of ± 50 µm about it. */
const GRAIN_SIZES_UM = [70, 4950] as const;
/** Least and greatest values of the table in the command `snowblue`. */
const EMBEDDED = { grain_size_um: [100, 500], facetness: [0.1, 0.9], density_kg_m3: [200, 400] } as const;

/** The material of a snow, and one sentence on what scenes cannot say of it, if there is something. */
export function materialOf(snow: Snow): { material: SnowMaterial; notice: string | undefined } {
  const kind = kinds.find(({ name }) => name === snow.snow);
  const wantedSize = grainSize(snow, kind?.ssa_m2_kg);
  const material: SnowMaterial = {
    type: "pca_snow",
    grain_size_um: Math.min(Math.max(wantedSize, GRAIN_SIZES_UM[0]), GRAIN_SIZES_UM[1]),
    facetness: mean(snow.facetness) ?? 0.3,
    density_kg_m3: snow.density_kg_m3 ?? kind?.density_kg_m3 ?? 300,
  };
  const { water_saturation = 0, temperature_c = DEFAULT_TEMPERATURE_C } = snow;
  if (water_saturation > 0) material.water_saturation = water_saturation;
  if (temperature_c !== DEFAULT_TEMPERATURE_C) material.temperature_c = temperature_c;
  const impurities = Object.entries(snow.impurities_ng_g ?? {}).filter(([, amount]) => amount > 0);
  if (impurities.length > 0) material.impurities_ng_g = Object.fromEntries(impurities);

  const differences: string[] = [];
  if (material.grain_size_um !== wantedSize) differences.push(`grains of ${material.grain_size_um} µm`);
  if (snow.sphericity !== undefined && (Array.isArray(snow.sphericity) || snow.sphericity !== 0.8)) {
    differences.push("the default sphericity");
  }
  if (Array.isArray(snow.facetness)) differences.push(`facetness about ${material.facetness}`);
  if (snow.ice === "picard2016") differences.push("the ice of Warren & Brandt 2008");
  if (Array.isArray(snow.grain_size_um)) differences.push("grains within 50 µm of the mean");
  if (snow.grain_size_um === undefined || (snow.size_measure ?? "greatest-extension") !== "greatest-extension") {
    const isKnown = snow.grain_size_um !== undefined || snow.ssa_m2_kg !== undefined || kind !== undefined;
    if (isKnown) differences.push(`grains of ${material.grain_size_um} µm that transmit as much`);
  }
  const notice = differences.length === 0 ? undefined : `The snow in 3-D has ${differences.join(", ")}.`;
  return { material, notice };
}

/** Whether the table in the command `snowblue` holds a snow. */
export function isEmbedded(material: SnowMaterial): boolean {
  const keys = ["grain_size_um", "facetness", "density_kg_m3"] as const;
  const fits = keys.every((key) => material[key] >= EMBEDDED[key][0] && material[key] <= EMBEDDED[key][1]);
  return fits && Object.keys(material).length === keys.length + 1;
}

/** The command that computes the table of a snow. */
export function tableCommand(material: SnowMaterial, file: string): string {
  const options = [
    `--preset default --grain-size ${material.grain_size_um}`,
    `--facetness ${material.facetness} --density ${material.density_kg_m3}`,
  ];
  if (material.water_saturation !== undefined) options.push(`--water-saturation ${material.water_saturation}`);
  if (material.temperature_c !== undefined) options.push(`--temperature ${material.temperature_c}`);
  for (const [name, amount] of Object.entries(material.impurities_ng_g ?? {})) {
    options.push(`--impurity ${name}=${amount}`);
  }
  return `snowblue database build ${options.join(" ")} -o ${file}`;
}

/** Mean greatest extension of the grains, in µm. */
function grainSize(snow: Snow, areaOfKind: number | undefined): number {
  const size = snow.grain_size_um;
  if (size !== undefined) {
    const middle = typeof size === "number" ? size : 0.5 * (size[0]! + size[1]!);
    return round(middle * EXTENSIONS[snow.size_measure ?? "greatest-extension"]);
  }
  const area = snow.ssa_m2_kg ?? areaOfKind;
  return area === undefined ? 400 : round((EXTENSIONS["optical-diameter"] * 6e6) / (ICE_DENSITY_KG_M3 * area));
}

/** The number, or the mean of least value, greatest value, mean and standard deviation. */
function mean(value: number | number[] | undefined): number | undefined {
  return typeof value === "object" ? value[2] : value;
}

/** Three digits. */
function round(value: number): number {
  return Number(value.toPrecision(3));
}
