// The command `snowblue`, which the page must agree with.

import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import { mkdtemp, readFile, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { promisify } from "node:util";

const COMMAND = process.env.SNOWBLUE;
assert.ok(COMMAND, "SNOWBLUE must be the path of the command; scripts/test-web sets it");

/** Runs `work` in a folder with some files, by name; `run` runs the command there and `read` reads a file. */
export async function inFolder(files, work) {
  const folder = await mkdtemp(join(tmpdir(), "snowblue-web-"));
  const run = async (...words) => (await promisify(execFile)(COMMAND, ["--quiet", ...words], { cwd: folder })).stdout;
  const read = (name) => readFile(join(folder, name));
  try {
    for (const [name, content] of Object.entries(files)) await writeFile(join(folder, name), content);
    return await work(run, read);
  } finally {
    await rm(folder, { recursive: true });
  }
}

/** A Python that has the package `snowblue`, if there is one. */
export const PYTHON = process.env.SNOWBLUE_PYTHON;

/** Runs lines in Python; gives the values of arrays of xarray, by the expressions of them. */
export async function inPython(lines, expressions) {
  const values = expressions.map((expression) => `(${expression}).values.ravel().tolist()`);
  const code = `${lines}\nimport json\nprint(json.dumps([${values.join(", ")}]))\n`;
  const { stdout } = await promisify(execFile)(PYTHON, ["-c", code]);
  return Object.fromEntries(JSON.parse(stdout).map((one, index) => [expressions[index], one]));
}

/** Rows of comma-separated values as objects by the header; no value may hold a comma outside quotes. */
export function rowsOf(csv) {
  const [header, ...lines] = String(csv).trim().split("\n").map((line) => line.replace(/"[^"]*"/g, "").split(","));
  return lines.map((line) => Object.fromEntries(header.map((name, column) => [name, line[column]])));
}
