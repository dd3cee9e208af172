// SPDX-License-Identifier: Apache-2.0
// A path that is drawn by hand on the plane, in the static page: places, speed and file, against where the pointer was.
import assert from "node:assert/strict";
import { createRequire } from "node:module";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { accessible, drawnAt, folder, hasValue, keptPicture, lookedAt, middle, openPage, run, settled, sleep, startBrowser, takeAway } from "./support.mjs";
import { host, skip } from "./site.mjs";

const { unzipSync } = createRequire(new URL("../../extras/studio/web/package.json", import.meta.url))("fflate");
const radius = 30, height = 130; // mm, of the circle that is drawn

async function openSite(t, options) {
  const page = await openPage(t, await startBrowser(t), await host(t), options);
  await settled(page);
  return page;
}

/** The rows of the path in a bundle. */
function rowsOf(bundle) {
  const files = unzipSync(new Uint8Array(bundle));
  const [name] = Object.keys(files).filter((each) => each.endsWith(".csv"));
  const [head, ...rows] = Buffer.from(files[name]).toString().trim().split("\n");
  assert.equal(head, "time_ms,x_mm,y_mm,z_mm");
  return rows.map((row) => row.split(",").map(Number));
}

/** Where a part of the circle is on the page. */
async function circleOf(page) {
  const view = await middle(page);
  return (part) => drawnAt([radius * Math.cos(2 * Math.PI * part), radius * Math.sin(2 * Math.PI * part), height], view);
}

/** Draws it, the second half twice as fast. @return when the pointer was where, ms and part of the circle */
async function drawCircle(page) {
  const at = await circleOf(page);
  const move = async (part) => await page.mouse.move(at(part).x, at(part).y);
  await move(0);
  await page.mouse.down();
  const when = [[performance.now(), 0]];
  for (let i = 1; i <= 60; i++) {
    await move(i / 60);
    when.push([performance.now(), i / 60]);
    await sleep(i <= 30 ? 30 : 15);
  }
  await page.mouse.up();
  return when;
}

const away = ([, x, y, z]) => Math.abs(Math.hypot(x, y, 0) - radius) + Math.abs(z - height);

for (const colorScheme of ["light", "dark"])
  test(`a circle drawn by the pointer lies where it was drawn, as fast as it was, and its image is the command line's, ${colorScheme}`, { skip }, async (t) => {
    const page = await openSite(t, { colorScheme });
    const where = await folder(t);
    await lookedAt(page);
    await page.getByRole("button", { name: "Draw a path by hand" }).click();
    await page.getByText("Draw on the plane:").waitFor();
    assert.ok((await accessible(page)) > 10);
    await keptPicture(page, `drawing-${colorScheme}`);
    const when = await drawCircle(page);
    await page.locator("footer", { hasText: "200 focal points" }).waitFor();
    await settled(page);
    await page.getByText(/Smoothed over 30 ms: no place was moved by more than [\d.]+ mm\./).waitFor();
    assert.ok((await accessible(page)) > 10);
    const bundle = await takeAway(page, "Bundle (.haptogram)");
    const rows = rowsOf(bundle);
    assert.equal(rows.length, 200);
    assert.ok(Math.max(...rows.map(away)) < 2, `${Math.max(...rows.map(away))} mm beside the circle`);
    // As long as it was drawn, and where the hand was slower, places are nearer.
    const lasted = when.at(-1)[0] - when[0][0];
    const lasts = (rows[1][0] - rows[0][0]) * 200;
    t.diagnostic(`drawn in ${lasted.toFixed(0)} ms, lasts ${lasts.toFixed(0)} ms`);
    assert.ok(Math.abs(lasts - lasted) < 0.25 * lasted + 50, `${lasts} instead of ${lasted} ms`);
    const half = when.find(([, part]) => part >= 0.5)[0] - when[0][0];
    const upper = rows.filter(([, , y]) => y > 0).length / 200;
    assert.ok(Math.abs(upper - half / lasted) < 0.12, `${upper} of the time in the slow half, ${half / lasted} when it was drawn`);
    writeFileSync(join(where, "drawn.haptogram"), bundle);
    await run("compile", join(where, "drawn.haptogram"), "-o", join(where, "drawn.hex"));
    assert.equal(String(await takeAway(page, "Image (.hex)")), readFileSync(join(where, "drawn.hex"), "utf8"));
    // Faster: the same places in less time. Each is a step back, also after the page was loaded again.
    await page.getByLabel("Lasts", { exact: true }).fill("0.2");
    await page.getByLabel("Lasts", { exact: true }).press("Enter");
    await settled(page);
    const faster = rowsOf(await takeAway(page, "Bundle (.haptogram)"));
    assert.deepEqual(faster.map((row) => row.slice(1)), rows.map((row) => row.slice(1)));
    assert.equal(faster[1][0], 1);
    await sleep(1000); // until the browser has kept it
    await page.reload();
    await settled(page);
    await hasValue(page.getByLabel("Lasts", { exact: true }), "0.2");
    await page.keyboard.press("Control+z");
    await settled(page);
    await hasValue(page.getByLabel("Lasts", { exact: true }), String(Number((lasts / 1000).toFixed(3))));
    await page.keyboard.press("Control+z");
    await page.getByRole("button", { name: "Draw a path by hand" }).waitFor();
    await settled(page);
  });

test("a path is drawn by the keyboard and by a finger", { skip }, async (t) => {
  const page = await openSite(t);
  await page.getByRole("button", { name: "Draw a path by hand" }).focus();
  await page.keyboard.press("Enter");
  await page.getByRole("status").filter({ hasText: "The pen is at 0.0, 0.0, 130.0 mm." }).waitFor();
  await page.keyboard.press("Shift+ArrowLeft");
  await page.keyboard.press("Enter");
  for (let i = 0; i < 10; i++) {
    await page.keyboard.press("ArrowRight");
    await sleep(20);
  }
  await page.getByRole("status").filter({ hasText: "A line of 11 places, at 10.0, 0.0, 130.0 mm." }).waitFor();
  await page.keyboard.press("ArrowUp");
  await page.keyboard.press("Enter");
  await page.locator("footer", { hasText: "200 focal points" }).waitFor();
  await settled(page);
  const first = await page.locator("p.file").textContent();
  assert.match(first, /^drawn-[0-9a-f]{8}\.csv$/);
  const rows = rowsOf(await takeAway(page, "Bundle (.haptogram)"));
  assert.deepEqual(rows[0].slice(1), [-10, 0, 130]);
  assert.deepEqual(rows.at(-1).slice(1), [10, 2, 130]);
  assert.ok(rows.every(([, x, y, z]) => Math.abs(x) <= 10 && y >= 0 && y <= 2 && z === 130));
  // A finger does what the pointer does.
  await page.getByRole("button", { name: "Draw another path" }).click();
  const at = await circleOf(page);
  const fingers = await page.context().newCDPSession(page);
  const touch = async (type, part) => await fingers.send("Input.dispatchTouchEvent", { type, touchPoints: type === "touchEnd" ? [] : [at(part)] });
  await touch("touchStart", 0);
  for (let i = 1; i <= 20; i++) await touch("touchMove", i / 20);
  await touch("touchEnd");
  await page.locator("p.file", { hasNotText: first }).waitFor();
  await settled(page);
  assert.ok(Math.max(...rowsOf(await takeAway(page, "Bundle (.haptogram)")).map(away)) < 4);
});

test("what cannot be a path is refused, and said", { skip }, async (t) => {
  const page = await openSite(t);
  const draw = page.getByRole("button", { name: "Draw a path by hand" });
  // The pen did not move: nothing is kept, and another line can be drawn.
  await draw.click();
  const view = await middle(page);
  await page.mouse.click(view.x, view.y);
  await page.locator(".failed", { hasText: "The pen did not move. Nothing of the line was kept; draw it again." }).waitFor();
  await page.getByText("Draw on the plane:").waitFor();
  // Esc ends the drawing.
  await page.keyboard.press("Escape");
  assert.equal(await page.getByText("Draw on the plane:").count(), 0);
  // Out of the array's reach: it is said where, and a step back has the object again.
  await draw.click();
  const [from, to] = [[0, 0, height], [230, 150, height]].map((at) => drawnAt(at, view));
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  await page.mouse.move(to.x, to.y, { steps: 20 });
  await page.mouse.up();
  await page.locator(".failed", { hasText: /reach/ }).waitFor();
  assert.match(await page.locator(".failed").innerText(), /-?\d+(\.\d+)?, -?\d+(\.\d+)?, 130/);
  await page.keyboard.press("Control+z");
  await settled(page);
  await page.locator("footer", { hasText: "200 focal points" }).waitFor();
});
