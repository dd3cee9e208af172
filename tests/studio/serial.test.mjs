// SPDX-License-Identifier: Apache-2.0
// The static page with a board at a serial port: the port is a shim, and behind it is a virtual board. What goes over the line is the
// command line's, and everything that must turn the outputs off does.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { accessible, boardSays, drop, eventually, folder, openPage, panel, picture, quantile, run, settled, show, sleep, start, startBrowser, takeAway } from "./support.mjs";
import { requests, serialShim, tap } from "./serial_shim.mjs";
import { host, skip } from "./site.mjs";

const [write, enable, disable, begin, digest, modulate] = [0x02, 0x04, 0x05, 0x08, 0x0c, 0x0f];

async function startBoard(t, ...args) {
  const where = await folder(t);
  const pulses = join(where, "pulses.csv");
  const board = await start(t, "board", "run", "--json", "--model", "reference", "--pty", join(where, "port"), "--pulses", pulses, ...args);
  return { ...board, port: board.first.port, pulses, where };
}

/** The static page with a board at its port. */
async function openAtBoard(t, board, options = {}) {
  const shim = serialShim(board.port);
  const page = await openPage(t, await startBrowser(t), await host(t, shim.serve), { before: shim.before, ...options });
  t.after(() => shim.end());
  await settled(page);
  return { page, shim };
}

async function points(page, count) {
  await page.getByLabel("Focal points", { exact: true }).fill(String(count));
  await page.getByLabel("Focal points", { exact: true }).press("Enter");
  await page.locator("footer", { hasText: `${count} focal points` }).waitFor();
  await settled(page);
}

async function connect(page) {
  await page.getByRole("button", { name: "Choose a board…" }).click();
  await boardSays(page, "outputs off");
}

async function play(page) {
  await page.locator("button.play").click();
  await boardSays(page, "outputs ON");
  await page.getByText(/Playing for [1-9]/).waitFor();
}

/** What the board says when another program asks it, once the page's line is cut. */
const status = async (board) => JSON.parse(await run("device", "status", "--json", "--port", board.port));

/** Ends the board, which must have its outputs off and have played. */
async function endsSilent(board) {
  board.child.kill("SIGINT");
  const { value } = await board.lines.next();
  assert.equal(JSON.parse(value).enabled, false);
  await board.ended;
  assert.ok(readFileSync(board.pulses, "utf8").trim().split("\n").length > 100, "it had played");
}

const bytesOf = (shim) => shim.written.map(({ byte }) => byte);
const ofUploads = (bytes) => requests(bytes).filter(({ command }) => [write, digest, modulate].includes(command));

test("an upload by the page is the command line's, request by request", { skip }, async (t) => {
  const board = await startBoard(t);
  const { page, shim } = await openAtBoard(t, board);
  await points(page, 60);
  await connect(page);
  assert.deepEqual(shim.rates, [3000000, 1000000], "the line's rate was looked for");
  assert.ok(shim.workerHasSerial, "this browser lets Workers use ports");
  await page.getByRole("button", { name: "Upload" }).click();
  // While it goes on, the page draws: fields are still shown.
  await page.getByText(/Uploaded: \d+ of \d+ pieces/).waitFor();
  const first = ofUploads(bytesOf(shim));
  const hex = join(board.where, "image.hex");
  writeFileSync(hex, await takeAway(page, "Image (.hex)"));
  writeFileSync(join(board.where, "image.json"), await takeAway(page, "Manifest (.json)"));
  const other = await startBoard(t);
  const line = await tap(t, other.port);
  await run("upload", hex, "--port", line.port, "--baud", 1000000);
  const expected = ofUploads(line.written());
  t.diagnostic(`${first.length} requests, ${bytesOf(shim).length} bytes`);
  assert.ok(expected.length > 100);
  assert.deepEqual(first, expected);
  // A second time there is nothing to write, and the board holds what the command line would write, too.
  await page.getByRole("button", { name: "Upload" }).click();
  await page.getByText(/Uploaded: 0 of \d+ pieces/).waitFor();
  await page.getByRole("button", { name: "Disconnect" }).click();
  await boardSays(page, "No board");
  await eventually(() => shim.child === undefined);
  const report = JSON.parse(await run("upload", hex, "--port", board.port, "--json"));
  assert.equal(report.frames_written, 0);
});

test("the page plays on a board, makes it weaker, and STOP and Esc turn it off at once", { skip }, async (t) => {
  const board = await startBoard(t);
  const { page, shim } = await openAtBoard(t, board);
  await points(page, 8);
  // Play asks for a board, and then plays.
  await page.locator("button.play").click();
  await boardSays(page, "outputs ON");
  await show(page, "Play");
  await page.getByText(/Playing for [1-9]/).waitFor();
  await picture(page, "serial-playing-light");
  await page.getByRole("button", { name: "Theme" }).click();
  await picture(page, "serial-playing-dark");
  assert.ok((await accessible(page)) > 10); // which may keep the page silent for so long that the outputs go off
  if (/outputs off/.test(await page.locator("#board").innerText())) await play(page);
  const intensity = page.getByLabel("Intensity", { exact: true });
  await intensity.fill("30");
  await page.locator(".unit", { hasText: /^30 %$/ }).waitFor();
  await sleep(500);
  const took = [];
  for (let i = 0; i < 5; i++) {
    // Not locator.click(), which first waits for two pictures of a browser that draws in software.
    const { x, y, width, height } = await page.getByRole("button", { name: "STOP" }).boundingBox();
    const from = shim.written.length;
    const asked = performance.now();
    if (i % 2 === 0) await page.mouse.click(x + width / 2, y + height / 2);
    else await page.keyboard.press("Escape");
    await boardSays(page, "outputs off");
    const left = shim.written.slice(from);
    const at = left.findIndex((_, end) => requests(left.slice(0, end + 1).map(({ byte }) => byte)).some(({ command }) => command === disable));
    assert.ok(at >= 0, "DISABLE went over the line");
    took.push(left[at].when - asked);
    await page.getByText("Stopped.").waitFor();
    if (i < 4) await play(page);
  }
  t.diagnostic(`from the click to DISABLE on the line: median ${quantile(took, 0.5).toFixed(0)}, worst ${Math.max(...took).toFixed(0)} ms`);
  assert.ok(Math.max(...took) < 500, `${took}`);
  // STOP while the image is still on its way: the outputs never come on.
  const before = requests(bytesOf(shim)).filter(({ command }) => command === enable).length;
  await page.evaluate(() => {
    document.querySelector("button.play").click();
    document.querySelector("#stop").click();
  });
  await sleep(1000);
  assert.equal(requests(bytesOf(shim)).filter(({ command }) => command === enable).length, before);
  // One point of it, which the slider moves.
  await page.getByRole("slider", { name: /Focal point|Point|Place/ }).first().focus();
  await page.keyboard.press("ArrowRight");
  await page.getByRole("button", { name: "Follow the slider" }).click();
  await boardSays(page, "outputs ON");
  await page.getByText(/Playing the marked focal point/).waitFor();
  await page.keyboard.press("Escape");
  await boardSays(page, "outputs off");
  await page.getByRole("button", { name: "Disconnect" }).click();
  await eventually(() => shim.child === undefined);
  board.child.kill("SIGINT");
  const { value } = await board.lines.next();
  assert.equal(JSON.parse(value).enabled, false);
  await board.ended;
  const counts = new Map();
  for (const row of readFileSync(board.pulses, "utf8").trim().split("\n").slice(1)) {
    const [, rise, fall] = row.split(",").map(Number);
    counts.set(fall - rise, (counts.get(fall - rise) ?? 0) + 1);
  }
  const most = [...counts].filter(([, count]) => count > 1000).map(([length]) => length).sort((a, b) => a - b);
  const drive = (length) => Math.sin((Math.PI * length) / 1250);
  const ratio = drive(most[0]) / drive(most.at(-1));
  assert.ok(Math.abs(ratio - 0.3) < 0.02, `pulses of ${most} clocks`);
});

test("a modulation gives way to another while the page plays", { skip }, async (t) => {
  const board = await startBoard(t, "--board", "tile-100-wide");
  const { page, shim } = await openAtBoard(t, board);
  const project = 'format = "haptogram-project-1"\narray = "tile-10x10"\nboard = "tile-100-wide"\nam = "sine:200"\npoints = 8\n[[shape]]\nkind = "circle"\n';
  await drop(page, [{ name: "ring.toml", bytes: Buffer.from(project) }]);
  await page.locator("footer", { hasText: "ring: 8 focal points" }).waitFor();
  await settled(page);
  await connect(page);
  await play(page);
  const before = requests(bytesOf(shim)).filter(({ command }) => command === modulate).length;
  await page.getByLabel("Modulation", { exact: true }).selectOption("square:200");
  await settled(page);
  await page.getByRole("button", { name: "Modulate as shown" }).click();
  await eventually(() => requests(bytesOf(shim)).filter(({ command }) => command === modulate).length > before);
  await page.getByText(/Playing for/).waitFor();
  await page.keyboard.press("Escape");
  await boardSays(page, "outputs off");
  await page.getByRole("button", { name: "Disconnect" }).click();
  await eventually(() => shim.child === undefined);
  await endsSilent(board);
});

test("a key starts its part on the board, and nothing plays before", { skip }, async (t) => {
  const board = await startBoard(t);
  const { page, shim } = await openAtBoard(t, board);
  const project = 'format = "haptogram-project-1"\npoints = 8\nrate_hz = 10\n[[shape]]\nkind = "circle"\n[[trigger]]\non = "key:a"\nfrom_s = 0.05\nto_s = 0.0875\nloops = 2\n';
  await drop(page, [{ name: "ring.toml", bytes: Buffer.from(project) }]);
  await page.locator("footer", { hasText: "ring: 8 focal points" }).waitFor();
  await settled(page);
  await connect(page);
  await page.locator("button.play").click();
  await boardSays(page, "outputs ON");
  await show(page, "Play");
  await page.getByText("Outputs are on; it waits for a trigger.").waitFor();
  const begun = () => requests(bytesOf(shim)).filter(({ command }) => command === begin).map(({ payload }) => payload);
  await page.locator("body").press("b");
  await sleep(500);
  assert.deepEqual(begun(), []);
  await page.locator("body").press("a");
  await eventually(() => begun().length === 1);
  assert.deepEqual(begun(), ["5 0 3 0 2 0"]); // entries of 12.5 ms: from the fifth on, three, twice
  await page.keyboard.press("Escape");
  await boardSays(page, "outputs off");
  await page.getByRole("button", { name: "Disconnect" }).click();
  await eventually(() => shim.child === undefined);
  await endsSilent(board);
});

test("outputs go off when the page is left", { skip }, async (t) => {
  const board = await startBoard(t);
  const { page, shim } = await openAtBoard(t, board);
  await points(page, 8);
  await connect(page);
  await play(page);
  await page.close();
  await sleep(2000); // its watchdog has half a second
  shim.end();
  assert.equal((await status(board)).outputs, "off");
  await endsSilent(board);
});

test("outputs go off by the board's watchdog when the line is dead, and the page says that it has lost the board", { skip }, async (t) => {
  const board = await startBoard(t);
  const { page, shim } = await openAtBoard(t, board);
  await points(page, 8);
  await connect(page);
  await play(page);
  shim.cut = true;
  await page.locator("#board", { hasText: "connection lost" }).waitFor(); // after 32 tries, each as long as answers took until now
  shim.end();
  const now = await status(board);
  assert.equal(now.outputs, "off");
  assert.equal(now.watchdog_trips, 1);
});

test("a page that is out of sight turns the outputs off, and says so", { skip }, async (t) => {
  const board = await startBoard(t);
  const { page } = await openAtBoard(t, board);
  await points(page, 8);
  await connect(page);
  await play(page);
  await page.evaluate(() => {
    Object.defineProperty(document, "hidden", { configurable: true, get: () => true });
    document.dispatchEvent(new Event("visibilitychange"));
  });
  await page.locator("#banner", { hasText: "out of sight" }).waitFor();
  await boardSays(page, "outputs off");
});

test("a page whose script hangs turns nothing on for longer than the board's watchdog lets it", { skip }, async (t) => {
  const board = await startBoard(t);
  const { page } = await openAtBoard(t, board);
  await points(page, 8);
  await connect(page);
  await play(page);
  await page.evaluate(() => {
    for (const end = performance.now() + 3000; performance.now() < end; );
  });
  await boardSays(page, "outputs off");
});

test("a cable that is pulled, a board that is not chosen, and another that is", { skip }, async (t) => {
  const board = await startBoard(t);
  const { page, shim } = await openAtBoard(t, board);
  await points(page, 8);
  await page.evaluate(() => (window.shimRefuses = true));
  await page.locator("button.play").click();
  await page.locator(".failed", { hasText: "No board was chosen." }).waitFor();
  await page.evaluate(() => (window.shimRefuses = false));
  await connect(page);
  shim.end();
  await page.locator("#board", { hasText: "connection lost" }).waitFor();
  assert.match(await panel(page, "Board").innerText(), /was its cable pulled/);
  assert.ok((await accessible(page)) > 10);
  await page.getByRole("button", { name: "Disconnect" }).click();
  await connect(page);
  await play(page);
  await page.keyboard.press("Escape");
  await boardSays(page, "outputs off");
});
