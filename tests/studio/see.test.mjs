// SPDX-License-Identifier: Apache-2.0
// Seeing what is played: the timeline, findings, profiles, comparison, several objects, and the pins.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { accessible, boardSays, coloursSeen, eventually, folder, hasValue, keptPicture, lookedAt, openPage, panel, picture, run, settled, startBrowser, startStudio, takeAway } from "./support.mjs";

const field = (page, label) => page.getByLabel(label, { exact: true });
async function fill(page, label, value) {
  await field(page, label).fill(String(value));
  await field(page, label).press("Enter");
}

/** A page with a project of its own, and its text as a file. */
async function openProject(t, text, settings) {
  const where = await folder(t);
  const project = join(where, "project.toml");
  writeFileSync(project, `format = "haptogram-project-1"\n${text}`);
  const page = await openPage(t, await startBrowser(t), await startStudio(t, project), settings);
  await settled(page);
  return { page, where, project };
}

const ring = 'points = 8\nrate_hz = 20\n[[shape]]\nkind = "circle"\ndiameter_mm = 40\n';

for (const colorScheme of ["light", "dark"])
  test(`the timeline: marked points, their phases and their field, ${colorScheme}`, async (t) => {
    const { page, where, project } = await openProject(t, ring, { colorScheme });
    await lookedAt(page);
    const scrubber = page.locator(".scrubber");
    // A place of the lane is a time, and so a focal point: the middle of the third of eight.
    const lane = await page.locator(".lane").boundingBox();
    await page.mouse.click(lane.x + (2.5 / 8) * lane.width, lane.y + lane.height / 2);
    await scrubber.getByText("3 of 8").waitFor();
    await scrubber.getByText("12.5 to 18.8 ms of 50 ms").waitFor();
    await scrubber.getByText("phase 0°").waitFor();
    await scrubber.getByText(/Pa, .* mm wide, .* mN/).waitFor();
    await page.locator(".mark-here").waitFor();
    await accessible(page);
    await picture(page, `timeline-${colorScheme}`);
    await field(page, "Focal point").press("End");
    await scrubber.getByText("8 of 8").waitFor();
    await field(page, "Zoom").selectOption("4");
    const box = await page.locator(".mark-here").boundingBox();
    assert.ok(Math.abs(box.width / lane.width - 0.5) < 0.05, `an eighth of the pass is half of a quarter: ${box.width} of ${lane.width}`);
    // The field of that point alone is what the command line computes of its record.
    await field(page, "Only the marked point").check();
    await settled(page);
    await fill(page, "Step", 4);
    const command = await page.locator("pre.command").innerText();
    assert.match(command, /field image\.hex --record 8 /);
    const csv = await takeAway(page, "Field (.csv)");
    await run("compile", project, "-o", join(where, "image.hex"));
    await run(...command.split("\n").at(-1).replace("haptogram ", "").replaceAll("image.hex", join(where, "image.hex")).replace("field.png", join(where, "field.csv")).split(" "));
    assert.deepEqual(csv, readFileSync(join(where, "field.csv")));
  });

test("what one focus could have is what the command line maps", async (t) => {
  const { page, where } = await openProject(t, ring);
  await field(page, "Shown").selectOption("rms");
  await field(page, "Plane").selectOption("xz");
  await settled(page);
  const middle = async () => Number((await panel(page, "Numbers").innerText()).match(/At the plane's middle\s+([\d.,]+)/)[1].replaceAll(",", ""));
  const played = await middle();
  await field(page, "What one focus could have at each point").check();
  await page.getByText("The array's workspace").waitFor();
  await settled(page);
  await accessible(page);
  await picture(page, "workspace");
  const at = await field(page, "Middle z").inputValue();
  await run("analyze", "--array", "tile-10x10", "--plane", `xy@z=${at}`, "--extent", 4, "--step", 2, "-o", join(where, "map.csv"));
  const rows = readFileSync(join(where, "map.csv"), "utf8").trim().split("\n").filter((line) => /^[-\d]/.test(line)).map((line) => line.split(",").map(Number));
  const [, , amplitude] = rows.find(([x, y]) => x === 0 && y === 0);
  const found = await middle();
  assert.ok(Math.abs(found / (amplitude / Math.SQRT2) - 1) < 0.01, `${found} Pa rms, and a pressure of ${amplitude} Pa`);
  await field(page, "What one focus could have at each point").uncheck();
  await settled(page);
  await eventually(async () => (await middle()) === played);
});

test("the field on the skin of a hand is that of the plane in which its palm lies", async (t) => {
  const { page } = await openProject(t, 'points = 40\nrate_hz = 10\n[[shape]]\nkind = "circle"\ndiameter_mm = 40\n');
  await lookedAt(page);
  await field(page, "Keep this scale").check();
  // On the palm, beside the focal points and the tour, which have colours of their own.
  const places = [[-14, 4], [12, 3], [27, 2], [-27, 6], [3, -28], [-8, -12], [-36, -8], [34, -30]];
  const colours = async () => {
    const at = await coloursSeen(page);
    return places.map(([x, y]) => at([x, y, 130])[0]);
  };
  const difference = (a, b) => Math.max(...a.map((colour, i) => Math.max(...colour.map((each, k) => Math.abs(each - b[i][k])))));
  const plane = await colours();
  assert.ok(difference(plane, plane.map(() => plane[0])) > 60, "the places differ");
  await fill(page, "Middle z", 40);
  await settled(page);
  assert.ok(difference(plane, await colours()) > 60, "another plane has another field");
  await field(page, "On the skin of a hand, too").check();
  await eventually(async () => difference(plane, await colours()) < 45, async () => JSON.stringify([plane, await colours()]));
  assert.equal(await page.getByRole("button", { name: "Hand for scale" }).getAttribute("aria-pressed"), "true");
  await accessible(page);
  await keptPicture(page, "skin");
  // It goes with the object, and with the hand.
  await fill(page, "Centre z", 150);
  await settled(page);
  await eventually(async () => difference(plane, await colours()) > 60);
  await fill(page, "Centre z", 130);
  await eventually(async () => difference(plane, await colours()) < 45);
  await page.getByRole("button", { name: "Hand for scale" }).click();
  await eventually(async () => difference(plane, await colours()) > 60);
});

test("the timeline runs in slow motion, and a mark holds it", async (t) => {
  const { page } = await openProject(t, ring);
  await field(page, "Time").selectOption("10");
  await page.getByRole("button", { name: "Run" }).click();
  const seen = new Set();
  await eventually(async () => {
    seen.add((await page.locator(".scrubber output").innerText()).split(" ")[0]);
    return seen.size >= 4;
  }, () => `only ${[...seen]}`);
  await field(page, "Focal point").press("Home");
  await page.getByRole("button", { name: "Run" }).waitFor();
  await page.locator(".scrubber").getByText("1 of 8").waitFor();
  // Who wants little motion sees four steps a second at most, and nothing that turns.
  await page.emulateMedia({ reducedMotion: "reduce" });
  await page.evaluate(() => {
    window.steps = 0;
    new MutationObserver(() => window.steps++).observe(document.querySelector(".scrubber output"), { childList: true, characterData: true, subtree: true });
  });
  await page.getByRole("button", { name: "Run" }).click();
  const [begun, before] = [performance.now(), await page.evaluate(() => window.steps)];
  await page.waitForTimeout(2000);
  const [steps, seconds] = [(await page.evaluate(() => window.steps)) - before, (performance.now() - begun) / 1000];
  assert.ok(steps >= 2 && steps <= 4 * seconds + 2, `${steps} steps in ${seconds} s`);
  await fill(page, "Focal points", 9);
  assert.deepEqual(await page.evaluate(() => document.getAnimations().length), 0);
});

test("a running timeline moves the focus on the board", async (t) => {
  const { page } = await openProject(t, ring);
  await page.getByRole("button", { name: "Start a virtual board" }).click();
  await boardSays(page, "outputs off");
  await field(page, "Focal point").press("End");
  await page.getByRole("button", { name: "Follow the slider" }).click();
  await boardSays(page, "outputs ON, one point");
  await field(page, "Time").selectOption("100");
  await page.getByRole("button", { name: "Run" }).click();
  const seen = new Set();
  await eventually(async () => {
    const text = await panel(page, "Board").innerText();
    seen.add(text.match(/plays record (\d+)/)?.[1]);
    return seen.size >= 4;
  }, () => `the board played ${[...seen]}`);
  await page.keyboard.press("Escape");
  await boardSays(page, "outputs off");
});

for (const colorScheme of ["light", "dark"])
  test(`findings are shown where they are, and mended by an edit that undo takes back, ${colorScheme}`, async (t) => {
    const { page } = await openProject(t, 'points = 100\nrate_hz = 100\n[[shape]]\nkind = "circle"\n', { colorScheme });
    await lookedAt(page);
    const finding = page.locator('[data-kind="short-dwell"]');
    assert.match(await finding.innerText(), /a point lasts 100\.0 µs/);
    await finding.getByRole("button", { name: "Show" }).click();
    await page.locator(".scrubber").getByText("of 100:").waitFor();
    await settled(page);
    await accessible(page);
    await keptPicture(page, `findings-${colorScheme}`);
    await finding.getByRole("button", { name: /^Take \d+ points/ }).click();
    await finding.waitFor({ state: "detached" });
    await settled(page);
    assert.ok(Number(await field(page, "Focal points").inputValue()) < 100);
    await page.getByRole("button", { name: "Undo" }).click();
    await hasValue(field(page, "Focal points"), "100");
    await finding.waitFor();
  });

test("a shape out of reach is mended by leaving out what is", async (t) => {
  const { page } = await openProject(t, 'points = 40\nrate_hz = 10\n[[shape]]\nkind = "line"\nlength_mm = 100\n');
  await fill(page, "Size", 900);
  await page.locator(".failed", { hasText: "out of reach" }).waitFor();
  await page.getByRole("button", { name: "Leave out what is out of reach" }).click();
  await page.locator(".failed").waitFor({ state: "detached" });
  await page.locator('[data-kind="out-of-reach"]').waitFor();
  assert.match(String(await takeAway(page, "Project")), /clip = true/);
});

for (const colorScheme of ["light", "dark"])
  test(`a profile, and two scenes compared, ${colorScheme}`, async (t) => {
    const { page, where, project } = await openProject(t, ring, { colorScheme });
    await field(page, "Shown").selectOption("rms");
    await fill(page, "Middle x", 4);
    const profile = panel(page, "Profile");
    await profile.getByText("Through x, 0.0, 130.0 mm").waitFor();
    const waiting = page.waitForEvent("download");
    await profile.getByRole("button", { name: "Profile" }).click();
    const rows = readFileSync(await (await waiting).path(), "utf8").trim().split("\n").slice(1).map((row) => row.split(",").map(Number));
    assert.equal(rows.length, 401);
    await run("field", project, "--line", "x@y=0,z=130", "--x=-76:84", "--step", 0.4, "--quantity", "rms", "-o", join(where, "line.csv"));
    const expected = readFileSync(join(where, "line.csv"), "utf8").trim().split("\n").filter((row) => /^[-\d]/.test(row)).map((row) => Number(row.split(",").at(-1)) ** 2);
    assert.equal(expected.length, 401);
    const peak = Math.max(...expected);
    assert.ok(Math.max(...rows.map((row, i) => Math.abs(row[3] - expected[i]))) <= 1e-5 * peak);

    await page.getByRole("button", { name: "Keep this to compare" }).click();
    await fill(page, "Focal points", 12);
    await page.locator("footer", { hasText: "12 focal points" }).waitFor();
    await settled(page);
    const compare = panel(page, "Compare");
    assert.match((await compare.locator("tr", { hasText: "Focal points" }).innerText()).replace(/\s+/g, " "), /8 12/);
    await page.locator(".curve.kept").waitFor();
    await accessible(page);
    await picture(page, `compare-${colorScheme}`);
    const now = await panel(page, "Numbers").locator("tr", { hasText: "Greatest on the plane" }).innerText();
    await compare.getByLabel("Show the kept one").check();
    await eventually(async () => (await panel(page, "Numbers").locator("tr", { hasText: "Greatest on the plane" }).innerText()) !== now);
    await compare.getByRole("button", { name: "Go back to it" }).click();
    await page.locator("footer", { hasText: "8 focal points" }).waitFor();
    await compare.getByRole("button", { name: "Forget it" }).click();
    await page.locator(".curve.kept").waitFor({ state: "detached" });
  });

test("the kept scene is sent again to a server that has dropped it", async (t) => {
  const { page } = await openProject(t, ring);
  await page.getByRole("button", { name: "Keep this to compare" }).click();
  const many = async () => { // more scenes than a server keeps, from a connection of the test's own
    for (let points = 20; points < 40; points++)
      await page.evaluate(
        (points) => new Promise((done) => {
          const socket = new WebSocket(`ws://${location.host}/ws`, ["haptogram.1", `token.${sessionStorage.getItem("token")}`]);
          socket.onopen = () => socket.send(JSON.stringify({ t: "scene", n: 1, document: { format: "haptogram-project-1", points, rate_hz: 50, shape: [{ kind: "circle" }] } }));
          socket.onmessage = ({ data }) => {
            if (typeof data !== "string" || JSON.parse(data).t !== "scene") return;
            socket.close();
            done();
          };
        }),
        points,
      );
  };
  await fill(page, "Focal points", 12);
  await page.locator("footer", { hasText: "12 focal points" }).waitFor();
  await settled(page);
  await many();
  await panel(page, "Compare").getByLabel("Show the kept one").check();
  await settled(page);
  await page.locator(".curve.kept").waitFor();
});

for (const colorScheme of ["light", "dark"])
  test(`several objects, each at its own place, ${colorScheme}`, async (t) => {
    const { page, where } = await openProject(t, 'points = 40\nrate_hz = 20\n[place]\ncenter_mm = [-20, 0, 130]\n[[shape]]\nkind = "circle"\ndiameter_mm = 20\n', { colorScheme });
    await page.getByRole("button", { name: "+ Add an object" }).click();
    await hasValue(field(page, "Of several"), "1");
    await field(page, "Shape").selectOption("square");
    await fill(page, "Size", 20);
    await fill(page, "Centre x", 25);
    await fill(page, "Centre z", 140);
    await settled(page);
    await accessible(page);
    await picture(page, `objects-${colorScheme}`);
    await field(page, "Of several").selectOption("0");
    await hasValue(field(page, "Centre x"), "-20");
    await fill(page, "Centre y", 10);
    await settled(page);
    const project = join(where, "taken.toml");
    writeFileSync(project, await takeAway(page, "Project"));
    const text = readFileSync(project, "utf8");
    assert.doesNotMatch(text, /\[place\]/);
    assert.match(text, /center_mm = \[-20\.0, 10\.0, 130\.0\]/);
    assert.match(text, /center_mm = \[25\.0, 0\.0, 140\.0\]/);
    await run("compile", project, "-o", join(where, "image.hex"));
    assert.deepEqual(await takeAway(page, "Image"), readFileSync(join(where, "image.hex")));
    await page.getByRole("button", { name: "Remove this one" }).click();
    await settled(page);
    await hasValue(field(page, "Shape"), "square");
    await hasValue(field(page, "Centre x"), "25");
    await page.keyboard.press("Control+z");
    await field(page, "Of several").waitFor();
  });

for (const colorScheme of ["light", "dark"])
  test(`the pins of the Verilated core, ${colorScheme}`, async (t) => {
    // A short pass: the simulation is hundreds of times slower than the board on a crowded machine.
    const { page, where, project } = await openProject(t, ring.replace("rate_hz = 20", "rate_hz = 500"), { colorScheme });
    const pins = panel(page, "Pins");
    await pins.getByRole("button", { name: "Simulate" }).click();
    await pins.locator("[data-verdict=good]").waitFor();
    const told = (await pins.locator("[data-verdict]").innerText()).match(/([\d,]+) of ([\d,]+) pulses/);
    await run("simulate", project, "--load", "direct", "--pulses", join(where, "pulses.csv"));
    const pulses = readFileSync(join(where, "pulses.csv"), "utf8").trim().split("\n").slice(1).map((row) => row.split(",").map(Number));
    assert.equal(Number(told[2].replaceAll(",", "")), pulses.length);
    await field(page, "Focal point").press("ArrowRight");
    await page.locator(".scrubber").getByText("2 of 8").waitFor();
    // Two carrier periods from the first pulse of that record on, as the command line measured them.
    const first = Math.min(...pulses.filter((pulse) => pulse[3] === 2).map((pulse) => pulse[1]));
    const expected = pulses.filter((pulse) => pulse[1] >= first && pulse[1] < first + 2500).length;
    await pins.getByText(`for record 2: ${expected} pulses`).waitFor();
    await accessible(page);
    await keptPicture(page, `pins-${colorScheme}`);
    await fill(page, "Focal points", 9);
    await pins.getByText("of an older image").waitFor();
  });

test("a simulation can be stopped", async (t) => {
  const { page } = await openProject(t, 'points = 20\nrate_hz = 0.1\n[[shape]]\nkind = "circle"\n');
  const pins = panel(page, "Pins");
  await pins.getByRole("button", { name: "Simulate" }).click();
  await pins.getByRole("button", { name: "Stop simulating" }).click();
  await pins.getByRole("button", { name: "Simulate" }).waitFor();
  await fill(page, "Passes a second", 500);
  await settled(page);
  await pins.getByRole("button", { name: "Simulate" }).click();
  await pins.locator("[data-verdict=good]").waitFor();
  assert.equal(await page.locator(".failed").count(), 0);
});
