// Runs all tests: two files at a time, in one browser. A single file runs alone: `node --test FILE`.

import { readdirSync } from "node:fs";
import { run } from "node:test";
import { spec } from "node:test/reporters";
import { fileURLToPath } from "node:url";
import { IS_FIREFOX, shareBrowser } from "./browser.mjs";

const HERE = fileURLToPath(new URL(".", import.meta.url));
/** One page waits for one worker most of the time. */
const AT_ONCE = 2;

const files = readdirSync(HERE).filter((name) => name.endsWith(".test.mjs")).filter((n) => /^(snow|poster|realtime|files)/.test(n)).sort().map((name) => HERE + name);
const browser = IS_FIREFOX ? undefined : await shareBrowser();
run({ files, concurrency: AT_ONCE })
  .on("test:fail", () => (process.exitCode = 1))
  .on("end", () => void browser?.close())
  .compose(new spec())
  .pipe(process.stdout);
