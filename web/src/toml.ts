/** Values as TOML. */

import { short } from "./numbers";

/** A number with all of its meaningful digits. */
export function exact(value: number): string {
  return short(value, 12);
}

/** A value of a key. */
export function toml(value: unknown): string {
  if (typeof value === "string" || typeof value === "boolean") return JSON.stringify(value);
  if (typeof value === "number") return exact(value);
  if (Array.isArray(value)) return `[${value.map(toml).join(", ")}]`;
  return `{ ${Object.entries(value as object).map(([key, one]) => `${key} = ${toml(one)}`).join(", ")} }`;
}
