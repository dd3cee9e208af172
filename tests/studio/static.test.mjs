// SPDX-License-Identifier: Apache-2.0
// The page of `make site`, which no program serves: its images are the command line's, it is quick and small, and says what it leaves out.
import assert from "node:assert/strict";
import { existsSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { gzipSync } from "node:zlib";
import { accessible, drop, folder, lookedAt, openDesign, openPage, panel, picture, run, settled, shapes, show, slices, startBrowser, takeAway } from "./support.mjs";
import { randomDesign, randomOf } from "./designs.mjs";
import { host, site, skip } from "./site.mjs";

async function openSite(t, options) {
  const page = await openPage(t, await startBrowser(t), await host(t), options);
  await settled(page);
  return page;
}

test("image and manifest from the static page are the command line's, of the gallery and of random designs", { skip }, async (t) => {
  const page = await openSite(t);
  const where = await folder(t);
  const compiled = async (file) => {
    await run("compile", file, "-o", join(where, "image.hex"));
    return ["image.hex", "image.json"].map((name) => readFileSync(join(where, name), "utf8"));
  };
  const gallery = JSON.parse(readFileSync(join(site, "gallery.json"), "utf8"));
  assert.ok(gallery.length >= 12);
  for (const { file, title } of gallery) {
    await openDesign(page, title);
    await page.locator("footer", { hasText: `${title}: ` }).waitFor();
    await settled(page);
    const [hex, manifest] = [String(await takeAway(page, "Image (.hex)")), String(await takeAway(page, "Manifest (.json)"))];
    const bundle = join(where, `${file}.haptogram`);
    writeFileSync(bundle, await takeAway(page, "Bundle (.haptogram)"));
    const [image, meaning] = await compiled(bundle);
    assert.equal(hex, image, title);
    alike(JSON.parse(manifest), JSON.parse(meaning), title);
  }
  const seed = Number(process.env.HAPTOGRAM_SEED ?? Math.floor(1e9 * Math.random()));
  t.diagnostic(`HAPTOGRAM_SEED=${seed}`);
  const random = randomOf(seed);
  const made = await page.evaluate(imagesOf, Array.from({ length: 50 }, () => randomDesign(random)));
  for (const { text, image } of made) {
    const project = join(where, "project.toml");
    writeFileSync(project, text);
    assert.equal(image, (await compiled(project))[0], text);
  }
});

/** In the page: each design as a project file and its image, by an engine of its own. */
async function imagesOf(designs) {
  const worker = new Worker("worker.js", { type: "module" });
  const next = (isIt) => new Promise((done) => worker.addEventListener("message", function take({ data }) {
    if (!isIt(data)) return;
    worker.removeEventListener("message", take);
    done(data);
  }));
  const ask = async (message, isIt) => {
    const answer = next(isIt);
    worker.postMessage(message);
    return await answer;
  };
  const get = async (method, target, body = "") => new TextDecoder().decode((await ask({ request: 1, method, target, body: new TextEncoder().encode(body).buffer }, (told) => told.request === 1)).body);
  await next((told) => told.ready);
  const made = [];
  for (const document of designs) {
    const { scene, error } = JSON.parse((await ask({ message: JSON.stringify({ t: "scene", n: 1, document }) }, (told) => told.text)).text);
    const { text } = JSON.parse(await get("POST", "/api/project", JSON.stringify(document)));
    made.push({ text, image: scene ? await get("GET", `/api/take?scene=${scene.name}&as=hex`) : error.message });
  }
  worker.terminate();
  return made;
}

/** The same but for the last digits: sines are those of another C library, and a hash of what they give is another. */
function alike(found, expected, where) {
  if (typeof expected === "number") return assert.ok(Math.abs(found - expected) <= 1e-12 * Math.max(1, Math.abs(expected)), `${where}: ${found} instead of ${expected}`);
  if (typeof expected !== "object" || expected === null) return where.endsWith(".inputs_sha256") || assert.equal(found, expected, where);
  assert.deepEqual(Object.keys(found), Object.keys(expected), where);
  for (const [key, value] of Object.entries(expected)) alike(found[key], value, `${where}.${key}`);
}

test("a static page is there soon, is small, and computes quickly", { skip }, async (t) => {
  const browser = await startBrowser(t);
  const page = await openPage(t, browser, await host(t));
  await page.waitForFunction(() => performance.getEntriesByName("first slice").length > 0);
  const firstMs = await page.evaluate(() => performance.getEntriesByName("first slice")[0].startTime);
  const loaded = await page.evaluate(() => ["", ...performance.getEntriesByType("resource").map(({ name }) => new URL(name).pathname.slice(1))]);
  // A Worker's own imports are not in the page's list.
  const files = new Set([...loaded.map((name) => name || "index.html"), "studio_engine.js", "studio_engine.wasm"]);
  const bytes = [...files].filter((name) => existsSync(join(site, name))).reduce((sum, name) => sum + gzipSync(readFileSync(join(site, name)), { level: 9 }).length, 0);
  await settled(page);
  await lookedAt(page);
  // The engine alone, in a Worker of its own.
  const took = await page.evaluate(async () => {
    const worker = new Worker("worker.js", { type: "module" });
    const next = (isIt) => new Promise((done) => worker.addEventListener("message", function take({ data }) {
      if (!isIt(data)) return;
      worker.removeEventListener("message", take);
      done(data);
    }));
    await next((told) => told.ready);
    const document = { format: "haptogram-project-1", rate_hz: 5, points: 200, place: { size_mm: 80, center_mm: [0, 0, 150] }, shape: [{ kind: "sphere" }] };
    const ask = async (message, isIt) => {
      const begun = performance.now();
      const answer = next(isIt);
      worker.postMessage({ message: JSON.stringify(message) });
      return { answer: await answer, ms: performance.now() - begun };
    };
    const isScene = (told) => told.text && JSON.parse(told.text).t === "scene";
    const compile = [], one = [], sequence = [];
    let scene = "";
    for (let i = 0; i < 20; i++) {
      document.place.center_mm[0] = i / 2; // another document each time, so that none is known already
      const drawn = next((told) => told.bulk);
      const { answer, ms } = await ask({ t: "scene", n: i, document }, isScene);
      scene = JSON.parse(answer.text).scene.name;
      compile.push(ms);
      await drawn; // the next is not to wait for this one's drawing
    }
    const slice = async (record, points) => {
      const { answer } = await ask({ t: "slice", n: 100, scene, origin: [-80, -80, 150], u: [160, 0, 0], v: [0, 160, 0], width: points, height: points, record, view: 0 }, (told) => told.bulk && new DataView(told.bulk).getUint32(8, true) === points);
      return new DataView(answer.bulk).getFloat32(28, true);
    };
    for (let i = 0; i < 8; i++) one.push(await slice(1, 200));
    for (let i = 0; i < 3; i++) sequence.push(await slice(0, 50), await slice(0, 200));
    const begun = performance.now();
    await ask({ t: "analyze", n: 200, scene }, (told) => told.text && JSON.parse(told.text).t === "analysis");
    const analysis = performance.now() - begun;
    worker.terminate();
    return { compile: Math.min(...compile), one: Math.min(...one), coarse: Math.min(...sequence.filter((_, i) => i % 2 === 0)), whole: Math.min(...sequence.filter((_, i) => i % 2 === 1)), analysis };
  });
  t.diagnostic(`first picture ${firstMs.toFixed(0)} ms, ${bytes} bytes compressed; compile of 200 points ${took.compile.toFixed(1)} ms, field 200 × 200 ${took.one.toFixed(2)} ms; of 200 records 50 × 50 ${took.coarse.toFixed(1)} ms, 200 × 200 ${took.whole.toFixed(0)} ms; analysis ${took.analysis.toFixed(0)} ms`);
  assert.ok(bytes <= 1_000_000, `${bytes} bytes`);
  assert.ok(firstMs <= 2000, `first picture after ${firstMs} ms`);
  assert.ok(took.compile <= 60, `compiled in ${took.compile} ms`);
  assert.ok(took.one <= 5, `a field in ${took.one} ms`);
  assert.ok(took.coarse <= 250, `a field of a sequence, as while dragging, in ${took.coarse} ms`);
});

test("all that a static page shows is accessible, and it says what it leaves out", { skip }, async (t) => {
  const page = await openSite(t, { firstVisit: true });
  await lookedAt(page);
  for (const step of ["Make", "See", "Play"]) {
    await show(page, step);
    assert.ok((await accessible(page)) > 10);
    await picture(page, `static-${step}`);
  }
  // A browser in which pages use serial ports: a board can be chosen.
  assert.match(await page.locator("header").innerText(), /No board\. Play asks for one/);
  assert.ok(await page.locator("button.play").isEnabled());
  assert.ok(await page.locator("#stop").isVisible());
  for (const title of ["Board", "Pins"]) assert.match(await panel(page, title).innerText(), /haptogram studio NAME\.haptogram/);
  assert.match(await panel(page, "Take away").innerText(), /bitstreams by the program/);
  assert.equal(await page.getByRole("button", { name: "Field (.png)" }).count(), 0);
  assert.match(await panel(page, "Take away").innerText(), /Pictures \(\.png\) of the field are drawn by the program/);
  await page.locator("section", { hasText: /Studies are run, and what a hand scatters of the sound is computed, by the program/ }).waitFor();
});

test("a static page is accessible with a hand, with findings and when something fails", { skip }, async (t) => {
  const page = await openSite(t);
  await page.getByLabel("Passes a second", { exact: true }).fill("50");
  await page.keyboard.press("Enter");
  await settled(page);
  await page.locator(".findings li").first().waitFor();
  assert.ok((await accessible(page)) > 10);
  await page.getByLabel("Focal points", { exact: true }).fill("60000");
  await page.keyboard.press("Enter");
  await page.locator(".failed").waitFor();
  assert.ok((await accessible(page)) > 10);
  await openDesign(page, "Touched ball");
  await page.locator("footer", { hasText: "Touched ball: " }).waitFor();
  await settled(page);
  assert.ok((await accessible(page)) > 10);
});

test("a static page in a browser without serial ports says where boards are reached", { skip }, async (t) => {
  const before = (page) => page.addInitScript(() => delete Navigator.prototype.serial);
  const page = await openSite(t, { before });
  await show(page, "Play");
  assert.ok((await accessible(page)) > 10);
  await picture(page, "static-without-serial");
  assert.match(await page.locator("header").innerText(), /No boards in this browser/);
  assert.ok(await page.locator("button.play").isDisabled());
  assert.ok(!(await page.locator("#stop").isVisible()));
  assert.match(await panel(page, "Board").innerText(), /Chrome, Edge and Chromium/);
});

test("a static page sees, authors and takes away as with the program", { skip }, async (t) => {
  const page = await openSite(t);
  const where = await folder(t);
  // A file that is dropped, its findings, its field.
  await drop(page, [{ name: "trimesh.obj", bytes: readFileSync(join(shapes, "trimesh.obj")) }]);
  await page.locator(".file", { hasText: "trimesh.obj" }).waitFor();
  await settled(page);
  await lookedAt(page);
  writeFileSync(join(where, "dropped.haptogram"), await takeAway(page, "Bundle (.haptogram)"));
  await run("compile", join(where, "dropped.haptogram"), "-o", join(where, "dropped.hex"));
  assert.equal(String(await takeAway(page, "Image (.hex)")), readFileSync(join(where, "dropped.hex"), "utf8"));
  const found = await run("analyze", join(where, "dropped.hex"), "--json");
  assert.ok(found.length > 0);
  await page.getByLabel("Step", { exact: true }).fill("4");
  await page.keyboard.press("Enter");
  const field = String(await takeAway(page, "Field (.csv)")).trim().split("\n");
  const asked = (await page.locator("pre.command").innerText()).split("\n").find((line) => line.startsWith("haptogram field"));
  const args = asked.split(" ").slice(2).map((word) => word.replaceAll("'", "")).map((word) => (word.endsWith(".hex") ? join(where, "dropped.hex") : word));
  const output = join(where, "field.csv");
  args[args.findIndex((word) => word === "-o" || word === "--output") + 1] = output;
  await run("field", ...args);
  const expected = readFileSync(output, "utf8").trim().split("\n");
  assert.equal(field.length, expected.length);
  assert.equal(field[0], expected[0]);
  const values = (lines) => lines.slice(1).map((line) => Number(line.split(",").at(-1)));
  const [ours, theirs] = [values(field), values(expected)];
  const greatest = Math.max(...theirs);
  assert.ok(ours.every((value, i) => Math.abs(value - theirs[i]) < 1e-4 * greatest), "the field is the command line's");
  const report = String(await takeAway(page, "Report (.html)"));
  assert.match(report, /<h2>Foci<\/h2>/);
  // Analyses that a newer design overtakes hold nothing up, and the newest is what is shown.
  const force = page.locator("#feel");
  const strong = await force.innerText();
  for (const amplitude of [90, 80, 70, 60]) {
    await page.getByLabel("Amplitude", { exact: true }).fill(String(amplitude));
    await page.keyboard.press("Enter");
    await settled(page);
  }
  await lookedAt(page);
  assert.notEqual(await force.innerText(), strong);
  // A design is kept across a reload, and a hand is rendered.
  await page.getByLabel("Amplitude", { exact: true }).fill("55");
  await page.keyboard.press("Enter");
  await settled(page);
  await page.locator("summary", { hasText: "kept in this browser" }).waitFor();
  await page.reload();
  await settled(page);
  assert.equal(await page.getByLabel("Amplitude", { exact: true }).inputValue(), "55");
  await openDesign(page, "Touched ball");
  await page.locator("footer", { hasText: "Touched ball: " }).waitFor();
  await settled(page);
  const path = await takeAway(page, "Path of this frame");
  const command = (await page.getByLabel("Commands that make these paths").innerText()).split("\n")[0];
  await run(...command.split(" ").slice(1, -1), join(where, "path.json"));
  alike(JSON.parse(String(path)), JSON.parse(readFileSync(join(where, "path.json"), "utf8")), "path");
  const before = await slices(page);
  await page.getByLabel("Middle z").fill("140");
  await page.keyboard.press("Enter");
  await page.waitForFunction((shown) => Number(document.getElementById("app").dataset.slices) > shown, before);
  // What makes no sense is said as the program says it.
  await drop(page, [{ name: "wrong.obj", bytes: Buffer.from("v 1 2\n") }]);
  await page.locator(".failed", { hasText: "wrong.obj" }).waitFor();
});
