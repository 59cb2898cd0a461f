// Runs all tests: `node all.mjs`. Two processes run half of the files each, in one browser each, as a page waits for
// one worker most of the time. `node --test FILE` runs one file.

import { spawn } from "node:child_process";
import { readdirSync } from "node:fs";
import { fileURLToPath } from "node:url";

const HERE = new URL(".", import.meta.url);
const [, , half] = process.argv;

if (half === undefined) {
  for (const half of ["0", "1"]) {
    const words = ["--test-reporter=spec", fileURLToPath(import.meta.url), half];
    spawn(process.execPath, words, { stdio: "inherit" }).on("exit", (code) => {
      if (code !== 0) process.exitCode = 1;
    });
  }
} else {
  const files = readdirSync(HERE).filter((name) => name.endsWith(".test.mjs")).sort();
  for (const file of files.filter((_, place) => place % 2 === Number(half))) await import(new URL(file, HERE));
}
