/** The controls of the snow of one layer. */

import { impurities, kinds, parameters, type SpreadKey } from "../catalog";
import { el, say } from "../dom";
import { short } from "../numbers";
import {
  amounts, impurity, plain, setImpurity, setPlain, setSpread, spread, type PlainKey, type Spread,
} from "../snow";
import type { IceTable, Layer } from "../state";
import type { Store } from "../store";
import { Radio, Select } from "./choice";
import type { LayerList } from "./layers";
import { NumberField } from "./number-field";
import {
  DENSITY, FACETNESS, GRAIN_SIZE, SPHERICITY, SURFACE_AREA, TEMPERATURE, THICKNESS, WATER, impurityControl,
  type Control,
} from "./parameters";

type Measure = NonNullable<Layer["size_measure"]>;
const USUAL_MEASURE: Measure = "greatest-extension";

export function snowControls(store: Store, layers: LayerList): HTMLElement[] {
  return [
    kindButtons(layers),
    thicknessField(layers),
    ...grainFields(layers),
    plainField(layers, "density_kg_m3", DENSITY),
    plainField(layers, "water_saturation", WATER),
    spreadField(layers, "facetness", FACETNESS),
    fold("Impurities", impurityFields(layers), layers, (layer) => {
      const count = amounts(layer).length;
      return count === 0 ? "none" : `${count} present`;
    }),
    fold("Shape, spread, temperature and ice", [
      spreadField(layers, "sphericity", SPHERICITY),
      ...spreadFields(layers),
      plainField(layers, "temperature_c", TEMPERATURE),
      iceSelect(store),
    ]),
  ];
}

/** A kind of snow sets the surface area and the density. */
function kindButtons(layers: LayerList): HTMLElement {
  const buttons = kinds.map((kind) => el("button", {
    type: "button", class: "chip",
    title: `${short(kind.ssa_m2_kg)} m²/kg, ${short(kind.density_kg_m3)} kg/m³`,
    click: () => layers.change((layer) => {
      delete layer.grain_size_um;
      delete layer.size_measure;
      layer.ssa_m2_kg = kind.ssa_m2_kg;
      layer.density_kg_m3 = kind.density_kg_m3;
    }),
  }, kind.name.replaceAll("-", " ")));
  const source = el("p", { class: "note" });
  layers.subscribe(() => {
    const { ssa_m2_kg, density_kg_m3 } = layers.layer;
    const chosen = kinds.findIndex((kind) => ssa_m2_kg === kind.ssa_m2_kg && density_kg_m3 === kind.density_kg_m3);
    buttons.forEach((button, index) => button.setAttribute("aria-pressed", String(index === chosen)));
    say(source, kinds[chosen]?.source ?? "");
  });
  return el("div", { class: "kinds" },
    el("div", { class: "chips", role: "group", "aria-label": "Kind of snow" }, ...buttons), source);
}

function thicknessField(layers: LayerList): HTMLElement {
  const field = new NumberField(THICKNESS, (value) => layers.change((layer) => (layer.thickness_cm = value)));
  layers.subscribe(() => field.set(layers.layer.thickness_cm));
  return field.element;
}

/** Grains by their size in some measure, or by their surface. */
function grainFields(layers: LayerList): HTMLElement[] {
  const by = new Radio<"size" | "area">(
    { label: "Grains by" },
    [{ value: "size", label: "Size" }, { value: "area", label: "Surface area" }],
    (value) => layers.change((layer) => {
      delete layer.grain_size_um;
      delete layer.size_measure;
      delete layer.ssa_m2_kg;
      if (value === "area") layer.ssa_m2_kg = parameters.ssa_m2_kg.default;
    }),
  );
  const size = spreadField(layers, "grain_size_um", GRAIN_SIZE);
  const measure = new Select<Measure>(
    {
      label: "Size measure",
      sentence: "The diameter that the grain size states; the choice changes the extinction by a factor of 1.4.",
      source: "Fierz et al. 2009",
    },
    [
      { value: "greatest-extension", label: "greatest extension" },
      { value: "volume-diameter", label: "diameter of equal volume" },
      { value: "optical-diameter", label: "optical diameter" },
    ],
    (value) => layers.change((layer) => {
      if (value === USUAL_MEASURE) delete layer.size_measure;
      else layer.size_measure = value;
    }),
  );
  const area = new NumberField(SURFACE_AREA, (value) => layers.change((layer) => (layer.ssa_m2_kg = value)));
  layers.subscribe(() => {
    const { ssa_m2_kg, size_measure } = layers.layer;
    const isArea = ssa_m2_kg !== undefined;
    by.set(isArea ? "area" : "size");
    area.element.hidden = !isArea;
    size.hidden = measure.element.hidden = isArea;
    area.set(ssa_m2_kg ?? parameters.ssa_m2_kg.default);
    measure.set(size_measure ?? USUAL_MEASURE);
  });
  return [by.element, size, area.element, measure.element];
}

function plainField(layers: LayerList, key: PlainKey, control: Control): HTMLElement {
  const field = new NumberField(control, (value) => layers.change((layer) => setPlain(layer, key, value)));
  layers.subscribe(() => field.set(plain(layers.layer, key)));
  return field.element;
}

/** The mean of a distribution. A grain size keeps its whole spread within the range. */
function spreadField(layers: LayerList, key: SpreadKey, control: Control): HTMLElement {
  const field = new NumberField(control, (mean) =>
    layers.change((layer) => setSpread(layer, key, { ...spread(layer, key), mean })));
  layers.subscribe(() => {
    const { mean, half_width } = spread(layers.layer, key);
    const { least, greatest, ...rest } = control.range;
    const margin = key === "grain_size_um" ? half_width : 0;
    field.set(mean, { ...rest, least: least + margin, greatest: greatest - margin });
  });
  return field.element;
}

/** Half-widths and deviations of the distributions. */
function spreadFields(layers: LayerList): HTMLElement[] {
  const field = (key: SpreadKey, part: "half_width" | "deviation", control: Control) => {
    const one = new NumberField(control, (value) =>
      layers.change((layer) => setSpread(layer, key, { ...spread(layer, key), [part]: value } satisfies Spread)));
    layers.subscribe(() => {
      const { mean, ...rest } = spread(layers.layer, key);
      const { least, greatest } = parameters[key];
      const most = key === "grain_size_um" ? Math.min(mean - least, greatest - mean) : control.range.greatest;
      one.set(rest[part], { ...control.range, greatest: most });
    });
    return one.element;
  };
  const source = "Varsa & Baranoski 2024, Table S1, doi:10.1109/MCG.2023.3307517";
  const width = (label: string, greatest: number, step: number, unit: string): Control => ({
    label: `Half-width of ${label}`, quantity: `half-width of ${label}`,
    range: { least: 0, greatest, default: 0, unit }, scale: "linear", step,
    sentence: `The ${label} lies within the mean ± this.`, source,
  });
  const deviation = (label: string): Control => ({
    label: `Deviation of ${label}`, quantity: `standard deviation of ${label}`,
    range: { least: 0.005, greatest: 1, default: 0, unit: "" }, scale: "linear", step: 0.005,
    sentence: `The standard deviation of the normal distribution of the ${label}, before its ends are cut.`, source,
  });
  return [
    field("grain_size_um", "half_width", { ...width("grain size", 2000, 10, "µm") }),
    field("facetness", "half_width", width("facetness", 1, 0.01, "")),
    field("facetness", "deviation", deviation("facetness")),
    field("sphericity", "half_width", width("sphericity", 0.5, 0.01, "")),
    field("sphericity", "deviation", deviation("sphericity")),
  ];
}

function impurityFields(layers: LayerList): HTMLElement[] {
  return impurities.map((one) => {
    const field = new NumberField(impurityControl(one), (value) =>
      layers.change((layer) => setImpurity(layer, one.name, value)));
    layers.subscribe(() => field.set(impurity(layers.layer, one.name)));
    return field.element;
  });
}

/** The table of ice is one for all layers. */
function iceSelect(store: Store): HTMLElement {
  const select = new Select<IceTable>(
    {
      label: "Absorption of ice",
      sentence:
        "In the blue, ice is so clear that two tables differ by a factor of seven at 450 nm; with the second, thick " +
        "snow is not blue.",
      source: "Warren & Brandt 2008; Picard, Libois & Arnaud 2016, doi:10.5194/tc-10-2655-2016",
    },
    [
      { value: "warren2008", label: "Warren & Brandt 2008" },
      { value: "picard2016", label: "Picard, Libois & Arnaud 2016" },
    ],
    (table) => store.update(({ layers }) => {
      for (const layer of layers) {
        if (table === "warren2008") delete layer.ice;
        else layer.ice = table;
      }
    }),
  );
  store.subscribe(({ layers }) => select.set(layers[0]!.ice ?? "warren2008"));
  return select.element;
}

/** Controls that few need, folded, with a summary of what is set. */
function fold(
  title: string,
  children: HTMLElement[],
  layers?: LayerList,
  summarise?: (layer: Layer) => string,
): HTMLElement {
  const note = el("span", { class: "note" });
  if (layers !== undefined && summarise !== undefined) {
    layers.subscribe(() => (note.textContent = summarise(layers.layer)));
  }
  return el("details", { class: "fold" }, el("summary", {}, title, " ", note), el("div", {}, ...children));
}
