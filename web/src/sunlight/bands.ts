/** Broadband albedo: what snow does with the light of bands of the sun's spectrum. */

import { FORMER, type Shown } from "../answers";
import { sunlight } from "../catalog";
import { scrolled } from "../chart/chart";
import { announce, el, say } from "../dom";
import type { Band, SunlightAnswer } from "../native";
import { decimal } from "../numbers";
import { precision } from "./precision";

const NAMES: Record<Band["name"], string> = {
  solar: "Solar", visible: "Visible", "near-infrared": "Near-infrared", par: "PAR (photons)",
};
const PARTS = [
  { key: "reflectance", label: "Reflected" },
  { key: "transmittance", label: "Transmitted" },
  { key: "absorptance", label: "Absorbed" },
] as const;

export class Bands {
  readonly #lead = el("p", { class: "lead", hidden: true });
  readonly #table = el("table", { class: "figures bands" });
  readonly #precision = el("p", { class: "note precision" });
  readonly #error = el("p", { class: "error", role: "alert", hidden: true });

  constructor(parent: HTMLElement) {
    parent.append(
      this.#precision, this.#error, this.#lead, scrolled("Bands of sunlight", this.#table),
      el("p", { class: "note" },
        `Means weighted by the standard sun (${sunlight}), at the incidence of the sample. Absorbed is by the ` +
        "snow: A = 1 − R − (1 − ground albedo) T. PAR counts photons, all other bands energy."),
    );
  }

  wait(): void {
    this.#precision.textContent = "Computing a preview.";
  }

  show(shown: Shown<SunlightAnswer>): void {
    say(this.#error, "error" in shown ? `${shown.error}.` : "");
    if ("error" in shown) {
      this.#precision.textContent = this.#lead.hidden ? "" : FORMER;
      return;
    }
    const { bands } = shown.answer;
    const [solar] = bands;
    this.#precision.textContent = precision(shown.fine);
    this.#lead.hidden = false;
    this.#lead.replaceChildren(
      el("strong", {}, decimal(solar!.reflectance, 3)),
      ` broadband albedo: of the light of the sun, ${limits(solar!)}, this snow reflects ` +
      `${decimal(100 * solar!.reflectance, 1)} %.`);
    if (shown.fine) announce("bands", `Broadband albedo in sunlight: ${decimal(solar!.reflectance, 3)}.`);
    this.#table.replaceChildren(
      el("thead", {}, el("tr", {},
        el("th", { scope: "col" }, "Band"),
        ...PARTS.map(({ key, label }) => el("th", { scope: "col" }, el("span", { class: `key ${key}` }), label)),
        el("th", { scope: "col", class: "share" }, "Shares"),
        el("th", { scope: "col" }, "Full sun"))),
      el("tbody", {}, ...bands.map(row)),
    );
  }
}

function row(band: Band): HTMLElement {
  const bar = el("div", { class: "bar", "aria-hidden": "true" },
    ...PARTS.map(({ key }) => el("span", { class: key, style: `flex-grow: ${Math.max(0, band[key])}` })));
  return el("tr", {},
    el("th", { scope: "row" }, el("strong", {}, NAMES[band.name]), el("span", { class: "limits" }, limits(band))),
    ...PARTS.map(({ key }) => el("td", {}, decimal(band[key], 4))),
    el("td", { class: "share" }, bar),
    el("td", {}, `${decimal(band.full_sun, 0)} ${band.unit}`));
}

function limits({ first_nm, last_nm }: Band): string {
  return `${first_nm}–${last_nm} nm`;
}
