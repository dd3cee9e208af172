// SPDX-License-Identifier: Apache-2.0
// What the tests of the studio in a browser share: a server, a browser, and a page that is watched for what must not happen.
import assert from "node:assert/strict";
import { execFile, spawn } from "node:child_process";
import { existsSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { mkdtemp, rm } from "node:fs/promises";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { createInterface } from "node:readline";
import { fileURLToPath } from "node:url";
import { promisify } from "node:util";

const here = dirname(fileURLToPath(import.meta.url));
const require = createRequire(join(here, "../../extras/studio/web/package.json"));
const { chromium } = require("playwright-core");
const axeSource = readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");

export const program = process.env.HAPTOGRAM_PROGRAM;
assert.ok(program, "HAPTOGRAM_PROGRAM names the program to test");
export const shapes = join(here, "../data/shapes");
/** How long anything is waited for, ms: long enough for a machine that does much else, and the end of it is a failure. */
export const patience = 90_000;
export const sleep = (ms) => new Promise((done) => setTimeout(done, ms));

/** Runs the program to its end and returns what it printed. */
export async function run(...args) {
  return (await promisify(execFile)(program, args.map(String), { maxBuffer: 1 << 28 })).stdout;
}

/** A folder that is removed after the test. */
export async function folder(t) {
  const made = await mkdtemp(join(tmpdir(), "haptogram-studio-"));
  t.after(() => rm(made, { recursive: true, force: true }));
  return made;
}

/** Starts the program; its first line on standard output is JSON. It is ended after the test. */
export async function start(t, ...args) {
  const child = spawn(program, args.map(String), { stdio: ["ignore", "pipe", "pipe"] });
  let said = "";
  child.stderr.on("data", (bytes) => (said += bytes));
  const ended = new Promise((done) => child.on("exit", (code, signal) => done({ code, signal, said })));
  const lines = createInterface(child.stdout)[Symbol.asyncIterator]();
  const { value } = await Promise.race([lines.next(), ended.then((end) => assert.fail(JSON.stringify(end)))]);
  t.after(async () => {
    child.kill("SIGKILL");
    await ended;
  });
  return { child, ended, lines, first: JSON.parse(value) };
}

export async function startStudio(t, ...args) {
  const begun = performance.now();
  const studio = await start(t, "studio", "--no-browser", "--json", ...args);
  const address = new URL(studio.first.address);
  return { ...studio, startMs: performance.now() - begun, address: address.href, origin: address.origin, host: address.host, token: address.hash.slice(1) };
}

/** A browser that draws in software. */
export async function startBrowser(t, ...args) {
  const flags = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-dev-shm-usage", ...args];
  if (process.getuid() === 0) flags.push("--no-sandbox");
  const browser = await chromium.launch({ timeout: patience, executablePath: process.env.HAPTOGRAM_CHROMIUM ?? "/usr/bin/chromium", args: flags });
  t.after(() => browser.close());
  return browser;
}

/**
 * A page of the studio. After the test it must have had no error on its console, no violation of its policy, and no request
 * but to its server. Errors on its console that a test provokes are `allowed`; `mayFail` is for lost servers, of which the browser
 * says many things. `before` prepares the page before it is loaded.
 */
export async function openPage(t, browser, studio, { colorScheme = "light", mayFail = false, allowed = /^$/, firstVisit = false, before = async () => undefined } = {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 800 }, colorScheme, acceptDownloads: true });
  context.setDefaultTimeout(patience);
  const page = await context.newPage();
  const wrong = [];
  page.on("console", (message) => message.type() === "error" && wrong.push(`console: ${message.text()}`));
  page.on("pageerror", (error) => wrong.push(`error: ${error.message}`));
  page.on("request", (request) => {
    const url = new URL(request.url());
    if (!["blob:", "data:"].includes(url.protocol) && url.host !== studio.host) wrong.push(`request: ${url}`);
  });
  await page.exposeFunction("reportViolation", (text) => wrong.push(`policy: ${text}`));
  await page.addInitScript(() => {
    addEventListener("securitypolicyviolation", (event) => window.reportViolation(`${event.violatedDirective} ${event.blockedURI}`));
  });
  page.on("dialog", (dialog) => dialog.accept()); // of leaving a design that is not saved
  await before(page);
  if (!firstVisit) await page.addInitScript(() => localStorage.setItem("hinted", ""));
  await page.goto(studio.address);
  t.after(() => mayFail || assert.deepEqual(wrong.filter((each) => !allowed.test(each)), []));
  return guided(page);
}

/** Which of the page's three steps has what, by its label, the name of its button, its heading or its selector. */
const steps = {
  Make: ["Shape", "Focal points", "Passes a second", "Drawings a second", "Amplitude", "Strongest", "At the other side", "Modulation", "Pace", "Speed", "Passes in all", "Array", "For board", "All points feel alike", "Size", "Of several", "+ Add an object", "+ One afterwards", "Remove this one",
    "Unit of the file", "Upwards in the file", ...["x", "y", "z"].flatMap((axis) => [`Centre ${axis}`, `Turn about ${axis}`]), ".file", ".gallery", ".wrong-value", "Recording", "Algorithm", "Kind", "Frame", "This frame", "Frame number", "Palm height",
    "output.frame", "Touched object", "Hand", "Path", "Commands that make these paths", "Back to an object of focal points", "Path of this frame", "How strong each of 300 frames is; 300 touch the object", "Points of a pass", "Look through all frames", "Height (object)", "Let it move", "Let it stay in its place", "Remove this key frame", "Add a key frame after this one", "At", "From here it", "Shape here", "Lasts", "Draw a path by hand", "Draw another path", "Back to a built-in shape", "Beats", "Grown to", "Strength here", "Add a trigger", ...[1, 2, 3].flatMap((i) => [`Trigger ${i} is`, `Key of trigger ${i}`, `Trigger ${i} plays to`, `Trigger ${i} plays so often`, `Diameter of region ${i}`, `Remove trigger ${i}`]), ...["x", "y", "z"].flatMap((axis) => [`Moved by ${axis}`, `Turned by ${axis}`]), ...[1, 2, 3].map((i) => `Key frame ${i}, at ${(i - 1) / 2} s`)],
  See: ["Shown", "Colours", "Range", "Keep this scale", "Top", "Plane", "Height", "Middle x", "Middle y", "Middle z", "Back onto the object", "Only the marked point", "What one focus could have at each point", "On the skin of a hand, too", "Surface", "Handles", "Profile", "Numbers",
    "Compare", "Keep this to compare", "Show the kept one", "Go back to it", "Forget it", ".curve.kept", "Pins", "Simulate", "Stop simulating", "Simulate and measure the pins", "[data-verdict]", "[data-verdict=good]", "Along", "Carrier periods"],
  Play: ["Start a virtual board", "Choose a board…", "Simulate the FPGA's Verilog", "Port", "Rate", "Connect", "Disconnect", "Upload", "Intensity", "Follow the slider", "Modulate as shown", "Board", "Image", "Manifest", "Project", "Records", "Sequence", "Bundle", "Step", "pre.command",
    "Copy as command", "Copy methods text", "with autostart", "Report", "Study", "Field (.csv)", "Field (.png)", "Field (.npy)", "Field (.vti)", "Take away"],
};
function stepOf(name) {
  if (typeof name !== "string") return undefined;
  const kind = name.endsWith(".bin") ? "with autostart" : name.replace(/ \(.*$/, "");
  return Object.entries(steps).find(([, names]) => names.includes(name) || names.includes(kind))?.[0];
}

/** Goes to a step and unfolds all that it has. */
export async function show(page, step) {
  const tab = page.locator(`[data-step=${step}]`);
  await tab.waitFor();
  if ((await tab.getAttribute("aria-selected")) !== "true") await tab.click();
  await page.evaluate(() => document.querySelectorAll("aside details").forEach((each) => (each.open = true)));
}

/** A page, or a part of it, that goes to the step that has what is looked for, as a user does. */
function guided(page) {
  const real = Symbol("real");
  const plain = (value) => value?.[real] ?? value;
  const finders = new Set(["locator", "getByLabel", "getByRole", "getByText", "first", "last", "nth", "filter"]);
  const wrap = (target, step) =>
    new Proxy(target, {
      get(_, key) {
        if (key === real) return target;
        const value = target[key];
        if (typeof value !== "function") return value;
        if (finders.has(key))
          return (first, options) => {
            const given = options && Object.fromEntries(Object.entries(options).map(([name, each]) => [name, plain(each)]));
            const found = target[key](plain(first), given);
            const name = key === "getByRole" ? options?.name : key === "locator" && options?.has ? options.heading : first;
            return wrap(found, stepOf(name instanceof RegExp ? name.source : name) ?? step);
          };
        if (step === undefined || target === page || key === "count" || key === "elementHandle") return (...args) => value.apply(target, args.map(plain));
        return async (...args) => {
          await show(page, step);
          return await value.apply(target, args.map(plain));
        };
      },
    });
  return wrap(page, undefined);
}

/** The panel with a heading. */
export const panel = (page, title) => page.locator("section", { has: page.locator("h2", { hasText: new RegExp(`^${title}$`) }), heading: title });

/** Opens a design of the gallery. */
export const openDesign = (page, title) => page.locator(".gallery").locator("button", { has: page.locator("b", { hasText: new RegExp(`^${title}$`) }) }).click();

/** Waits until each focal point has been looked at. */
export const lookedAt = (page) => page.locator("[data-verdict-of-feel]:not([data-verdict-of-feel=looking])").waitFor();

/** Waits until a whole slice of the document's scene is shown and nothing else is to come. */
export async function settled(page) {
  await page.locator("footer", { hasText: /focal points? for/ }).waitFor();
  await page.locator("footer", { hasText: "slice 200 × 200" }).waitFor();
  await page.locator("#view[aria-busy=false]").waitFor();
}

/** Waits until something is so. @param words  what is there instead, for the message */
export async function eventually(isSo, words = () => "it never came to be") {
  for (const end = performance.now() + patience; !(await isSo()); await sleep(50)) if (performance.now() > end) assert.fail(await words());
}

/** Waits until a field has a value. */
export async function hasValue(field, value) {
  await eventually(async () => (await field.inputValue()) === value, async () => `${await field.inputValue()} instead of ${value}`);
}

/** Number of slices that were shown. */
export const slices = async (page) => Number((await page.locator("#app").getAttribute("data-slices")) ?? 0);

/** Hands files to the page as if they were dropped. */
export async function drop(page, files) {
  const transfer = await page.evaluateHandle((given) => {
    const data = new DataTransfer();
    for (const { name, base64 } of given) data.items.add(new File([Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))], name));
    return data;
  }, files.map(({ name, bytes }) => ({ name, base64: Buffer.from(bytes).toString("base64") })));
  await page.dispatchEvent("#view", "drop", { dataTransfer: transfer });
}

/** The bytes that a button gives to take away. */
export async function takeAway(page, button) {
  const waiting = page.waitForEvent("download");
  await page.getByRole("button", { name: button }).click();
  return readFileSync(await (await waiting).path());
}

/** Nothing that axe finds wrong, by the rules of WCAG 2.2 AA and of good practice. */
export async function accessible(page) {
  await page.evaluate(axeSource); // not bound by the page's policy
  const found = await page.evaluate(() =>
    window.axe.run(document, { runOnly: ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"] }),
  );
  const words = found.violations.map((each) => `${each.id}: ${each.nodes.map((node) => node.html + " " + node.failureSummary).join("\n")}`);
  assert.deepEqual(words, []);
  return found.passes.length;
}

const keptPictures = join(here, "pictures");
const mostDifferent = 0.005; // of a picture's pixels
const visible = 48; // difference of a colour, of 255, from which on it counts

/** What pictures depend on beside the page: the browser, and how wide its letters are. */
async function madeWith(page) {
  const width = await page.evaluate(() => {
    const context = document.createElement("canvas").getContext("2d");
    context.font = getComputedStyle(document.body).font;
    return context.measureText("Focal points in the air, 0123456789 mm").width;
  });
  return `Chromium ${page.context().browser().version().split(".")[0]}, letters ${width.toFixed(1)} wide`;
}

/** Half as large, without the line at the bottom, which has times. @param kept  a picture like it. @return itself, and the part of its pixels that differ */
const compared = (page, shot, kept) =>
  page.evaluate(
    async ([now, before, visible]) => {
      const half = async (url, scale) => {
        const image = new Image();
        image.src = url;
        await image.decode();
        const canvas = Object.assign(document.createElement("canvas"), { width: Math.round(image.width * scale), height: Math.round(image.height * scale) });
        const context = canvas.getContext("2d");
        context.drawImage(image, 0, 0, canvas.width, canvas.height);
        return { canvas, values: context.getImageData(0, 0, canvas.width, canvas.height).data };
      };
      const { canvas, values } = await half(now, 0.5);
      const small = canvas.toDataURL("image/webp", 0.85);
      if (!before) return { small };
      const { canvas: other, values: expected } = await half(before, 1);
      if (other.width !== canvas.width || other.height !== canvas.height) return { small, different: 1 };
      let count = 0;
      for (let i = 0; i < values.length; i += 4) if ([0, 1, 2].some((k) => Math.abs(values[i + k] - expected[i + k]) > visible)) count++;
      return { small, different: count / (values.length / 4) };
    },
    [`data:image/png;base64,${shot.toString("base64")}`, kept && `data:image/webp;base64,${kept.toString("base64")}`, visible],
  );

/** Leaves a picture of the page in the folder that HAPTOGRAM_SCREENSHOTS names, if any. */
export async function picture(page, name) {
  const where = process.env.HAPTOGRAM_SCREENSHOTS;
  if (!where) return;
  mkdirSync(where, { recursive: true });
  await page.screenshot({ path: join(where, `${name}.png`) });
}

/**
 * The same, and compares it with the one in pictures/, from which at most 0.5 % of its pixels may differ visibly. HAPTOGRAM_PICTURES=record
 * keeps it instead. With another browser or other letters there is nothing to compare, which is said.
 */
export async function keptPicture(page, name) {
  await page.getByText("points is being looked at").waitFor({ state: "hidden" });
  await picture(page, name);
  await page.mouse.move(0, 0); // what the pointer is over has another colour
  const { width, height } = page.viewportSize();
  const shot = await page.screenshot({ clip: { x: 0, y: 0, width, height: height - 28 }, animations: "disabled" });
  const [file, list] = [join(keptPictures, `${name}.webp`), join(keptPictures, "made_with.json")];
  const now = await madeWith(page);
  const all = existsSync(list) ? JSON.parse(readFileSync(list, "utf8")) : {};
  if (process.env.HAPTOGRAM_PICTURES === "record") {
    mkdirSync(keptPictures, { recursive: true });
    writeFileSync(file, Buffer.from((await compared(page, shot)).small.split(",")[1], "base64"));
    const sorted = Object.entries({ ...all, [name]: now }).sort(([a], [b]) => (a < b ? -1 : 1));
    return writeFileSync(list, `${JSON.stringify(Object.fromEntries(sorted), null, 1)}\n`);
  }
  assert.ok(existsSync(file), `${file} is missing; HAPTOGRAM_PICTURES=record makes it`);
  if (all[name] !== now) return console.log(`# ${name}: not compared; it was kept with ${all[name]}, and this is ${now}`);
  const { different } = await compared(page, shot, readFileSync(file));
  if (different <= mostDifferent) return;
  const left = join(tmpdir(), `haptogram-${name}.png`);
  writeFileSync(left, shot);
  assert.fail(`${name}: ${(100 * different).toFixed(2)} % of the picture differ, expected at most ${100 * mostDifferent} %. Compare ${left} with ${file}; if it is right, HAPTOGRAM_PICTURES=record keeps it`);
}

/** What the status line of the board says. */
export const boardSays = (page, text) => page.locator("#board", { hasText: text }).waitFor();

/** The part `part` of sorted numbers: 0.5 is the median. */
export function quantile(numbers, part) {
  const sorted = [...numbers].sort((a, b) => a - b);
  return sorted[Math.min(sorted.length - 1, Math.floor(part * sorted.length))];
}

/** Where the middle of the view is, in pixels of the page. */
export async function middle(page) {
  const box = await page.locator("#view canvas").boundingBox();
  return { x: box.x + box.width / 2, y: box.y + box.height / 2, box };
}

/** Where a point in millimetres is drawn by the view's first camera: its place, its target and its angle are those of view.ts. */
export function drawnAt([x, y, z], { x: middleX, y: middleY, box }) {
  const [eye, target, up] = [[260, -400, 340], [0, 0, 75], [0, 0, 1]];
  const minus = (a, b) => a.map((each, i) => each - b[i]);
  const dot = (a, b) => a.reduce((sum, each, i) => sum + each * b[i], 0);
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const unit = (a) => a.map((each) => each / Math.sqrt(dot(a, a)));
  const forward = unit(minus(target, eye)), right = unit(cross(forward, up)), above = cross(right, forward);
  const from = minus([x, y, z], eye);
  const size = box.height / 2 / Math.tan((19 * Math.PI) / 180) / dot(from, forward);
  return { x: middleX + size * dot(from, right), y: middleY - size * dot(from, above) };
}

/** The pixels of the view, as red, green and blue, one after the other. */
export async function pixels(page) {
  const shot = (await page.locator("#view canvas").screenshot()).toString("base64");
  return page.evaluate(async (base64) => {
    const image = new Image();
    image.src = `data:image/png;base64,${base64}`;
    await image.decode();
    const context = Object.assign(document.createElement("canvas"), { width: image.width, height: image.height }).getContext("2d");
    context.drawImage(image, 0, 0);
    return [...context.getImageData(0, 0, image.width, image.height).data].filter((_, i) => i % 4 !== 3);
  }, shot);
}

/**
 * The colours that the view has at places, by its first camera. What the panel below finds makes the view less high, so that it is looked at
 * again if it had another size afterwards. @return for a place in millimetres, the colours of its pixel and of its eight neighbours
 */
export async function coloursSeen(page) {
  for (;;) {
    const shown = await middle(page);
    const all = await pixels(page);
    if (JSON.stringify(await middle(page)) !== JSON.stringify(shown)) continue;
    const width = Math.round(shown.box.width);
    return (place) => {
      const at = drawnAt(place, shown);
      const [x, y] = [Math.round(at.x - shown.box.x), Math.round(at.y - shown.box.y)];
      return [0, -1, 1].flatMap((dy) => [0, -1, 1].map((dx) => all.slice(3 * ((y + dy) * width + x + dx), 3 * ((y + dy) * width + x + dx) + 3)));
    };
  }
}
