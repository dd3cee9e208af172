// SPDX-License-Identifier: Apache-2.0
// Runs the browser's cases, a file at a time. The browser draws in software and beside other tests, so a file in which a case fails is run
// once more, and must then pass as a whole. Both runs are printed. HAPTOGRAM_SCREENSHOTS=FOLDER keeps pictures, HAPTOGRAM_PICTURES=record
// renews those in pictures/.
import { spawnSync } from "node:child_process";
import { readdirSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";

const folder = fileURLToPath(new URL(".", import.meta.url));
const passes = (file) => spawnSync(process.execPath, ["--test", join(folder, file)], { stdio: "inherit" }).status === 0;
const failed = readdirSync(folder).filter((name) => name.endsWith(".test.mjs")).sort().filter((file) => !passes(file));
for (const file of failed) console.log(`# ${file} failed and is run once more`);
process.exit(failed.every(passes) ? 0 : 1);
