/** Modules that `build.mjs` provides. */

/** What the module `spectrum` says of its parameters, read when the page is built. */
declare module "virtual:catalog" {
  const catalog: import("./catalog").Catalog;
  export default catalog;
}

/** What `display_shader` of the module `spectrum` gives. */
declare module "virtual:display-shader" {
  const shader: string;
  export default shader;
}

/** The spectrum of the default sample, computed when the page is built. */
declare module "virtual:first-answer" {
  const answer: import("./native").SpectrumAnswer;
  export default answer;
}

/** Of the service worker: its files and the hash of all of them. */
declare const FILES: readonly string[];
declare const BUILD: string;
