// Baked snow in three.js: a page with lines of three.js, and the radiance of its pixels.

import { fileURLToPath } from "node:url";
import * as esbuild from "esbuild";

const HERE = fileURLToPath(new URL(".", import.meta.url));

/** Software rendering, so that machines without a graphics card show the same. */
export const FLAGS = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"];

/** The lines in a page, with a camera and a picture of floats. The axes of glTF are x, z and −y. */
function program(lines) {
  return `
    import * as THREE from "three";
    import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
    const turned = ([x, y, z]) => new THREE.Vector3(x, z, -y);
    const scene = new THREE.Scene();
    ${lines}
    window.radiance = (size, position, target, fov, places) => {
      const renderer = new THREE.WebGLRenderer();
      const camera = new THREE.PerspectiveCamera(fov, 1, 0.1, 100);
      camera.position.copy(turned(position));
      camera.lookAt(turned(target));
      const picture = new THREE.WebGLRenderTarget(size, size, { type: THREE.FloatType });
      renderer.setRenderTarget(picture);
      renderer.render(scene, camera);
      const pixels = new Float32Array(4 * size * size);
      renderer.readRenderTargetPixels(picture, 0, 0, size, size, pixels);
      return places.map(([column, row]) => {
        const start = 4 * ((size - 1 - row) * size + column);
        return [...pixels.subarray(start, start + 3)];
      });
    };
    window.isLoaded = () => scene.getObjectByProperty("isMesh", true) !== undefined;`;
}

/**
 * The radiance at places, column and row, of a picture of `size` pixels from a position to a target. `lines` show
 * `block.glb`, whose content is `glb`.
 */
export async function radiance(page, lines, glb, [size, position, target, fov, places]) {
  const { outputFiles } = await esbuild.build({
    stdin: { contents: program(lines), resolveDir: HERE }, bundle: true, format: "iife", write: false,
  });
  await page.route("**/*", (route) => {
    const files = { "/block.glb": glb, "/": "<!doctype html><script src=program.js></script>" };
    const { pathname } = new URL(route.request().url());
    return route.fulfill({ body: files[pathname] ?? outputFiles[0].text });
  });
  await page.goto("http://snow.test/");
  await page.waitForFunction(() => window.isLoaded());
  const found = await page.evaluate((view) => window.radiance(...view), [size, position, target, fov, places]);
  await page.unroute("**/*");
  return found;
}
