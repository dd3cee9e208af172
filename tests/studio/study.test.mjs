// SPDX-License-Identifier: Apache-2.0
// Studies in the page: a participant's session by buttons and keys, against the same session in a terminal, and all that ends it.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { existsSync, readdirSync, readFileSync, readlinkSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { accessible, boardSays, eventually, folder, openPage, picture, run, settled, sleep, start, startBrowser, startStudio } from "./support.mjs";

const root = join(dirname(fileURLToPath(import.meta.url)), "../..");
const python = existsSync(join(root, "build/venv/bin/python3")) ? join(root, "build/venv/bin/python3") : "python3";

const short = `format = "haptogram-protocol-1"
name = "short"
title = "A short study"
source = "this test"
participants = 2
instructions = ["Rest your palm on the stand."]

[[factor]]
name = "shape"
levels = ["circle", "line"]

[order]
within = "random"
repetitions = 2

[stimulus]
text = "the {shape}"
compile = ["--shape", "{shape}", "--rate", "500", "--points", "4", "--loops", "0"]

[[question]]
name = "answer"
text = "Which shape is it?"
kind = "choice"
keys = { a = "circle", l = "line" }
correct = "{shape}"

[[question]]
name = "sure"
text = "How sure are you?"
kind = "scale"
from = 1
to = 5

[[question]]
name = "size"
text = "How large is it, in mm?"
kind = "number"
from = 0
to = 500

[[question]]
name = "words"
text = "What was it like?"
kind = "text"
when = "end"
`;

/** A studio whose project stands in a folder beside the protocol, and its page of studies. */
async function studies(t, options = {}, protocol = short) {
  const where = await folder(t);
  writeFileSync(join(where, "short.toml"), protocol);
  writeFileSync(join(where, "project.toml"), 'format = "haptogram-project-1"\nrate_hz = 500\npoints = 4\n[[shape]]\nkind = "circle"\n');
  const studio = await startStudio(t, join(where, "project.toml"));
  const page = await openPage(t, await startBrowser(t), studio, options);
  await choose(page);
  return { where, studio, page };
}

async function choose(page) {
  await page.getByRole("button", { name: "Study" }).click();
  await page.getByLabel("Protocol").selectOption("short.toml");
  await page.getByLabel("Participant", { exact: true }).fill("2");
  await page.getByLabel("Seed").fill("7");
  await page.getByLabel("Results file").fill("p2.jsonl");
}

const begin = (page) => page.getByRole("button", { name: "Begin, or go on" }).click();
const trial = (page) => page.getByRole("button", { name: "Begin the trial" });
const question = (page, words) => page.locator(".question", { hasText: words });
const says = (page, words) => page.locator("#study", { hasText: words }).waitFor();
const records = (path) => readFileSync(path, "utf8").trimEnd().split("\n").map((line) => JSON.parse(line));

/** Waits until a trial may begin; a session that ends instead fails with what the page says of it. */
async function begun(page) {
  await trial(page).or(page.getByRole("button", { name: /^(Try again|Go on)$/ })).waitFor();
  assert.ok(await trial(page).isVisible(), await page.locator("#study").innerText());
}

/** Answers a trial by keys alone. */
async function byKeys(page, key) {
  await eventually(async () => (await trial(page).count()) === 1 && (await trial(page).evaluate((each) => each === document.activeElement)));
  await page.keyboard.press("Enter");
  await question(page, "Which shape").waitFor();
  await page.keyboard.press(key);
  await question(page, "How sure").waitFor();
  await page.keyboard.press("4");
  await question(page, "How large").waitFor();
  await page.keyboard.type("12.5");
  await page.keyboard.press("Enter");
}

/** The processes of the runner that work in this folder. */
const runners = (where) =>
  readdirSync("/proc").filter((name) => {
    try {
      return /^\d+$/.test(name) && readFileSync(`/proc/${name}/cmdline`, "latin1").includes("haptogram_study\0run") && readlinkSync(`/proc/${name}/cwd`) === where;
    } catch {
      return false; // it has ended
    }
  });

test("a session by buttons and by keys, stopped, gone on with, and equal to the terminal's", async (t) => {
  const { where, page } = await studies(t);
  await says(page, "4 trials a participant");
  await accessible(page);
  await picture(page, "study-choose-light");
  await begin(page);
  await says(page, "Rest your palm on the stand.");
  await says(page, "Trial 1 of 4");
  await page.getByText("what is presented").click();
  await page.getByText(/^the (circle|line)$/).waitFor();
  await trial(page).click();
  await question(page, "Which shape").waitFor();
  await accessible(page);
  await picture(page, "study-choice-light");
  await page.getByRole("button", { name: "circle a" }).click();
  await page.getByRole("group", { name: "How sure" }).getByRole("button", { name: "2" }).click();
  await question(page, "How large").waitFor();
  await page.getByRole("textbox").fill("huge");
  await page.getByRole("button", { name: "Answer" }).click();
  await page.getByText("type a number from 0 to 500").waitFor();
  await accessible(page);
  await picture(page, "study-number-light");
  await page.getByRole("textbox").fill("80");
  await page.getByRole("button", { name: "Answer" }).click();
  await says(page, "Trial 2 of 4");
  await says(page, "1 of 4");
  await page.getByRole("button", { name: "Pause the session" }).click();
  await says(page, "The session was stopped.");
  await says(page, "stopped after 1 more answers");
  await accessible(page);
  await picture(page, "study-stopped-light");
  assert.equal(records(join(where, "p2.jsonl")).length, 1);

  await page.getByRole("button", { name: "Theme" }).click();
  await page.getByRole("button", { name: "Go on" }).click();
  await says(page, "goes on after 1 records");
  for (const key of ["l", "a", "l"]) await byKeys(page, key);
  await question(page, "What was it like?").waitFor();
  await accessible(page);
  await picture(page, "study-text-dark");
  await page.keyboard.type("soft <b>&\nwarm");
  await page.getByRole("button", { name: "Answer" }).click();
  await says(page, "The session is complete.");
  await says(page, join(where, "p2.jsonl"));
  await accessible(page);
  await picture(page, "study-complete-dark");

  const ours = records(join(where, "p2.jsonl"));
  assert.ok(readFileSync(join(where, "p2.jsonl"), "utf8").endsWith("}\n"));
  const terminal = spawn(python, ["-m", "haptogram_study", "run", "short.toml", "--participant", "2", "--seed", "7", "-o", "terminal.jsonl"], {
    cwd: where,
    env: { ...process.env, PYTHONPATH: `${join(root, "python")}:${join(root, "extras/studies")}` },
    stdio: ["pipe", "ignore", "ignore"],
  });
  terminal.stdin.end(["a\n2\n80", "l\n4\n12.5", "a\n4\n12.5", "l\n4\n12.5"].map((each) => `\n${each}\n`).join("") + "soft <b>& warm\n");
  assert.equal(await new Promise((done) => terminal.on("exit", done)), 0);
  const theirs = records(join(where, "terminal.jsonl"));
  assert.equal(ours.length, 5);
  assert.equal(ours[4].answers.words.value, "soft <b>&\nwarm");
  // All but who answered, when, and how fast; a terminal takes no two lines of words.
  const same = (record) => {
    const { observer, at, ...rest } = structuredClone(record);
    for (const answer of Object.values(rest.answers)) delete answer.seconds;
    delete rest.answers.words;
    return JSON.stringify(rest);
  };
  assert.deepEqual(ours.map(same), theirs.map(same));
  assert.deepEqual([ours[0].observer, theirs[0].observer], ["page", "keyboard"]);
  assert.deepEqual(ours.map((record) => Object.keys(record).join()), theirs.map((record) => Object.keys(record).join()));

  // The file of another participant is refused, in the runner's words.
  await page.getByRole("button", { name: "Another session" }).click();
  await page.getByLabel("Participant", { exact: true }).fill("3");
  await begin(page);
  await page.getByRole("alert").filter({ hasText: "name another file for this session" }).waitFor();
  await accessible(page);
  await picture(page, "study-refused-dark");
});

test("STOP ends the runner, and so does a page that is closed and a server that is killed", async (t) => {
  const { where, studio, page } = await studies(t, { mayFail: true });
  await begin(page);
  await trial(page).click();
  await question(page, "Which shape").waitFor();
  assert.equal(runners(where).length, 1);
  const begun = performance.now();
  await page.getByRole("button", { name: "STOP" }).click();
  await eventually(() => runners(where).length === 0);
  t.diagnostic(`STOP to the runner's end: ${(performance.now() - begun).toFixed(0)} ms`);
  await says(page, "The session was stopped.");
  await says(page, "stopped after 0 more answers");
  await page.getByRole("button", { name: "Go on" }).click();
  await byKeys(page, "a");
  await says(page, "Trial 2 of 4");
  await page.reload();
  await eventually(() => runners(where).length === 0);
  assert.equal(records(join(where, "p2.jsonl")).length, 1);
  // What was chosen is still there.
  await page.getByRole("button", { name: "Study" }).click();
  await page.getByLabel("Protocol").waitFor();
  await page.getByLabel("Results file").fill("p2.jsonl");
  await begin(page);
  await says(page, "goes on after 1 records");
  await trial(page).waitFor();
  studio.child.kill("SIGKILL");
  await eventually(() => runners(where).length === 0);
  assert.equal(records(join(where, "p2.jsonl")).length, 1);
});

test("stimuli are played on the studio's board, which is lent and taken back", async (t) => {
  const { page, where } = await studies(t);
  await page.getByRole("button", { name: "Study" }).click();
  await settled(page);
  await page.getByRole("button", { name: "Start a virtual board" }).click();
  await boardSays(page, "virtual board, outputs off");
  await page.getByRole("button", { name: "Study" }).click();
  await page.getByLabel("Stimuli").selectOption("studio");
  await begin(page);
  await boardSays(page, "lent to the study");
  await begun(page);
  await trial(page).click();
  await question(page, "Which shape").waitFor();
  await page.keyboard.press("Escape");
  await says(page, "The session was stopped.");
  await boardSays(page, "virtual board, outputs off");
  assert.equal(await page.locator("#banner").isVisible(), false, "the end of the outputs was confirmed");
  await page.getByRole("button", { name: "Go on" }).click();
  await byKeys(page, "a");
  await says(page, "Trial 2 of 4");
  // A page that hangs ends the session while a stimulus plays, and only then.
  const hang = () => page.evaluate(() => {
    for (const until = performance.now() + 3000; performance.now() < until;);
  });
  await trial(page).waitFor();
  await hang();
  await trial(page).click();
  await question(page, "Which shape").waitFor();
  await hang();
  await says(page, "The session was stopped.");
  await page.locator("#banner", { hasText: "was silent" }).waitFor();
  await boardSays(page, "virtual board, outputs off");
  const [record] = records(join(where, "p2.jsonl"));
  assert.ok(record.stimulus.played && record.versions.haptogram && existsSync(join(where, "study-images", record.stimulus.image)));
  await accessible(page);
});

test("a board at another port plays, and is off after the page was closed and after the server was killed", async (t) => {
  const { page, where, studio } = await studies(t, { mayFail: true });
  const pulses = join(where, "pulses.csv");
  const board = await start(t, "board", "run", "--json", "--pty", join(where, "port"), "--pulses", pulses);
  const status = async () => JSON.parse(await run("device", "status", "--json", "--port", board.first.port));
  const choosePort = async (page) => {
    await page.getByLabel("Stimuli").selectOption("port");
    await page.getByLabel("Board's port").fill(board.first.port);
    await begin(page);
    await trial(page).click();
    await question(page, "Which shape").waitFor();
  };
  await choosePort(page);
  await sleep(500);
  await page.close();
  await eventually(() => runners(where).length === 0);
  assert.equal((await status()).outputs, "off");
  const again = await openPage(t, await startBrowser(t), studio, { mayFail: true });
  await choose(again);
  await choosePort(again);
  await sleep(500);
  studio.child.kill("SIGKILL");
  await eventually(() => runners(where).length === 0);
  assert.equal((await status()).outputs, "off");
  board.child.kill("SIGINT");
  assert.equal(JSON.parse((await board.lines.next()).value).enabled, false);
  await board.ended;
  assert.ok(readFileSync(pulses, "utf8").trim().split("\n").length > 100, "it had played");
});

test("a session by the keyboard alone, from the choice on", async (t) => {
  const { page, where } = await studies(t);
  await page.reload();
  await page.getByRole("button", { name: "Study" }).waitFor();
  /** Tabs to what has this name. */
  const to = async (name) => {
    for (let i = 0; i < 40; i++) {
      await page.keyboard.press("Tab");
      if (await page.evaluate((name) => (document.activeElement.labels?.[0] ?? document.activeElement).textContent === name, name)) return;
    }
    assert.fail(`${name} cannot be reached by Tab`);
  };
  await to("Study");
  await page.keyboard.press("Enter");
  await page.getByLabel("Protocol").waitFor();
  await to("Protocol");
  await page.keyboard.type("short");
  await to("Results file");
  await page.keyboard.press("Control+A");
  await page.keyboard.type("keys.jsonl");
  await to("Begin, or go on");
  await page.keyboard.press("Enter");
  for (const key of ["l", "a", "l", "a"]) await byKeys(page, key);
  await question(page, "What was it like?").waitFor();
  await page.keyboard.type("light");
  await to("Answer");
  await page.keyboard.press("Enter");
  await says(page, "The session is complete.");
  assert.equal(records(join(where, "keys.jsonl")).length, 5);
});

/** What the server answers to a message on a connection of the test's own, and whether it then closes. */
const send = (page, message) =>
  page.evaluate(async (message) => {
    const socket = new WebSocket(`ws://${location.host}/ws`, ["haptogram.1", `token.${sessionStorage.getItem("token")}`]);
    await new Promise((done) => (socket.onopen = done));
    const answer = await new Promise((done) => {
      socket.onmessage = ({ data }) => typeof data === "string" && ["error", "failed", "study"].includes(JSON.parse(data).t) && done(JSON.parse(data));
      socket.send(JSON.stringify(message));
    });
    const closed = answer.t === "error" && (await new Promise((done) => (socket.onclose = () => done(true))));
    socket.close();
    return { ...answer, closed };
  }, message);

test("hostile messages are refused, and a second session, too", async (t) => {
  const { where, page } = await studies(t);
  const good = { t: "study", n: 1, protocol: "short.toml", participant: 1, seed: 1, results: "x.jsonl", port: "" };
  for (const [wrong, words] of [
    [{ protocol: "../short.toml" }, /'protocol' is no name/],
    [{ results: "/tmp/x.jsonl" }, /'results' is no name/],
    [{ results: "project.toml" }, /ends in .jsonl/],
    [{ protocol: "--help" }, /'protocol' is no name/],
    [{ observer: "simulated:chance" }, /unknown member/],
    [{ participant: 1e9 }, /participant/],
    [{ port: "a\n" }, /control/],
  ]) {
    const answer = await send(page, { ...good, ...wrong });
    assert.match(answer.error?.message ?? "", words);
    assert.ok(answer.closed);
  }
  assert.match((await send(page, { ...good, port: "studio" })).error.message, /no connection/);
  assert.equal(runners(where).length, 0);
  await begin(page);
  await trial(page).waitFor();
  assert.match((await send(page, good)).error.message, /under way/);
  // Another page's answers are not this session's.
  await page.evaluate(async () => {
    const socket = new WebSocket(`ws://${location.host}/ws`, ["haptogram.1", `token.${sessionStorage.getItem("token")}`]);
    await new Promise((done) => (socket.onopen = done));
    socket.send(JSON.stringify({ t: "answer", n: 1, number: 1, text: "" }));
    socket.send(JSON.stringify({ t: "leave", n: 2 }));
    await new Promise((done) => setTimeout(done, 300));
    socket.close();
  });
  await sleep(300);
  assert.ok(await trial(page).isVisible());
  assert.equal(runners(where).length, 1);
  assert.ok(!existsSync(join(where, "x.jsonl")));
});

test("a protocol that is wrong, and a Python that does not start, are said in the page", async (t) => {
  const { page, where } = await studies(t, {}, short.replace("participants = 2", "participants = 0"));
  await page.getByText(/participants.*found 0/).waitFor();
  assert.ok(await page.getByRole("button", { name: "Begin, or go on" }).isDisabled());
  await accessible(page);
  process.env.PYTHONHOME = "/nowhere"; // Python then finds none of its parts
  t.after(() => delete process.env.PYTHONHOME);
  const studio = await startStudio(t, join(where, "project.toml"));
  delete process.env.PYTHONHOME;
  const other = await openPage(t, await startBrowser(t), studio);
  await other.getByRole("button", { name: "Study" }).click();
  await says(other, "the runner of studies did not start");
  await accessible(other);
  await other.getByRole("button", { name: "Study" }).click();
  await settled(other);
});
