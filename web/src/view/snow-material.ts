/** The exit law of snow as a shader: L = sum over lamps of strength (R0 V F + (H + K(mu) J) / pi). */

import {
  ClampToEdgeWrapping,
  Data3DTexture,
  DataUtils,
  GLSL3,
  HalfFloatType,
  LinearFilter,
  RedFormat,
  ShaderMaterial,
  Vector3,
} from "three";
import { GAMUT_GLSL } from "./gamut";
import { TABLE_SIZE } from "./table-size";

/** What one lamp does to a picture. */
export interface LampUniforms {
  position: readonly [number, number, number];
  /** Linear sRGB of the radiant intensity for 1 W/sr. */
  rgb: readonly [number, number, number];
  strength: number;
}

/** Names of the attributes of a lamp: J and V, and H. */
export function attributeNames(lamp: number): [string, string] {
  return [`flux${lamp}`, `irradiance${lamp}`];
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
  private readonly positions: Vector3[];
  private readonly intensities: Vector3[];
  private readonly strengths: number[];

  constructor(lamps: number, escape: readonly number[], reflection: Data3DTexture) {
    const vectors = () => Array.from({ length: lamps }, () => new Vector3());
    const [positions, intensities, strengths] = [vectors(), vectors(), new Array<number>(lamps).fill(0)];
    super({
      glslVersion: GLSL3,
      uniforms: {
        escape: { value: [...escape] },
        reflection: { value: reflection },
        positions: { value: positions },
        intensities: { value: intensities },
        strengths: { value: strengths },
        exposure: { value: 1 },
        is_linear: { value: false },
      },
      vertexShader: vertexShader(lamps),
      fragmentShader: fragmentShader(lamps),
    });
    [this.positions, this.intensities, this.strengths] = [positions, intensities, strengths];
  }

  setLamp(index: number, { position, rgb, strength }: LampUniforms): void {
    this.positions[index]!.set(...position);
    this.intensities[index]!.set(...rgb).multiplyScalar(strength);
    this.strengths[index] = strength;
  }

  /** The factor of the display. */
  set exposure(factor: number) {
    this.uniforms.exposure!.value = factor;
  }

  /** Whether the output is radiance instead of a display's colour. */
  set isLinear(value: boolean) {
    this.uniforms.is_linear!.value = value;
  }
}

function each(lamps: number, line: (lamp: number) => string): string {
  return Array.from({ length: lamps }, (_, lamp) => line(lamp)).join("\n");
}

/** J and H are added up here: the exit law is linear in them. */
function vertexShader(lamps: number): string {
  const names = (lamp: number) => attributeNames(lamp);
  return /* glsl */ `
${each(lamps, (lamp) => `in vec4 ${names(lamp)[0]};\nin vec3 ${names(lamp)[1]};`)}
uniform float strengths[${lamps}];
out vec3 place;
out vec3 surface_normal;
out vec3 flux;
out vec3 irradiance;
out vec4 visibility;

void main() {
  place = position;
  surface_normal = normal;
  flux = vec3(0.0);
  irradiance = vec3(0.0);
  visibility = vec4(0.0);
  ${each(lamps, (lamp) => `flux += strengths[${lamp}] * ${names(lamp)[0]}.rgb;
  irradiance += strengths[${lamp}] * ${names(lamp)[1]};
  visibility[${lamp}] = ${names(lamp)[0]}.a;`)}
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;
}

function fragmentShader(lamps: number): string {
  return /* glsl */ `
precision highp float;
precision highp sampler3D;
uniform float escape[4];
uniform sampler3D reflection;
uniform vec3 positions[${lamps}];
uniform vec3 intensities[${lamps}];
uniform float exposure;
uniform bool is_linear;
in vec3 place;
in vec3 surface_normal;
in vec3 flux;
in vec3 irradiance;
in vec4 visibility;
out vec4 colour;

const float PI = 3.14159265358979;
${GAMUT_GLSL}
// Light of a lamp that the surface reflects after few scatterings.
vec3 reflected(vec3 normal, vec3 to_eye, float mu, vec3 lamp, vec3 intensity, float visible) {
  vec3 towards = lamp - place;
  float square = dot(towards, towards);
  vec3 to_lamp = towards * inversesqrt(square);
  float mu0 = dot(normal, to_lamp);
  if (mu0 <= 0.0) return vec3(0.0);
  float sines = sqrt(max((1.0 - mu * mu) * (1.0 - mu0 * mu0), 1e-12));
  float azimuth = sqrt(clamp(0.5 + 0.5 * (dot(to_eye, to_lamp) - mu * mu0) / sines, 0.0, 1.0));
  vec3 where = (vec3(azimuth, sqrt(mu0), sqrt(mu)) * ${TABLE_SIZE - 1}.0 + 0.5) / ${TABLE_SIZE}.0;
  float r0 = texture(reflection, where).r / max(mu + mu0, 1e-4);
  return r0 * visible * mu0 / square * intensity;
}

float transfer(float linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1.0 / 2.4) - 0.055;
}

void main() {
  vec3 normal = normalize(surface_normal);
  vec3 to_eye = normalize(cameraPosition - place);
  float mu = clamp(dot(normal, to_eye), 0.0, 1.0);
  float k = escape[0] + mu * (escape[1] + mu * (escape[2] + mu * escape[3]));
  vec3 radiance = (irradiance + k * flux) / PI;
  ${each(lamps, (lamp) =>
    `radiance += reflected(normal, to_eye, mu, positions[${lamp}], intensities[${lamp}], visibility[${lamp}]);`)}
  if (is_linear) {
    colour = vec4(radiance, 1.0);
  } else {
    vec3 shown = displayable(exposure * radiance);
    colour = vec4(transfer(shown.r), transfer(shown.g), transfer(shown.b), 1.0);
  }
}`;
}
