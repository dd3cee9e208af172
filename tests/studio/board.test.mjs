// SPDX-License-Identifier: Apache-2.0
// Playing on the simulated board, and everything that must turn its outputs off.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { accessible, boardSays, folder, openPage, picture, quantile, run, settled, sleep, start, startBrowser, startStudio } from "./support.mjs";

/** A document that is soon uploaded: the simulated line is as slow as a real one, and the simulation slower. */
async function small(page) {
  await page.getByLabel("Focal points", { exact: true }).fill("8");
  await page.getByLabel("Focal points", { exact: true }).press("Enter");
  await page.locator("footer", { hasText: "8 focal points" }).waitFor();
  await settled(page);
}

/** A board of its own, whose pins are written down, and a page that is connected to it. */
async function withBoard(t, studio) {
  const where = await folder(t);
  const pulses = join(where, "pulses.csv");
  const board = await start(t, "board", "run", "--json", "--pty", join(where, "port"), "--pulses", pulses);
  const browser = await startBrowser(t);
  const page = await openPage(t, browser, studio, { mayFail: true });
  await settled(page);
  await small(page);
  await page.getByLabel("Port", { exact: true }).fill(board.first.port);
  await page.getByRole("button", { name: "Connect" }).click();
  await boardSays(page, "outputs off");
  return { board, browser, page, pulses };
}

async function play(page) {
  await page.getByRole("button", { name: "Play" }).click();
  await boardSays(page, "outputs ON");
}

/** What the board itself says, asked by another program. */
async function status(board) {
  return JSON.parse(await run("device", "status", "--json", "--port", board.first.port));
}

/**
 * Waits until the board has turned its outputs off; then ends it and looks at its pins. Each question is a sign of life for the
 * board's watchdog, whose half second of board time takes the simulation much longer: hence the growing pauses.
 */
async function endsSilent(board, pulses, pause = 500) {
  for (; ; pause *= 2) {
    await sleep(pause);
    const now = await status(board).catch(() => undefined); // while another host has the port
    if (now?.outputs === "off") break;
    assert.ok(pause < 60_000, "the outputs stayed on");
  }
  board.child.kill("SIGINT");
  const { value } = await board.lines.next();
  assert.equal(JSON.parse(value).enabled, false);
  await board.ended;
  const rows = readFileSync(pulses, "utf8").trim().split("\n").slice(1);
  assert.ok(rows.length > 100, "it had played");
}

test("the intensity, while it plays: shorter pulses at the pins", async (t) => {
  const studio = await startStudio(t);
  const { board, page, pulses } = await withBoard(t, studio);
  await play(page);
  await page.getByText(/Playing for [1-9]/).waitFor();
  const intensity = page.getByLabel("Intensity", { exact: true });
  assert.equal(await intensity.inputValue(), "100");
  await intensity.fill("30");
  await page.locator(".unit", { hasText: /^30 %$/ }).waitFor();
  await sleep(4000);
  await page.getByRole("button", { name: "STOP" }).click();
  await boardSays(page, "outputs off");
  await page.getByRole("button", { name: "Disconnect" }).click(); // so that another program can ask the board
  await endsSilent(board, pulses);
  const counts = new Map();
  for (const row of readFileSync(pulses, "utf8").trim().split("\n").slice(1)) {
    const [, rise, fall] = row.split(",").map(Number);
    counts.set(fall - rise, (counts.get(fall - rise) ?? 0) + 1);
  }
  const most = [...counts].filter(([, count]) => count > 1000).map(([length]) => length).sort((a, b) => a - b);
  t.diagnostic(`pulses by their length in clocks: ${[...counts].map((each) => each.join(": ")).join(", ")}`);
  assert.equal(most.length, 2, "pulses of full strength, and of 30 %");
  const drive = (length) => Math.sin((Math.PI * length) / 1250);
  const ratio = drive(most[0]) / drive(most[1]);
  assert.ok(Math.abs(ratio - 0.3) < 0.02, `the carrier of the short pulses is ${ratio} of the others'`);
});

test("two clicks to a playing virtual board, and STOP", async (t) => {
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t), studio);
  await settled(page);
  await small(page);
  await page.getByRole("button", { name: "Start a virtual board" }).click();
  await boardSays(page, "virtual board, outputs off");
  await page.getByRole("button", { name: "Upload" }).click();
  await page.getByText(/Uploaded: \d+ of \d+ pieces/).waitFor();
  const begun = performance.now();
  await page.getByRole("button", { name: "Play" }).click();
  await boardSays(page, "outputs ON");
  t.diagnostic(`from Play to outputs on: ${(performance.now() - begun).toFixed(0)} ms`);
  await page.getByText(/Playing for/).waitFor();
  await accessible(page);
  await picture(page, "playing-light");
  await page.getByRole("button", { name: "Theme" }).click();
  await picture(page, "playing-dark");
  await page.getByRole("button", { name: "STOP" }).click();
  await boardSays(page, "outputs off");
  await page.getByText("Stopped.").waitFor();
  // Nothing of before turns them on again.
  await sleep(1000);
  assert.match(await page.locator("#board").innerText(), /outputs off/);
  await page.getByRole("button", { name: "Play" }).click();
  await boardSays(page, "outputs ON");
  await page.keyboard.press("Escape");
  await boardSays(page, "outputs off");
  await page.getByRole("button", { name: "Disconnect" }).click();
  await boardSays(page, "No board");
});

test("a modulated scene for a board that computes foci, on a virtual board that is one", async (t) => {
  const project = join(await folder(t), "ring.toml");
  writeFileSync(project, 'format = "haptogram-project-1"\narray = "tile-10x10"\nboard = "tile-100-wide"\nam = "sine:200"\npoints = 8\n[[shape]]\nkind = "circle"\n');
  const studio = await startStudio(t, project);
  const page = await openPage(t, await startBrowser(t), studio);
  await settled(page);
  await page.getByRole("button", { name: "Start a virtual board" }).click();
  await boardSays(page, "virtual board, outputs off");
  await page.getByRole("button", { name: "Upload" }).click();
  await page.getByText(/Uploaded: \d+ of \d+ pieces/).waitFor();
  await page.getByRole("button", { name: "Play" }).click();
  await page.getByText(/Playing for [1-9]/).waitFor();
  await page.getByLabel("Intensity", { exact: true }).fill("40");
  await page.locator(".unit", { hasText: /^40 %$/ }).waitFor();
  // Another waveform is played without a pause; another shape is not.
  await page.getByLabel("Modulation", { exact: true }).selectOption("square:200");
  await settled(page);
  await page.getByRole("button", { name: "Modulate as shown" }).click();
  await page.getByRole("button", { name: "Modulate as shown" }).waitFor({ state: "detached" });
  await page.getByLabel("Focal points", { exact: true }).fill("9");
  await page.getByLabel("Focal points", { exact: true }).press("Enter");
  await settled(page);
  await page.getByRole("button", { name: "Modulate as shown" }).click();
  await page.getByText(/differs from the one that plays in more than its modulation/).first().waitFor();
  await sleep(1000);
  assert.match(await page.locator("#board").innerText(), /Outputs ON, not as shown/);
  await page.getByRole("button", { name: "STOP" }).click();
  await boardSays(page, "outputs off");
});

test("some passes, and the board is silent by itself", async (t) => {
  const { page, board, pulses } = await withBoard(t, await startStudio(t));
  await page.getByLabel("Passes in all", { exact: true }).fill("2");
  await page.getByLabel("Passes in all", { exact: true }).press("Enter");
  await page.getByLabel("Passes a second", { exact: true }).fill("100");
  await page.getByLabel("Passes a second", { exact: true }).press("Enter");
  await settled(page);
  await page.getByRole("button", { name: "Upload" }).click();
  await page.getByText(/Uploaded: \d+ of \d+ pieces/).waitFor();
  await page.getByRole("button", { name: "Play" }).click();
  await page.getByText("Played to its end.").waitFor();
  await boardSays(page, "outputs off");
  await page.getByRole("button", { name: "Disconnect" }).click();
  await endsSilent(board, pulses);
});

test("STOP is confirmed by the board while slices are computed", async (t) => {
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t), studio);
  await settled(page);
  await small(page);
  await page.getByRole("button", { name: "Start a virtual board" }).click();
  await boardSays(page, "outputs off");
  const took = [];
  for (let i = 0; i < 5; i++) {
    await play(page);
    took.push(
      await page.evaluate(async () => {
        const slider = document.querySelector("aside input[type=range]");
        const moving = setInterval(() => {
          slider.value = String(100 + 100 * Math.random());
          slider.dispatchEvent(new Event("input", { bubbles: true }));
        }, 10);
        await new Promise((done) => setTimeout(done, 300));
        const begun = performance.now();
        document.getElementById("stop").click();
        await new Promise((done) => {
          const look = new MutationObserver(() => {
            if (!document.getElementById("board").textContent.includes("outputs off")) return;
            look.disconnect();
            done();
          });
          look.observe(document.getElementById("board"), { subtree: true, childList: true, characterData: true });
        });
        clearInterval(moving);
        return performance.now() - begun;
      }),
    );
  }
  t.diagnostic(`STOP to the board's own word: median ${quantile(took, 0.5).toFixed(0)}, worst ${Math.max(...took).toFixed(0)} ms, on a simulated line`);
  assert.ok(Math.max(...took) < 10_000);
});

test("the line is cut while it plays: nobody knows of the outputs", async (t) => {
  const { board, page } = await withBoard(t, await startStudio(t));
  const place = await page.locator("#stop").boundingBox();
  await play(page);
  board.child.kill("SIGKILL");
  await boardSays(page, "connection lost, outputs unknown");
  await page.locator("#board.unknown").waitFor();
  assert.equal(await page.locator("#board.on").count(), 0);
  assert.match(await page.title(), /Outputs unknown/);
  await picture(page, "cut-light");
  assert.deepEqual(await page.locator("#stop").boundingBox(), place, "STOP stays in its place");
  await page.locator("#stop").click();
  await page.locator("#banner", { hasText: /STOP.*not.*confirmed/ }).waitFor();
  await page.getByRole("button", { name: "Disconnect" }).click();
  await boardSays(page, "No board");
});

test("the page is closed: outputs off", async (t) => {
  const studio = await startStudio(t);
  const { board, page, pulses } = await withBoard(t, studio);
  await play(page);
  await page.close();
  await sleep(100);
  // The studio still has the port; another page sees what the board says, and lets it go.
  const other = await openPage(t, await startBrowser(t), studio, { mayFail: true });
  await boardSays(other, "outputs off");
  await other.getByRole("button", { name: "Disconnect" }).click();
  await endsSilent(board, pulses);
});

test("the server is killed: the board's watchdog turns the outputs off", async (t) => {
  const studio = await startStudio(t);
  const { board, page, pulses } = await withBoard(t, studio);
  await play(page);
  studio.child.kill("SIGKILL");
  await page.locator("#banner", { hasText: "watchdog" }).waitFor();
  await studio.ended;
  await endsSilent(board, pulses, 4000);
});

test("Ctrl-C while it plays: outputs off, then the end", async (t) => {
  const studio = await startStudio(t);
  const { board, page, pulses } = await withBoard(t, studio);
  await play(page);
  studio.child.kill("SIGINT");
  assert.equal((await studio.ended).code, 0);
  assert.equal((await status(board)).outputs, "off");
  await endsSilent(board, pulses);
});

test("the page hangs: outputs off", async (t) => {
  const studio = await startStudio(t);
  const { board, browser, page, pulses } = await withBoard(t, studio);
  const watcher = await openPage(t, browser, studio);
  await play(page);
  await boardSays(watcher, "outputs ON");
  await page.evaluate(() => {
    const until = performance.now() + 4000;
    while (performance.now() < until);
  });
  await watcher.locator("#banner", { hasText: "was silent" }).waitFor();
  await boardSays(watcher, "outputs off");
  await watcher.getByRole("button", { name: "Disconnect" }).click();
  await endsSilent(board, pulses);
});

test("the page is hidden for ten seconds: outputs off", async (t) => {
  const studio = await startStudio(t);
  const { board, page, pulses } = await withBoard(t, studio);
  await play(page);
  await page.evaluate(() => {
    Object.defineProperty(document, "hidden", { get: () => true });
    document.dispatchEvent(new Event("visibilitychange"));
  });
  const begun = performance.now();
  await page.locator("#banner", { hasText: "out of sight" }).waitFor();
  assert.ok(performance.now() - begun > 9000);
  await boardSays(page, "outputs off");
  await page.getByRole("button", { name: "Disconnect" }).click();
  await endsSilent(board, pulses);
});

test("one page plays, another stops, and cannot play meanwhile", async (t) => {
  const studio = await startStudio(t);
  const { board, browser, page, pulses } = await withBoard(t, studio);
  const watcher = await openPage(t, browser, studio);
  await settled(watcher);
  await play(page);
  await boardSays(watcher, "outputs ON");
  await watcher.getByRole("button", { name: "STOP" }).click();
  await boardSays(watcher, "outputs off");
  await boardSays(page, "outputs off");
  await watcher.getByRole("button", { name: "Disconnect" }).click();
  await endsSilent(board, pulses);
});

test("a port where no board is, and one that does not exist, are said", async (t) => {
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t), studio);
  await settled(page);
  await page.getByLabel("Port", { exact: true }).fill("/dev/there-is-none");
  await page.getByRole("button", { name: "Connect" }).click();
  await page.locator(".warning", { hasText: "/dev/there-is-none" }).waitFor();
  await page.getByRole("button", { name: "STOP" }).click();
  await page.getByRole("button", { name: "Disconnect" }).click();
  await boardSays(page, "No board");
});
