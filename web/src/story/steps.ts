/** The steps of the story: what each shows, its one control, and what it says of the present values. */

import { impurities, parameters } from "../catalog";
import { BLUE_NM, RED_NM, compared } from "../brightness";
import { figure, short } from "../numbers";
import { GRAIN_SIZE, THICKNESS, control, impurityControl, type Control } from "../panel/parameters";
import { setImpurity } from "../snow";
import type { State, Vector } from "../state";
import type { ProbedLight } from "../view/field-messages";
import type { Ringed } from "../view/rings";
import { BLOCK_CM, blockFront_m, defaults } from "../view/shapes";
import type { Backdrop } from "../view/snow-canvas";
import { absorptionAt, left } from "./ice";

export interface Step {
  /** In the list of steps. */
  name: string;
  title: string;
  control: Control;
  value: number;
  /** The 3-D snow, or a drawing of what cannot be seen. */
  figure: Backdrop | "ice" | "walks";
  /** Places of the snow whose light the text states, from left to right. */
  rings?(value: number): Vector[];
  /** Sets the state of the page before the control does. */
  start(state: State): void;
  set(state: State, value: number): void;
  /** Without light while it is computed. */
  text(value: number, lights: Ringed): string;
  source: string;
}

/** In percent; what is next to all has a digit more. */
export const percent = (value: number, digits = 2) =>
  `${figure(100 * value, value > 0.995 && value < 1 ? 4 : digits)}\u00a0%`;

/** What the picture has at a ring, in a clause. */
const atRing = (light: ProbedLight, ring = "ring") =>
  `at the ${ring}, ${compared(light.radiance, light) ?? "hardly any light leaves the snow"}`;
/** The light of all wavelengths. */
const power = ({ radiance }: ProbedLight) =>
  `${figure(radiance.reduce((sum, value) => sum + value, 0) / radiance.length, 2)} W/(m² sr)`;

/** Height of the mound of the drift above the ground, in m. */
const MOUND_M = 0.22;
const MOON: Vector = [-1.9, -1.2, 1.5];
/** Snow above the lamp at first, and in the step of soot. */
const LAMP_DEPTH_CM = 15;

function lampBelow(depth_cm: number): Vector {
  return [0, 0, Number((MOUND_M - 0.01 * depth_cm).toFixed(4))];
}

/** A drift with a lamp in it, and a moon. */
function dusk({ view }: State): void {
  Object.assign(view, { shape: "drift", sky: undefined, method: "field", exposure: -0.3 });
  view.lamps = [
    { position: lampBelow(LAMP_DEPTH_CM), illuminant: "D65", radiant_intensity_w_sr: 0.075 },
    { position: MOON, illuminant: "D75", radiant_intensity_w_sr: 6 },
  ];
  view.camera = { azimuth_deg: 0, elevation_deg: 11, distance_m: 1.05 };
}

/** On the side of the mound that faces the camera. */
const ON_MOUND: Vector = [0, -0.1, 0.19];
/** On the sides of the mound towards the sun and away from it. */
const IN_SUN: Vector = [-0.14, -0.04, 0.164];
const IN_SHADE: Vector = [0.12, -0.12, 0.149];

/** The middle of the front of a block. */
const onBlock = (thickness_cm: number): Vector => [0, blockFront_m(thickness_cm), 0.2];

/** A block with a lamp behind it. */
function block({ view }: State, exposure: State["view"]["exposure"]): void {
  Object.assign(view, { shape: "block", sky: undefined, method: "field", exposure });
  Object.assign(view, structuredClone(defaults("block")));
}

const DEPTH: Control = {
  ...THICKNESS, label: "Snow above the lamp", quantity: "snow above the lamp",
  range: { least: 2, greatest: 25, default: 10, unit: "cm" }, slider: [2, 25], scale: "linear", step: 0.5,
};
/** What is drawn. */
const BLOCK_THICKNESS: Control = { ...THICKNESS, range: { ...THICKNESS.range, ...BLOCK_CM }, slider: [4, 50] };
const ICE_PATH: Control = {
  label: "Path through ice", quantity: "path through ice", range: { least: 0.01, greatest: 100, default: 3, unit: "m" },
  scale: "log", sentence: "Clear ice without bubbles, which does not scatter light.",
  source: "Warren & Brandt 2008, doi:10.1029/2007JD009744",
};
const WAVELENGTH: Control = {
  label: "Wavelength", quantity: "wavelength", range: { least: 400, greatest: 700, default: 650, unit: "nm" },
  scale: "linear", step: 10, sentence: "The colour of the light that enters: 400 nm is violet, 700 nm is red.",
  source: "CIE 018:2019",
};
const SOOT: Control = {
  ...impurityControl(impurities.find(({ name }) => name === "black-carbon")!), label: "Soot",
  slider: [0, 300],
};
/** From where the spectrum needs no more streams than usual. */
const HEIGHTS = { least: 10, greatest: 60 };
const SUN = control("elevation_deg", { slider: [HEIGHTS.least, HEIGHTS.greatest], scale: "linear", step: 1 });
const ELEVATION: Control = { ...SUN, label: "Height of the sun", range: { ...SUN.range, ...HEIGHTS } };
const SIDE: Control = {
  label: "Lamp to the side", quantity: "position of the lamp",
  range: { least: -40, greatest: 40, default: -5, unit: "cm" }, scale: "linear", step: 1,
  sentence: "From the middle of the block to the right.", source: "snowblue, chapter The light field",
};

export const STEPS: Step[] = [
  {
    name: "Glow", title: "A lamp in the snow glows blue", control: DEPTH, value: LAMP_DEPTH_CM, figure: "dusk",
    rings: () => [ON_MOUND],
    start: dusk,
    set(state, below_cm) {
      state.layers = [{ thickness_cm: below_cm }];
      state.view.lamps[0]!.position = lampBelow(below_cm);
    },
    text: (below_cm, [light]) =>
      `Under moonlight snow is white. But a lamp shines below ${short(below_cm)} cm of this snow, and what comes ` +
      `through is blue${light === undefined ? "" : `: ${atRing(light)}`}. Bury the lamp deeper.`,
    source: "After Varsa & Baranoski 2024; Bohren 1983, Colors of snow, frozen waterfalls, and icebergs",
  },
  {
    name: "Ice", title: "Ice absorbs red", control: ICE_PATH, value: 3, figure: "ice",
    start: () => undefined, set: () => undefined,
    text: (path_m) =>
      `Ice absorbs red light ${short(absorptionAt(RED_NM) / absorptionAt(BLUE_NM), 2)} times as strongly as blue. ` +
      `After ${length(path_m)} of clear ice, ${percent(left(BLUE_NM, path_m))} of the blue is left and ` +
      `${percent(left(RED_NM, path_m))} of the red. It takes metres; so how can centimetres of snow be blue?`,
    source: "Absorption of ice: Warren & Brandt 2008. Blue is 450 nm, red 650 nm",
  },
  {
    name: "Paths", title: "Light stays long in snow", control: WAVELENGTH, value: 650, figure: "walks",
    start: () => undefined,
    set: (state) => {
      state.layers = [{ thickness_cm: 15, ssa_m2_kg: parameters.ssa_m2_kg.default }];
    },
    // Needs the walks.
    text: () => "",
    source: "Mean free path of the walks: Kokhanovsky & Zege 2004; mean straight piece 4 V/S between surfaces of " +
      "grains: Cauchy; path through ice by the transmittances at 450 and 650 nm",
  },
  {
    name: "Grains", title: "Coarse grains let more light through", control: GRAIN_SIZE, value: 400, figure: "dark",
    rings: () => [onBlock(15)],
    start: (state) => block(state, -0.3),
    set: (state, grain_size_um) => {
      state.layers = [{ thickness_cm: 15, grain_size_um }];
    },
    text: (grain_size_um, [light]) =>
      `A lamp shines behind 15 cm of snow with grains of ${short(grain_size_um)} µm. ` +
      (light === undefined ? "" : `The ring sends out ${power(light)}, and ${atRing(light)}. `) +
      `Coarse grains have fewer surfaces that turn light back: old snow is brighter inside than fresh snow.`,
    source: "Wiscombe & Warren 1980, A model for the spectral albedo of snow. I",
  },
  {
    name: "Thickness", title: "Each centimetre makes it bluer", control: BLOCK_THICKNESS, value: 15,
    figure: "dark", rings: (thickness_cm) => [onBlock(thickness_cm)],
    start: (state) => block(state, -1),
    set: (state, thickness_cm) => {
      state.layers = [{ thickness_cm }];
    },
    text: (thickness_cm, [light]) =>
      `A lamp shines behind a block of ${short(thickness_cm)} cm. ` +
      (light === undefined ? "" : `The ring sends out ${power(light)}, and ${atRing(light)}. `) +
      `Make it thicker: it gets darker and bluer.`,
    source: "Warren 1982, Optical properties of snow",
  },
  {
    name: "Soot", title: "A little soot takes the blue away", control: SOOT, value: 30, figure: "dusk",
    rings: () => [ON_MOUND],
    start: dusk,
    set(state, ng_g) {
      const [layer] = (state.layers = [{ thickness_cm: LAMP_DEPTH_CM }]);
      setImpurity(layer!, "black-carbon", ng_g);
    },
    text(ng_g, [light]) {
      const result = light === undefined ? "" : ` The ring sends out ${power(light)}, and ${atRing(light)}.`;
      return ng_g === 0
        ? `The snow is without soot.${result} Add some, and the glow dies.`
        : `Each gram of the snow holds ${short(ng_g)} ng of soot, ${short(ng_g / 10, 3)} parts in a hundred ` +
          `million.${result} Soot absorbs all colours. Set it to 0, and the glow is back.`;
    },
    source: "Warren & Wiscombe 1980, A model for the spectral albedo of snow. II",
  },
  {
    name: "Sun", title: "By day snow is white, its shadow blue", control: ELEVATION, value: 18, figure: "day",
    rings: () => [IN_SUN, IN_SHADE],
    start: (state) => {
      dusk(state);
      state.view.exposure = "auto";
    },
    set(state, elevation_deg) {
      state.layers = [{ thickness_cm: 40 }];
      state.angle_deg = 90 - elevation_deg;
      state.view.sky = { type: "clear", elevation_deg, azimuth_deg: 305, turbidity: 2.5 };
    },
    text: (elevation_deg, [sunny, shady]) =>
      `The sun stands ${short(elevation_deg)}° high. Snow sends back nearly all of its light, of all colours: ` +
      `${sunny === undefined ? "in the sun it is white" : atRing(sunny, "left ring, towards the sun")}. Shadows are ` +
      `blue for another reason: only the sky shines there${shady === undefined ? "" : `, and ${
        atRing(shady, "right ring, away from the sun")}`}. A lower sun loses less light in the snow.`,
    source: "Wiscombe & Warren 1980; sky: Hosek & Wilkie 2012",
  },
  {
    name: "Method", title: "A line through the snow is not enough", control: SIDE, value: -5, figure: "dark",
    rings: () => [onBlock(15)],
    start(state) {
      block(state, -2);
      state.view.method = "pcasnow";
    },
    set(state, side_cm) {
      state.layers = [{ thickness_cm: 15 }];
      const [lamp] = state.view.lamps;
      lamp!.position = [0.01 * side_cm, lamp!.position[1], lamp!.position[2]];
    },
    text: (_, [light]) =>
      `On the right, the paper's PCASnow: light takes a straight line through the snow, whose transmittance is ` +
      `tabulated. On the left, the light field: light spreads and leaves by every side, so that the block fades ` +
      `towards its edges${light === undefined ? "" : `; ${atRing(light)}`}. Drag the line between both.`,
    source: "Varsa & Baranoski 2024, doi:10.1109/MCG.2023.3307517",
  },
];

/** Metres, or centimetres where they are few. */
export function length(metres: number): string {
  return metres < 1 ? `${short(100 * metres, 3)} cm` : `${short(metres, 3)} m`;
}
