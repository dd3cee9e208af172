// SPDX-License-Identifier: Apache-2.0
// Looking closer at the field, taking it away, moving the object by hand, and every edit taken back.
import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { delimiter, dirname, join } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { promisify } from "node:util";
import { accessible, boardSays, drawnAt, eventually, folder, hasValue, lookedAt, middle, openDesign, openPage, picture, pixels, program, run, settled, slices, startBrowser, startStudio, takeAway } from "./support.mjs";

const shipped = join(dirname(fileURLToPath(import.meta.url)), "../../extras/studio/gallery");
const field = (page, label) => page.getByLabel(label, { exact: true });
async function fill(page, label, value) {
  await field(page, label).fill(String(value));
  await field(page, label).press("Enter");
}

/** The colour of the page at a place, as red, green and blue. */
async function colourAt(page, x, y) {
  const shot = (await page.screenshot({ clip: { x, y, width: 1, height: 1 } })).toString("base64");
  return page.evaluate(async (base64) => {
    const image = new Image();
    image.src = `data:image/png;base64,${base64}`;
    await image.decode();
    const context = Object.assign(document.createElement("canvas"), { width: 1, height: 1 }).getContext("2d");
    context.drawImage(image, 0, 0);
    return [...context.getImageData(0, 0, 1, 1).data].slice(0, 3);
  }, shot);
}

test("colours, ranges and units ask for no new slice, and what is above the top is marked", async (t) => {
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t), studio);
  await settled(page);
  const before = await slices(page);
  const place = drawnAt([-55, -20, 130], await middle(page)); // of the plane, between its least and its greatest
  await field(page, "Colours").selectOption("grey");
  await eventually(async () => {
    const [red, green, blue] = await colourAt(page, place.x, place.y);
    return Math.max(red, green, blue) - Math.min(red, green, blue) < 12;
  }, async () => `no grey: ${await colourAt(page, place.x, place.y)}`);
  await field(page, "Colours").selectOption("inferno");
  await eventually(async () => {
    const [red, green] = await colourAt(page, place.x, place.y);
    return red > green + 30;
  }, async () => `not inferno: ${await colourAt(page, place.x, place.y)}`);

  await field(page, "Shown").selectOption("rms");
  await page.locator(".bar figcaption", { hasText: "rms" }).waitFor();
  const top = Number(await page.locator(".bar li").last().innerText());
  await field(page, "Keep this scale").check();
  await fill(page, "Top", top / 2);
  await page.locator(".bar", { hasText: "above the top" }).waitFor();
  assert.ok(Math.abs(Number(await page.locator(".bar li").last().innerText()) - top / 2) < 0.01 * top);
  // The same top in another unit: half the pressure is 6.02 dB less.
  await field(page, "Shown").selectOption("level");
  const levels = (await page.locator(".bar li").allInnerTexts()).map(Number).reverse();
  assert.ok(Math.abs(levels[0] - 20 * Math.log10(top / 2 / 20e-6)) < 0.6, String(levels));
  await fill(page, "Range", 20);
  await eventually(async () => Math.abs(levels[0] - 20 - Number(await page.locator(".bar li").first().innerText())) < 0.6);
  assert.equal(await slices(page), before);
  await accessible(page);
  await picture(page, "held-top");
});

test("the probe reads what the command line computes", async (t) => {
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t), studio);
  await settled(page);
  const where = await folder(t);
  writeFileSync(join(where, "image.hex"), await takeAway(page, "Image"));
  writeFileSync(join(where, "image.json"), await takeAway(page, "Manifest"));
  const step = 0.5, side = 321;
  await run("field", join(where, "image.hex"), "--plane", "xy@z=130", "--step", step, "--extent", 80, "-o", join(where, "plane.csv"));
  const rows = readFileSync(join(where, "plane.csv"), "utf8").trim().split("\n").slice(1);
  const values = rows.map((row) => Number(row.split(",").at(-1)));
  assert.equal(values.length, side * side);
  const peak = Math.max(...values);
  const at = (x, y) => {
    const [i, j] = [(x + 80) / step, (y + 80) / step];
    const [a, b] = [Math.floor(i), Math.floor(j)];
    const row = (k) => values[k * side + a] * (a + 1 - i) + values[k * side + a + 1] * (i - a);
    return row(b) * (b + 1 - j) + row(b + 1) * (j - b);
  };
  const view = await middle(page);
  let worst = 0;
  const found = [];
  for (const point of [[-45, 30, 130], [-20, -35, 130], [12, 47, 130], [-63, 58, 130], [50, -30, 130]]) {
    const place = drawnAt(point, view);
    await page.mouse.move(place.x, place.y);
    let x, y, z, value;
    // Within a pixel, which is a millimetre or less.
    await eventually(async () => {
      const text = await page.locator(".probe").innerText().catch(() => "");
      [, value, x, y, z] = (text.match(/^(\S+) Pa at\s+(\S+), (\S+), (\S+) mm/) ?? []).map(Number);
      return Math.hypot(x - point[0], y - point[1]) < 2 && z === 130;
    }, () => `${point}: the probe says ${value} at ${x}, ${y}, ${z}`);
    worst = Math.max(worst, Math.abs(value - at(x, y)) / peak);
    found.push(value);
  }
  t.diagnostic(`the probe against 'haptogram field': ${(100 * worst).toFixed(2)} % of the peak at worst`);
  assert.ok(worst < 0.03, `${worst}`);
  assert.ok(Math.max(...found) - Math.min(...found) > 0.2 * peak, "the places differ by much more than that");
});

test("the field as files, and the commands that make the same", async (t) => {
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t), studio);
  await settled(page);
  const where = await folder(t);
  await field(page, "Plane").selectOption("xz");
  await fill(page, "Middle x", 5);
  await field(page, "Shown").selectOption("level");
  await fill(page, "Step", 2);
  await settled(page);
  writeFileSync(join(where, "project.toml"), await takeAway(page, "Project"));
  const text = await page.locator("pre.command").innerText();
  assert.match(text, /--plane xz@y=0 --x=-75:85 --z=50:210 --step 2 --quantity spl -o field\.png$/);
  await page.context().grantPermissions(["clipboard-read", "clipboard-write"]);
  await page.getByRole("button", { name: "Copy as command" }).click();
  await eventually(async () => (await page.evaluate(() => navigator.clipboard.readText())) === text);
  const shell = (line) => promisify(execFile)("sh", ["-ec", line], { cwd: where, env: { ...process.env, PATH: `${dirname(program)}${delimiter}${process.env.PATH}` } });
  await shell(text);
  for (const as of ["csv", "npy", "vti", "png"]) {
    const given = await takeAway(page, `Field (.${as})`);
    if (as !== "png") await shell(text.split("\n").at(-1).replace("field.png", `field.${as}`));
    assert.deepEqual(given, readFileSync(join(where, `field.${as}`)), as);
  }
});

test("a field that cannot be had is explained", async (t) => {
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t), studio, { allowed: /status of 422/ });
  await settled(page);
  const scene = await page.evaluate(
    () => new Promise((done) => {
      const socket = new WebSocket(`ws://${location.host}/ws`, ["haptogram.1", `token.${sessionStorage.getItem("token")}`]);
      socket.onopen = () => socket.send(JSON.stringify({ t: "scene", n: 1, document: { format: "haptogram-project-1", points: 4, rate_hz: 50, shape: [{ kind: "circle" }] } }));
      socket.onmessage = ({ data }) => typeof data === "string" && JSON.parse(data).t === "scene" && done(JSON.parse(data).scene.name);
    }),
  );
  const good = { scene, plane: "xy@z=130", x: "-20:20", y: "-20:20", step: "5", quantity: "rms", as: "csv" };
  const ask = (changes) =>
    page.evaluate(async (query) => {
      const answer = await fetch(`/api/field?${new URLSearchParams(query)}`, { headers: { Authorization: `Bearer ${sessionStorage.getItem("token")}` } });
      return { status: answer.status, text: await answer.text() };
    }, { ...good, ...changes });
  const { status, text } = await ask({});
  assert.equal(status, 200);
  assert.equal(text.trim().split("\n").length, 1 + 9 * 9);
  const rows = [
    [{ scene: "none" }, /no scene/], [{ plane: "xy" }, /plane/], [{ plane: "z@x=0,y=0" }, /plane/], [{ x: "20" }, /x/], [{ step: "0" }, /step.*found '0'/],
    [{ step: "1mm" }, /step.*found '1mm'/], [{ step: "0.001" }, /step/], [{ quantity: "loudness" }, /loudness/], [{ quantity: "complex", as: "png" }, /complex/],
    [{ as: "exe" }, /exe/], [{ as: "/../x.csv" }, /expected png, csv/],
  ];
  for (const [changes, words] of rows) {
    const answer = await ask(changes);
    assert.equal(answer.status, 422, JSON.stringify(changes));
    assert.match(JSON.parse(answer.text).error.message, words, JSON.stringify(changes));
  }
});

test("the object is moved by its handles, one step for undo", async (t) => {
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t), studio);
  await settled(page);
  // In Make, the handles are the object's.
  const bounds = drawnAt([0, 0, 130], await middle(page));
  const centre = async () => Promise.all(["x", "y", "z"].map(async (axis) => Number(await field(page, `Centre ${axis}`).inputValue())));
  await page.mouse.move(bounds.x, bounds.y);
  await page.mouse.down();
  for (let i = 1; i <= 10; i++) await page.mouse.move(bounds.x + 4 * i, bounds.y + 3 * i); // whichever of its handles is there
  await page.mouse.up();
  await eventually(async () => Math.hypot(...(await centre()).map((each, i) => each - [0, 0, 130][i])) > 5, async () => `still at ${await centre()}`);
  await settled(page);
  await picture(page, "object-moved");
  await page.getByRole("button", { name: "Undo" }).click();
  await hasValue(field(page, "Centre x"), "0");
  assert.deepEqual(await centre(), [0, 0, 130]);
  assert.ok(await page.getByRole("button", { name: "Undo" }).isDisabled());
});

test("a picture of the view, the way back to an object that is out of sight, and the plane back on it", async (t) => {
  const page = await openPage(t, await startBrowser(t), await startStudio(t));
  await settled(page);
  assert.equal(await page.getByRole("button", { name: "Save a picture of the view" }).count(), 0);
  await page.locator("[data-step=See]").click();
  const waiting = page.waitForEvent("download");
  await page.getByRole("button", { name: "Save a picture of the view" }).click();
  const download = await waiting;
  assert.equal(download.suggestedFilename(), "example.png");
  const bytes = readFileSync(await download.path());
  assert.equal(bytes.subarray(1, 4).toString(), "PNG");
  const size = await page.locator("#view canvas").evaluate(({ width, height }) => [width, height]);
  assert.deepEqual([bytes.readUInt32BE(16), bytes.readUInt32BE(20)], size);
  // Not an empty one: the plane's colours are in it.
  const colours = await page.evaluate(async (base64) => {
    const image = new Image();
    image.src = `data:image/png;base64,${base64}`;
    await image.decode();
    const context = Object.assign(document.createElement("canvas"), { width: image.width, height: image.height }).getContext("2d");
    context.drawImage(image, 0, 0);
    return new Set(new Uint32Array(context.getImageData(0, 0, image.width, image.height).data.buffer)).size;
  }, bytes.toString("base64"));
  assert.ok(colours > 50, `${colours} colours`);
  await fill(page, "Middle x", 30);
  await page.getByRole("button", { name: "Back onto the object" }).click();
  await hasValue(field(page, "Middle x"), "0");
  // The handles are of what the step is about.
  await hasValue(field(page, "Handles"), "plane move");
  await fill(page, "Centre x", 0);
  assert.equal(await page.locator(".card", { hasText: "outside the view" }).count(), 0);
  // Moved by the right button until it is out of sight.
  const { x, y } = await middle(page);
  for (let i = 0; i < 3; i++) {
    await page.mouse.move(x - 200, y - 100);
    await page.mouse.down({ button: "right" });
    await page.mouse.move(x + 200, y + 150, { steps: 5 });
    await page.mouse.up({ button: "right" });
  }
  await page.locator(".card", { hasText: "outside the view" }).waitFor();
  await picture(page, "outside-light");
  await page.getByRole("button", { name: "Show it" }).click();
  await page.locator(".card", { hasText: "outside the view" }).waitFor({ state: "detached" });
});

test("undo takes back what was done last, of the view, too", async (t) => {
  const page = await openPage(t, await startBrowser(t), await startStudio(t));
  await settled(page);
  const focus = page.getByLabel("Focal point", { exact: true });
  const marked = (words) => page.locator(".scrubber output", { hasText: words }).waitFor();
  await fill(page, "Focal points", 30);
  await settled(page);
  await field(page, "Plane").selectOption("xz");
  await page.waitForTimeout(1100); // what follows within a second would be the same movement
  await field(page, "Middle x").fill("7");
  await field(page, "Middle x").press("Enter");
  await focus.press("End");
  await marked("30 of 30");
  const undo = () => page.keyboard.press("Control+z");
  const redo = () => page.keyboard.press("Control+Shift+Z");
  await undo();
  await marked("none marked");
  await hasValue(field(page, "Middle x"), "7");
  await undo();
  await hasValue(field(page, "Middle x"), "0");
  await hasValue(field(page, "Plane"), "xz");
  await undo();
  await hasValue(field(page, "Plane"), "xy");
  await page.locator("footer", { hasText: "30 focal points" }).waitFor();
  await undo();
  await page.locator("footer", { hasText: "200 focal points" }).waitFor();
  assert.ok(await page.getByRole("button", { name: "Undo" }).isDisabled());
  await redo();
  await page.locator("footer", { hasText: "30 focal points" }).waitFor();
  await settled(page);
  await redo();
  await hasValue(field(page, "Plane"), "xz");
  await redo();
  await hasValue(field(page, "Middle x"), "7");
  await redo();
  await marked("30 of 30");
  assert.ok(await page.getByRole("button", { name: "Redo" }).isDisabled());
  // The plane by its handles: one step.
  const before = await field(page, "Middle z").inputValue();
  const at = drawnAt([7, 0, 130], await middle(page));
  await page.mouse.move(at.x, at.y);
  await page.mouse.down();
  for (let i = 1; i <= 10; i++) await page.mouse.move(at.x, at.y - 4 * i);
  await page.mouse.up();
  await eventually(async () => (await field(page, "Middle z").inputValue()) !== before || (await field(page, "Middle y").inputValue()) !== "0");
  await undo();
  await hasValue(field(page, "Middle x"), "7");
  await hasValue(field(page, "Middle y"), "0");
  await hasValue(field(page, "Middle z"), before);
});

test("every edit is taken back and made again, by keys", async (t) => {
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t), studio);
  await settled(page);
  const first = String(await takeAway(page, "Project"));
  await field(page, "Shape").selectOption("cone");
  await fill(page, "Centre x", 4);
  await fill(page, "Size", 50);
  await fill(page, "Turn about z", 30);
  await fill(page, "Focal points", 30);
  await fill(page, "Passes a second", 20);
  await page.locator("footer", { hasText: "30 focal points" }).waitFor();
  await settled(page);
  const last = String(await takeAway(page, "Project"));
  for (const words of [/cone/, /center_mm/, /size_mm = 50/, /30/, /points = 30/, /rate_hz = 20/]) assert.match(last, words);
  for (let i = 0; i < 6; i++) await page.keyboard.press("Control+z");
  await hasValue(field(page, "Shape"), "hemisphere");
  await page.locator("footer", { hasText: "200 focal points" }).waitFor();
  assert.ok(await page.getByRole("button", { name: "Undo" }).isDisabled());
  assert.equal(String(await takeAway(page, "Project")), first);
  for (let i = 0; i < 6; i++) await page.keyboard.press(i % 2 ? "Control+y" : "Control+Shift+Z");
  await page.locator("footer", { hasText: "30 focal points" }).waitFor();
  assert.ok(await page.getByRole("button", { name: "Redo" }).isDisabled());
  assert.equal(String(await takeAway(page, "Project")), last);
});

test("the gallery, and the ways to play an object", async (t) => {
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t), studio);
  await settled(page);
  const scenes = new Set();
  const compiled = async () => {
    await settled(page);
    assert.equal(await page.locator(".failed").count(), 0, await page.locator(".failed").allInnerTexts().then(String));
    return String(await takeAway(page, "Project"));
  };
  const designs = await page.evaluate(async () => (await fetch("gallery.json")).json());
  const names = await page.locator(".gallery").locator("b").allInnerTexts();
  assert.deepEqual(names, designs.map(({ title }) => title));
  assert.equal(names.length, 13);
  const there = await folder(t);
  for (const { file, title } of designs) {
    await openDesign(page, title);
    await page.locator("footer", { hasText: new RegExp(`^${title}: \\d+ focal points?`) }).waitFor();
    scenes.add(await compiled());
    // The page's verdict is the program's.
    await lookedAt(page);
    const said = (await run("compile", join(shipped, file, "project.toml"), "-o", join(there, "image.hex"))).trim().split("\n").at(-1).replace(/^hand\s+|; try .*/g, "");
    assert.ok((await page.locator("#feel").innerText()).includes(`By models: ${said}.`), `${title}: ${said}`);
    const word = await page.locator("[data-verdict-of-feel]").getAttribute("data-verdict-of-feel");
    assert.match(await run("report", join(there, "image.hex"), "--no-picture", "-o", "-"), new RegExp(`by models: ${said.replaceAll(/[.+*?()]/g, "\\$&")}\\.<`), title);
    // The bar below it says the same: all of what is known and not known over what is just felt, below it, or both.
    const bar = await page.locator(".meter").evaluate((svg) => {
      const x = (part, end) => Number(svg.querySelector(part).getAttribute("x")) + (end ? Number(svg.querySelector(part).getAttribute("width")) : 0);
      return { felt: x(".threshold") + 1, from: x(".unknown"), to: x(".unknown", true), low: x(".range"), high: x(".range", true) };
    });
    const heard = { felt: bar.from >= bar.felt, "not felt": bar.to <= bar.felt, perhaps: bar.from < bar.felt && bar.to > bar.felt };
    assert.ok(heard[said.split(":")[0]], `${title}: ${said}: ${JSON.stringify(bar)}`);
    assert.ok(bar.from <= bar.low && bar.to >= bar.low, `${title}: ${JSON.stringify(bar)}`);
    assert.ok({ felt: ["clear", "notes"], perhaps: ["perhaps"], "not felt": ["unfelt"] }[said.split(":")[0]].includes(word), `${title}: ${word}`);
  }
  assert.equal(scenes.size, names.length, "each is another object");
  // The page's own report says the same, and of which design.
  const report = String(await takeAway(page, "Report"));
  assert.match(report, /<title>Report on Triangle<\/title>/);
  const [, words] = (await page.locator("#feel").innerText()).match(/By models: (.*)\.\n/);
  assert.ok(report.includes(`Whether a hand feels it, by models: ${words}.`), words);
  await openDesign(page, "Ring");
  await hasValue(field(page, "Speed"), "7");
  await field(page, "Pace").selectOption("frequency_hz");
  await fill(page, "Drawings a second", 20);
  await field(page, "All points feel alike").check();
  assert.match(await compiled(), /frequency_hz = 20[^]*even = true|even = true[^]*frequency_hz = 20/);
  await field(page, "Pace").selectOption("rate_hz");
  await field(page, "All points feel alike").uncheck();
  await fill(page, "Focal points", 4);
  await fill(page, "Passes a second", 200); // as often as the waveform, so that the sequence is short
  await field(page, "Modulation").selectOption("sine:200");
  const where = await folder(t);
  const project = await compiled();
  assert.match(project, /am = .sine:200./);
  assert.doesNotMatch(project, /speed|frequency|even/);
  writeFileSync(join(where, "project.toml"), project);
  await run("compile", join(where, "project.toml"), "-o", join(where, "image.hex"));
  assert.deepEqual(await takeAway(page, "Image"), readFileSync(join(where, "image.hex")));
  await accessible(page);
});

test("the slider below the view moves the focus on the board", async (t) => {
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t), studio);
  await settled(page);
  await fill(page, "Focal points", 8);
  await page.locator("footer", { hasText: "8 focal points" }).waitFor();
  await settled(page);
  await page.getByRole("button", { name: "Start a virtual board" }).click();
  await boardSays(page, "outputs off");
  const slider = field(page, "Focal point");
  await slider.fill("2");
  await page.locator(".scrubber", { hasText: "3 of 8" }).waitFor();
  await page.getByRole("button", { name: "Follow the slider" }).click();
  await boardSays(page, "outputs ON, one point");
  await page.getByText("plays record 3", { exact: false }).waitFor();
  for (const [at, record] of [[6, 7], [0, 1], [4, 5]]) {
    await slider.fill(String(at));
    await page.getByText(`plays record ${record}`, { exact: false }).waitFor();
  }
  await picture(page, "slider-plays");
  await accessible(page);
  await page.keyboard.press("Escape");
  await boardSays(page, "outputs off");
  // It only marks now.
  await slider.fill("1");
  await page.locator(".scrubber", { hasText: "2 of 8" }).waitFor();
  assert.match(await page.locator("#board").innerText(), /outputs off/);
});

test("the surface around the focal points: drawn, wider further below, of the object where it is now, and gone again", async (t) => {
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t), studio);
  await settled(page);
  await page.mouse.move(2, 2);
  const corners = async () => Number(await page.locator("#app").getAttribute("data-surface"));
  const shown = async (choice) => {
    const before = await corners();
    await field(page, "Surface").selectOption(choice);
    await eventually(async () => (await corners()) !== before && (await page.getByText("The surface is being computed").count()) === 0);
    return pixels(page);
  };
  const differing = (a, b) => a.reduce((sum, each, i) => sum + (i % 3 === 0 && Math.abs(each - b[i]) + Math.abs(a[i + 1] - b[i + 1]) + Math.abs(a[i + 2] - b[i + 2]) > 60 ? 1 : 0), 0);
  const none = await pixels(page);
  const narrow = await shown("3");
  const first = await corners();
  assert.ok(first > 1000 && differing(none, narrow) > 300, `${first} corners, ${differing(none, narrow)} pixels`);
  const wide = await shown("6");
  assert.ok(differing(none, wide) > 1.2 * differing(none, narrow), `${differing(none, wide)} pixels at 6 dB, ${differing(none, narrow)} at 3 dB`);
  await accessible(page);
  await picture(page, "surface");
  // It follows the object.
  await field(page, "Surface").selectOption("3");
  await eventually(async () => (await corners()) === first);
  await fill(page, "Centre z", 150);
  await settled(page);
  await eventually(async () => (await corners()) !== first);
  await fill(page, "Centre z", 130);
  await eventually(async () => (await corners()) === first);
  await field(page, "Surface").selectOption("");
  await eventually(async () => (await corners()) === 0);
  await settled(page);
  await page.mouse.move(2, 2);
  await eventually(async () => differing(none, await pixels(page)) < 50);
});
