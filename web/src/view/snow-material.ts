/**
 * The exit law of snow as a shader: L = sum over lights of strength (R0 V F + (H + K(mu) J) / pi).
 *
 * A sky shines from many directions. What the surface reflects of it depends on the eye as that of the sky without
 * shadows does, which is a sum of R0 over some directions, in each vertex.
 */

import {
  ClampToEdgeWrapping,
  Data3DTexture,
  DataTexture,
  DataUtils,
  FloatType,
  GLSL3,
  HalfFloatType,
  LinearFilter,
  RedFormat,
  RGBAFormat,
  ShaderMaterial,
  Vector3,
} from "three";
import DISPLAY_GLSL from "virtual:display-shader";
import { DOME_DIRECTIONS, type Light } from "./lights";
import { TABLE_SIZE } from "./table-size";

/** What one light does to a picture. */
export interface LightUniforms {
  /** The position of a lamp, or the direction towards the sun. */
  place: readonly [number, number, number];
  /** Linear sRGB of the radiant intensity of a lamp of 1 W/sr, or of the irradiance by the sun. */
  rgb: readonly [number, number, number];
  /** Radiance of a sky from each direction. */
  dome: Float32Array;
  strength: number;
}

/** Radiance, or colours of a display by a tone curve of the command: `filmic`, its default, or none. */
export type Output = "radiance" | "none" | "filmic";
const OUTPUTS: readonly Output[] = ["radiance", "none", "filmic"];

/** Names of the attributes of a light and their sizes: J and V, H, and V F of a sky. */
export function attributesOf(light: number, type: Light["type"]): [string, number][] {
  const names: [string, number][] = [[`flux${light}`, 4], [`irradiance${light}`, 3]];
  return type === "dome" ? [...names, [`sky${light}`, 3]] : names;
}

/** The table of (mu + mu0) R0. */
export function reflectionTexture(table: Float32Array): Data3DTexture {
  const halves = Uint16Array.from(table, (value) => DataUtils.toHalfFloat(value));
  const texture = new Data3DTexture(halves, TABLE_SIZE, TABLE_SIZE, TABLE_SIZE);
  texture.format = RedFormat;
  texture.type = HalfFloatType;
  texture.minFilter = LinearFilter;
  texture.magFilter = LinearFilter;
  texture.wrapS = texture.wrapT = texture.wrapR = ClampToEdgeWrapping;
  texture.needsUpdate = true;
  return texture;
}

export class SnowMaterial extends ShaderMaterial {
  private readonly places: Vector3[];
  private readonly intensities: Vector3[];
  private readonly strengths: number[];
  private readonly dome: DataTexture;

  constructor(lights: readonly Light["type"][], escape: readonly number[], reflection: Data3DTexture) {
    const vectors = () => lights.map(() => new Vector3());
    const [places, intensities, strengths] = [vectors(), vectors(), new Array<number>(lights.length).fill(0)];
    const dome = domeTexture();
    super({
      glslVersion: GLSL3,
      uniforms: {
        escape: { value: [...escape] },
        reflection: { value: reflection },
        places: { value: places },
        intensities: { value: intensities },
        strengths: { value: strengths },
        dome: { value: dome },
        exposure: { value: 1 },
        output_kind: { value: 0 },
      },
      vertexShader: vertexShader(lights),
      fragmentShader: fragmentShader(lights),
    });
    [this.places, this.intensities, this.strengths, this.dome] = [places, intensities, strengths, dome];
  }

  setLight(index: number, { place, rgb, dome, strength }: LightUniforms): void {
    this.places[index]!.set(...place);
    this.intensities[index]!.set(...rgb).multiplyScalar(strength);
    this.strengths[index] = strength;
    if (dome.length > 0) {
      setTexels(this.dome, 1, dome);
      this.dome.needsUpdate = true;
    }
  }

  override dispose(): void {
    this.dome.dispose();
    super.dispose();
  }

  /** The factor of the display. */
  set exposure(factor: number) {
    this.uniforms.exposure!.value = factor;
  }

  set output(output: Output) {
    this.uniforms.output_kind!.value = OUTPUTS.indexOf(output);
  }
}

const DOME_COUNT = DOME_DIRECTIONS.length / 3;

/** The directions of a sky, and below each the radiance from there. Uniforms would be too many for some devices. */
function domeTexture(): DataTexture {
  const texture = new DataTexture(new Float32Array(2 * 4 * DOME_COUNT), DOME_COUNT, 2, RGBAFormat, FloatType);
  setTexels(texture, 0, DOME_DIRECTIONS);
  texture.needsUpdate = true;
  return texture;
}

/** Sets the first three channels of a row of a `domeTexture`. */
function setTexels({ image }: DataTexture, row: number, values: Float32Array): void {
  const data = image.data as Float32Array;
  for (let k = 0; k < DOME_COUNT; k++) data.set(values.subarray(3 * k, 3 * k + 3), 4 * (row * DOME_COUNT + k));
}

function each(lights: readonly Light["type"][], line: (light: number, type: Light["type"]) => string): string {
  return lights.map((type, light) => line(light, type)).join("\n");
}

/** R0 of a direction of light and one to the eye, by the cosines of both. */
const REFLECTION_GLSL = /* glsl */ `
precision highp sampler3D;
uniform sampler3D reflection;
float r0(vec3 to_eye, float mu, vec3 to_light, float mu0) {
  float sines = sqrt(max((1.0 - mu * mu) * (1.0 - mu0 * mu0), 1e-12));
  float azimuth = sqrt(clamp(0.5 + 0.5 * (dot(to_eye, to_light) - mu * mu0) / sines, 0.0, 1.0));
  vec3 where = (vec3(azimuth, sqrt(mu0), sqrt(mu)) * ${TABLE_SIZE - 1}.0 + 0.5) / ${TABLE_SIZE}.0;
  return texture(reflection, where).r / max(mu + mu0, 1e-4);
}
`;

/** J and H are added up here: the exit law is linear in them. */
function vertexShader(lights: readonly Light["type"][]): string {
  const declarations = each(lights, (light, type) =>
    attributesOf(light, type).map(([name, size]) => `in vec${size} ${name};`).join("\n"));
  return /* glsl */ `
precision highp float;
${declarations}
${REFLECTION_GLSL}
uniform float strengths[${lights.length}];
uniform highp sampler2D dome;
out vec3 place;
out vec3 surface_normal;
out vec3 flux;
out vec3 irradiance;
out vec4 visibility;

// What the surface reflects of the sky towards the eye, relative to a white diffuse surface.
vec3 reflected_sky() {
  vec3 to_eye = normalize(cameraPosition - position);
  float mu = clamp(dot(normal, to_eye), 0.0, 1.0);
  vec3 received = vec3(1e-20);
  vec3 sent = vec3(1e-20);
  for (int k = 0; k < ${DOME_COUNT}; k++) {
    vec3 to_light = texelFetch(dome, ivec2(k, 0), 0).rgb;
    float mu0 = dot(normal, to_light);
    if (mu0 <= 0.0) continue;
    vec3 light = mu0 * texelFetch(dome, ivec2(k, 1), 0).rgb;
    received += light;
    sent += 3.14159265 * r0(to_eye, mu, to_light, mu0) * light;
  }
  return sent / received;
}

void main() {
  place = position;
  surface_normal = normal;
  flux = vec3(0.0);
  irradiance = vec3(0.0);
  visibility = vec4(0.0);
  ${each(lights, (light, type) => `flux += strengths[${light}] * flux${light}.rgb;
  irradiance += strengths[${light}] * ${type === "dome"
    ? `(irradiance${light} + reflected_sky() * sky${light})`
    : `irradiance${light}`};
  visibility[${light}] = flux${light}.a;`)}
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;
}

/** Towards a light, and the square of its distance. */
const TOWARDS: Record<Exclude<Light["type"], "dome">, (light: number) => string> = {
  point: (light) => `places[${light}] - place`,
  sun: (light) => `places[${light}]`,
};

function fragmentShader(lights: readonly Light["type"][]): string {
  return /* glsl */ `
precision highp float;
uniform float escape[4];
uniform vec3 places[${lights.length}];
uniform vec3 intensities[${lights.length}];
uniform float exposure;
uniform int output_kind;
in vec3 place;
in vec3 surface_normal;
in vec3 flux;
in vec3 irradiance;
in vec4 visibility;
out vec4 colour;

const float PI = 3.14159265358979;
${DISPLAY_GLSL}
${REFLECTION_GLSL}

// Light of a lamp or the sun that the surface reflects after few scatterings. The direction to the sun has length 1.
vec3 reflected(vec3 normal, vec3 to_eye, float mu, vec3 towards, vec3 intensity, float visible) {
  float square = dot(towards, towards);
  vec3 to_light = towards * inversesqrt(square);
  float mu0 = dot(normal, to_light);
  if (mu0 <= 0.0) return vec3(0.0);
  return r0(to_eye, mu, to_light, mu0) * visible * mu0 / square * intensity;
}

void main() {
  vec3 normal = normalize(surface_normal);
  vec3 to_eye = normalize(cameraPosition - place);
  float mu = clamp(dot(normal, to_eye), 0.0, 1.0);
  float k = escape[0] + mu * (escape[1] + mu * (escape[2] + mu * escape[3]));
  vec3 radiance = (irradiance + k * flux) / PI;
  ${each(lights, (light, type) => (type === "dome" ? "" :
    `radiance +=
      reflected(normal, to_eye, mu, ${TOWARDS[type](light)}, intensities[${light}], visibility[${light}]);`))}
  vec3 exposed = exposure * radiance;
  if (output_kind == ${OUTPUTS.indexOf("radiance")}) colour = vec4(radiance, 1.0);
  else colour = vec4(display(output_kind == ${OUTPUTS.indexOf("filmic")} ? filmic(exposed) : exposed), 1.0);
}`;
}
