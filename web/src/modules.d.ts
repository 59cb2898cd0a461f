/** Modules that `build.mjs` provides. */

/** `wasm/spectrum.js`; its wasm file lies beside every script of the page. */
declare module "native:spectrum" {
  type Native = import("./native").SpectrumModule;
  const init: Native["default"];
  export default init;
  export const spectrum: Native["spectrum"];
  export const sunlight: Native["sunlight"];
  export const light_at_depth: Native["light_at_depth"];
  export const measured_curve: Native["measured_curve"];
  export const difference_from: Native["difference_from"];
  export const delta_e: Native["delta_e"];
}

/** `wasm/scene.js`; its wasm file lies beside every script of the page. */
declare module "native:scene" {
  type Native = import("./native").SceneModule;
  const init: Native["default"];
  export default init;
  export const Files: Native["Files"];
  export const LightField: Native["LightField"];
  export const Picture: Native["Picture"];
  export const bake_glb: Native["bake_glb"];
}

/** `wasm/meshes.js`; its wasm file lies beside every script of the page. */
declare module "native:meshes" {
  type Native = import("./native").MeshesModule;
  const init: Native["default"];
  export default init;
  export const closed_mesh: Native["closed_mesh"];
}

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
