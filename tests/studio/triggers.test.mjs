// SPDX-License-Identifier: Apache-2.0
// Triggers: made in the page, the same in the project, and fired by keys and buttons while the virtual board plays.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { appendFileSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { accessible, boardSays, eventually, folder, openPage, panel, picture, run, settled, startBrowser, startStudio, takeAway } from "./support.mjs";

async function fill(page, label, value) {
  const field = page.getByLabel(label, { exact: true });
  await field.fill(String(value));
  await field.press("Enter");
}

/** A page whose design has two triggers, by keys. */
async function withTwo(t) {
  const page = await openPage(t, await startBrowser(t), await startStudio(t));
  await settled(page);
  await fill(page, "Focal points", 8);
  await page.locator("[data-step=Make]").click();
  const triggers = panel(page, "Triggers");
  await triggers.getByRole("button", { name: "Add a trigger" }).click();
  await triggers.getByRole("button", { name: "Add a trigger" }).click();
  return { page, triggers };
}

/** Waits until a part has begun. */
const plays = (page) => page.getByText("Outputs are on; it waits for a trigger.").waitFor({ state: "detached" });

test("triggers are made in the page, and a key or a button starts its part on the board", async (t) => {
  const { page, triggers } = await withTwo(t);
  await fill(page, "Trigger 1 plays to", 0.05);
  await page.getByLabel("Key of trigger 1", { exact: true }).fill("q");
  await settled(page); // what is typed stays when the page is drawn anew
  assert.equal(await page.getByLabel("Key of trigger 1", { exact: true }).inputValue(), "q");
  await page.getByLabel("Key of trigger 1", { exact: true }).press("Enter");
  await page.getByLabel("Trigger 2 is", { exact: true }).selectOption("region");
  await fill(page, "Diameter of region 2", 80);
  await fill(page, "Trigger 2 plays so often", 0);
  await settled(page);
  assert.ok((await accessible(page)) > 10);
  await picture(page, "triggers-light");
  assert.equal(await page.locator("path.trigger-at").count(), 1); // both begin at 0
  const where = await folder(t);
  writeFileSync(join(where, "design.haptogram"), await takeAway(page, "Bundle (.haptogram)"));
  const project = String(await takeAway(page, "Project (.toml)"));
  assert.match(project, /\[\[trigger\]\]\non = "key:q"\nto_s = 0\.05\n/);
  assert.match(project, /\[\[trigger\]\]\non = "region"\ncenter_mm = \[0(\.0)?, 0(\.0)?, 150(\.0)?\]\nsize_mm = 80(\.0)?\nloops = 0\n/);
  await run("compile", join(where, "design.haptogram"), "-o", join(where, "design.hex"));
  assert.equal(String(await takeAway(page, "Image (.hex)")), readFileSync(join(where, "design.hex"), "utf8"));
  // A key that another trigger has, and what no board has, are not taken.
  await page.locator("[data-step=Make]").click();
  await triggers.getByRole("button", { name: "Add a trigger" }).click();
  await fill(page, "Key of trigger 3", "q");
  assert.equal(await page.getByLabel("Key of trigger 3", { exact: true }).inputValue(), "a");
  await page.getByLabel("Trigger 3 is", { exact: true }).selectOption("pin");
  await page.locator(".failed", { hasText: "TRIGGER" }).waitFor();
  await triggers.getByRole("button", { name: "Remove trigger 3" }).click();
  await settled(page);
  // Play turns the outputs on, and waits.
  await page.locator("[data-step=Play]").click();
  await page.locator("button.play").first().click();
  await boardSays(page, "outputs ON");
  await page.getByText("Outputs are on; it waits for a trigger.").waitFor();
  await page.locator("body").press("x"); // no trigger
  await page.getByText("Outputs are on; it waits for a trigger.").waitFor();
  const buttons = page.getByRole("group", { name: "Triggers" });
  await buttons.getByRole("button", { name: "Region" }).click();
  await plays(page); // on and on
  await page.locator("body").press("q"); // which ends that, and itself
  await page.getByText("Outputs are on; it waits for a trigger.").waitFor();
  assert.ok((await accessible(page)) > 10);
  // Where text is typed, a key is a letter.
  await buttons.getByRole("button", { name: "Region" }).click();
  await plays(page);
  await page.locator(".menu summary").click();
  await page.getByLabel("Name", { exact: true }).press("q");
  await plays(page);
  await page.keyboard.press("Escape");
  await boardSays(page, "outputs off");
  await eventually(async () => (await buttons.count()) === 0);
});

test("words of a script and hands that enter a region start their parts by a named pipe", async (t) => {
  const { page } = await withTwo(t);
  assert.equal(await page.getByLabel("Pipe of lines").count(), 0); // keys need none
  await page.getByLabel("Trigger 1 is", { exact: true }).selectOption("line");
  await fill(page, "Line of trigger 1", "go");
  await fill(page, "Trigger 1 plays so often", 0);
  await page.getByLabel("Trigger 2 is", { exact: true }).selectOption("region");
  const pipe = join(await folder(t), "lines");
  await fill(page, "Pipe of lines", pipe);
  await settled(page);
  // What is no pipe is said, and nothing plays; then it waits, with nobody at its other end.
  const play = async () => {
    await page.locator("[data-step=Play]").click();
    await page.locator("button.play").first().click();
  };
  await play();
  await page.getByText(/lines cannot be opened: No such file.*mkfifo/).waitFor();
  execFileSync("mkfifo", [pipe]);
  await play();
  await boardSays(page, "outputs ON");
  await page.getByText("Outputs are on; it waits for a trigger.").waitFor();
  appendFileSync(pipe, "stop\n");
  await page.getByText("found 'stop', expected 'go' or a scene of a live session").waitFor();
  appendFileSync(pipe, "go\n");
  await plays(page); // on and on
  const hand = (x) => `${JSON.stringify({ scene: 2, hands: [{ palm_mm: [x, 0, 150], fingers_mm: [] }] })}\n`;
  appendFileSync(pipe, hand(100) + hand(0) + hand(10)); // which ends that, and itself
  await page.getByText("Outputs are on; it waits for a trigger.").waitFor();
  appendFileSync(pipe, "go\n");
  await plays(page);
  await page.keyboard.press("Escape");
  await boardSays(page, "outputs off");
});
