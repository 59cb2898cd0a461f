// What the tests share: a server of the page below a path, a browser, and pages that fail on any error. The browser is
// Chromium, or Firefox if SNOWBLUE_BROWSER says so. playwright-core drives Firefox by WebDriver BiDi; versions after
// 1.64 send commands that Firefox ESR 153 does not know.

import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import { readFile } from "node:fs/promises";
import { createServer } from "node:http";
import { extname, join } from "node:path";
import { fileURLToPath } from "node:url";
import test, { after } from "node:test";
import { chromium, firefox } from "playwright-core";
import { FLAGS } from "./three.mjs";

/** Whether the released page is tested, instead of that which is quickly built. */
export const IS_RELEASED = process.env.SNOWBLUE_PAGE === "released";
export const DIST = fileURLToPath(new URL(IS_RELEASED ? "../dist" : "../quick/dist", import.meta.url));
/** The page must not depend on being at the root of its host. */
const BELOW = "/snow/";
const TYPES = {
  ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".wasm": "application/wasm",
  ".svg": "image/svg+xml", ".webp": "image/webp",
};
/** Only against tests that hang: a busy machine may need many times as long as a free one, also for many parts. */
const HANGS_MS = 600_000;

/**
 * Serves the page at `url` until `close`. Before it sends a file it waits for `ready` of its name. `sent` has the paths
 * and names of those that it sent; a browser that has a file is told that it is the same.
 */
export async function serve(ready = async () => undefined) {
  const sent = [];
  const server = createServer(async ({ url, headers }, response) => {
    const { pathname } = new URL(url, "http://host");
    const file = pathname === BELOW ? "index.html" : pathname.slice(BELOW.length);
    try {
      const content = await readFile(join(DIST, file));
      const etag = `"${createHash("sha256").update(content).digest("hex")}"`;
      await ready(file);
      if (headers["if-none-match"] === etag) {
        response.writeHead(304).end();
        return;
      }
      sent.push({ pathname, file });
      const type = TYPES[extname(file)] ?? "application/octet-stream";
      response.writeHead(200, { etag, "content-type": type }).end(content);
    } catch {
      response.writeHead(404).end();
    }
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  const close = () => new Promise((resolve) => {
    server.close(resolve);
    server.closeAllConnections();
  });
  return { url: `http://127.0.0.1:${server.address().port}${BELOW}`, close, sent };
}

export const server = await serve();
export const IS_FIREFOX = process.env.SNOWBLUE_BROWSER === "firefox";
const browser = await (IS_FIREFOX
  // It has WebGL only with a display.
  ? firefox.launch({ channel: "moz-firefox", executablePath: process.env.FIREFOX ?? "/usr/bin/firefox-esr",
    headless: false, firefoxUserPrefs: { "webgl.force-enabled": true, "gfx.webrender.software": true } })
  : chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: FLAGS }));
after(async () => {
  await browser.close();
  await server.close();
});

/**
 * A test with an empty page of its own, which fails on any error in the console or of the page, except those that
 * `expected` matches. `options` are those of a browser context, and `skip` the reason to leave the test out. `body`
 * gets the page, and the context of the test for parts of it.
 */
export function browserTest(name, body, { skip = false, expected, ...options } = {}) {
  test(name, { timeout: HANGS_MS, skip }, async (t) => {
    const context = await browser.newContext({ viewport: { width: 800, height: 600 }, ...options });
    const problems = [];
    context.on("console", (message) => message.type() === "error" && problems.push(message.text()));
    context.on("weberror", (error) => problems.push(error.error().message));
    try {
      const page = await context.newPage();
      page.setDefaultTimeout(HANGS_MS / 2);
      if (IS_FIREFOX) Object.getPrototypeOf(page.locator("input")).fill = fillNumber;
      await body(page, t);
    } finally {
      await context.close();
    }
    assert.deepEqual(problems.filter((problem) => !expected?.test(problem)), []);
  });
}

/** In Firefox, Playwright adds to a number instead of replacing it. */
function fillNumber(value) {
  return this.evaluate((field, value) => {
    field.focus();
    field.value = value;
    for (const type of ["input", "change"]) field.dispatchEvent(new Event(type, { bubbles: true }));
  }, value);
}

/**
 * A test of the page at a fragment, by default in the laboratory. It fails on any request to somewhere else. `url` is
 * that of another server; `options` and `body` are those of `browserTest`.
 */
export function pageTest(name, { fragment = "laboratory", url = server.url, ...options }, body) {
  const opened = async (page, t) => {
    const elsewhere = [];
    page.context().on("request", (request) => {
      const address = request.url();
      if (!address.startsWith(url) && !/^(blob|data):/.test(address)) elsewhere.push(`request to ${address}`);
    });
    await page.goto(`${url}${fragment && `#${fragment}`}`);
    await body(page, t);
    assert.deepEqual(elsewhere, []);
  };
  browserTest(name, opened, options);
}

/** The result of a promise of the page, which has no time limit of its own; a promise that hangs is named. */
function within(promise, name) {
  let timer;
  const hangs = new Promise((_, reject) => {
    timer = setTimeout(() => reject(new Error(`${name} takes more than ${HANGS_MS / 2e3} s`)), HANGS_MS / 2);
  });
  return Promise.race([promise, hangs]).finally(() => clearTimeout(timer));
}

/** A field, a select or a slider by its whole label. */
export function control(page, label) {
  return page.getByLabel(label, { exact: true });
}

/** Follows a link to another fragment; the page has taken it when this is done. */
export async function follow(page, fragment) {
  const followed = page.evaluate((fragment) => new Promise((resolve) => {
    addEventListener("hashchange", resolve, { once: true });
    location.hash = fragment;
  }), fragment);
  await within(followed, `the link ${fragment}`);
}

/** Waits for the final spectrum of the present sample. */
export async function final(page) {
  await page.waitForFunction(() => document.getElementById("precision").textContent.startsWith("Final"));
}

/** Brings sunlight and light at depth into view, one after the other, and waits for their final figures. */
export async function sunlit(page) {
  for (const part of ["#bands", "#depth-chart"]) {
    await page.locator(part).scrollIntoViewIfNeeded();
    await page.waitForFunction(
      (part) => document.querySelector(`${part} .precision`)?.textContent.startsWith("Final"), part);
  }
}

/** Changes the snow, which the 3-D view follows once its control rests, and waits until that computes new light. */
export async function relight(page, change) {
  await page.evaluate(() => {
    const status = document.getElementById("view-status");
    window.relit = new Promise((resolve) => {
      const observer = new MutationObserver(() => {
        if (!status.textContent.includes("is being computed")) return;
        observer.disconnect();
        resolve();
      });
      observer.observe(status, { childList: true });
    });
  });
  await change();
  await within(page.evaluate(() => window.relit), "new light");
}

/** Waits for the fine light field of the present view. */
export async function lit(page) {
  await page.waitForFunction(() => window.__snowblue);
  await within(page.evaluate(() => window.__snowblue.ready), "the fine light field");
}

/** A text to copy, by its title. */
export function code(page, title) {
  return page.getByRole("region", { name: title, exact: true }).textContent();
}

/** Chooses a file as the measured curve. The controls for it are there once the results have been in view. */
export async function chooseCurve(page, name, content) {
  await page.setInputFiles("#measured input[type=file]", { name, mimeType: "text/csv", buffer: Buffer.from(content) });
}

/** Presses a button below "Share and reproduce" and gives the files that it saves, by name. */
export async function saved(page, name, count = 1, press = (button) => button.click()) {
  const wait = await (IS_FIREFOX ? linked : downloaded)(page, count);
  await press(page.getByRole("button", { name, exact: true }));
  return within(wait(), `saving by ${name}`);
}

function downloaded(page, count) {
  const downloads = [];
  const all = new Promise((resolve) => {
    page.on("download", (download) => downloads.push(download) === count && resolve());
  });
  return async () => {
    await all;
    page.removeAllListeners("download");
    const files = downloads.map(async (one) => [one.suggestedFilename(), await readFile(await one.path())]);
    return Object.fromEntries(await Promise.all(files));
  };
}

/** Playwright learns of no download in Firefox, so the links of the files are read. */
async function linked(page, count) {
  await page.evaluate(() => {
    window.savedFiles = [];
    HTMLAnchorElement.prototype.click = function () {
      const { download, href } = this;
      const bytes = fetch(href).then(async (file) => [...new Uint8Array(await file.arrayBuffer())]);
      window.savedFiles.push(bytes.then((bytes) => [download, bytes]));
    };
  });
  return async () => {
    await page.waitForFunction((count) => window.savedFiles.length === count, count);
    const files = await page.evaluate(() => Promise.all(window.savedFiles));
    return Object.fromEntries(files.map(([name, bytes]) => [name, Buffer.from(bytes)]));
  };
}

/** Chooses a file as the visitor's own mesh. */
export async function chooseMesh(page, name, buffer) {
  await page.setInputFiles("#toolbar input[type=file]", { name, mimeType: "application/octet-stream", buffer });
}

/** Radiance of some pixels of the 3-D view by column and row: linear red, green, blue, and alpha. */
export function pixels(page, places) {
  return page.evaluate((places) => {
    const { width, height } = document.querySelector(".sb-field");
    const all = window.__snowblue.readPixels(0, 0, width, height);
    return places.map(([x, y]) => [...all.subarray(4 * (y * width + x), 4 * (y * width + x) + 4)]);
  }, places.map((place) => place.map(Math.floor)));
}

/** Radiance of one pixel. */
export async function pixel(page, place) {
  return (await pixels(page, [place]))[0];
}

/** Width and height of the 3-D view in pixels. */
export function viewSize(page) {
  return page.evaluate(() => {
    const { width, height } = document.querySelector(".sb-field");
    return [width, height];
  });
}
