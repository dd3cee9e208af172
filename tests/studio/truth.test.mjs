// SPDX-License-Identifier: Apache-2.0
// What the page says holds: what is on the screen is what plays and is saved, the lamp tells of every output, a server that has gone is told
// of, and no work is lost.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { boardSays, drop, eventually, hasValue, lookedAt, openDesign, openPage, picture, settled, shapes, show, sleep, startBrowser, startStudio, takeAway } from "./support.mjs";

const play = (page) => page.locator("#playing button");

test("a design that fails neither plays nor is saved, and both say why", async (t) => {
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t), studio);
  await settled(page);
  const size = page.getByLabel("Size", { exact: true });
  const before = await size.inputValue();
  await size.fill("900");
  await size.press("Enter");
  await page.locator(".failed", { hasText: "out of reach" }).waitFor();
  assert.ok(await play(page).isDisabled());
  assert.match(await play(page).getAttribute("title"), /reach/);
  await page.locator(".failed").getByRole("button", { name: "Close" }).click();
  await page.locator("footer", { hasText: "cannot be made" }).waitFor();
  await page.locator("#view[aria-busy=false]").waitFor();
  await picture(page, "fails-light");
  for (const name of ["Image", "Manifest", "Report"]) assert.ok(await page.getByRole("button", { name }).isDisabled(), name);
  await page.getByText(/not be made.*reach/).first().waitFor();
  await picture(page, "fails-play-light");
  assert.ok(await play(page).isDisabled());
  await page.getByLabel("Undo").click();
  await hasValue(size, before);
  await settled(page);
  await eventually(() => play(page).isEnabled());
  assert.ok(await page.getByRole("button", { name: "Image" }).isEnabled());
});

test("what plays and is not what is shown is told, whoever began it", async (t) => {
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t), studio);
  await settled(page);
  const points = page.getByLabel("Focal points", { exact: true });
  const take = async (count) => {
    await points.fill(count);
    await points.press("Enter");
    await page.locator("footer", { hasText: `${count} focal points` }).waitFor();
    await settled(page);
  };
  await take("8");
  const other = await page.context().newPage();
  await other.goto(studio.address);
  await other.locator("footer", { hasText: "focal points for" }).waitFor(); // the example
  await page.bringToFront();
  await play(page).click();
  await boardSays(page, "Virtual board, outputs ON");
  await boardSays(other, "outputs ON, not as shown");
  await take("9");
  await boardSays(page, "outputs ON, not as shown");
  await show(page, "Play");
  await page.getByText(/plays another design than is shown/).waitFor();
  await picture(page, "plays-other-light");
  // What is refused has not changed what plays.
  await page.getByRole("button", { name: "Modulate as shown" }).click();
  await page.locator(".failed", { hasText: "more than its modulation" }).waitFor();
  await sleep(1000);
  assert.match(await page.locator("#board").innerText(), /not as shown/);
  await page.getByLabel("Undo").click();
  await boardSays(page, "Virtual board, outputs ON");
  // Nor has a design that fails.
  await page.getByLabel("Size", { exact: true }).fill("900");
  await page.getByLabel("Size", { exact: true }).press("Enter");
  await page.locator("footer", { hasText: "cannot be made" }).waitFor();
  await boardSays(page, "outputs ON, not as shown");
  await page.keyboard.press("Escape");
  await boardSays(page, "outputs off");
  await boardSays(other, "outputs off");
});

test("what was kept is shown, and neither plays nor is saved as this design", async (t) => {
  const page = await openPage(t, await startBrowser(t), await startStudio(t));
  await settled(page);
  await page.getByRole("button", { name: "Keep this to compare" }).click();
  await openDesign(page, "Ring");
  await page.locator("footer", { hasText: "Ring: " }).waitFor();
  await settled(page);
  assert.ok(await play(page).isEnabled());
  const kept = page.getByLabel("Show the kept one");
  await kept.check();
  assert.ok(await play(page).isDisabled());
  assert.match(await play(page).getAttribute("title"), /kept/);
  for (const name of ["Image", "Report", "Field (.csv)"]) assert.ok(await page.getByRole("button", { name }).isDisabled(), name);
  await page.locator(".warning", { hasText: "The view shows the kept design" }).first().waitFor();
  await picture(page, "kept-play-light");
  await kept.uncheck();
  await eventually(() => play(page).isEnabled());
  assert.ok(await page.getByRole("button", { name: "Image" }).isEnabled());
});

test("what is refused can be mended by one press", async (t) => {
  const page = await openPage(t, await startBrowser(t), await startStudio(t));
  await settled(page);
  const way = (name) => page.locator("button.remedy", { hasText: name });
  await openDesign(page, "Ring");
  await page.locator("footer", { hasText: "Ring: " }).waitFor();
  const points = page.getByLabel("Focal points", { exact: true });
  await points.fill("5000");
  await points.press("Enter");
  await page.locator(".failed").waitFor();
  await way(/^Take \d+ points/).waitFor();
  await picture(page, "ways-light");
  // The box can be closed; what mends it stays beside it.
  await page.locator(".failed").getByRole("button", { name: "Close" }).click();
  await page.locator("#feel", { hasText: "Cannot be made" }).waitFor();
  await picture(page, "ways-closed-light");
  await way(/^Take \d+ points/).click();
  await settled(page);
  assert.ok(await play(page).isEnabled());
  assert.ok(Number(await points.inputValue()) > 10);
  // What is drawn at a speed moves at once, and a modulation is mended by its pace before its points.
  await openDesign(page, "Ring");
  await page.getByRole("button", { name: "Let it move" }).click();
  await settled(page);
  assert.equal(await page.locator(".failed").count(), 0);
  await openDesign(page, "Ring");
  await hasValue(page.getByLabel("Speed", { exact: true }), "7");
  await page.getByLabel("Modulation", { exact: true }).selectOption("square:200");
  await page.locator(".failed").waitFor();
  await way(/./).first().waitFor();
  assert.match(await way(/./).first().innerText(), /^Draw it at [\d.]+ m\/s$/);
  await way(/./).first().click();
  await settled(page);
  // A shape that moves, of too many steps.
  await openDesign(page, "Plus");
  await page.locator("footer", { hasText: "Plus: " }).waitFor();
  await page.getByRole("button", { name: "Let it move" }).click();
  await settled(page);
  const rate = page.getByLabel("Passes a second", { exact: true });
  await rate.fill("300");
  await rate.press("Enter");
  await page.locator(".failed", { hasText: "steps" }).waitFor();
  await way(/^Make \d+ passes a second/).first().click();
  await settled(page);
  assert.equal(await page.locator(".failed").count(), 0);
});

test("a server that does not answer is told of after a second, and one that has gone plays nothing", async (t) => {
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t), studio, { mayFail: true });
  await settled(page);
  await play(page).click();
  await boardSays(page, "outputs ON");
  const banner = page.locator("#banner");
  studio.child.kill("SIGSTOP");
  const stopped = performance.now();
  await banner.filter({ hasText: "does not answer" }).waitFor();
  t.diagnostic(`told ${(performance.now() - stopped).toFixed(0)} ms after the server stopped to answer`);
  assert.match(await banner.innerText(), /power/);
  assert.ok(await play(page).isDisabled());
  assert.equal(await page.locator("#board.on").count(), 0, "what was known of the outputs is old");
  await page.locator("#stop").click();
  await picture(page, "frozen-light");
  await banner.filter({ hasText: /STOP.*not.*confirmed/ }).waitFor();
  studio.child.kill("SIGCONT");
  await boardSays(page, "outputs off");
  await banner.filter({ hasText: "does not answer" }).waitFor({ state: "hidden" });
  await eventually(() => play(page).isEnabled());
  // Killed, and started again at the same port with another key.
  studio.child.kill("SIGKILL");
  await banner.filter({ hasText: "The server is gone" }).waitFor();
  assert.ok(await play(page).isDisabled());
  await boardSays(page, "gone");
  await startStudio(t, "--port", new URL(studio.origin).port);
  await banner.filter({ hasText: "does not take this page's key" }).waitFor();
  assert.ok(await play(page).isDisabled());
});

test("STOP without a board is answered", async (t) => {
  const page = await openPage(t, await startBrowser(t), await startStudio(t));
  await settled(page);
  await page.locator("#stop").click();
  await boardSays(page, "No board");
});

test("a browser without room for designs says so", async (t) => {
  const before = async (page) =>
    page.addInitScript(() => {
      IDBObjectStore.prototype.put = () => {
        throw new DOMException("", "QuotaExceededError");
      };
    });
  const page = await openPage(t, await startBrowser(t), await startStudio(t), { before });
  await settled(page);
  await openDesign(page, "Ring");
  await page.locator(".failed", { hasText: /room.*bundle/ }).waitFor();
});

test("the studio begins with a shape's file", async (t) => {
  const page = await openPage(t, await startBrowser(t), await startStudio(t, join(shapes, "trimesh_binary.stl")));
  await settled(page);
  await page.locator(".file", { hasText: "trimesh_binary.stl" }).waitFor();
});

/** A box as STL, in text. */
function box(sides) {
  const corner = (bits) => sides.map((side, axis) => ((bits >> axis) & 1 ? side : 0)).join(" ");
  const faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
  const triangles = faces.flatMap(([a, b, c, d]) => [[a, b, c], [a, c, d]]);
  return `solid box\n${triangles.map((each) => `facet normal 0 0 0\nouter loop\n${each.map((bits) => `vertex ${corner(bits)}`).join("\n")}\nendloop\nendfacet`).join("\n")}\nendsolid box\n`;
}

test("a file in inches is fitted until its unit is said, and its own size is shown", async (t) => {
  const page = await openPage(t, await startBrowser(t), await startStudio(t));
  await settled(page);
  await drop(page, [{ name: "box.stl", bytes: Buffer.from(box([2, 1, 0.5])) }]);
  await page.locator(".file", { hasText: "box.stl" }).waitFor();
  await settled(page);
  const unit = page.getByLabel("Unit of the file", { exact: true });
  await hasValue(unit, "");
  await page.getByText("its numbers are 2 × 1 × 0.5").waitFor();
  const options = await unit.locator("option").allInnerTexts();
  assert.deepEqual(options, ["not known: fitted to 60 mm", "mm: 2 mm", "cm: 20 mm", "inch: 50.8 mm", "m: 2,000 mm"]);
  const width = async () => {
    const { records } = JSON.parse(String(await takeAway(page, "Manifest")));
    const x = records.map(({ focus_mm }) => focus_mm[0]);
    return Math.max(...x) - Math.min(...x);
  };
  const fitted = await width();
  await unit.selectOption("inch");
  await settled(page);
  const project = String(await takeAway(page, "Project"));
  assert.match(project, /unit = .inch./);
  assert.doesNotMatch(project, /size_mm/);
  const inches = await width();
  assert.ok(Math.abs(inches / fitted - 50.8 / 60) < 0.05, `${inches} instead of ${fitted} mm`);
  await picture(page, "inches-light");
  await unit.selectOption("");
  await settled(page);
  assert.match(String(await takeAway(page, "Project")), /size_mm = 60/);
});

test("what a design begins with stands first, and a second object may come beside or afterwards", async (t) => {
  const page = await openPage(t, await startBrowser(t), await startStudio(t));
  await page.setViewportSize({ width: 1280, height: 720 });
  await settled(page);
  for (const name of ["Open a file…", "Draw a path by hand", "+ Add an object", "+ One afterwards"]) {
    const { y, height } = await page.locator("#left .button, #left button", { hasText: name }).first().boundingBox();
    assert.ok(y + height < 240, `${name} at ${y} px`);
  }
  await page.getByRole("button", { name: "+ One afterwards" }).click();
  await settled(page);
  assert.equal(await page.locator(".failed").count(), 0);
  const project = String(await takeAway(page, "Project"));
  assert.equal(project.match(/\[\[shape\]\]/g).length, 2);
  assert.equal(project.match(/\[\[keyframe\]\]/g).length, 3);
  assert.ok(await play(page).isEnabled());
  for (const colorScheme of ["light", "dark"]) {
    await page.emulateMedia({ colorScheme });
    await show(page, "Make");
    for (const [width, height] of [[1280, 720], [390, 844]]) {
      await page.setViewportSize({ width, height });
      await picture(page, `begin-${width}-${colorScheme}`);
    }
    await page.setViewportSize({ width: 1280, height: 720 });
  }
});

test("unsaved work outlives the designs that are looked at behind it", async (t) => {
  const page = await openPage(t, await startBrowser(t), await startStudio(t));
  await settled(page);
  await page.locator(".menu summary").click();
  await page.locator("#design").fill("My work");
  await page.locator("#design").press("Enter");
  const points = page.getByLabel("Focal points", { exact: true });
  await points.fill("77");
  await points.press("Enter");
  await openDesign(page, "Ring"); // at once: what was edited a moment before is kept, too
  const names = await page.locator(".gallery").locator("b").allInnerTexts();
  for (const name of names) {
    await openDesign(page, name);
    await page.locator(".menu summary", { hasText: name }).waitFor();
    await sleep(500); // until it is kept
  }
  await page.locator(".menu summary").click();
  await page.locator(".sheet button", { hasText: "My work" }).waitFor();
  await page.reload();
  await page.locator(".card", { hasText: "My work" }).getByRole("button", { name: "Restore it" }).click();
  await hasValue(points, "77");
});

test("a file that cannot be read replaces nothing", async (t) => {
  const page = await openPage(t, await startBrowser(t), await startStudio(t));
  await settled(page);
  const kind = page.getByLabel("Shape", { exact: true });
  const before = await kind.inputValue();
  const bad = [{ name: "bad.stl", bytes: Buffer.from("this is no mesh") }];
  await drop(page, bad);
  await page.locator(".failed", { hasText: "bad.stl" }).waitFor();
  await settled(page);
  assert.equal(await kind.inputValue(), before);
  assert.ok(await play(page).isEnabled());
  assert.ok(await page.locator(".failed", { hasText: "bad.stl" }).isVisible(), "it is still said");
  // A design with several shapes and key frames takes a file.
  await openDesign(page, "Bloom");
  await page.locator("footer", { hasText: "Bloom: " }).waitFor();
  await settled(page);
  await drop(page, bad);
  await page.locator(".failed", { hasText: "bad.stl" }).waitFor();
  await settled(page);
  await drop(page, [{ name: "trimesh_binary.stl", bytes: readFileSync(join(shapes, "trimesh_binary.stl")) }]);
  await page.locator(".file", { hasText: "trimesh_binary.stl" }).waitFor();
  await settled(page);
  await picture(page, "bloom-file");
});

test("the timeline draws a modulated design as strong as it is", async (t) => {
  const scenes = [];
  const before = async (page) =>
    page.on("websocket", (socket) =>
      socket.on("framereceived", ({ payload }) => {
        if (typeof payload === "string" && payload.startsWith('{"t":"scene"')) scenes.push(JSON.parse(payload).scene);
      }),
    );
  const page = await openPage(t, await startBrowser(t), await startStudio(t), { before });
  await settled(page);
  await openDesign(page, "Heartbeat");
  await page.locator("footer", { hasText: "Heartbeat: " }).waitFor();
  await settled(page);
  await lookedAt(page);
  const { tour, pass_s: pass } = scenes.at(-1);
  const heights = await page.evaluate(() =>
    [...document.querySelector(".lane .blocks").getAttribute("d").matchAll(/M([\d.]+) 40V([\d.]+)H([\d.]+)/g)].map(([, left, top, right]) => ({ at: (Number(left) + Number(right)) / 2000, high: 40 - Number(top) })),
  );
  await picture(page, "timeline-light");
  const most = Math.max(...tour.map(({ amplitude }) => amplitude));
  const entryAt = (time) => tour.find(({ from_s, dwell_s }) => from_s <= time && time < from_s + dwell_s);
  const places = new Set(tour.map(({ at }) => at.join()));
  t.diagnostic(`${tour.length} entries at ${places.size} places, ${heights.length} blocks, amplitudes ${Math.min(...tour.map(({ amplitude }) => amplitude))} to ${most}`);
  const strong = heights.filter(({ at }) => entryAt(at * pass)?.amplitude > 0.95 * most);
  const weak = heights.filter(({ at }) => entryAt(at * pass)?.amplitude < 0.3 * most);
  assert.ok(strong.length > 0 && weak.length > 0);
  assert.ok(Math.min(...strong.map(({ high }) => high)) > Math.max(...weak.map(({ high }) => high)), JSON.stringify([strong.slice(0, 3), weak.slice(0, 3)]));
});

test("a live session's outputs are told in every window", async (t) => {
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t), studio);
  await openDesign(page, "Touched ball");
  await page.locator("footer", { hasText: "100 focal points for" }).waitFor();
  await settled(page);
  const other = await page.context().newPage();
  await other.goto(studio.address);
  await settled(other);
  await page.bringToFront();
  await page.locator("[data-step=Play]").click();
  // The session may be over before a busy machine has looked at it, so each window notes what it shows.
  for (const each of [page, other])
    await each.evaluate(() => {
      const board = document.getElementById("board");
      window.shown = [];
      new MutationObserver(() => window.shown.push({ words: board.textContent, lit: board.classList.contains("on") })).observe(board, { childList: true, characterData: true, subtree: true, attributes: true });
      new MutationObserver(() => window.shown.push({ title: document.title })).observe(document.querySelector("title"), { childList: true });
    });
  await page.getByRole("button", { name: "Feel it live" }).click();
  const shown = (each) => each.evaluate(() => window.shown);
  for (const each of [page, other])
    await eventually(
      async () => {
        const all = await shown(each);
        return all.some(({ words, lit }) => lit && words.includes("lent to the live session, outputs ON")) && all.some(({ title }) => /Outputs on/.test(title ?? ""));
      },
      async () => JSON.stringify(await shown(each)),
    );
  await picture(page, "live-lamp-light");
  await other.keyboard.press("Escape");
  for (const each of [page, other]) {
    await boardSays(each, "outputs off");
    assert.equal(await each.locator("#board.on").count(), 0);
    assert.doesNotMatch(await each.title(), /Outputs on/);
  }
});

test("what is read aloud of the board changes only with what it says", async (t) => {
  const page = await openPage(t, await startBrowser(t), await startStudio(t));
  await settled(page);
  await page.getByRole("button", { name: "Start a virtual board" }).click();
  await boardSays(page, "outputs off");
  const changes = await page.evaluate(
    () =>
      new Promise((done) => {
        let count = 0;
        const watch = new MutationObserver((all) => (count += all.length));
        for (const each of [document.getElementById("board"), document.querySelector("title")]) watch.observe(each, { childList: true, characterData: true, subtree: true });
        setTimeout(() => done(count), 2000);
      }),
  );
  assert.equal(changes, 0);
});

test("Escape closes the menu, studies have a way back, and in a small window all has its place", async (t) => {
  const page = await openPage(t, await startBrowser(t), await startStudio(t));
  await settled(page);
  await page.locator(".menu summary").click();
  await page.keyboard.press("Escape");
  await page.locator(".menu:not([open])").waitFor();
  await page.locator("[data-step=Play]").click();
  await page.getByRole("button", { name: "Study", exact: true }).click();
  await page.getByRole("button", { name: "Back to the design" }).click();
  await page.locator("#view canvas").waitFor();
  for (const width of [1280, 800, 390]) {
    await page.setViewportSize({ width, height: 720 });
    await page.reload();
    await settled(page);
    const off = await page.evaluate(() => {
      const bar = document.querySelector(".bar rect").getBoundingClientRect(), box = document.querySelector(".bar svg").getBoundingClientRect();
      const marks = [...document.querySelectorAll(".bar li")].map((each, i, { length }) => {
        const { left, right } = each.getBoundingClientRect();
        if (right === left) return 0; // there is no room for it
        return (i === 0 ? left : i === length - 1 ? right : (left + right) / 2) - (bar.left + (bar.width * i) / (length - 1));
      });
      return Math.max(Math.abs(bar.width - box.width), ...marks.map(Math.abs));
    });
    assert.ok(off < 1.5, `${off} px at ${width}`);
    await lookedAt(page);
    // The verdict's band stands beside it, whole.
    const band = page.locator("#feel .band");
    assert.match(await band.innerText(), /dB over the least felt.*not known$/);
    assert.ok(await band.evaluate((each) => each.scrollWidth <= each.clientWidth + 1), `the band is cut at ${width}`);
    const feel = await page.locator("#feel").boundingBox();
    assert.ok(feel.height < 90, `what it will feel like takes ${feel.height} px at ${width}`);
    for (const colorScheme of ["light", "dark"]) {
      await page.emulateMedia({ colorScheme });
      await picture(page, `small-${width}-${colorScheme}`);
    }
  }
});
