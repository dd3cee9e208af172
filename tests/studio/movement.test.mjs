// SPDX-License-Identifier: Apache-2.0
// A shape that moves from key frame to key frame, and a hand's outline as a scale, in the static page.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { accessible, eventually, folder, hasValue, keptPicture, lookedAt, openPage, picture, pixels, run, settled, startBrowser, takeAway } from "./support.mjs";
import { host, skip } from "./site.mjs";

async function openSite(t, options) {
  const page = await openPage(t, await startBrowser(t), await host(t), options);
  await settled(page);
  return page;
}

async function fill(page, label, value) {
  const field = page.getByLabel(label, { exact: true });
  await field.fill(String(value));
  await field.press("Enter");
}

test("a shape moves from key frame to key frame, and its image is the command line's", { skip }, async (t) => {
  const page = await openSite(t);
  const where = await folder(t);
  await page.getByRole("button", { name: "Let it move" }).click();
  await settled(page);
  await page.locator("footer", { hasText: "141 focal points" }).waitFor(); // 20 in each of 7 passes, and what rounding leaves
  await fill(page, "Moved by x", 25);
  await fill(page, "Moved by z", -20);
  await fill(page, "Grown to", 0.5);
  await fill(page, "Turned by z", 90);
  await fill(page, "Strength here", 60);
  // A third one between the two has what the first has, and its own way on from there.
  await page.getByRole("button", { name: "Key frame 1, at 0 s" }).click();
  await page.getByRole("button", { name: "Add a key frame after this one" }).click();
  await hasValue(page.getByLabel("At", { exact: true }), "0.5");
  await page.getByLabel("From here it", { exact: true }).selectOption("smooth");
  await page.locator("details", { hasText: "beats, trigger" }).locator("summary").click();
  await fill(page, "Beats", 40);
  await settled(page);
  await lookedAt(page);
  assert.equal(await page.locator("path.key").count(), 3);
  assert.ok((await accessible(page)) > 10);
  await keptPicture(page, "movement-light");
  await page.getByRole("button", { name: "Theme" }).click();
  await keptPicture(page, "movement-dark");
  const project = String(await takeAway(page, "Project (.toml)"));
  assert.equal(project.match(/\[\[keyframe\]\]/g).length, 3);
  assert.match(project, /time_s = 0\.5[\s\S]*am_hz = 40[\s\S]*ease = "smooth"|time_s = 0\.5[\s\S]*ease = "smooth"[\s\S]*am_hz = 40/);
  const bundle = join(where, "moves.haptogram");
  writeFileSync(bundle, await takeAway(page, "Bundle (.haptogram)"));
  await run("compile", bundle, "-o", join(where, "moves.hex"));
  assert.equal(String(await takeAway(page, "Image (.hex)")), readFileSync(join(where, "moves.hex"), "utf8"));
  // In the timeline a key frame is moved by the pointer and by keys, no further than its neighbours, and is one step back.
  const handle = (number) => page.getByRole("slider", { name: `Time of key frame ${number}` });
  const lane = await page.locator(".lane").boundingBox();
  const grip = await handle(2).boundingBox();
  assert.ok(Math.abs(grip.x + grip.width / 2 - (lane.x + 0.5 * lane.width)) < 3, "it stands at half of the pass");
  await page.mouse.move(grip.x + grip.width / 2, grip.y + grip.height / 2);
  await page.mouse.down();
  for (const part of [0.55, 0.65, 0.75]) await page.mouse.move(lane.x + part * lane.width, grip.y + 5);
  await page.mouse.up();
  await eventually(async () => Math.abs(Number(await handle(2).getAttribute("aria-valuenow")) - 0.75) < 0.01);
  await settled(page);
  await page.getByRole("button", { name: /Key frame 2, at 0\.7/ }).and(page.locator("[aria-pressed=true]")).waitFor();
  await page.keyboard.press("Control+z");
  await hasValue(page.getByLabel("At", { exact: true }), "0.5");
  await handle(2).press("ArrowRight");
  await hasValue(page.getByLabel("At", { exact: true }), "0.51");
  for (let i = 0; i < 6; i++) await handle(2).press("Shift+ArrowRight");
  await hasValue(page.getByLabel("At", { exact: true }), "0.999");
  for (let i = 0; i < 7; i++) await page.keyboard.press("Control+z");
  await hasValue(page.getByLabel("At", { exact: true }), "0.5");
  await handle(3).click();
  await page.locator(".scrubber", { hasText: /: 2\d\.\d, / }).waitFor(); // 25 mm to the right there
  await page.getByRole("button", { name: "Key frame 2, at 0.5 s" }).click();
  await settled(page);
  // What cannot be is said; what is undone is as before.
  await fill(page, "At", 9);
  await page.locator(".wrong-value", { hasText: "At: “9” is no number of 0.001 to 0.999 s; 0.5 stays." }).waitFor();
  await fill(page, "Focal points", 200);
  await page.locator(".failed", { hasText: "take fewer points" }).waitFor();
  await page.keyboard.press("Control+z");
  await settled(page);
  await page.getByRole("button", { name: "Remove this key frame" }).click();
  await page.getByRole("button", { name: "Let it stay in its place" }).click();
  await page.getByRole("button", { name: "Let it move" }).waitFor();
  await settled(page);
});

test("a shape becomes another one at a key frame, and its image is the command line's", { skip }, async (t) => {
  const page = await openSite(t);
  const where = await folder(t);
  await page.getByRole("button", { name: "Let it move" }).click();
  const form = page.getByLabel("Shape here", { exact: true });
  await form.selectOption("square");
  await settled(page);
  await hasValue(form, "2");
  await fill(page, "Grown to", 0.8);
  await settled(page);
  const compiled = async (name) => {
    const bundle = join(where, `${name}.haptogram`);
    writeFileSync(bundle, await takeAway(page, "Bundle (.haptogram)"));
    await run("compile", bundle, "-o", join(where, `${name}.hex`));
    assert.equal(String(await takeAway(page, "Image (.hex)")), readFileSync(join(where, `${name}.hex`), "utf8"));
    return String(await takeAway(page, "Project (.toml)"));
  };
  const project = await compiled("becomes");
  assert.deepEqual(project.match(/kind = "\w+"/g), ['kind = "hemisphere"', 'kind = "square"']);
  assert.match(project, /time_s = 1\.?0?\nscale = 0\.8\nshape = 2/);
  // Another one takes its place; without any, the object is alone again.
  await form.selectOption("triangle");
  await settled(page);
  assert.deepEqual((await compiled("other")).match(/kind = "\w+"/g), ['kind = "hemisphere"', 'kind = "triangle"']);
  await form.selectOption("");
  await settled(page);
  assert.deepEqual((await compiled("alone")).match(/kind = "\w+"|shape = \d/g), ['kind = "hemisphere"']);
  // A chosen key frame is seen to be.
  const colours = async (i) => await page.getByRole("button", { name: `Key frame ${i}, at ${i - 1} s` }).evaluate((each) => getComputedStyle(each).backgroundColor);
  assert.notEqual(await colours(1), await colours(2));
});

test("the outline of a hand stands where the object is, as large as the hand of the library", { skip }, async (t) => {
  const page = await openSite(t);
  const before = await pixels(page);
  const button = page.getByRole("button", { name: "Hand for scale" });
  await button.click();
  assert.equal(await button.getAttribute("aria-pressed"), "true");
  const changed = (after) => after.filter((value, i) => Math.abs(value - before[i]) > 40).length;
  await eventually(async () => changed(await pixels(page)) > 500);
  assert.ok((await accessible(page)) > 10);
  await picture(page, "outline-light");
  const ends = await page.evaluate(async () => {
    const worker = new Worker("worker.js", { type: "module" });
    return await new Promise((done) => {
      worker.onmessage = ({ data }) => {
        if (data.ready) worker.postMessage({ request: 1, method: "GET", target: "/api/outline", body: new ArrayBuffer(0) });
        if (data.request === 1) done(JSON.parse(new TextDecoder().decode(data.body)).segments);
      };
    });
  });
  const along = ends.map(([, y]) => y), across = ends.map(([x]) => x);
  assert.ok(Math.abs(Math.min(...along) + 45) < 1, "a palm of 90 mm, around its centre");
  assert.ok(Math.max(...along) > 100 && Math.max(...along) < 160, "fingers");
  assert.ok(Math.max(...across) - Math.min(...across) >= 85, "a palm of 85 mm");
  await page.getByRole("button", { name: "Theme" }).click();
  await picture(page, "outline-dark");
  await button.click();
  await page.getByRole("button", { name: "Theme" }).click();
  await page.getByRole("button", { name: "Theme" }).click();
  await eventually(async () => changed(await pixels(page)) < 500);
});
