// SPDX-License-Identifier: Apache-2.0
// The page as one designs with it: the view first at every size, work that is never lost, bundles, what it will feel like, and Play.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { accessible, boardSays, drop, eventually, folder, hasValue, lookedAt, keptPicture, openDesign, openPage, picture, run, settled, shapes, show, startBrowser, startStudio, takeAway } from "./support.mjs";

const field = (page, label) => page.getByLabel(label, { exact: true });
async function fill(page, label, value) {
  await field(page, label).fill(String(value));
  await field(page, label).press("Enter");
}
const shapeOf = async (page) => String(await takeAway(page, "Project"));

/** The bundle that the page saves, as a file. */
async function saveBundle(page, file) {
  const waiting = page.waitForEvent("download");
  await page.keyboard.press("Control+s");
  const download = await waiting;
  writeFileSync(file, readFileSync(await download.path()));
  return download.suggestedFilename();
}
const namesIn = (bundle) => execFileSync("python3", ["-c", "import sys, zipfile; print('\\n'.join(sorted(zipfile.ZipFile(sys.argv[1]).namelist())))", bundle]).toString().trim().split("\n");

for (const [width, height, theme, least] of [[1280, 800, "light", 0.4], [800, 600, "dark", 0.4], [1920, 1080, "contrast", 0.4], [390, 844, "light", 0.25]])
  test(`the view comes first, ${width} × ${height}, ${theme}`, async (t) => {
    const studio = await startStudio(t);
    const page = await openPage(t, await startBrowser(t), studio);
    await page.setViewportSize({ width, height });
    await page.evaluate((theme) => localStorage.setItem("theme", theme), theme);
    await page.reload();
    await page.locator("#view[aria-busy=false]").waitFor();
    await lookedAt(page);
    const inside = async (selector) => {
      const box = await page.locator(selector).boundingBox();
      assert.ok(box && box.x >= 0 && box.y >= 0 && box.x + box.width <= width && box.y + box.height <= height, `${selector} at ${JSON.stringify(box)}`);
      return box;
    };
    const oneLine = async () => assert.ok((await page.locator("#board").boundingBox()).height < 24, "what the board does is one line");
    await oneLine();
    for (const step of ["Make", "See", "Play"]) {
      await page.locator(`[data-step=${step}]`).click();
      const box = await inside("#view");
      const part = (box.width * box.height) / (width * height);
      t.diagnostic(`${step}: the view has ${(100 * part).toFixed(0)} % of ${width} × ${height}`);
      assert.ok(part >= least && box.y < 60);
      for (const always of ["#stop", "button.play", "[data-verdict-of-feel]", `[data-step=${step}]`, "#board", "footer"]) await inside(always);
      assert.match(await page.locator("footer span").first().innerText(), /^example: 200 focal points/);
      assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= width, "nothing stands out at the side");
      await page.evaluate(() => document.querySelectorAll("details.more").forEach((each) => (each.open = true)));
      const cut = await page.evaluate(() =>
        [...document.querySelectorAll("select")].filter((each) => {
          if (!each.checkVisibility()) return false;
          const now = each.offsetWidth;
          each.style.maxWidth = "none";
          each.style.flex = "none";
          const whole = each.offsetWidth;
          each.style.maxWidth = each.style.flex = "";
          return whole > now + 1;
        }).map((each) => each.labels[0]?.textContent),
      );
      assert.deepEqual(cut, [], "no word of a select is cut");
      const lane = (await page.locator(".lane").count()) > 0 && (await page.locator(".lane").boundingBox());
      if (lane) assert.ok((await page.locator(".scrubber").getByRole("button", { name: "Run" }).boundingBox()).y > lane.y + lane.height + 3, "the lane and the button do not touch");
      const short = await page.evaluate(() => [...document.querySelectorAll(".box > input")].filter((each) => each.checkVisibility() && each.scrollWidth > each.clientWidth).map((each) => each.value));
      assert.deepEqual(short, [], "no number is cut");
      await accessible(page);
      await keptPicture(page, `design-${step}-${width}-${theme}`);
    }
    await page.locator("button.play").click();
    await boardSays(page, "Virtual board, outputs ON");
    await inside("#board");
    await oneLine();
    await page.locator("#stop").click();
    await boardSays(page, "outputs off");
  });

test("panels fold, are widened by keys, and stay so", async (t) => {
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t), studio);
  await settled(page);
  const width = async () => (await page.locator("#view").boundingBox()).width;
  const first = await width();
  await page.getByRole("separator", { name: "Width of the panel at the left" }).press("ArrowLeft");
  await eventually(async () => (await width()) === first + 16);
  await page.reload();
  await settled(page);
  assert.equal(await width(), first + 16);
  for (const side of ["left", "right"]) {
    const before = await width();
    await page.getByRole("button", { name: `Panel at the ${side}` }).click();
    await eventually(async () => (await width()) > before + 100);
  }
  await accessible(page);
  // The steps are tabs: arrows go from one to the next.
  await page.locator("[data-step=Make]").press("ArrowRight");
  await page.locator("[data-step=See][aria-selected=true]").waitFor();
});

test("a first visit has hints, which go and stay away", async (t) => {
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t), studio, { firstVisit: true });
  await settled(page);
  assert.equal(await page.locator(".hints p").count(), 3);
  // What a first visitor sees is felt.
  await page.locator("footer", { hasText: "Dome: " }).waitFor();
  await lookedAt(page);
  assert.match(await page.locator("#feel").innerText(), /By models: felt:/);
  await accessible(page);
  await picture(page, "first-visit");
  await page.setViewportSize({ width: 1000, height: 700 });
  await page.reload();
  await settled(page);
  for (let i = 0; i < 3; i++) assert.ok(await page.locator(".hints p").nth(i).isVisible(), "a narrow window has all three, too");
  await page.getByRole("button", { name: "Got it" }).click();
  await page.reload();
  await settled(page);
  assert.equal(await page.locator(".hints").count(), 0);
  // The theme is the system's, until another is chosen.
  const theme = () => page.evaluate(() => document.documentElement.dataset.theme);
  await page.emulateMedia({ contrast: "more" });
  await eventually(async () => (await theme()) === "contrast");
  await page.emulateMedia({ contrast: "no-preference", colorScheme: "dark" });
  await eventually(async () => (await theme()) === "dark");
  await page.getByRole("button", { name: "Theme" }).click();
  assert.equal(await theme(), "contrast");
});

test("numbers are taken with units and sums, and refused with words", async (t) => {
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t), studio);
  await settled(page);
  await fill(page, "Centre z", "15 cm");
  await hasValue(field(page, "Centre z"), "150");
  await fill(page, "Centre z", "150-12.5");
  await hasValue(field(page, "Centre z"), "137.5");
  for (const [label, wrong] of [["Focal points", "0"], ["Focal points", "2.5"], ["Passes a second", "0"], ["Passes in all", "0"], ["Centre x", "12 kg"], ["Size", "0"]]) {
    await fill(page, label, wrong);
    await page.locator(".wrong-value", { hasText: `${label}: “${wrong}” is no` }).waitFor();
    await accessible(page);
    await fill(page, label, { "Focal points": "200", "Passes a second": "7", "Centre x": "0" }[label] ?? "");
    await page.locator(".wrong-value").waitFor({ state: "detached" });
  }
  await settled(page);
  assert.doesNotMatch(await shapeOf(page), /points|loops|size_mm/, "what was refused is in no file");
});

test("a bundle from the page is what the command line takes, and the page opens it again", async (t) => {
  const studio = await startStudio(t);
  const browser = await startBrowser(t);
  const page = await openPage(t, browser, studio);
  const where = await folder(t);
  await settled(page);
  await drop(page, [{ name: "trimesh.obj", bytes: readFileSync(join(shapes, "trimesh.obj")) }]);
  await page.locator(".file", { hasText: "trimesh.obj" }).waitFor();
  await field(page, "Upwards in the file").selectOption("y");
  await fill(page, "Focal points", 20);
  await settled(page);
  await page.locator(".menu summary").click();
  await fill(page, "Name", "heap");
  await page.locator("footer", { hasText: "heap: 20 focal points" }).waitFor();
  await page.locator(".menu summary").click();
  await accessible(page);
  assert.equal(await saveBundle(page, join(where, "heap.haptogram")), "heap.haptogram");
  assert.deepEqual(namesIn(join(where, "heap.haptogram")), ["project.toml", "trimesh.obj"]);
  const image = String(await takeAway(page, "Image"));
  await run("compile", join(where, "heap.haptogram"), "-o", join(where, "heap.hex"));
  assert.equal(image, readFileSync(join(where, "heap.hex"), "utf8"));

  // In another browser, which knows nothing of it; by a drop, and by the command line.
  for (const way of ["drop", "start"]) {
    const other = await openPage(t, await startBrowser(t), await startStudio(t, ...(way === "start" ? [join(where, "heap.haptogram")] : [])));
    await settled(other);
    if (way === "drop") await drop(other, [{ name: "heap.haptogram", bytes: readFileSync(join(where, "heap.haptogram")) }]);
    await other.locator("footer", { hasText: "heap: 20 focal points" }).waitFor();
    await hasValue(field(other, "Upwards in the file"), "y");
    await settled(other);
    assert.equal(String(await takeAway(other, "Image")), image);
    assert.equal(await saveBundle(other, join(where, "again.haptogram")), "heap.haptogram");
    assert.deepEqual(readFileSync(join(where, "again.haptogram")), readFileSync(join(where, "heap.haptogram")), "the same bytes");
  }
});

/** A sound of 16 bits, one channel: half a period of 20 Hz. */
function wav() {
  const samples = Array.from({ length: 200 }, (_, i) => Math.round(20_000 * Math.sin((Math.PI * i) / 200)));
  const bytes = Buffer.alloc(44 + 2 * samples.length);
  bytes.write("RIFF", 0);
  bytes.writeUInt32LE(bytes.length - 8, 4);
  bytes.write("WAVEfmt ", 8);
  bytes.writeUInt32LE(16, 16);
  bytes.writeUInt16LE(1, 20);
  bytes.writeUInt16LE(1, 22);
  bytes.writeUInt32LE(8000, 24);
  bytes.writeUInt32LE(16_000, 28);
  bytes.writeUInt16LE(2, 32);
  bytes.writeUInt16LE(16, 34);
  bytes.write("data", 36);
  bytes.writeUInt32LE(2 * samples.length, 40);
  samples.forEach((value, i) => bytes.writeInt16LE(value, 44 + 2 * i));
  return bytes;
}

test("a dropped file becomes what is in it: a path, a sound, a curve, a hand, a calibration with its array", async (t) => {
  const where = await folder(t);
  writeFileSync(join(where, "four.toml"), 'format = "haptogram-project-1"\npoints = 4\n[[shape]]\nkind = "circle"\n');
  const page = await openPage(t, await startBrowser(t), await startStudio(t, join(where, "four.toml")), { allowed: /status of 422/ });
  await settled(page);
  const files = {
    "way.csv": "\ufeff# by hand\nx_mm,y_mm,z_mm,time_s\n0,0,130,0\n10,0,130,0.1\n0,0,130,0.2\n",
    "beat.wav": wav(),
    "curve.csv": "time_ms,amplitude\n0,0\n5,1\n10,0\n",
    "my.toml": 'name = "mine"\n[array]\nrows = 2\ncolumns = 2\npitch_mm = 10.5\ncarrier_hz = 40000\nduty = 0.5\n[transducer]\nradius_mm = 4.5\nsource_pa_m = 4\n',
    "cal.toml": `format = "haptogram-calibration-1"\narray = "my.toml"\n${"\n[[element]]\ngain = 1.0\n".repeat(4)}`,
  };
  for (const [name, bytes] of Object.entries(files)) writeFileSync(join(where, name), bytes);
  await run("render", "sphere", "--hand", "synthetic:press", "--frame", 100, "--points", 20, "-o", join(where, "path.json"));
  /** Drops them; the page's project and its image, which must be the command line's of the saved bundle. */
  const dropped = async (...names) => {
    await drop(page, names.map((name) => ({ name, bytes: readFileSync(join(where, name)) })));
    let project = "";
    await eventually(async () => {
      await settled(page);
      project = await shapeOf(page);
      return names.some((name) => project.includes(name));
    }, () => `${project}, ${names}`);
    await saveBundle(page, join(where, "now.haptogram"));
    await run("compile", join(where, "now.haptogram"), "-o", join(where, "now.hex"));
    assert.equal(String(await takeAway(page, "Image")), readFileSync(join(where, "now.hex"), "utf8"), project);
    return project;
  };
  let project = await dropped("beat.wav");
  assert.match(project, /am = "wav:beat\.wav"/);
  assert.match(project, /kind = "circle"/, "the shape stays");
  assert.equal(await field(page, "Modulation").locator("option:checked").innerText(), "sound of beat.wav");
  project = await dropped("curve.csv");
  assert.match(project, /am = "csv:curve\.csv"/);
  await field(page, "Modulation").selectOption("");
  project = await dropped("cal.toml", "my.toml");
  assert.match(project, /array = "cal\.toml"/);
  assert.deepEqual(namesIn(join(where, "now.haptogram")), ["cal.toml", "my.toml", "project.toml"]);
  await field(page, "Array").selectOption("tile-10x10");
  project = await dropped("way.csv");
  assert.match(project, /path = "way\.csv"/);
  assert.doesNotMatch(project, /shape/);
  project = await dropped("path.json");
  assert.match(project, /path = "path\.json"/);
  // What is wrong is told by the file's name and the page's labels, without folders of this machine.
  await drop(page, [{ name: "no.wav", bytes: Buffer.from("RIFFxxxx") }]);
  await page.locator(".failed", { hasText: "no.wav" }).waitFor();
  assert.doesNotMatch(await page.locator(".failed").innerText(), /\/tmp|\//);
  assert.match(await shapeOf(page), /path = "path\.json"/, "it has replaced nothing");
  await page.locator(".failed").getByRole("button", { name: "Close" }).click();
  // A calibration names no file of this machine that the page was not given.
  await drop(page, [{ name: "far.toml", bytes: Buffer.from(files["cal.toml"].replace("my.toml", join(where, "my.toml"))) }]);
  await page.locator(".failed", { hasText: "my.toml" }).waitFor();
  assert.match(await page.locator(".failed").innerText(), /does not have this file|names its own files alone/);
});

test("a project with its files is opened, with an array and a waveform of its own", async (t) => {
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t), studio, { allowed: /status of 422/ });
  const where = await folder(t);
  await settled(page);
  const files = {
    "own.toml": 'format = "haptogram-project-1"\narray = "my.toml"\nam = "csv:beat.csv"\npoints = 4\n[[shape]]\nfile = "cloud.xyz"\n',
    "my.toml": 'name = "mine"\n[array]\nrows = 6\ncolumns = 6\npitch_mm = 10.5\ncarrier_hz = 40000\nduty = 0.5\n[transducer]\nradius_mm = 4.5\nsource_pa_m = 4\n',
    "beat.csv": "time_ms,amplitude\n0,0\n50,1\n100,0\n",
    "cloud.xyz": "0 0 130\n10 0 130\n0 10 130\n-10 0 130\n",
  };
  for (const [name, text] of Object.entries(files)) writeFileSync(join(where, name), text);
  await drop(page, Object.entries(files).map(([name, text]) => ({ name, bytes: Buffer.from(text) })));
  await page.locator("footer", { hasText: "own: 4 focal points for mine" }).waitFor();
  await settled(page);
  await run("compile", join(where, "own.toml"), "-o", join(where, "own.hex"));
  assert.equal(String(await takeAway(page, "Image")), readFileSync(join(where, "own.hex"), "utf8"));
  await saveBundle(page, join(where, "own.haptogram"));
  assert.deepEqual(namesIn(join(where, "own.haptogram")), ["beat.csv", "cloud.xyz", "my.toml", "project.toml"]);
  await run("compile", join(where, "own.haptogram"), "-o", join(where, "bundle.hex"));
  assert.equal(readFileSync(join(where, "bundle.hex"), "utf8"), readFileSync(join(where, "own.hex"), "utf8"));

  for (const [name, bytes, words] of [
    ["no.haptogram", Buffer.from("no zip"), "cannot be unpacked"],
    ["cut.haptogram", readFileSync(join(where, "own.haptogram")).subarray(0, 200), "cannot be unpacked"],
    ["bad.toml", Buffer.from('format = "haptogram-project-9"\n'), "haptogram-project-1"],
  ]) {
    await drop(page, [{ name, bytes }]);
    await page.locator(".failed", { hasText: words }).waitFor();
    await page.locator("footer", { hasText: "own: 4 focal points" }).waitFor();
  }
});

/** An AdapTics pattern: a brush that moves 20 mm in 20 ms and rests there for 10. */
function adaptics(brush) {
  const number = (value) => ({ type: "f64", value });
  const linear = { name: "linear", params: {} };
  const frame = (type, time, x) => ({ type, time, brush: { brush, transition: linear }, intensity: { intensity: { name: "constant", params: { value: number(1) } }, transition: linear }, cjumps: [], ...(x === undefined ? {} : { coords: { coords: { x, y: 0, z: 0 }, transition: linear } }) });
  const all = (value) => ({ x: number(value), y: number(value), z: number(value) });
  return {
    $DATA_FORMAT: "MidAirHapticsAnimationFileFormat", $REVISION: "0.1.0-alpha.2", name: "x", keyframes: [frame("standard", 0, -10), frame("standard", 20, 10), frame("pause", 30), { type: "stop", time: 30 }],
    pattern_transform: { geometric_transforms: { translate: { ...all(0), z: number(150) }, rotation: number(0), scale: all(1) }, intensity_factor: number(1), playback_speed: number(1) }, user_parameter_definitions: {},
  };
}

const f64 = (value) => ({ type: "f64", value });

test("an AdapTics pattern keeps its key frames, or stays a path with the reason, and is saved in a bundle", async (t) => {
  const page = await openPage(t, await startBrowser(t), await startStudio(t), { allowed: /status of 422/ }); // of the pattern that stays a path
  const where = await folder(t);
  await settled(page);
  await drop(page, [{ name: "wipe.adaptics", bytes: Buffer.from(JSON.stringify(adaptics({ name: "circle", params: { radius: f64(0), am_freq: f64(0) } }))) }]);
  await page.getByRole("slider", { name: "Time of key frame 3" }).waitFor();
  await settled(page);
  await accessible(page);
  await saveBundle(page, join(where, "frames.haptogram"));
  assert.deepEqual(namesIn(join(where, "frames.haptogram")), ["project.toml"]);
  await run("compile", join(where, "frames.haptogram"), "-o", join(where, "frames.hex"), "--save-path", join(where, "path.json"));
  assert.equal(String(await takeAway(page, "Image")), readFileSync(join(where, "frames.hex"), "utf8"));
  const { steps } = JSON.parse(readFileSync(join(where, "path.json"), "utf8"));
  assert.equal(steps.reduce((sum, { periods }) => sum + periods, 0), 1200);
  for (const [i, { foci: [{ position_mm: [x, y, z] }] }] of steps.entries()) // a step a millisecond
    assert.ok(Math.abs(x - Math.min(10, -10 + (i + 0.5))) < 1e-6 && Math.abs(y) < 1e-6 && Math.abs(z - 150) < 1e-6, `${i}: ${x} ${y} ${z}`);

  const bytes = Buffer.from(JSON.stringify(adaptics({ name: "line", params: { length: f64(6), thickness: f64(1), rotation: f64(90), am_freq: f64(0) } })));
  await drop(page, [{ name: "line.adaptics", bytes }]);
  await page.locator(".file", { hasText: "line.adaptics" }).waitFor();
  await page.locator(".hint", { hasText: "It stays a path: key frames of a shape cannot say it: at 0 ms its brush is a line" }).waitFor();
  await fill(page, "Focal points", 60);
  await settled(page);
  await saveBundle(page, join(where, "line.haptogram"));
  assert.deepEqual(namesIn(join(where, "line.haptogram")), ["line.adaptics", "project.toml"]);
  writeFileSync(join(where, "line.adaptics"), bytes);
  await run("compile", "--path", join(where, "line.adaptics"), "--points", 60, "-o", join(where, "line.hex"));
  assert.equal(String(await takeAway(page, "Image")), readFileSync(join(where, "line.hex"), "utf8"));
});

test("work outlives a reload, with its steps and its files, and is offered when the browser comes back", async (t) => {
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t), studio, { allowed: /WebSocket connection|ERR_CONNECTION|status of 401/ });
  await settled(page);
  await drop(page, [{ name: "cloud.xyz", bytes: Buffer.from("0 0 0\n10 0 0\n0 10 0\n-10 0 0\n") }]);
  await page.locator(".file", { hasText: "cloud.xyz" }).waitFor();
  await fill(page, "Centre z", 120);
  await settled(page);
  await page.locator(".menu", { hasText: "kept in this browser" }).waitFor();
  const before = await shapeOf(page);
  // Asked before it is left, for no file has it.
  const asked = page.waitForEvent("dialog");
  await page.reload();
  assert.equal((await asked).type(), "beforeunload");
  await page.locator(".file", { hasText: "cloud.xyz" }).waitFor();
  await settled(page);
  assert.equal(await shapeOf(page), before);
  await page.getByRole("button", { name: "Undo" }).click();
  await hasValue(field(page, "Centre z"), "130");
  await page.getByRole("button", { name: "Undo" }).click();
  await hasValue(field(page, "Shape"), "hemisphere");
  for (let i = 0; i < 2; i++) await page.getByRole("button", { name: "Redo" }).click();
  await hasValue(field(page, "Centre z"), "120");
  await page.locator(".menu", { hasText: "kept in this browser" }).waitFor();

  // A new tab of the same browser: what was not saved is offered, and restored with its files.
  const next = await page.context().newPage();
  await next.goto(studio.address);
  await next.locator(".card", { hasText: "was not saved as a file" }).waitFor();
  await settled(next);
  await accessible(next);
  await next.getByRole("button", { name: "Restore it" }).click();
  await next.locator(".file", { hasText: "cloud.xyz" }).waitFor();
  await next.locator("footer", { hasText: "4 focal points" }).waitFor();

  // Recent designs are found by name, and a saved one is left without a question.
  await openDesign(page, "Ring");
  await page.locator("footer", { hasText: "Ring: " }).waitFor();
  await fill(page, "Centre z", 150);
  const where = await folder(t);
  await saveBundle(page, join(where, "ring.haptogram"));
  await page.locator(".menu", { hasText: "file is up to date" }).waitFor();
  await page.locator(".menu summary").click();
  await page.locator(".sheet").getByRole("button", { name: /^example/ }).first().click();
  await page.locator("footer", { hasText: "example: 4 focal points" }).waitFor();
  await fill(page, "Centre z", 140);
  await settled(page);
  await page.locator(".menu", { hasText: "kept in this browser" }).waitFor();

  // The program was ended, and is started again at the same port.
  studio.child.kill("SIGKILL");
  await studio.ended;
  const second = await startStudio(t, "--port", new URL(studio.origin).port);
  const later = await page.context().newPage();
  await later.goto(second.address);
  await later.locator(".card", { hasText: "“example”" }).waitFor();
  await later.getByRole("button", { name: "Restore it" }).click();
  await later.locator("footer", { hasText: "example: 4 focal points" }).waitFor();
  await hasValue(field(later, "Centre z"), "140");
});

test("what it will feel like: weakest part, loudness, remedies, and never a verdict before looking", async (t) => {
  const where = await folder(t);
  writeFileSync(join(where, "far.toml"), 'format = "haptogram-project-1"\npoints = 12\nrate_hz = 20\n[place]\ncenter_mm = [0, 0, 480]\n[[shape]]\nkind = "circle"\ndiameter_mm = 60\n');
  const page = await openPage(t, await startBrowser(t), await startStudio(t, join(where, "far.toml")));
  await settled(page);
  await lookedAt(page);
  await run("compile", join(where, "far.toml"), "-o", join(where, "far.hex"));
  const { places } = JSON.parse(await run("feel", join(where, "far.hex"), "--json"));
  const words = await page.locator("#feel dl").innerText();
  const weakest = Number(words.match(/Weakest place\s+([−+][\d.]+) dB/)[1].replace("−", "-"));
  assert.ok(Math.abs(weakest - Math.min(...places.map(({ verdict }) => verdict.over_db))) < 0.06, `${weakest} dB`);
  const said = (await run("compile", join(where, "far.toml"), "-o", join(where, "far.hex"))).trim().split("\n").at(-1).replace(/^hand\s+|; try .*/g, "");
  assert.ok((await page.locator("#feel").innerText()).includes(said), said);
  await page.locator("#feel").getByRole("button", { name: /dB, at/ }).click();
  await page.locator(".scrubber", { hasText: "of 12:" }).waitFor();
  // While it is being looked at, nothing is said of it.
  await page.evaluate(() => {
    window.verdicts = [];
    const feel = document.querySelector("#feel");
    new MutationObserver(() => window.verdicts.push(feel.querySelector("[data-verdict-of-feel]").dataset.verdictOfFeel)).observe(feel, { subtree: true, attributes: true, childList: true, characterData: true });
  });
  await fill(page, "Centre z", 130);
  await eventually(async () => page.evaluate(() => window.verdicts.includes("looking")));
  await lookedAt(page);
  assert.match(await page.locator("#feel dl").innerText(), /At an ear, 300 mm\s+\d+ dB of 110/);
});

test("Play starts a virtual board when there is no other, and STOP ends it", async (t) => {
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t), studio);
  await settled(page);
  await boardSays(page, "No board: Play starts one");
  await page.locator("button.play").click();
  await boardSays(page, "Virtual board, outputs ON");
  assert.equal(await page.locator("body.outputs-on").count(), 1);
  await show(page, "Play");
  await accessible(page);
  await picture(page, "playing");
  await page.getByRole("button", { name: "STOP" }).click();
  await boardSays(page, "outputs off");
  // STOP while the board is still coming: it does not go on afterwards.
  await page.getByRole("button", { name: "Disconnect" }).click();
  await boardSays(page, "No board");
  await page.locator("button.play").click();
  await page.keyboard.press("Escape");
  await boardSays(page, "Virtual board, outputs off");
  await page.waitForTimeout(1000);
  await boardSays(page, "Virtual board, outputs off");
  await page.getByRole("button", { name: "Disconnect" }).click();
});
