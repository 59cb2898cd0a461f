/** The controls of the 3-D view: shape, light transport, lamps or a sky, exposure and the visitor's own mesh. */

import { byId, el } from "./dom";
import { acceptDrops } from "./drops";
import { icon } from "./icons/icons";
import { Radio, Select } from "./panel/choice";
import { illuminantOptions } from "./panel/light";
import { outside } from "./numbers";
import { NumberField } from "./panel/number-field";
import { control, type Control } from "./panel/parameters";
import { MOST_LAMPS, type Lamp, type Method, type Shape, type Sky, type State } from "./state";
import type { Store } from "./store";
import type { ViewHost } from "./view-host";
import { defaults } from "./view/shapes";
import { AZIMUTH as SUN_AZIMUTH } from "./view/sky";

const SHAPES: { value: Exclude<Shape, "own">; label: string }[] = [
  { value: "block", label: "Block" },
  { value: "ball", label: "Ball" },
  { value: "igloo", label: "Igloo" },
  { value: "drift", label: "Drift" },
  { value: "sculpture", label: "Sculpture" },
];
const METHODS: { value: Method; label: string }[] = [
  { value: "field", label: "Light field, live" },
  { value: "pcasnow", label: "Beside it: the paper's PCASnow" },
  { value: "hybrid", label: "Beside it: path tracer (hybrid)" },
];
const LIGHTS: { value: "lamps" | Sky["type"]; label: string }[] = [
  { value: "lamps", label: "Lamps" },
  { value: "clear", label: "Clear sky" },
  { value: "overcast", label: "Overcast" },
];
const STRENGTH = {
  quantity: "strength", range: { least: 0, greatest: 1e6, default: 10, unit: "W/sr" },
  slider: [0, 200], scale: "cubic",
  sentence: "Radiant intensity of the lamp, over 400–700 nm, equal in all directions.",
  source: "snowblue, chapter Rendering",
} as const;
const ELEVATION = control("elevation_deg", { scale: "linear", step: 1 });
const AZIMUTH: Control = {
  label: "Sun azimuth", quantity: "sun azimuth", range: SUN_AZIMUTH, scale: "linear", step: 5,
  sentence:
    "From north by way of east. North is away from the camera at its start: at 0° the sun stands behind the snow.",
  source: ELEVATION.source,
};
const TURBIDITY = control("turbidity", { scale: "linear", step: 0.5 });
const EXPOSURE: Control = {
  ...control("exposure", { slider: [-10, 10], scale: "linear", step: 0.5 }), label: "Stops",
};

const UNITS = [
  { value: "", label: "of the format (STL mm, others m)" }, { value: "1", label: "m" }, { value: "0.01", label: "cm" },
  { value: "0.001", label: "mm" }, { value: "0.0254", label: "inches" },
];
const MESH_LENGTH: Control = {
  label: "Greatest length", quantity: "greatest length", range: { least: 0.1, greatest: 3000, default: 40, unit: "cm" },
  slider: [1, 300], scale: "log", sentence: "Of the mesh along an axis; lamps and camera move with it.",
  source: "snowblue, chapter In the browser",
};

function defaultSky(type: Sky["type"]): Sky {
  const elevation_deg = ELEVATION.range.default;
  return type === "overcast"
    ? { type, elevation_deg }
    : { type, elevation_deg, azimuth_deg: AZIMUTH.range.default, turbidity: TURBIDITY.range.default };
}

export function buildToolbar(store: Store, host: ViewHost): void {
  byId("toolbar").append(
    shapeRow(store, host), settings(store),
    el("p", { class: "note" },
      "Drag the view to turn it, and a lamp to move it. The snow is that of the first layer. The block is as thick " +
      "as it; all other shapes have a thickness of their own."),
  );
}

function shapeRow(store: Store, host: ViewHost): HTMLElement {
  const shape = new Radio<Shape>(
    { label: "Shape" },
    SHAPES.map((one) => ({ ...one, icon: icon(one.value) })),
    (value) => {
      host.error("");
      const places = structuredClone(defaults(value));
      store.update(({ view }) => Object.assign(view, { shape: value, mesh: undefined }, places));
    },
  );
  shape.element.classList.add("shapes");
  const size = new MeshSize(store);
  const take = (file: File) => {
    size.element.hidden = false;
    void host.addMesh(file, size.scale(file.name));
  };
  acceptDrops(byId("view-drop"), take);
  const input = el("input", {
    type: "file", accept: ".ply,.obj,.stl,.glb", class: "hidden", tabindex: -1,
    "aria-label": "File of a mesh, PLY, OBJ, STL or GLB",
    change: () => {
      const [file] = input.files ?? [];
      if (file !== undefined) take(file);
      input.value = "";
    },
  });
  const own = el("button", {
    type: "button", class: "button own", title: "PLY, OBJ, STL or GLB; or drop a file on the view",
    click: () => input.click(),
  }, icon("own"), "Own mesh");
  store.subscribe(({ view }) => {
    shape.set(view.shape);
    own.setAttribute("aria-pressed", String(view.shape === "own"));
    if (view.shape === "own") for (const radio of shape.element.querySelectorAll("input")) radio.checked = false;
  });
  const add = el("button", {
    type: "button", class: "quiet end",
    click: () => store.update(({ view }) => view.lamps.push(another(view.lamps))),
  }, icon("plus"), "Lamp");
  store.subscribe(({ view }) => {
    add.disabled = view.lamps.length >= MOST_LAMPS;
    add.hidden = view.sky !== undefined;
  });
  return el("div", { class: "row wrap" }, shape.element, own, input, add, size.element);
}

function settings(store: Store): HTMLElement {
  const method = new Select<Method>({ label: "Light transport" }, METHODS, (value) =>
    store.update(({ view }) => (view.method = value)));
  const mode = new Radio<"auto" | "stops">(
    { label: "Exposure" },
    [{ value: "auto", label: "Automatic" }, { value: "stops", label: "Fixed" }],
    (value) => store.update(({ view }) => (view.exposure = value === "auto" ? "auto" : 0)),
  );
  const stops = new NumberField(EXPOSURE, (value) => store.update(({ view }) => (view.exposure = value)));
  const light = new Radio<"lamps" | Sky["type"]>(
    { label: "Light" },
    LIGHTS,
    (value) => store.update(({ view }) => (view.sky = value === "lamps" ? undefined : defaultSky(value))),
  );
  const lamps = el("div", { class: "lamps" });
  const sky = new SkyFields(store);
  let fields: LampField[] = [];
  store.subscribe(({ view }) => {
    light.set(view.sky?.type ?? "lamps");
    lamps.hidden = view.sky !== undefined;
    sky.set(view.sky);
    method.set(view.method);
    mode.set(view.exposure === "auto" ? "auto" : "stops");
    stops.element.hidden = view.exposure === "auto";
    if (view.exposure !== "auto") stops.set(view.exposure);
    if (fields.length !== view.lamps.length) {
      fields = view.lamps.map((_, index) => new LampField(store, index));
      lamps.replaceChildren(...fields.map(({ element }) => element));
    }
    fields.forEach((field, index) => field.set(view.lamps[index]!, view.lamps.length));
  });
  return el("div", { class: "settings" },
    method.element, el("div", { class: "stack" }, mode.element, stops.element), light.element, lamps, sky.element);
}

/** The unit of mesh files, and the length of the present mesh. */
class MeshSize {
  readonly element = el("div", { class: "row wrap", hidden: true });
  readonly #unit: Select<string>;
  #chosen = "";

  constructor(store: Store) {
    this.#unit = new Select<string>({ label: "Unit of mesh files" }, UNITS, (value) => {
      this.#chosen = value;
      const { shape, mesh } = store.state.view;
      const length_m = shape === "own" ? mesh!.length * this.scale(mesh!.name) : NaN;
      // A unit in which the present mesh is not shown is for the next file.
      if (outside("", 100 * length_m, MESH_LENGTH.range) === undefined) resize(length_m);
    });
    const resize = (length_m: number) => store.update(({ view }) => {
      const factor = length_m / (view.mesh!.scale * view.mesh!.length);
      view.mesh!.scale = Number((factor * view.mesh!.scale).toPrecision(6));
      for (const { position } of view.lamps) position.forEach((value, axis) => (position[axis] = factor * value));
      view.camera.distance_m *= factor;
    });
    const length = new NumberField(MESH_LENGTH, (cm) => resize(0.01 * cm));
    this.element.append(this.#unit.element, length.element);
    store.subscribe(({ view: { shape, mesh } }) => {
      length.element.hidden = shape !== "own";
      if (shape === "own") {
        this.element.hidden = false;
        length.set(Number((100 * mesh!.scale * mesh!.length).toPrecision(4)));
      }
      this.#unit.set(this.#chosen);
    });
  }

  /** The unit of a file in m: glTF states it, and of others the formats' usual one counts until a unit is chosen. */
  scale(name: string): number {
    return /\.glb$/i.test(name) ? 1 : Number(this.#chosen || (/\.stl$/i.test(name) ? 0.001 : 1));
  }
}

class SkyFields {
  readonly element = el("div", { class: "sky" });
  readonly #elevation: NumberField;
  readonly #azimuth: NumberField;
  readonly #turbidity: NumberField;

  constructor(store: Store) {
    const change = (values: Partial<Extract<Sky, { type: "clear" }>>) =>
      store.update(({ view }) => Object.assign(view.sky!, values));
    this.#elevation = new NumberField(ELEVATION, (elevation_deg) => change({ elevation_deg }));
    this.#azimuth = new NumberField(AZIMUTH, (azimuth_deg) => change({ azimuth_deg }));
    this.#turbidity = new NumberField(TURBIDITY, (turbidity) => change({ turbidity }));
    this.element.append(this.#elevation.element, this.#azimuth.element, this.#turbidity.element);
  }

  set(sky: Sky | undefined): void {
    this.element.hidden = sky === undefined;
    if (sky === undefined) return;
    this.#elevation.set(sky.elevation_deg);
    this.#azimuth.element.hidden = this.#turbidity.element.hidden = sky.type === "overcast";
    if (sky.type === "overcast") return;
    this.#azimuth.set(sky.azimuth_deg);
    this.#turbidity.set(sky.turbidity);
  }
}

class LampField {
  readonly element: HTMLElement;
  readonly #illuminant: Select<string>;
  readonly #strength: NumberField;
  readonly #remove: HTMLButtonElement;

  constructor(store: Store, index: number) {
    const change = (set: (lamp: Lamp) => void) => store.update(({ view }: State) => set(view.lamps[index]!));
    this.#illuminant = new Select({ label: `Lamp ${index + 1} light` }, illuminantOptions(), (value) =>
      change((lamp) => (lamp.illuminant = value)));
    this.#strength = new NumberField({ ...STRENGTH, label: `Lamp ${index + 1} strength` }, (value) =>
      change((lamp) => (lamp.radiant_intensity_w_sr = value)));
    this.#remove = el("button", {
      type: "button", class: "quiet icon", "aria-label": `Remove lamp ${index + 1}`,
      click: () => store.update(({ view }) => view.lamps.splice(index, 1)),
    }, icon("cross"));
    this.element = el("div", { class: "lamp" }, this.#strength.element, this.#illuminant.element, this.#remove);
  }

  set(lamp: Lamp, count: number): void {
    this.#illuminant.set(lamp.illuminant);
    this.#strength.set(lamp.radiant_intensity_w_sr);
    this.#remove.hidden = count === 1;
  }
}

/** A lamp like the last one, 12 cm to its side. */
function another(lamps: Lamp[]): Lamp {
  const last = structuredClone(lamps[lamps.length - 1]!);
  last.position[0] += 0.12;
  return last;
}
