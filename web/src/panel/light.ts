/** The controls of the light, of the eye and of the ground. */

import { illuminants, parameters } from "../catalog";
import type { Sample } from "../state";
import type { Store } from "../store";
import { Radio, Select } from "./choice";
import { NumberField } from "./number-field";
import { ANGLE, GROUND } from "./parameters";

const CIE = "CIE 015:2018, doi:10.25039/TR.015.2018";
/** What the best-known illuminants are. */
const ILLUMINANT_NAMES: Record<string, string> = {
  A: "incandescent, 2856 K",
  C: "average daylight, obsolete",
  D50: "horizon daylight, 5000 K",
  D55: "mid-morning daylight, 5500 K",
  D65: "noon daylight, 6500 K",
  D75: "north sky daylight, 7500 K",
  E: "equal energy",
};

export function illuminantOptions(): { value: string; label: string }[] {
  return illuminants.map((value) => {
    const name = ILLUMINANT_NAMES[value];
    return { value, label: name === undefined ? value : `${value} (${name})` };
  });
}

export function lightControls(store: Store): HTMLElement[] {
  const incidence = new Radio<"beam" | "diffuse">(
    {
      label: "Incidence",
      sentence: "A parallel beam, or light from the whole sky (Lambertian).",
      source: "snowblue, chapter The two engines",
    },
    [{ value: "beam", label: "Beam" }, { value: "diffuse", label: "Diffuse" }],
    (value) => store.update((state) => (state.angle_deg = value === "diffuse" ? value : parameters.angle_deg.default)),
  );
  const angle = new NumberField(ANGLE, (value) => store.update((state) => (state.angle_deg = value)));
  const illuminant = new Select<string>(
    {
      label: "Illuminant",
      sentence: "The spectrum of the light; it changes the colour, but not R, T and A.",
      source: CIE,
    },
    illuminantOptions(),
    (value) => store.update((state) => (state.illuminant = value)),
  );
  const observer = new Radio<Sample["observer"]>(
    {
      label: "Observer",
      sentence: "The sensitivity of the eye: 2° (1931), by which sRGB is defined, or 10° (1964).",
      source: CIE,
    },
    [{ value: "1931", label: "1931, 2°" }, { value: "1964", label: "1964, 10°" }],
    (value) => store.update((state) => (state.observer = value)),
  );
  const ground = new NumberField(GROUND, (value) => store.update((state) => (state.ground_albedo = value)));
  store.subscribe((state) => {
    const isDiffuse = state.angle_deg === "diffuse";
    incidence.set(isDiffuse ? "diffuse" : "beam");
    angle.element.hidden = isDiffuse;
    if (state.angle_deg !== "diffuse") angle.set(state.angle_deg);
    illuminant.set(state.illuminant);
    observer.set(state.observer);
    ground.set(state.ground_albedo);
  });
  return [incidence.element, angle.element, illuminant.element, observer.element, ground.element];
}
