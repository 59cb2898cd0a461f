/** Elements in one expression. */

type Attributes = Record<string, string | number | boolean | undefined | ((event: never) => void)>;

/** An element. Attributes that are functions are event listeners; `true` is an empty attribute, `false` is none. */
export function el<Tag extends keyof HTMLElementTagNameMap>(
  tag: Tag,
  attributes: Attributes = {},
  ...children: (Node | string)[]
): HTMLElementTagNameMap[Tag] {
  const element = document.createElement(tag);
  apply(element, attributes);
  element.append(...children);
  return element;
}

/** The same for SVG. */
export function svg<Tag extends keyof SVGElementTagNameMap>(
  tag: Tag,
  attributes: Attributes = {},
  ...children: (Node | string)[]
): SVGElementTagNameMap[Tag] {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  apply(element, attributes);
  element.append(...children);
  return element;
}

function apply(element: Element, attributes: Attributes): void {
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") element.addEventListener(name, value as EventListener);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== undefined && value !== false) element.setAttribute(name, String(value));
  }
}

/** An element of `index.html`. */
export function byId(id: string): HTMLElement {
  const found = document.getElementById(id);
  if (found === null) throw new Error(`The page has no element #${id}`);
  return found;
}

let count = 0;

/** An identifier that no other element has. */
export function fresh(stem: string): string {
  count += 1;
  return `${stem}-${count}`;
}

/** A result is announced after so long without another one, in ms. */
const ANNOUNCE_MS = 1000;
/** Results to announce, by what they are of. */
const results = new Map<string, string>();
let announcement: ReturnType<typeof setTimeout> | undefined;

/** Announces a result to screen readers, in one sentence. A newer one of the same name replaces it. */
export function announce(name: string, sentence: string): void {
  results.set(name, sentence);
  clearTimeout(announcement);
  announcement = setTimeout(() => {
    byId("summary").textContent = [...results.values()].join(" ");
    results.clear();
  }, ANNOUNCE_MS);
}

/** Shows or hides text that announces itself. */
export function say(element: HTMLElement, text: string): void {
  if (element.textContent !== text) element.textContent = text;
  element.hidden = text === "";
}
