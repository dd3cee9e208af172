// SPDX-License-Identifier: Apache-2.0
// The page in a real browser: what a user does from the start to the image, and what it shows.
import assert from "node:assert/strict";
import { existsSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { accessible, drop, eventually, folder, hasValue, keptPicture, lookedAt, openPage, panel, picture, run, settled, shapes, show, slices, startBrowser, startStudio, takeAway } from "./support.mjs";

/** Numbers of a request over a WebSocket of the test's own, with the page's token. */
const askSlice = (page, message) =>
  page.evaluate(async (message) => {
    const socket = new WebSocket(`ws://${location.host}/ws`, ["haptogram.1", `token.${sessionStorage.getItem("token")}`]);
    socket.binaryType = "arraybuffer";
    await new Promise((done) => (socket.onopen = done));
    const answer = new Promise((done) => (socket.onmessage = ({ data }) => typeof data !== "string" && done(data)));
    socket.send(JSON.stringify(message));
    const bytes = await answer;
    socket.close();
    return [...new Float32Array(bytes, 64)];
  }, message);

/** What the browser takes by itself: the first content of a page that is a heading alone, in a browser that was just started. */
async function firstPaintOfHeading(t) {
  const page = await (await startBrowser(t)).newPage();
  await page.goto("data:text/html,<h1>A heading</h1>");
  await page.waitForFunction(() => performance.getEntriesByName("first-contentful-paint").length > 0);
  return page.evaluate(() => performance.getEntriesByName("first-contentful-paint")[0].startTime);
}

for (const colorScheme of ["light", "dark"])
  test(`from the start to the first slice, ${colorScheme}`, async (t) => {
    const studio = await startStudio(t);
    const browser = await startBrowser(t);
    const page = await openPage(t, browser, studio, { colorScheme });
    await settled(page);
    const times = await page.evaluate(() => ({
      paint: performance.getEntriesByName("first-contentful-paint")[0].startTime,
      slice: performance.getEntriesByName("first slice")[0].startTime,
      isolated: crossOriginIsolated,
    }));
    const paintOfHeading = await firstPaintOfHeading(t);
    t.diagnostic(
      `listening after ${studio.startMs.toFixed(0)} ms, first content ${times.paint.toFixed(0)} ms (of a page that is a heading alone, in a browser as new: ` +
        `${paintOfHeading.toFixed(0)} ms), first slice ${times.slice.toFixed(0)} ms`,
    );
    assert.ok(times.paint < 20_000 && times.slice < 60_000, "generous limits: this machine may be busy");
    assert.ok(times.isolated);
    assert.equal(page.url(), studio.origin + "/", "the token is not left in the address");
    assert.match(await panel(page, "Numbers").innerText(), /Focal points\s+200/);
    await accessible(page);
    await lookedAt(page);
    await keptPicture(page, `start-${colorScheme}`);

    // The middle of the plane over the dome is not the page's ground: the field is drawn. Yellow is the strongest.
    const shot = await page.locator("#view canvas").screenshot();
    const colours = await page.evaluate(async (base64) => {
      const image = new Image();
      image.src = `data:image/png;base64,${base64}`;
      await image.decode();
      const canvas = Object.assign(document.createElement("canvas"), { width: image.width, height: image.height });
      const context = canvas.getContext("2d");
      context.drawImage(image, 0, 0);
      const { data } = context.getImageData(0, 0, image.width, image.height);
      let dark = 0, strong = 0;
      for (let i = 0; i < data.length; i += 4) {
        if (data[i] < 95 && data[i + 1] < 50 && data[i + 2] > 70 && data[i + 2] < 135) dark++;
        if (data[i] > 170 && data[i + 1] > 180 && data[i + 2] < 90) strong++;
      }
      return { dark, strong };
    }, shot.toString("base64"));
    assert.ok(colours.dark > 2000 && colours.strong > 20, JSON.stringify(colours));

    // Reloading keeps the token; a new tab without it is told what to do.
    await page.reload();
    await settled(page);
    const bare = await browser.newPage();
    await bare.goto(studio.origin);
    assert.match(await bare.locator("#banner").innerText(), /needs its key/);
  });

test("the slice is the field that the command line computes", async (t) => {
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t), studio);
  await settled(page);
  const where = await folder(t);
  writeFileSync(join(where, "image.hex"), await takeAway(page, "Image"));
  writeFileSync(join(where, "image.json"), await takeAway(page, "Manifest"));
  await run("field", join(where, "image.hex"), "--plane", "xy@z=130", "--step", 1, "--extent", 80, "--quantity", "rms", "-o", join(where, "plane.csv"));
  const rows = readFileSync(join(where, "plane.csv"), "utf8").trim().split("\n").filter((line) => /^[-\d]/.test(line));
  const expected = rows.map((row) => Number(row.split(",").at(-1)) ** 2);
  assert.equal(expected.length, 161 * 161);
  const scene = await page.evaluate(
    () => new Promise((done) => {
      const socket = new WebSocket(`ws://${location.host}/ws`, ["haptogram.1", `token.${sessionStorage.getItem("token")}`]);
      socket.onopen = () => socket.send(JSON.stringify({ t: "scene", n: 1, document: { format: "haptogram-project-1", rate_hz: 7, shape: [{ kind: "hemisphere" }] } }));
      socket.onmessage = ({ data }) => typeof data === "string" && JSON.parse(data).t === "scene" && done(JSON.parse(data).scene.name);
    }),
  );
  const ask = { t: "slice", n: 1, scene, width: 161, height: 161, record: 0, view: 0 };
  const peak = Math.max(...expected);
  const off = (values) => Math.max(...values.map((value, i) => Math.abs(value - expected[i]))) / peak;
  const along = off(await askSlice(page, { ...ask, origin: [-80, -80, 130], u: [160, 0, 0], v: [0, 160, 0] }));
  // Turned by half a turn the slice takes the way for planes in any direction; its values come in the opposite order.
  const turned = off((await askSlice(page, { ...ask, origin: [80, 80, 130], u: [-160, 0, 0], v: [0, -160, 0] })).reverse());
  const askew = off((await askSlice(page, { ...ask, origin: [80, -80, 130], u: [-160, 0, 1e-9], v: [0, 160, 0] })).map((_, i, all) => all[161 * Math.floor(i / 161) + 160 - (i % 161)]));
  t.diagnostic(`of the peak: ${along.toExponential(1)} along the axes, ${turned.toExponential(1)} the other way round, ${askew.toExponential(1)} askew`);
  assert.ok(Math.max(along, turned, askew) <= 1e-5);
});

/** Moves the plane to and fro for some seconds. @return slices and frames a second */
const movePlane = (page) =>
  page.evaluate(async () => {
    const slider = document.querySelector("#right input[type=range]");
    const app = document.getElementById("app");
    const begun = performance.now(), before = Number(app.dataset.slices);
    let frames = 0;
    await new Promise((done) => {
      const step = () => {
        slider.value = String(130 + 40 * Math.sin((performance.now() - begun) / 300));
        slider.dispatchEvent(new Event("input", { bubbles: true }));
        frames++;
        if (performance.now() - begun < 4000) requestAnimationFrame(step);
        else done();
      };
      step();
    });
    const seconds = (performance.now() - begun) / 1000;
    return { hz: (Number(app.dataset.slices) - before) / seconds, frames: frames / seconds };
  });

test("a slice follows the hand, and is whole at rest", async (t) => {
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t), studio);
  const follows = async (what) => {
    await settled(page);
    await show(page, "See");
    const moved = await movePlane(page);
    t.diagnostic(`${what}: ${moved.hz.toFixed(1)} slices/s at ${moved.frames.toFixed(1)} frames/s`);
    assert.ok(moved.hz > 1.5, "slices come while the plane moves, however busy this machine is; without care there are none");
  };
  await follows("sequence of 200 foci");
  await page.getByLabel("Focal point", { exact: true }).press("End");
  await page.getByLabel("Only the marked point").check();
  await follows("one focus");
  await page.getByLabel("Only the marked point").uncheck();
  await settled(page);
  await page.getByLabel("Plane", { exact: true }).selectOption("xz");
  await settled(page);
  await page.getByLabel("Shown", { exact: true }).selectOption("below");
  const before = await slices(page);
  await picture(page, "upright-decibels");
  await page.getByLabel("Shown", { exact: true }).selectOption("rms");
  await page.getByLabel("Shown", { exact: true }).selectOption("level");
  assert.match(await page.locator(".bar").innerText(), /Sound pressure level, dB/);
  assert.equal(await slices(page), before, "another quantity needs no new slice");
});

test("files of every kind are dropped, and bad ones are named", async (t) => {
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t), studio, { allowed: /status of 422/ });
  await settled(page);
  for (const name of ["plyfile_little.ply", "trimesh.obj", "trimesh_binary.stl", "trimesh_cloud.xyz", "numpy_header.csv"]) {
    await drop(page, [{ name, bytes: readFileSync(join(shapes, name)) }]);
    await page.locator(".file", { hasText: name }).waitFor();
    await settled(page);
    assert.equal(await page.locator(".failed").count(), 0, name);
  }
  await drop(page, [{ name: "broken.ply", bytes: Buffer.from("ply\nformat ascii 1.0\nelement vertex 3\n") }]);
  await page.locator(".failed", { hasText: "broken.ply" }).waitFor();
  await drop(page, [{ name: "garbage.xyz", bytes: Buffer.from([0xff, 0xfe, 0x00, 0x20, 0xc3, 0x28, 0x0a]) }]);
  await page.locator(".failed", { hasText: "garbage.xyz" }).waitFor();
  await drop(page, [{ name: "picture.png", bytes: Buffer.from("x") }]);
  await page.locator(".failed", { hasText: "picture.png" }).waitFor();
  assert.ok(!(await page.locator(".failed").innerText()).includes("/"), "no path of the server");
  const hostile = "<img src=x onerror=alert(1)>.xyz";
  await drop(page, [{ name: hostile, bytes: Buffer.from("0 0 0\n10 0 0\n0 10 0\n") }]);
  await page.locator(".file", { hasText: hostile }).waitFor();
  await settled(page);
  assert.equal(await page.locator("img:not(.gallery img)").count(), 0);
  for (let i = 0; i < 20 && (await page.getByRole("button", { name: "Undo" }).isEnabled()); i++) await page.keyboard.press("Control+z");
  await hasValue(page.getByLabel("Shape", { exact: true }), "hemisphere");
  await settled(page);
});

test("large files: from the drop to the mean field of their foci", async (t) => {
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t), studio);
  await settled(page);
  // A sphere of 69,120 triangles as binary STL, 3.5 MB; a dome of a million points as PLY, 12 MB.
  const rings = 144, sides = 240;
  const at = (i, j) => {
    const a = (Math.PI * i) / rings, b = (2 * Math.PI * j) / sides;
    return [30 * Math.sin(a) * Math.cos(b), 30 * Math.sin(a) * Math.sin(b), 30 * Math.cos(a)];
  };
  const corners = [];
  for (let i = 0; i < rings; i++) for (let j = 0; j < sides; j++) corners.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
  const stl = Buffer.alloc(84 + 50 * corners.length);
  stl.writeUInt32LE(corners.length, 80);
  corners.forEach((triangle, k) => triangle.flat().forEach((value, m) => stl.writeFloatLE(value, 84 + 50 * k + 12 + 4 * m)));
  const count = 1_000_000;
  const head = Buffer.from(`ply\nformat binary_little_endian 1.0\nelement vertex ${count}\nproperty float x\nproperty float y\nproperty float z\nend_header\n`);
  const points = new Float32Array(3 * count);
  for (let i = 0; i < count; i++) {
    const z = (i + 0.5) / count, r = Math.sqrt(1 - z * z), a = 2.399963 * i;
    points.set([30 * r * Math.cos(a), 30 * r * Math.sin(a), 30 * z], 3 * i);
  }
  for (const [name, bytes] of [["sphere.stl", stl], ["dome.ply", Buffer.concat([head, Buffer.from(points.buffer)])]]) {
    await page.evaluate(() => {
      window.took = undefined;
      const name = () => document.querySelector("footer").innerText;
      const app = document.getElementById("app");
      document.addEventListener("drop", () => {
        const begun = performance.now();
        let compiling = false;
        const look = new MutationObserver(() => {
          if (name().startsWith("Compiling")) compiling = true;
          if (compiling && !name().startsWith("Compiling")) {
            look.disconnect();
            const before = app.dataset.slices;
            const next = new MutationObserver(() => {
              if (app.dataset.slices === before) return;
              next.disconnect();
              window.took = performance.now() - begun;
            });
            next.observe(app, { attributes: true });
          }
        });
        look.observe(document.querySelector("footer"), { subtree: true, childList: true, characterData: true });
      }, { once: true, capture: true });
    });
    await drop(page, [{ name, bytes }]);
    await page.waitForFunction(() => window.took !== undefined, null);
    t.diagnostic(`${name}, ${(bytes.length / 1e6).toFixed(1)} MB: mean field after ${(await page.evaluate(() => window.took)).toFixed(0)} ms`);
    await settled(page);
    assert.equal(await page.locator(".failed").count(), 0);
  }
  await picture(page, "dropped-dome");
});

test("the amplitude is the project's, and of every record", async (t) => {
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t), studio);
  await settled(page);
  const amplitude = page.getByLabel("Amplitude", { exact: true });
  await hasValue(amplitude, "100");
  for (const wrong of ["0", "101", "x"]) {
    await amplitude.fill(wrong);
    await amplitude.press("Enter");
    await page.locator(".wrong-value", { hasText: "100 stays" }).waitFor();
  }
  await amplitude.fill("40");
  await amplitude.press("Enter");
  await page.locator("#view[aria-busy=true]").waitFor({ timeout: 2000 }).catch(() => {});
  await settled(page);
  assert.match(String(await takeAway(page, "Project")), /^amplitude = 0\.4$/m);
  assert.ok(JSON.parse(await takeAway(page, "Manifest")).records.every((record) => record.amplitude === 0.4));
  await page.keyboard.press("Control+z");
  await hasValue(amplitude, "100");
});

test("what is taken away is what the command line makes", async (t) => {
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t), studio);
  await settled(page);
  const where = await folder(t);
  const name = "trimesh_binary.stl";
  writeFileSync(join(where, name), readFileSync(join(shapes, name)));
  await drop(page, [{ name, bytes: readFileSync(join(shapes, name)) }]);
  await page.locator(".file", { hasText: name }).waitFor();
  await page.getByLabel("Focal points", { exact: true }).fill("50");
  await page.getByLabel("Focal points", { exact: true }).press("Enter");
  await page.getByLabel("Turn about y", { exact: true }).fill("12.5");
  await page.getByLabel("Turn about y", { exact: true }).press("Enter");
  await page.getByLabel("Centre z", { exact: true }).press("Shift+ArrowUp");
  await hasValue(page.getByLabel("Centre z", { exact: true }), "140");
  await page.locator("footer", { hasText: "50 focal points" }).waitFor();
  await settled(page);
  writeFileSync(join(where, "project.toml"), await takeAway(page, "Project"));
  const [hex, manifest] = [await takeAway(page, "Image"), await takeAway(page, "Manifest")];
  await run("compile", join(where, "project.toml"), "-o", join(where, "image.hex"));
  assert.deepEqual(hex, readFileSync(join(where, "image.hex")));
  assert.deepEqual(manifest, readFileSync(join(where, "image.json")));
  await run("compile", join(where, "project.toml"), "-o", join(where, "again.hex"), "--readmemh", join(where, "again"));
  assert.deepEqual(await takeAway(page, "Records (.mem)"), readFileSync(join(where, "again.primary.mem")));
  assert.deepEqual(await takeAway(page, "Sequence (.mem)"), readFileSync(join(where, "again.sequence.mem")));
  const methods = await run("report", join(where, "image.hex"), "--methods");
  await page.context().grantPermissions(["clipboard-read", "clipboard-write"]);
  await page.getByRole("button", { name: "Copy methods text" }).click();
  const copied = () => page.evaluate(() => navigator.clipboard.readText());
  await eventually(async () => (await copied()).startsWith("The stimulus"));
  assert.equal((await copied()) + "\n", methods);
  // The report is a page of its own: it has all foci and a picture, and asks for nothing.
  writeFileSync(join(where, "report.html"), await takeAway(page, "Report"));
  const report = await page.context().newPage();
  const asked = [];
  report.on("request", (request) => asked.push(request.url()));
  await report.goto(`file://${join(where, "report.html")}`);
  assert.equal(await report.locator("p").first().innerText(), methods.trim());
  assert.equal(await report.locator("table.foci tbody tr").count(), 50);
  assert.ok((await report.locator("img").evaluate((image) => image.naturalWidth)) > 300);
  assert.deepEqual(asked.filter((url) => !url.startsWith("file:") && !url.startsWith("data:")), []);
  await accessible(report);
  await picture(report, "report");
  await report.close();
  // And a studio that is started with that project makes them, too.
  const second = await startStudio(t, join(where, "project.toml"));
  const again = await openPage(t, await startBrowser(t), second);
  await settled(again);
  assert.deepEqual(await takeAway(again, "Image"), hex);
});

test("a board's bitstream holds the image, as the command line makes it", async (t) => {
  const placed = join(shapes, "../../../build/boards");
  const studio = await startStudio(t, "--placed", placed);
  const page = await openPage(t, await startBrowser(t), studio, { allowed: /422/ });
  await settled(page);
  const button = page.getByRole("button", { name: "with autostart" });
  assert.ok(await button.isDisabled());
  const board = "ice40-hx8k-breakout";
  const choose = async (on) => {
    await on.getByLabel("Focal points", { exact: true }).fill("20");
    await on.getByLabel("Focal points", { exact: true }).press("Enter");
    await on.getByLabel("For board", { exact: true }).selectOption(board);
    await on.locator("footer", { hasText: "20 focal points" }).waitFor();
    await settled(on);
  };
  await choose(page);
  assert.match(await page.locator("pre.command").innerText(), new RegExp(`haptogram bitstream --board ${board} --image image.hex -o ${board}.bin`));
  if (existsSync(join(placed, board, "placed.asc"))) {
    const where = await folder(t);
    writeFileSync(join(where, "image.hex"), await takeAway(page, "Image (.hex)"));
    await run("bitstream", "--board", board, "--placed", placed, "--image", join(where, "image.hex"), "--autostart", "-o", join(where, "made.bin"));
    assert.deepEqual(await takeAway(page, "with autostart"), readFileSync(join(where, "made.bin")));
    await run("bitstream", "--board", board, "--placed", placed, "--image", join(where, "image.hex"), "-o", join(where, "silent.bin"));
    assert.deepEqual(await takeAway(page, `${board}.bin`), readFileSync(join(where, "silent.bin")));
  } else t.diagnostic(`${board} is not placed here`);
  // One that was never placed says how.
  const unplaced = await startStudio(t, "--placed", await folder(t));
  const other = await openPage(t, await startBrowser(t), unplaced, { allowed: /422/ });
  await settled(other);
  await choose(other);
  await other.getByRole("button", { name: `${board}.bin` }).click();
  await other.locator(".failed", { hasText: `make bitstream BOARD=${board}` }).waitFor();
});

test("a document that makes no sense is explained, and undone", async (t) => {
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t), studio);
  await settled(page);
  await page.getByLabel("Focal points", { exact: true }).fill("60000");
  await page.getByLabel("Focal points", { exact: true }).press("Enter");
  await page.locator(".failed").waitFor();
  await accessible(page);
  await picture(page, "failed");
  await page.getByRole("button", { name: "Undo" }).click();
  await page.locator(".failed").waitFor({ state: "detached" });
  await settled(page);
  // By the page's label, not by the project's key.
  await page.getByLabel("Passes a second", { exact: true }).fill("100000");
  await page.getByLabel("Passes a second", { exact: true }).press("Enter");
  await page.locator(".failed").waitFor();
  assert.equal(await page.locator(".failed strong").innerText(), "Passes a second");
});

test("messages that make no sense end the connection, and nothing else", async (t) => {
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t), studio);
  await settled(page);
  for (const message of ["{", '{"t":"fly"}', '{"t":"stop","n":1,"x":2}', "x".repeat(2_000_000)]) {
    const code = await page.evaluate(
      (message) => new Promise((done) => {
        const socket = new WebSocket(`ws://${location.host}/ws`, ["haptogram.1", `token.${sessionStorage.getItem("token")}`]);
        socket.onopen = () => socket.send(message);
        socket.onclose = (event) => done(event.code);
      }),
      message,
    );
    assert.ok([1008, 1009, 1006].includes(code), `${message.slice(0, 20)}: ${code}`);
  }
  await page.getByLabel("Focal points", { exact: true }).fill("20");
  await page.getByLabel("Focal points", { exact: true }).press("Enter");
  await page.locator("footer", { hasText: "20 focal points" }).waitFor();
});

test("the server is started again, and the page goes on", async (t) => {
  const studio = await startStudio(t);
  const { port } = new URL(studio.origin);
  const page = await openPage(t, await startBrowser(t), studio, { mayFail: true }); // the browser logs lost connections
  await settled(page);
  studio.child.kill("SIGKILL");
  await page.locator("#banner", { hasText: "The server is gone" }).waitFor();
  await accessible(page);
  await picture(page, "server-gone");
  await studio.ended;
  const second = await startStudio(t, "--port", port);
  await page.locator("#banner", { hasText: "does not take this page's key" }).waitFor();
  await page.goto("about:blank");
  await page.goto(second.address);
  await settled(page);
});

test("a narrow window shows STOP first, and without WebGL the rest works", async (t) => {
  const studio = await startStudio(t);
  const page = await openPage(t, await startBrowser(t, "--disable-3d-apis"), studio, { mayFail: true }); // three.js logs it
  await page.locator(".failed", { hasText: "There is no 3-D view" }).waitFor();
  await settled(page);
  await page.setViewportSize({ width: 360, height: 640 });
  const box = await page.locator("#stop").boundingBox();
  assert.ok(box.x >= 0 && box.x + box.width <= 360 && box.y < 200, JSON.stringify(box));
  await accessible(page);
  await picture(page, "narrow");
});
