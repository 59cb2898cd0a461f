/** Light or dark: as the system has it, unless the visitor chooses. */

import { byId } from "./dom";

const KEY = "snowblue-theme";
const CHOICES = ["auto", "light", "dark"] as const;
type Choice = (typeof CHOICES)[number];

export function buildTheme(): void {
  const button = byId("theme");
  let choice = CHOICES.find((one) => one === stored()) ?? "auto";
  const show = () => {
    if (choice === "auto") delete document.documentElement.dataset["theme"];
    else document.documentElement.dataset["theme"] = choice;
    button.lastElementChild!.textContent = `Theme: ${choice}`;
  };
  button.addEventListener("click", () => {
    choice = CHOICES[(CHOICES.indexOf(choice) + 1) % CHOICES.length]!;
    store(choice);
    show();
  });
  show();
}

/** Browsers may refuse storage. */
function stored(): string | null {
  try {
    return localStorage.getItem(KEY);
  } catch {
    return null;
  }
}

function store(choice: Choice): void {
  try {
    localStorage.setItem(KEY, choice);
  } catch {
    // The choice holds until the page is left.
  }
}
