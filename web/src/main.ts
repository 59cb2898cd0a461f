/** The page: state, engine and views put together. */

import init from "native:spectrum";
import firstAnswer from "virtual:first-answer";
import { Answers, FORMER, type Shown } from "./answers";
import { BLUE_NM, RED_NM, compared } from "./brightness";
import { version } from "./catalog";
import { Chart } from "./chart/chart";
import { curve, type Content, type Curve } from "./chart/draw";
import { Compare } from "./compare";
import { compiled } from "./compiled";
import { announce, byId, el, say } from "./dom";
import { Engine } from "./engine";
import { decode, encode } from "./fragment";
import { imported } from "./imported";
import type { SpectrumAnswer } from "./native";
import { figure } from "./numbers";
import { once } from "./once";
import { buildPanel } from "./panel/panel";
import { COARSE_RAYS, FINE_RAYS, coarseRequest, defaultState, fineRequest } from "./request";
import { Share } from "./share";
import type { State } from "./state";
import { Store } from "./store";
import { STEPS } from "./story/steps";
import { Story } from "./story/story";
import type { Sunlight } from "./sunlight/sunlight";
import { Swatches } from "./swatch";
import { buildTheme } from "./theme";
import { buildToolbar } from "./toolbar";
import { ViewHost } from "./view-host";

/** What a spectrum and its colours depend on. */
const ASKED = ["layers", "ground_albedo", "angle_deg", "illuminant", "observer", "swatch_exposure"] as const;
/** The address follows the state after so long, in ms. */
const ADDRESS_MS = 250;

/** The results are near the window within this. */
const NEAR = "400px";
/** Longest wait of the view for the poster, in ms. */
const POSTER_MS = 1500;

/** The fragment of the laboratory with the default state, whose own is empty. */
const LABORATORY = "laboratory";

buildTheme();
const store = new Store(defaultState());
const native = compiled("spectrum_bg.wasm");
const subject = { name: "spectrum", coarse: coarseRequest, fine: fineRequest } as const;
const spectra = new Answers([new Engine(native), new Engine(native)], subject, show, wait);
spectra.keep(defaultState(), firstAnswer);
const chart = new Chart((range) => store.update((state) => (state.range = range)));
const swatches = new Swatches(store);
const ready = once(async () => init({ module_or_path: await native() }));
const compare = new Compare(store, spectra, ready, drawCurves);
const host = new ViewHost(store);
let current: Curve | undefined;
/** Infrared light and light at depth; none before the results come near the window. */
let sunlight: Sunlight | undefined;
let sunlightStarted: Promise<void> | undefined;
const sunlightScript = imported<typeof import("./sunlight/sunlight")>("sunlight.js");
let addressTimer: ReturnType<typeof setTimeout> | undefined;
/** The open step of the story; none in the laboratory. */
let storyStep: number | undefined;
/** What the laboratory had when the story was opened from it. */
let beforeStory: State | undefined;

buildPanel(byId("panel"), store);
buildToolbar(store, host);
const share = new Share(store, chart, { content, settle, solar_nm }, host);
const story = new Story(store, host, addEntry, opened, () => enterLaboratory());
byId("open-story").addEventListener("click", () => enterStory());
byId("open-laboratory").addEventListener("click", () => enterLaboratory(beforeStory));
follow(location.hash.slice(1));
// The first light takes longest, so it is asked for before anything is drawn.
host.ask();
store.subscribe((state, before) => {
  if (state === before || ASKED.some((key) => state[key] !== before[key])) spectra.want(state);
});
store.subscribe((state, before) => {
  if (state === before || state.pinned !== before.pinned || state.swatch_exposure !== before.swatch_exposure) {
    compare.update(state);
    drawCurves();
  }
  if (state.range !== before.range) drawCurves();
});
store.subscribe(writeAddress);
window.addEventListener("hashchange", ({ newURL }) => {
  // Not the present address: a write of it may have come between the link and this event.
  const fragment = new URL(newURL).hash.slice(1);
  // The name of a part of the page, as in the link that skips to the controls, is no state.
  if (fragment !== "" && document.getElementById(fragment) !== null) return;
  clearTimeout(addressTimer);
  if (fragment !== address()) follow(fragment);
});
byId("version").textContent = `snowblue ${version}`;
// The view is loaded after the poster is painted, or late.
const painted = (byId("poster") as HTMLImageElement).decode().catch(() => undefined);
const late = new Promise((resolve) => setTimeout(resolve, POSTER_MS));
void Promise.race([painted, late]).then(() => afterPaint(() => void host.start()));
// What is for later must not slow the first light down.
void host.opened.then(() => {
  spectra.warm(store.state);
  return keepOffline();
});
const near = new IntersectionObserver((entries) => {
  if (entries.some(({ isIntersecting }) => isIntersecting)) void startSunlight();
}, { rootMargin: NEAR });
near.observe(byId("results"));

function wait(): void {
  byId("precision").textContent = "Computing a preview.";
}

function show(shown: Shown<SpectrumAnswer>): void {
  say(byId("spectrum-error"), "error" in shown ? `${upper(shown.error)}.` : "");
  document.body.classList.toggle("stale", "error" in shown);
  if ("error" in shown) {
    byId("precision").textContent = current === undefined ? "" : FORMER;
    return;
  }
  const { answer, sample, fine } = shown;
  current = curve(sample, 0, answer);
  swatches.set(answer);
  if (storyStep !== undefined) story.set(answer);
  const words = compared(answer.transmittance, answer, 1);
  byId("meaning").textContent = words === undefined
    ? "Hardly any light comes through this snow."
    : `Through this snow, ${words} (${BLUE_NM} and ${RED_NM} nm).`;
  compare.set(answer);
  drawCurves();
  byId("precision").textContent = precision(answer, fine);
  glance(answer);
  if (fine) announce("spectrum", summary(current.name, answer));
}

/** Over the range of the chart; visible light alone where that is all that is known. */
function curves(): Curve[] {
  const visible = [...(current === undefined ? [] : [current]), ...compare.curves()];
  if (store.state.range === "visible") return visible;
  return visible.map((one) => sunlight?.extended(one) ?? one);
}

/** All that the chart shows. */
function content(): Content {
  return { curves: curves(), measured: sunlight?.measured, range: store.state.range };
}

/** The wavelengths of the solar spectrum, if it is shown and that of the present sample is known. */
function solar_nm(): readonly number[] | undefined {
  return store.state.range === "solar" ? sunlight?.wavelengths_nm : undefined;
}

/** Shows the final figures of the present samples, so that a file has them. */
async function settle(): Promise<void> {
  let state: State;
  do {
    ({ state } = store);
    await Promise.all([spectra.fine(state), compare.settle(), state.range === "solar" ? settleSunlight() : undefined]);
  } while (state !== store.state);
  spectra.want(state);
}

async function settleSunlight(): Promise<void> {
  await startSunlight();
  if (sunlight === undefined) throw new Error("sunlight cannot be computed");
  await sunlight.settle();
}

function drawCurves(): void {
  if (current === undefined) return;
  chart.set(content());
  share.show();
}

/** Loads sunlight once. After a failure the next call tries again. */
function startSunlight(): Promise<void> {
  sunlightStarted ??= loadSunlight();
  return sunlightStarted;
}

async function loadSunlight(): Promise<void> {
  try {
    const { Sunlight } = await sunlightScript();
    say(byId("sunlight-error"), "");
    sunlight = new Sunlight(store, native, drawCurves);
    near.disconnect();
  } catch (error) {
    sunlightStarted = undefined;
    const reason = error instanceof Error ? error.message : error;
    say(byId("sunlight-error"), `Sunlight cannot be computed: ${reason}. Scroll away and back to try again.`);
  }
}

/** How exact the figures are. */
function precision({ transmittance, transmittance_se }: SpectrumAnswer, fine: boolean): string {
  const [name, rays] = fine ? ["Final", FINE_RAYS] : ["Preview", COARSE_RAYS];
  const words = `${name}: ${rays.toLocaleString("en")} rays through grains`;
  if (transmittance_se === undefined) return `${words}; the standard error comes with the final figures.`;
  const relative = transmittance_se.map((error, index) => error / Math.max(transmittance[index]!, Number.MIN_VALUE));
  return `${words}, standard error of T at most ${figure(100 * Math.max(...relative), 2)} % (400–700 nm).`;
}

/** The result beside the controls. */
function glance({ transmitted, transmittance, wavelengths_nm }: SpectrumAnswer): void {
  const value = figure(transmittance[wavelengths_nm.indexOf(450)]!);
  const dot = el("span", { class: "dot", style: `background: ${transmitted.hex}` });
  byId("glance").replaceChildren(dot, `T ${value} at 450 nm`);
}

/** What a screen reader says of a new result. */
function summary(name: string, answer: SpectrumAnswer): string {
  const value = figure(answer.transmittance[answer.wavelengths_nm.indexOf(450)]!);
  return `${name}: transmitted colour ${answer.transmitted.hex}, transmittance ${value} at 450 nm.`;
}

/** Opens what a fragment names: a step of the story, which is also without one, or a state of the laboratory. */
function follow(fragment: string): void {
  const step = /^story=(\d)$/.exec(fragment)?.[1];
  if (fragment === "" || (step !== undefined && STEPS[Number(step) - 1] !== undefined)) {
    say(byId("notice"), "");
    showPart("story");
    story.open(Number(step ?? 1) - 1);
  } else {
    storyStep = undefined;
    showPart("laboratory");
    store.replace(stateOfFragment(fragment === LABORATORY ? "" : fragment));
  }
}

/** From the laboratory to the story; the button of the browser leads back. */
function enterStory(): void {
  if (storyStep !== undefined) return;
  addEntry();
  beforeStory = store.state;
  follow("");
  replaceAddress();
}

/** From the story to the laboratory, with the same snow or a state that it had before. */
function enterLaboratory(before?: State): void {
  if (storyStep === undefined) return;
  addEntry();
  storyStep = undefined;
  showPart("laboratory");
  if (before !== undefined) store.replace(before);
  beforeStory = undefined;
  replaceAddress();
  byId("open-laboratory").focus();
}

function opened(step: number): void {
  if (step !== 0) host.endPoster();
  storyStep = step;
  replaceAddress();
}

/** Shows one part of the page, with the 3-D view in it. */
function showPart(part: "story" | "laboratory"): void {
  const isStory = part === "story";
  byId("story").hidden = !isStory;
  byId("lab").hidden = isStory;
  if (isStory) byId("story-snow").append(byId("view-box"));
  else byId("toolbar").before(byId("view-box"));
  if (!isStory) {
    story.close();
    host.backdrop("dark");
    host.endPoster();
  }
  byId("open-story").setAttribute("aria-pressed", String(isStory));
  byId("open-laboratory").setAttribute("aria-pressed", String(!isStory));
  byId("skip").setAttribute("href", isStory ? "#story-title" : "#panel");
}

function stateOfFragment(fragment: string): State {
  const notice = byId("notice");
  try {
    say(notice, "");
    return decode(fragment);
  } catch (error) {
    const reason = error instanceof Error ? error.message : error;
    say(notice, `The link cannot be read: ${reason}. The default snow is shown.`);
    return defaultState();
  }
}

/** The fragment of what is shown. */
function address(): string {
  if (storyStep === undefined) return encode(store.state) || LABORATORY;
  return storyStep === 0 ? "" : `story=${storyStep + 1}`;
}

function place(fragment: string): string {
  return fragment === "" ? location.pathname + location.search : `#${fragment}`;
}

/** The browser's button leads back to what is shown now. */
function addEntry(): void {
  replaceAddress();
  history.pushState(null, "");
}

function writeAddress(state: State, before: State): void {
  if (state !== before) scheduleAddress();
}

function scheduleAddress(): void {
  clearTimeout(addressTimer);
  addressTimer = setTimeout(replaceAddress, ADDRESS_MS);
}

function replaceAddress(): void {
  clearTimeout(addressTimer);
  history.replaceState(null, "", place(address()));
}

async function keepOffline(): Promise<void> {
  if (!("serviceWorker" in navigator) || !isSecureContext) return;
  await navigator.serviceWorker.register(new URL("service-worker.js", import.meta.url));
}

function afterPaint(run: () => void): void {
  requestAnimationFrame(() => setTimeout(run));
}

function upper(text: string): string {
  return text[0]!.toUpperCase() + text.slice(1);
}
