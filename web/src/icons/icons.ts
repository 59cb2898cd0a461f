/** Line icons of 16 units, drawn in the colour of the text. */

import { svg } from "../dom";

const PATHS = {
  block: "M2.5 5 8 2l5.5 3v6L8 14l-5.5-3zM2.5 5 8 8l5.5-3M8 8v6",
  ball: "M8 2.5a5.5 5.5 0 1 0 0 11 5.5 5.5 0 0 0 0-11zM4 10c2 1.4 6 1.4 8 0",
  igloo: "M1.5 13a6.5 6.5 0 0 1 13 0zM1.9 10.5h12.2M3.6 7.4h8.8M8 6.5v.9M5.5 7.4v3.1M10.5 7.4v3.1M8 10.5V13",
  drift: "M1 13c3 0 3.5-6 7-6s4 6 7 6zM8 11.2v.1M8 4.5v-2M11 5.5l1.2-1.4M5 5.5 3.8 4.1",
  sculpture: "M8 2.5c3 0 4 2 2.5 4S5 9 5.5 11s5 2 5 0S5 7.5 5 5s1.5-2.5 3-2.5z",
  own: "M8 10.5V3M5 5.5 8 2.5l3 3M2.5 10.5v3h11v-3",
  cross: "m4 4 8 8M12 4l-8 8",
  plus: "M8 3v10M3 8h10",
} as const;

export type IconName = keyof typeof PATHS;

export function icon(name: IconName): SVGElement {
  return svg("svg", { viewBox: "0 0 16 16", width: 16, height: 16, class: "icon", "aria-hidden": "true" },
    svg("path", {
      d: PATHS[name], fill: "none", stroke: "currentColor", "stroke-width": 1.4, "stroke-linecap": "round",
      "stroke-linejoin": "round",
    }));
}
