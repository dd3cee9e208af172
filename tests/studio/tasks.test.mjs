// SPDX-License-Identifier: Apache-2.0
// Ten things that a user comes for, each in at most five actions; and many designs that are the command line's, byte by byte.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { randomDesign, randomOf } from "./designs.mjs";
import { boardSays, coloursSeen, drop, folder, hasValue, lookedAt, openPage, run, settled, shapes, startBrowser, startStudio, takeAway } from "./support.mjs";

const mostActions = 5;

test("ten tasks, each in at most five actions", async (t) => {
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t), studio);
  await settled(page);
  await lookedAt(page);
  let actions = 0;
  // What stands on the page, with nothing unfolded: every click, typed value and key is an action.
  const act = async (work) => {
    actions++;
    await work;
  };
  const find = (selector, options) => page.locator(selector, options);
  const button = (name) => page.locator("button", { hasText: name }).first();
  const design = (title) => page.locator("li button", { has: page.locator("b", { hasText: new RegExp(`^${title}$`) }) });
  const typed = async (label, value) => {
    await page.locator(`[aria-label="${label}"], .field:has(label:text-is("${label}")) input`).first().fill(value);
    await page.keyboard.press("Enter");
  };
  const task = async (name, work, done) => {
    actions = 0;
    await work();
    await done();
    t.diagnostic(`${name}: ${actions} ${actions === 1 ? "action" : "actions"}`);
    assert.ok(actions <= mostActions, name);
  };
  const footer = (text) => page.locator("footer", { hasText: text }).waitFor();
  const saved = page.waitForEvent("download");

  await task("make a ring at 15 cm", async () => {
    await act(design("Ring").click());
    await footer("Ring: ");
    await act(typed("Centre z", "15 cm"));
  }, async () => hasValue(page.getByLabel("Centre z", { exact: true }), "150"));
  await task("save it as a file", async () => act(page.keyboard.press("Control+s")), async () => assert.equal((await saved).suggestedFilename(), "Ring.haptogram"));
  await task("open another, and find the ring again", async () => {
    await act(design("Plus").click());
    await footer("Plus: ");
    await act(find(".menu summary").click());
    await act(find(".sheet button.ghost").filter({ hasText: "Ring" }).first().click());
  }, async () => footer("Ring: "));
  await settled(page);
  await task("play it", async () => act(find("button.play").click()), async () => boardSays(page, "outputs ON"));
  await task("stop it", async () => act(page.keyboard.press("Escape")), async () => boardSays(page, "outputs off"));
  await task("make it stronger at the left", async () => act(page.getByLabel("Strongest", { exact: true }).selectOption("left")), async () => {
    await settled(page);
    const { records } = JSON.parse(String(await takeAway(page, "Manifest")));
    const x = records.map(({ focus_mm }) => focus_mm[0]);
    const [left, right] = [Math.min(...x), Math.max(...x)];
    assert.ok(right - left > 15);
    for (const [i, { amplitude = 1 }] of records.entries()) assert.ok(Math.abs(amplitude - (1 - (0.5 * (x[i] - left)) / (right - left))) < 0.02, `${amplitude} at ${x[i]} mm`);
  });
  await task("take that back", async () => act(page.keyboard.press("Control+z")), async () => hasValue(page.getByLabel("Strongest", { exact: true }), ""));
  await task("mend what is drawn too fast", async () => {
    await act(design("Two points").click());
    await footer("Two points: ");
    await act(typed("Passes a second", "2000"));
    await settled(page);
    await lookedAt(page);
    await act(find('[data-kind="short-dwell"] button.remedy').first().click());
  }, async () => find('[data-kind="short-dwell"]').waitFor({ state: "detached" }));
  await task("bring a mesh that lies down, and set it upright", async () => {
    await act(drop(page, [{ name: "trimesh.obj", bytes: readFileSync(join(shapes, "trimesh.obj")) }]));
    await act(find('.field:has(label:text-is("Upwards in the file")) select').selectOption("y"));
  }, async () => settled(page));
  await task("see how wide it is felt", async () => act(find("[data-step=See]").click()), async () => find(".hint", { hasText: /Half of the radiation pressure within|does not fall to half/ }).waitFor());
  await task("a hand that slides over a ball, played", async () => {
    await act(find("[data-step=Make]").click());
    await act(design("Touched ball").click());
    await footer("Touched ball: ");
    await settled(page);
    await act(find("button.play").click());
  }, async () => boardSays(page, "outputs ON"));
  await page.keyboard.press("Escape");
  await boardSays(page, "outputs off");
});

test("images from the page are the command line's, of fifty designs", async (t) => {
  const seed = Number(process.env.HAPTOGRAM_SEED ?? Math.floor(1e9 * Math.random()));
  t.diagnostic(`HAPTOGRAM_SEED=${seed}`);
  const random = randomOf(seed);
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t), studio);
  await settled(page);
  const where = await folder(t);
  for (let i = 0; i < 50; i++) {
    const design = randomDesign(random);
    const { text, image } = await page.evaluate(async (design) => {
      const key = sessionStorage.getItem("token");
      const socket = new WebSocket(`ws://${location.host}/ws`, ["haptogram.1", `token.${key}`]);
      await new Promise((done) => (socket.onopen = done));
      const answer = new Promise((done) => (socket.onmessage = ({ data }) => {
        const message = typeof data === "string" ? JSON.parse(data) : {};
        if (message.t === "scene" || message.t === "failed") done(message);
      }));
      socket.send(JSON.stringify({ t: "scene", n: 1, document: design }));
      const { scene, error } = await answer;
      socket.close();
      if (error) return { text: JSON.stringify(design), image: `failed: ${error.message}` };
      const get = async (path, init) => (await fetch(path, { ...init, headers: { Authorization: `Bearer ${key}` } }));
      const { text } = await (await get("/api/project", { method: "POST", body: JSON.stringify(design) })).json();
      return { text, image: await (await get(`/api/take?scene=${scene.name}&as=hex`)).text() };
    }, design);
    assert.ok(!image.startsWith("failed"), `${image}: ${text}`);
    const project = join(where, `${i}.toml`);
    writeFileSync(project, text);
    await run("compile", project, "-o", join(where, "image.hex"));
    assert.equal(image, readFileSync(join(where, "image.hex"), "utf8"), text);
  }
});

test("axes stand beside the array", async (t) => {
  const where = await folder(t);
  writeFileSync(join(where, "ring.toml"), 'format = "haptogram-project-1"\npoints = 8\nrate_hz = 1\n[[shape]]\nkind = "circle"\ndiameter_mm = 40\n');
  const page = await openPage(t, await startBrowser(t), await startStudio(t, join(where, "ring.toml")));
  await settled(page);
  await lookedAt(page);
  const coloursAt = await coloursSeen(page);
  // On each axis one colour is the strongest, for its line leads there from the array's corner.
  for (const axis of [0, 1, 2]) {
    const found = [10, 15, 20, 25, 30].some((mm) =>
      coloursAt([-57, -57, 0].map((each, i) => each + (i === axis ? mm : 0))).some((pixel) => Math.max(...pixel) - Math.min(...pixel) > 60 && pixel[axis] === Math.max(...pixel)));
    assert.ok(found, `axis ${"xyz"[axis]}`);
  }
});

test("while the board plays, view and timeline show where it is, also when a point is marked", async (t) => {
  const where = await folder(t);
  writeFileSync(join(where, "ring.toml"), 'format = "haptogram-project-1"\npoints = 8\nrate_hz = 1\n[[shape]]\nkind = "circle"\ndiameter_mm = 40\n');
  const page = await openPage(t, await startBrowser(t), await startStudio(t, join(where, "ring.toml")));
  await settled(page);
  await page.getByLabel("Focal point", { exact: true }).press("End");
  await page.locator(".scrubber", { hasText: "8 of 8" }).waitFor();
  await page.locator("button.play").click();
  await boardSays(page, "outputs ON");
  const seen = new Set();
  for (let i = 0; i < 40 && seen.size < 3; i++) {
    const text = await page.getByLabel("Intensity", { exact: true }).isVisible().then(() => page.locator("#right").innerText());
    seen.add(text.match(/plays record \d+, point (\d) of 8/)?.[1]);
    await page.waitForTimeout(200);
  }
  assert.ok(seen.size >= 3, [...seen].join(", "));
  const places = new Set();
  for (let i = 0; i < 40 && places.size < 3; i++) {
    const box = await page.locator(".plays-here").boundingBox();
    if (box) places.add(Math.round(box.x));
    await page.waitForTimeout(200);
  }
  assert.ok(places.size >= 3, "the timeline shows it, too");
  await page.getByRole("button", { name: "STOP" }).click();
  await boardSays(page, "outputs off");
  await page.locator(".plays-here").waitFor({ state: "detached" });
  await page.locator(".scrubber", { hasText: "8 of 8" }).waitFor();
});

test("a board that rests draws nothing", async (t) => {
  const page = await openPage(t, await startBrowser(t), await startStudio(t), {
    before: (page) => page.addInitScript(() => {
      window.frames_drawn = 0;
      const { clear } = WebGL2RenderingContext.prototype;
      WebGL2RenderingContext.prototype.clear = function (...of) {
        window.frames_drawn++;
        return clear.apply(this, of);
      };
    }),
  });
  await settled(page);
  await lookedAt(page);
  await page.getByRole("button", { name: "Start a virtual board" }).click();
  await boardSays(page, "Virtual board, outputs off");
  await page.mouse.move(0, 0);
  await page.waitForTimeout(1000);
  const drawn = () => page.evaluate(() => window.frames_drawn);
  const before = await drawn();
  await page.waitForTimeout(2000);
  assert.ok(before > 0, "the counter counts");
  assert.equal(await drawn(), before);
});
