/** The controls of the sample: its layers, the snow of one layer, and the light on all of it. */

import { el } from "../dom";
import type { Store } from "../store";
import { explainAll } from "./hint";
import { LayerList } from "./layers";
import { lightControls } from "./light";
import { snowControls } from "./snow";

export function buildPanel(parent: HTMLElement, store: Store): void {
  const layers = new LayerList(store);
  parent.append(
    el("div", { class: "row help" },
      el("p", { class: "note" }, "Each ? explains a control and names its source."), explainAll(parent)),
    section(heading("Snow", layers.buttons), layers.rows, ...snowControls(store, layers)),
    section(heading("Light and ground"), ...lightControls(store)),
  );
}

function section(...children: HTMLElement[]): HTMLElement {
  return el("div", { class: "group" }, ...children);
}

function heading(title: string, ...buttons: HTMLElement[]): HTMLElement {
  return el("div", { class: "row" }, el("h3", {}, title), ...buttons);
}
