/** The link, the files and the commands of what the page shows. */

import { version } from "./catalog";
import { compared } from "./brightness";
import type { Chart } from "./chart/chart";
import type { Content } from "./chart/draw";
import { describeView } from "./describe";
import { byId, el, say } from "./dom";
import { LAYERS_FILE, commandLines, layersToml, pythonCall } from "./share-commands";
import { captioned, csv, pngFile, save, svgFile } from "./share-files";
import type { Store } from "./store";
import type { Viewer } from "./view/viewer";
import type { ViewHost } from "./view-host";

/** Of a view. */
const MIDDLE = { x: 0.5, y: 0.5 };
/** Width of the chart in files, in px. */
const WIDTH = 1080;

/** What files and commands are of. */
export interface Shared {
  content(): Content;
  /** Has the final figures of the present samples shown. */
  settle(): Promise<void>;
  /** Wavelengths of the solar spectrum, if there is one. */
  solar_nm(): readonly number[] | undefined;
}

export class Share {
  readonly #command = code("Command line");
  readonly #layers = code(`File ${LAYERS_FILE}`);
  readonly #python = code("Python");
  readonly #store: Store;
  readonly #shared: Shared;

  constructor(store: Store, chart: Chart, shared: Shared, view: ViewHost) {
    const about = `snowblue ${version}, discrete ordinates`;
    const figure = () => svgFile(chart.picture(WIDTH), shared.content(), about);
    const button = (label: string, run: () => Promise<string | void>) =>
      el("button", { type: "button", class: "button", click: () => void this.#run(label, run) }, label);
    const file = (label: string, write: () => Promise<void>) => button(label, async () => {
      say(byId("share-status"), "Computing the final figures.");
      await shared.settle();
      await write();
    });
    byId("share").append(
      el("div", { class: "row wrap" },
        button("Copy link", async () => {
          await copy(location.href);
          const { shape, mesh } = store.state.view;
          return shape === "own" && mesh!.packed === ""
            ? `The link is copied without the mesh, which is too large for a link: it opens a block.`
            : "The link is copied.";
        }),
        file("CSV", async () => save("snow.csv", csv(shared.content().curves), "text/csv")),
        file("SVG", async () => save("snow.svg", figure(), "image/svg+xml")),
        file("PNG", async () => save("snow.png", await pngFile(figure()))),
        button("3-D PNG", async () => save("snow-view.png", await (await view.viewer()).exportPng())),
        button("Picture to share", async () => {
          const viewer = await view.viewer();
          const light = await viewer.lightAt(MIDDLE);
          const words = light && compared(light.radiance, light);
          const lines = [describeView(store.state), ...(words ? [`in the middle, ${words}`] : []), location.href];
          save("snow-blue.png", await captioned(await viewer.exportPng(), light?.srgb, lines));
        }),
        button("3-D GLB", async () => save("snow.glb", await (await view.viewer()).exportGlb())),
        button("Scene TOML", async () => saveScene(await view.viewer())),
      ),
      this.#command.element, this.#layers.element, this.#python.element,
    );
    this.#store = store;
    this.#shared = shared;
    store.subscribe(() => this.show());
  }

  /** Shows the commands of the present sample. */
  show(): void {
    const { state } = this.#store;
    const solar_nm = this.#shared.solar_nm();
    this.#command.set(commandLines(state, solar_nm));
    this.#layers.set(layersToml(state) ?? "");
    this.#python.set(pythonCall(state, solar_nm));
  }

  /** Says what has been done. */
  async #run(label: string, run: () => Promise<string | void>): Promise<void> {
    const status = byId("share-status");
    try {
      say(status, (await run()) ?? `${label} is saved.`);
    } catch (error) {
      say(status, `${label} failed: ${error instanceof Error ? error.message : error}`);
    }
  }
}

/** The scene file, and the mesh that it needs. */
function saveScene(viewer: Viewer): void {
  save("scene.toml", viewer.sceneToml(), "application/toml");
  const mesh = viewer.sceneMesh;
  if (mesh !== undefined) save(mesh.name, new Blob([mesh.bytes]));
}

/** A text to copy. */
function code(title: string) {
  const text = el("code");
  const button = el("button", {
    type: "button", class: "quiet", "aria-label": `Copy: ${title}`,
    click: async () => {
      await copy(text.textContent ?? "");
      say(byId("share-status"), `${title} is copied.`);
    },
  }, "Copy");
  const element = el("div", { class: "code" }, el("div", { class: "row" }, el("h3", {}, title), button),
    el("pre", { tabindex: 0, role: "region", "aria-label": title }, text));
  const set = (content: string) => {
    element.hidden = content === "";
    text.textContent = content;
  };
  return { element, set };
}

async function copy(text: string): Promise<void> {
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    // Without the permission, or on a page that is not secure.
    const area = el("textarea", { class: "hidden" });
    area.value = text;
    document.body.append(area);
    area.select();
    document.execCommand("copy");
    area.remove();
  }
}
