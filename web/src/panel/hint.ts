/** The sentence of a control, which its question mark shows. */

import { el, fresh } from "../dom";

export interface Hint {
  button: HTMLButtonElement;
  sentence: HTMLElement;
}

export function hint(label: string, sentence: string, source: string): Hint {
  const id = fresh("hint");
  const text = el("p", { id, class: "sentence", hidden: true }, sentence, " ", sourceElement(source));
  const button = el("button", {
    type: "button", class: "hint", "aria-expanded": "false", "aria-controls": id, "aria-label": `About ${label}`,
    click: () => show(made, Boolean(text.hidden)),
  }, "?");
  const made = { button, sentence: text };
  return made;
}

/** A button that shows or hides the sentences of some hints in an element, all together. */
export function explainAll(parent: HTMLElement): HTMLButtonElement {
  const button = el("button", {
    type: "button", class: "quiet", "aria-pressed": "false",
    click: () => {
      const isShown = button.getAttribute("aria-pressed") !== "true";
      button.setAttribute("aria-pressed", String(isShown));
      for (const one of parent.querySelectorAll<HTMLButtonElement>(".hint")) {
        show({ button: one, sentence: document.getElementById(one.getAttribute("aria-controls")!)! }, isShown);
      }
    },
  }, "Explain all");
  return button;
}

function show({ button, sentence }: Hint, isShown: boolean): void {
  sentence.hidden = !isShown;
  button.setAttribute("aria-expanded", String(isShown));
}

/** A source; its DOI is a link. */
function sourceElement(source: string): HTMLElement {
  const cite = el("cite");
  const doi = /doi:(\S+?)(?=[;,)]?(\s|$))/;
  const found = doi.exec(source);
  if (found === null) {
    cite.append(source);
  } else {
    const link = el("a", { href: `https://doi.org/${found[1]}`, rel: "noopener", target: "_blank" }, found[0]);
    cite.append(source.slice(0, found.index), link, source.slice(found.index + found[0].length));
  }
  return cite;
}
