// SPDX-License-Identifier: Apache-2.0
// A recorded hand that feels an object: chosen, scrubbed, drawn, taken away, played, and what is wrong with it told.
import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { delimiter, dirname, join } from "node:path";
import { test } from "node:test";
import { promisify } from "node:util";
import { accessible, boardSays, drawnAt, drop, eventually, folder, hasValue, keptPicture, middle, openDesign, openPage, panel, picture, pixels, program, run, settled, shapes, startBrowser, startStudio, takeAway } from "./support.mjs";

const field = (page, label) => page.getByLabel(label, { exact: true });
async function fill(page, label, value) {
  await field(page, label).fill(String(value));
  await field(page, label).press("Enter");
}
const shell = (where, text) => promisify(execFile)("/bin/sh", ["-ec", text], { cwd: where, env: { ...process.env, PATH: `${dirname(program)}${delimiter}${process.env.PATH}` } });
const commandsOf = async (page) => (await page.getByLabel("Commands that make these paths").innerText()).split("\n");

/** A page with a hand: the library's, or a project's. */
async function openHand(t, text, settings = {}) {
  const where = await folder(t);
  const project = join(where, "project.toml");
  if (text) writeFileSync(project, `format = "haptogram-project-1"\n${text}`);
  const studio = await startStudio(t, ...(text ? [project] : []));
  const page = await openPage(t, await startBrowser(t, ...(settings.flags ?? [])), studio, settings);
  if (!text) await openDesign(page, "Touched ball");
  return { page, where, project, studio };
}

/** Waits until the frame of a number has come, and its image if it has one. */
async function frameIs(page, frame, { image = true } = {}) {
  await page.locator("output.frame", { hasText: new RegExp(`^${frame} of \\d+, at `) }).waitFor();
  if (image) await settled(page);
}

/** The colour that the theme gives a thing in the view. */
const themeColour = (page, name) =>
  page.evaluate((name) => {
    const text = getComputedStyle(document.documentElement).getPropertyValue(name).trim();
    return [1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16));
  }, name);

/** Which part of places has a colour within two pixels. */
async function partDrawn(page, places, colour) {
  const { box, ...centre } = await middle(page);
  const values = await pixels(page);
  const width = Math.round(box.width);
  const near = (place) => {
    const at = drawnAt(place, { ...centre, box });
    const [x0, y0] = [Math.round(at.x - box.x), Math.round(at.y - box.y)];
    for (let y = y0 - 2; y <= y0 + 2; y++)
      for (let x = x0 - 2; x <= x0 + 2; x++)
        if (colour.every((each, i) => Math.abs(values[3 * (y * width + x) + i] - each) < 40)) return true;
    return false;
  };
  return places.filter(near).length / places.length;
}

for (const colorScheme of ["light", "dark"])
  test(`a hand that slides over a sphere: the frame in 3-D and in numbers, its path and its image as the command line makes them, ${colorScheme}`, async (t) => {
    const { page, where } = await openHand(t, undefined, { colorScheme });
    await frameIs(page, 60);
    const [frame, all] = await commandsOf(page);
    assert.equal(frame, "haptogram render sphere --hand=synthetic:slide --algorithm=A --frame=60 --points=100 -o path.json");
    assert.equal(all, "haptogram render sphere --hand=synthetic:slide --algorithm=A -o path.json");
    const taken = await takeAway(page, "Path of this frame");
    await shell(where, frame);
    assert.deepEqual(taken, readFileSync(join(where, "path.json")));
    // What the page says is what the command reports.
    const report = JSON.parse((await shell(where, `${frame} --report --json`)).stdout).frames[0];
    const rows = await panel(page, "This frame").innerText();
    for (const [name, value] of [["Strength on the lines", report.strength_pa], ["Length of all lines", report.length_mm], ["Passes a second", report.draw_hz], ["Lines", report.lines], ["Tilt leaves", 100 * report.tilt], ["Under the least mean force", 100 * report.weak]])
      assert.match(rows, new RegExp(`${name}\\s+${String(Number(value.toPrecision(3))).replace(".", "\\.")}\\b`), rows);
    // Its focal points and lines are drawn where the path has them.
    const foci = JSON.parse(taken).steps.flatMap((step) => step.foci.map((focus) => focus.position_mm));
    await keptPicture(page, `hand-${colorScheme}`);
    const drawn = await partDrawn(page, foci, await themeColour(page, "--focus"));
    assert.ok(drawn > 0.9, `${drawn} of the focal points are seen`);
    await accessible(page);
    // The image is that of the project, and of the path.
    const image = await takeAway(page, "Image");
    writeFileSync(join(where, "project.toml"), await takeAway(page, "Project"));
    await shell(where, "haptogram compile project.toml -o project.hex; haptogram compile --path path.json -o image.hex; haptogram render project.toml -o again.json");
    for (const file of ["project.hex", "image.hex"]) assert.deepEqual(image, readFileSync(join(where, file)), file);
    assert.deepEqual(taken, readFileSync(join(where, "again.json")));
    // With fewer focal points their lines show, where the path of many points has been.
    await fill(page, "Points of a pass", 10);
    await page.locator("footer", { hasText: "10 focal points" }).waitFor();
    await settled(page);
    await picture(page, `hand-lines-${colorScheme}`);
    const weak = await partDrawn(page, foci, await themeColour(page, "--weak"));
    assert.ok(weak > 0.8, `${weak} of the lines are drawn as weak, as ${report.weak} of them are`);
  });

test("scrubbing: by slider, keys, and the lane of all frames; one gesture is one step back", async (t) => {
  const { page, where } = await openHand(t);
  await frameIs(page, 60);
  const slider = panel(page, "Frame").getByRole("slider");
  const before = await pixels(page);
  await slider.press("End");
  await frameIs(page, 300);
  const [after] = [await pixels(page)];
  assert.ok(after.filter((value, i) => Math.abs(value - before[i]) > 60).length > 300, "the hand moves in the view");
  await slider.press("ArrowLeft");
  await frameIs(page, 299);
  await page.getByRole("button", { name: "Undo" }).click();
  await page.getByRole("button", { name: "Undo" }).click();
  await frameIs(page, 60);
  const all = await takeAway(page, "Path of all frames");
  await shell(where, (await commandsOf(page))[1]);
  assert.deepEqual(all, readFileSync(join(where, "path.json")));
  const lane = page.getByRole("img", { name: "How strong each of 300 frames is; 300 touch the object" });
  await lane.scrollIntoViewIfNeeded();
  const box = await lane.boundingBox();
  await page.mouse.click(box.x + 0.8 * box.width, box.y + box.height / 2);
  await frameIs(page, "(239|240|241|242)"); // a pixel is more than a frame
  await picture(page, "hand-frames");
  await page.getByRole("button", { name: "Undo" }).click();
  await frameIs(page, 60);
  // Another setting, and the lane is no longer of this document.
  await field(page, "Algorithm").selectOption("B");
  await lane.waitFor({ state: "detached" });
});

test("algorithms, objects, pace and place; a frame without lines says why, and has nothing to play", async (t) => {
  const { page, where } = await openHand(t);
  await frameIs(page, 60);
  await page.getByRole("button", { name: "Start a virtual board" }).click();
  await boardSays(page, "outputs off");
  await field(page, "Algorithm").selectOption("B"); // of a sphere, which has no edges
  await panel(page, "This frame").getByText(/Nothing is drawn: .*algorithm B has nothing to draw/).waitFor();
  await page.locator("footer", { hasText: "no image" }).waitFor();
  assert.ok(await page.getByRole("button", { name: "Play" }).isDisabled());
  await accessible(page);
  await picture(page, "hand-nothing");
  await field(page, "Kind").selectOption("cube");
  await fill(page, "Size", 80);
  await fill(page, "Turn about z", 30);
  await field(page, "Pace").selectOption("frequency_hz");
  await fill(page, "Passes a second", 20);
  await fill(page, "Points of a pass", 60);
  await settled(page);
  await eventually(async () => /Passes a second 20\s/.test((await panel(page, "This frame").innerText()).replaceAll("\t", " ")), () => panel(page, "This frame").innerText());
  const taken = await takeAway(page, "Path of this frame");
  await shell(where, (await commandsOf(page))[0]);
  assert.deepEqual(taken, readFileSync(join(where, "path.json")));
  await picture(page, "hand-cube");
  // The frame's pass on a board, and off again.
  await page.getByRole("button", { name: "Play" }).click();
  await boardSays(page, "outputs ON");
  await page.keyboard.press("Escape");
  await boardSays(page, "outputs off");
  await fill(page, "Centre z", 400);
  await panel(page, "This frame").getByText(/never touches the object; it comes nearest, to [\d.]+ mm/).waitFor();
  await page.getByRole("button", { name: "Back to an object of focal points" }).click();
  await settled(page);
  await panel(page, "This frame").waitFor({ state: "detached" });
  await page.locator("footer", { hasText: "200 focal points" }).waitFor();
});

/** A hand of a Leap's recording: the members that a reader looks at, millimetres, y up. */
function leapFrame(timestamp, height) {
  const finger = (type, x) => ({ id: 10 + type, type, width: 16, mcpPosition: [x, height, -40], pipPosition: [x, height, -70], dipPosition: [x, height, -95], tipPosition: [x, height, -115], btipPosition: [x, height, -110], handId: 1, extended: true });
  const hand = { id: 1, type: "right", palmPosition: [0, height, 0], palmNormal: [0, -1, 0], direction: [0, 0, -1], palmVelocity: [0, 0, 0], confidence: 1, grabStrength: 0, pinchStrength: 0 };
  return { timestamp, hands: [hand], pointables: [0, 1, 2, 3, 4].map((type) => finger(type, -50 + 22 * type)) };
}

test("a dropped recording and a dropped mesh, under names that a shell and a page must quote", async (t) => {
  const { page, where } = await openHand(t);
  await frameIs(page, 60);
  const name = `hand $(touch x) <b>'1'.json`;
  const recording = JSON.stringify({ frames: [0, 1, 2].map((i) => leapFrame(1e6 + 1e4 * i, 230 - 10 * i)) });
  writeFileSync(join(where, name), recording);
  await drop(page, [{ name, bytes: recording }]);
  await frameIs(page, 1, { image: false });
  const box = readFileSync(join(shapes, "trimesh_binary.stl"));
  writeFileSync(join(where, "box.stl"), box);
  await drop(page, [{ name: "box.stl", bytes: box }]);
  await hasValue(field(page, "Kind"), "box.stl");
  await field(page, "Frame").press("End");
  await frameIs(page, 3, { image: false });
  await eventually(async () => (await page.getByRole("button", { name: "Path of this frame" }).isEnabled()) || /Nothing/.test(await panel(page, "This frame").innerText()));
  await fill(page, "Centre z", 200);
  await settled(page);
  const taken = await takeAway(page, "Path of this frame");
  await shell(where, (await commandsOf(page))[0]);
  assert.deepEqual(taken, readFileSync(join(where, "path.json")));
  assert.rejects(async () => readFileSync(join(where, "x")), "the name is no command");
  await picture(page, "hand-mesh");
});

test("bad recordings, frames and objects are told in the library's words, and the server goes on", async (t) => {
  const { page } = await openHand(t, undefined, { allowed: /status of 4\d\d/ });
  await frameIs(page, 60);
  const failure = page.locator(".failed");
  for (const [name, bytes, words] of [
    ["torn.lz", "N4Igdghg", /torn\.lz/],
    ["none.json", "{\"frames\": []}", /none\.json/],
    ["text.json", "not json", /text\.json/],
    ["alone.pose", "1 2 3\n", /model_hand\.json.*drop it/],
  ]) {
    await drop(page, [{ name, bytes }]);
    await eventually(async () => words.test(await failure.innerText().catch(() => "")), async () => `${name}: ${await failure.innerText().catch(() => "no failure")}`);
    await frameIs(page, 60); // it has replaced nothing
    await failure.getByRole("button", { name: "Close" }).click();
    await failure.waitFor({ state: "detached" });
  }
  await accessible(page);
  const nobody = JSON.stringify({ frames: [{ timestamp: 1, hands: [], pointables: [] }, { timestamp: 2, hands: [], pointables: [] }] });
  await drop(page, [{ name: "nobody.json", bytes: nobody }]);
  await panel(page, "This frame").getByText(/there is no hand in it/).waitFor();
  await page.getByRole("button", { name: "Undo" }).click();
  await frameIs(page, 60);
  await fill(page, "Frame number", 301);
  await failure.getByText(/found 301, expected 1 to 300/).waitFor();
  await fill(page, "Frame number", 2);
  await frameIs(page, 2);
  await failure.waitFor({ state: "detached" });
  // Files of this machine are none of the page's.
  const said = await page.evaluate(
    () => new Promise((done) => {
      const told = [];
      const socket = new WebSocket(`ws://${location.host}/ws`, ["haptogram.1", `token.${sessionStorage.getItem("token")}`]);
      const hands = [{ recording: "/etc/passwd.json" }, { recording: "../secret.lz" }, { recording: "synthetic:slide", object: "/etc/passwd.stl" }, { recording: "a.pose", model: "/etc/passwd" }, { recording: "synthetic:clap" }];
      socket.onopen = () => ask();
      const ask = () => socket.send(JSON.stringify({ t: told.length % 2 ? "path" : "hand", n: told.length + 1, document: { format: "haptogram-project-1", hand: { frame: 1, ...hands[Math.floor(told.length / 2)] } }, ...(told.length % 2 ? {} : { drawn: "" }) }));
      socket.onmessage = ({ data }) => {
        if (typeof data !== "string" || JSON.parse(data).t !== "failed") return;
        told.push(JSON.parse(data).error.message);
        if (told.length === 2 * hands.length) { socket.close(); done(told); } else ask();
      };
    }),
  );
  assert.equal(said.filter((text) => /does not have this file/.test(text)).length, 8, said.join("\n"));
  assert.match(said.at(-1), /clap/);
});

test("without WebGL the numbers and the lines are still told, and all is done by keys", async (t) => {
  const { page } = await openHand(t, undefined, { flags: ["--disable-3d-apis"], allowed: /WebGL/ });
  await page.getByText("There is no 3-D view").waitFor();
  await page.locator("output.frame", { hasText: /^60 of 300, at 0\.590 of 2\.990 s/ }).waitFor();
  await panel(page, "This frame").getByText(/Each line, in its order: contour [\d.]+ mm, contour/).waitFor();
  const slider = panel(page, "Frame").getByRole("slider");
  for (let i = 0; !(await slider.evaluate((each) => each === document.activeElement)); i++) {
    assert.ok(i < 40, "the slider is reached by the Tab key");
    await page.keyboard.press("Tab");
  }
  await page.keyboard.press("ArrowRight");
  await page.locator("output.frame", { hasText: /^61 of 300, at / }).waitFor();
  await page.keyboard.press("Control+z");
  await page.locator("output.frame", { hasText: /^60 of 300, at / }).waitFor();
  await accessible(page);
});
