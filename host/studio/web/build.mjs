// SPDX-License-Identifier: Apache-2.0
// Builds the page into a folder: node build.mjs FOLDER. It checks the types, bundles, compresses, gathers the licences of
// what was bundled, and lists all files with their hashes in page.json. The same packages give the same bytes.
import { execFileSync } from "node:child_process";
import { createHash } from "node:crypto";
import { existsSync, mkdirSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";
import { build } from "esbuild";
import { zipSync } from "fflate";

const here = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2];
if (!out) throw new Error("usage: node build.mjs FOLDER");
const mostBytes = 300_000; // of all that is compressed

execFileSync(process.execPath, [join(here, "node_modules/typescript/bin/tsc"), "-p", here], { stdio: "inherit" });
rmSync(out, { recursive: true, force: true });
mkdirSync(out, { recursive: true });
const built = await build({
  absWorkingDir: here,
  entryPoints: { boot: "src/boot.ts", style: "src/style.css" },
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
});
writeFileSync(join(out, "index.html"), readFileSync(join(here, "src/index.html")));

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

const types = { html: "text/html; charset=utf-8", js: "text/javascript; charset=utf-8", css: "text/css; charset=utf-8", json: "application/json", svg: "image/svg+xml", haptogram: "application/zip" };
const files = [];
let total = 0;
for (const name of readdirSync(out).sort()) {
  const bytes = readFileSync(join(out, name));
  const packed = gzipSync(bytes, { level: 9 });
  writeFileSync(join(out, `${name}.gz`), packed);
  total += packed.length;
  files.push({ name, type: types[name.split(".").at(-1)], sha256: createHash("sha256").update(bytes).digest("hex"), gzip: true });
}
if (total > mostBytes) throw new Error(`the page has ${total} bytes, compressed; ${mostBytes} is the limit`);
if (!existsSync(join(out, "boot.js"))) throw new Error("boot.js was not made");
writeFileSync(join(out, "page.json"), JSON.stringify({ files }, null, 1) + "\n");
console.log(`studio: page of ${files.length} files, ${total} bytes compressed`);
