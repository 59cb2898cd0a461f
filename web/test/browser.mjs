// The browser of the tests: Chromium, or Firefox if SNOWBLUE_BROWSER says so. playwright-core drives Firefox by
// WebDriver BiDi; versions after 1.64 send commands that Firefox ESR 153 does not know.

import { chromium, firefox } from "playwright-core";
import { FLAGS } from "./three.mjs";

export const IS_FIREFOX = process.env.SNOWBLUE_BROWSER === "firefox";
const CHROMIUM = { executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: FLAGS };
const FIREFOX = {
  channel: "moz-firefox", executablePath: process.env.FIREFOX ?? "/usr/bin/firefox-esr",
  // It has WebGL only with a display.
  headless: false, firefoxUserPrefs: { "webgl.force-enabled": true, "gfx.webrender.software": true },
};

/** Starts a Chromium that all test files of this process and of its children share, until `close`. */
export async function shareBrowser() {
  const server = await chromium.launchServer(CHROMIUM);
  process.env.SNOWBLUE_BROWSER_AT = server.wsEndpoint();
  return server;
}

/** The browser that is shared, or another one. */
export function openBrowser() {
  if (IS_FIREFOX) return firefox.launch(FIREFOX);
  const address = process.env.SNOWBLUE_BROWSER_AT;
  return address === undefined ? chromium.launch(CHROMIUM) : chromium.connect(address);
}
