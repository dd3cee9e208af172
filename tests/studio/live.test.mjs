// SPDX-License-Identifier: Apache-2.0
// Live sessions in the page: a recorded hand, or one from a tracker's pipe, on the virtual board, and all that ends them.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { openSync, readdirSync, readFileSync, writeSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { accessible, boardSays, drop, eventually, folder, keptPicture, openDesign, openPage, panel, picture, quantile, settled, sleep, startBrowser, startStudio } from "./support.mjs";

/** The live sessions whose parent is this server. */
const sessions = (studio) =>
  readdirSync("/proc").filter((name) => {
    try {
      return /^\d+$/.test(name) && readFileSync(`/proc/${name}/cmdline`, "latin1").includes("\0live\0--scene=-\0") && Number(readFileSync(`/proc/${name}/stat`, "latin1").split(") ")[1].split(" ")[1]) === studio.child.pid;
    } catch {
      return false; // it has ended
    }
  });

/** A page with a ball that a hand touches, and what it receives of live sessions. */
async function touching(t, options = {}) {
  const studio = await startStudio(t);
  const scenes = [];
  const before = async (page) =>
    page.on("websocket", (socket) =>
      socket.on("framereceived", ({ payload }) => {
        const message = typeof payload === "string" && payload.startsWith('{"t":"live"') ? JSON.parse(payload).shown : {};
        if (message.scene) scenes.push(message);
      }),
    );
  const page = await openPage(t, await startBrowser(t), studio, { ...options, before });
  await openDesign(page, "Touched ball");
  await page.locator("footer", { hasText: "100 focal points for" }).waitFor();
  await settled(page);
  await page.locator("[data-step=Play]").click();
  return { studio, page, scenes };
}

const begin = (page) => page.getByRole("button", { name: /^Feel it/ }).click();
const runs = (page) => page.getByText("Outputs are on.").waitFor();
/** Waits for the end of a session that turned the outputs off by itself. */
async function over(page) {
  const live = panel(page, "Live hand");
  await live.getByText(/The session (is over|was cut off|ended)/).waitFor();
  assert.match(await live.innerText(), /The session is over/, await live.innerText());
}
const row = (page, name) => panel(page, "Live hand").getByRole("row", { name }).getByRole("cell").first().innerText();

test("a recorded hand feels a ball on the virtual board, which is drawn as it comes, and its board comes back", async (t) => {
  const { studio, page, scenes } = await touching(t);
  await accessible(page);
  await page.locator(".play.wide").scrollIntoViewIfNeeded();
  await keptPicture(page, "live-begin-light");
  await begin(page);
  await runs(page);
  await boardSays(page, "lent to the live session");
  await eventually(async () => Number(await row(page, "Foci in turn")) > 0);
  await panel(page, "Live hand").getByText("In the view: a hand, sphere of 100 mm at (0, 0, 200)").waitFor();
  await accessible(page);
  await picture(page, "live-light");
  await over(page);
  await boardSays(page, "outputs off");
  await eventually(() => sessions(studio).length === 0);
  assert.ok(scenes.length >= 5, `${scenes.length} scenes`);
  for (const each of scenes) assert.equal(each.hands.length, 1);
  const felt = scenes.filter(({ foci }) => foci.length > 0);
  assert.ok(felt.length >= 5, `${felt.length} of ${scenes.length} scenes have foci`);
  // A ball of 100 mm around (0, 0, 200): what is felt lies on the skin where that is within it.
  for (const { foci } of felt) for (const [x, y, z] of foci) assert.ok(Math.hypot(x, y, z - 200) < 75, `a focus at ${[x, y, z]}`);
  const late = scenes.flatMap(({ latency_ms: ms }) => (ms === null ? [] : [ms]));
  t.diagnostic(`${scenes.length} scenes, ${felt.length} with foci; latency ${quantile(late, 0.5).toFixed(1)} ms in the median, ${Math.max(...late).toFixed(1)} at most`);
  assert.ok(late.length > 0 && late.every((ms) => ms > 0));
  // What the session said at its end, as in a terminal.
  assert.match(await panel(page, "Live hand").locator(".notes").textContent(), /shots +\d+/);
  await page.getByRole("button", { name: "Upload" }).click();
  await page.getByText("pieces had to be written").waitFor();
  // At less than full strength a session is refused; while one runs there is no intensity to choose. Then a second one.
  const intensity = page.getByLabel("Intensity", { exact: true });
  await intensity.fill("30");
  await page.locator(".unit", { hasText: /^30 %$/ }).waitFor();
  await page.getByRole("button", { name: "Feel it again" }).click();
  await page.locator(".failed", { hasText: "plays at full strength" }).waitFor();
  await boardSays(page, "outputs off");
  await intensity.fill("100");
  await page.locator(".unit", { hasText: /^100 %$/ }).waitFor();
  const before = scenes.length;
  await begin(page);
  await runs(page);
  await boardSays(page, "lent to the live session");
  assert.equal(await intensity.count(), 0);
  await over(page);
  assert.ok(scenes.length >= before + 5, `${scenes.length - before} scenes of the second session`);
  await boardSays(page, "outputs off");
  await eventually(() => sessions(studio).length === 0);
});

test("the project's table [live] holds, and a design without a hand says what is missing", async (t) => {
  const { page, scenes } = await touching(t);
  await page.locator("[data-step=Make]").click();
  await openDesign(page, "Dome");
  await page.locator("[data-step=Play]").click();
  await panel(page, "Live hand").getByText("This design has no hand, and a live session needs one").waitFor();
  const project = 'format = "haptogram-project-1"\n[hand]\nrecording = "synthetic:press"\nframe = 30\n[live]\nseconds = 1\nport = "/dev/nowhere"\n';
  await drop(page, [{ name: "short.toml", bytes: Buffer.from(project) }]);
  await page.locator("footer", { hasText: "short: " }).waitFor();
  await settled(page);
  await begin(page);
  await over(page);
  assert.match(await panel(page, "Live hand").locator(".notes").textContent(), /does not take: port/);
  const last = Math.max(...scenes.map(({ time_s }) => time_s));
  assert.ok(last <= 1.1, `a scene at ${last} s`);
});

test("STOP, and a page that goes away, end a session at once", async (t) => {
  const { studio, page, scenes } = await touching(t, { colorScheme: "dark" });
  await begin(page);
  await runs(page);
  await page.keyboard.press("Escape");
  await over(page);
  await boardSays(page, "outputs off");
  assert.equal(sessions(studio).length, 0);
  // One that is still being prepared must not begin behind it, and one that has just begun must end before anything of it plays.
  await page.getByRole("button", { name: /^Feel it/ }).click({ trial: true }); // until the board is back
  const drawn = scenes.length;
  await page.evaluate(() => {
    const press = (words) => [...document.querySelectorAll("button")].find((button) => words.test(button.textContent)).click();
    press(/^Feel it/);
    document.getElementById("stop").click();
  });
  await sleep(500);
  await page.getByRole("button", { name: /^Feel it/ }).click({ trial: true });
  await eventually(() => sessions(studio).length === 0);
  await page.getByText(/STOP was pressed before it began|The session is over/).first().waitFor();
  await boardSays(page, "outputs off");
  assert.equal(scenes.length, drawn);
  await begin(page);
  await runs(page);
  await eventually(async () => Number(await row(page, "Foci in turn")) > 0);
  await accessible(page);
  await picture(page, "live-dark");
  assert.equal(sessions(studio).length, 1);
  await page.close();
  await eventually(() => sessions(studio).length === 0);
});

test("a session that is killed leaves outputs of which nobody knows, until its board says", async (t) => {
  const { studio, page } = await touching(t);
  await begin(page);
  await runs(page);
  await boardSays(page, "outputs ON");
  await page.evaluate(() => {
    const board = document.getElementById("board");
    window.said = [];
    new MutationObserver(() => window.said.push(`${board.textContent} ${board.className}`)).observe(board, { childList: true, characterData: true, subtree: true });
  });
  process.kill(Number(sessions(studio)[0]), "SIGKILL");
  await page.getByText("The session was cut off").waitFor();
  await boardSays(page, "outputs off");
  const said = await page.evaluate(() => window.said);
  t.diagnostic(said.join("; "));
  assert.match(said[0], /outputs unknown/);
  assert.doesNotMatch(await page.title(), /Outputs/);
});

test("a tracker's pipe is felt as its lines come; what is none is refused", async (t) => {
  const where = await folder(t);
  const { page, scenes } = await touching(t);
  const pipe = join(where, "hands");
  await page.getByLabel("Hand from").selectOption("pipe");
  await page.getByLabel("Pipe").fill(pipe);
  await page.getByRole("button", { name: "Feel it live" }).click();
  await page.getByText("is no named pipe").waitFor();
  execFileSync("mkfifo", [pipe]);
  const tracker = openSync(pipe, "r+"); // whoever opens it first would wait for the other
  await begin(page);
  await boardSays(page, "lent to the live session");
  // A Leap's frame: millimetres above the tracker, y up.
  const line = (id, height) =>
    `${JSON.stringify({ id, timestamp: id * 20_000, hands: [{ id: 1, type: "right", palmPosition: [0, height, 0], palmNormal: [0, -1, 0], direction: [0, 0, -1], palmWidth: 80 }], pointables: [] })}\n`;
  let id = 0;
  const sending = setInterval(() => writeSync(tracker, line(++id, 200)), 20);
  t.after(() => clearInterval(sending));
  await eventually(() => scenes.length > 3, async () => (await panel(page, "Live hand").innerText()));
  await page.getByRole("button", { name: "Stop the live session" }).click();
  await over(page);
});
