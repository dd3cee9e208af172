// SPDX-License-Identifier: Apache-2.0
// three without what this page's view never draws: headsets, shadows, environments, and the shaders of other materials. It takes three's
// sources in place of its one built file, so that parts can be left out. A part that three no longer has is an error.
import { readFileSync } from "node:fs";
import { basename, join } from "node:path";
import { fileURLToPath } from "node:url";

/** Materials that the view has; a line's is that of a mesh. */
const materials = ["meshbasic", "meshlambert", "points", "sprite"];
/** Pieces of their shaders; the others are for shadows, bones, fog and the like. */
const pieces = `beginnormal_vertex begin_vertex color_pars_vertex color_vertex color_pars_fragment color_fragment colorspace_pars_fragment
  colorspace_fragment common defaultnormal_vertex lights_fragment_begin lights_fragment_end lights_lambert_fragment lights_lambert_pars_fragment
  lights_pars_begin map_fragment map_pars_fragment normal_fragment_begin normal_pars_fragment normal_pars_vertex normal_vertex opaque_fragment premultiplied_alpha_fragment
  project_vertex specularmap_fragment uv_pars_fragment uv_pars_vertex uv_vertex`.split(/\s+/);
/** What stands in place of modules that the renderer calls and that do nothing here. */
const idle = {
  "renderers/webxr/WebXRManager": `export function WebXRManager() {
    Object.assign(this, { enabled: false, isPresenting: false, addEventListener() {}, removeEventListener() {}, setAnimationLoop() {}, dispose() {}, getEnvironmentBlendMode() {} });
  }`,
  "renderers/webgl/WebGLEnvironments": "export function WebGLEnvironments() { return { get: () => null, dispose() {} }; }",
  "renderers/webgl/WebGLShadowMap": "export function WebGLShadowMap() { this.render = () => {}; }",
  "renderers/webgl/WebGLMorphtargets": "export function WebGLMorphtargets() { return { update() {} }; }",
  "renderers/webgl/WebGLUniformsGroups": "export function WebGLUniformsGroups() { return { dispose() {} }; }",
  "renderers/webgl/WebGLOutput": "export function WebGLOutput() {}",
  "renderers/shaders/DFGLUTData": "export function getDFGLUT() {}",
};

export const leanThree = {
  name: "lean three",
  setup(build) {
    const source = fileURLToPath(new URL("node_modules/three/src/", import.meta.url));
    const expected = new Set([...materials.map((name) => `ShaderLib/${name}`), ...pieces.map((name) => `ShaderChunk/${name}`), ...Object.keys(idle)]);
    build.onResolve({ filter: /^three$/ }, () => ({ path: join(source, "Three.js"), sideEffects: false }));
    build.onLoad({ filter: /three\/src\/.*\.js$/ }, ({ path }) => {
      const name = path.slice(source.length).replace(/\.js$/, "");
      const part = name.replace("renderers/shaders/", "").replace(".glsl", "");
      const text = readFileSync(path, "utf8");
      const kept = expected.delete(part) || expected.delete(name);
      if (idle[name]) return { contents: idle[name] };
      if (kept || !/^Shader(Lib|Chunk)\//.test(part)) return { contents: text };
      return { contents: text.replaceAll(/`[^`]*`/g, "``") };
    });
    build.onEnd(() => {
      if (expected.size > 0) throw new Error(`lean_three.mjs: three has no ${[...expected].map((name) => basename(name)).join(", ")} any more`);
    });
  },
};
