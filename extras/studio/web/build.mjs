// SPDX-License-Identifier: Apache-2.0
// Builds the page into a folder: node build.mjs FOLDER. With a second folder, which has the engine that ../wasm became, the page needs no
// program: any web host serves it, and it computes by itself. It checks the types, bundles, compresses, gathers the licences of
// what was bundled, and lists all files with their hashes in page.json. The same packages give the same bytes.
import { execFileSync } from "node:child_process";
import { createHash } from "node:crypto";
import { existsSync, mkdirSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";
import { build, transformSync } from "esbuild";
import { zipSync } from "fflate";
import { leanThree } from "./lean_three.mjs";

const here = dirname(fileURLToPath(import.meta.url));
const [out, engine] = process.argv.slice(2).map((folder) => resolve(folder));
if (!out) throw new Error("usage: node build.mjs FOLDER [FOLDER_OF_THE_ENGINE]");
const mostBytes = engine ? 1_000_000 : 300_000; // of all that is compressed, but for the licences

execFileSync(process.execPath, [join(here, "node_modules/typescript/bin/tsc"), "-p", here], { stdio: "inherit" });
rmSync(out, { recursive: true, force: true });
mkdirSync(out, { recursive: true });
const built = await build({
  absWorkingDir: here,
  entryPoints: { boot: "src/boot.ts", style: "src/style.css", ...(engine ? { worker: "src/worker.ts", board_worker: "src/board_worker.ts" } : {}) },
  external: ["./studio_engine.js"],
  outdir: out,
  bundle: true,
  splitting: true,
  format: "esm",
  target: "es2022",
  minify: true,
  jsx: "automatic",
  jsxImportSource: "preact",
  legalComments: "none", // notices.html has the whole texts
  chunkNames: "[name]-[hash]",
  metafile: true,
  plugins: [leanThree],
});

/** A static page says by itself what a server says of one in its headers: it runs and loads its own files alone. */
const policy = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; worker-src 'self'; base-uri 'none'; form-action 'none'";
function index() {
  const text = readFileSync(join(here, "src/index.html"), "utf8");
  if (!engine) return text;
  const page = text.replace('<html lang="en">', '<html lang="en" data-engine="in-page">').replace('<meta charset="utf-8" />', `$&\n    <meta http-equiv="Content-Security-Policy" content="${policy}" />`);
  if (page.length < text.length + policy.length) throw new Error("src/index.html: expected <html lang=\"en\"> and <meta charset=\"utf-8\" />");
  return page;
}
writeFileSync(join(out, "index.html"), index());
if (engine) {
  writeFileSync(join(out, "studio_engine.js"), transformSync(readFileSync(join(engine, "studio_engine.js"), "utf8"), { minify: true, format: "esm" }).code);
  writeFileSync(join(out, "studio_engine.wasm"), readFileSync(join(engine, "studio_engine.wasm")));
}

/** The packages whose code is in the bundle, and their licence texts. */
function notices() {
  const packages = new Set();
  for (const output of Object.values(built.metafile.outputs))
    for (const [file, { bytesInOutput }] of Object.entries(output.inputs)) {
      const found = file.match(/node_modules\/((?:@[^/]+\/)?[^/]+)/);
      if (found && bytesInOutput > 0) packages.add(found[1]);
    }
  const escape = (text) => text.replace(/&/g, "&amp;").replace(/</g, "&lt;");
  const parts = [...packages].sort().map((name) => {
    const folder = join(here, "node_modules", name);
    const { version, license } = JSON.parse(readFileSync(join(folder, "package.json"), "utf8"));
    const texts = readdirSync(folder).filter((file) => /^(licen[cs]e|copying|notice)/i.test(file)).sort();
    if (texts.length === 0) throw new Error(`${name} ${version} has no licence file; see what it says and add it by hand`);
    const text = texts.map((file) => readFileSync(join(folder, file), "utf8").trim()).join("\n\n");
    return `<h2>${escape(name)} ${escape(version)}, ${escape(license)}</h2>\n<pre>${escape(text)}</pre>`;
  });
  // What the engine is made of, as Debian tells it.
  const libraries = engine ? ["emscripten", "libboost-dev", "libeigen3-dev", "libfmt-dev", "libhwy-dev", "libnanoflann-dev", "libtomlplusplus-dev", "nlohmann-json3-dev"] : [];
  for (const name of libraries) parts.push(`<h2>Debian's ${name}</h2>\n<pre>${escape(readFileSync(`/usr/share/doc/${name}/copyright`, "utf8").trim())}</pre>`);
  return `<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>Haptogram studio: licences</title><link rel="stylesheet" href="style.css"></head>
<body class="text"><h1>Licences</h1><p>Haptogram is under Apache-2.0. Its page contains these packages.</p>
${parts.join("\n")}
</body></html>
`;
}
writeFileSync(join(out, "notices.html"), notices());

/** The designs of ../gallery as bundles, with their pictures and a list: the second line of each project is "# Title: about". */
function gallery() {
  const folder = join(here, "../gallery");
  const list = readdirSync(folder).filter((name) => existsSync(join(folder, name, "project.toml"))).sort().map((file) => {
    const files = readdirSync(join(folder, file)).filter((name) => !name.endsWith(".svg")).sort();
    const all = Object.fromEntries(files.map((name) => [name, readFileSync(join(folder, file, name))]));
    const [, title, about] = String(all["project.toml"]).match(/^# [^\n]*\n# ([^:\n]+): ([^\n]+)\n/) ?? [];
    if (!title) throw new Error(`gallery/${file}/project.toml: expected a second line “# Title: what it is”`);
    writeFileSync(join(out, `${file}.haptogram`), zipSync(all, { mtime: "1980-01-01T00:00:00" }));
    writeFileSync(join(out, `${file}.svg`), readFileSync(join(folder, file, "picture.svg")));
    return { file, title, about };
  });
  writeFileSync(join(out, "gallery.json"), JSON.stringify(list));
}
gallery();

const types = { html: "text/html; charset=utf-8", js: "text/javascript; charset=utf-8", css: "text/css; charset=utf-8", json: "application/json", svg: "image/svg+xml", haptogram: "application/zip", wasm: "application/wasm" };
const files = [];
let total = 0;
for (const name of readdirSync(out).sort()) {
  const bytes = readFileSync(join(out, name));
  const packed = gzipSync(bytes, { level: 9 });
  if (!engine) { // web hosts pack by themselves
    writeFileSync(join(out, `${name}.gz`), packed);
    rmSync(join(out, name)); // the program unpacks it
  }
  if (name !== "notices.html") total += packed.length; // which is loaded when it is asked for
  files.push({ name, type: types[name.split(".").at(-1)], sha256: createHash("sha256").update(bytes).digest("hex"), bytes: bytes.length });
}
if (total > mostBytes) throw new Error(`the page has ${total} bytes, compressed; ${mostBytes} is the limit`);
if (!files.some(({ name }) => name === "boot.js")) throw new Error("boot.js was not made");
if (!engine) writeFileSync(join(out, "page.json"), JSON.stringify({ files }, null, 1) + "\n");
console.log(`studio: page of ${files.length} files, ${total} bytes compressed`);
