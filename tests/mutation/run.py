#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the co-simulation tests on every mutant that netlist.py has planted; one that no test notices must be explained.
mcy, which does the same, is not in Debian 12, and builds each mutant for itself, which takes longer than the tests.

Exit code 0 when mutation.toml's share of each group is killed and survivors.toml names exactly the others, 1 otherwise,
2 on a wrong table or command line, or when the tests fail without any mutant.
"""
import argparse
import json
import os
import re
import subprocess
import sys
import threading
import time
import tomllib
from concurrent.futures import ThreadPoolExecutor
from html import unescape
from pathlib import Path

from netlist import HERE, ROOT, Wrong, models, table


class Tests:
    """The test program of a model, with limits from how long it takes without a mutant."""

    def __init__(self, program, options):
        self.program, self.options, self.limits = program, options, {}

    def run(self, tests, number, limit):
        """None when all tests pass, otherwise the name of the first that does not."""
        command = ["prlimit", f"--cpu={limit}", self.program, tests, "--abort", "--warn", "NoTests", "--reporter", "xml", *self.options]
        done = subprocess.run(command, env={**os.environ, "HAPTOGRAM_MUTANT": str(number)}, capture_output=True, text=True, errors="replace")
        if done.returncode == 0:
            return None
        names = re.findall(r'<TestCase name="([^"]*)"', done.stdout)
        return unescape(names[-1]) if names else f"no test at all: {done.stderr.strip() or done.returncode}"

    def calibrate(self, tests):
        start = time.monotonic()
        failed = self.run(tests, 0, 600)
        if failed:
            raise Wrong(f"without any mutant '{tests}' fails: {failed}")
        # Processor time, but the other processors' work slows this one down.
        self.limits[tests] = int(10 + 3 * (time.monotonic() - start))

    def killer(self, steps, number):
        """The test that notices the mutant, if any does, and after how many seconds. One that never ends is noticed, too."""
        start = time.monotonic()
        killed = next((killed for killed in (self.run(step, number, self.limits[step]) for step in steps) if killed), None)
        return killed, time.monotonic() - start


class Progress:
    """A live count, on a terminal only."""

    def __init__(self, total):
        self.total, self.done, self.lock = total, 0, threading.Lock()

    def step(self, _):
        with self.lock:
            self.done += 1
            if sys.stdout.isatty():
                print(f"\r{self.done} of {self.total} mutants", end="\r" if self.done == self.total else "", flush=True)


def listed():
    """survivors.toml: what each is called and why nothing can notice it."""
    rows = tomllib.loads((HERE / "survivors.toml").read_text()).get("survivor", [])
    for row in rows:
        if set(row) != {"mutant", "reason"} or not row["reason"].strip():
            raise Wrong(f"survivors.toml: each has a mutant and a reason, not {row}")
    return {row["mutant"]: row["reason"] for row in rows}


def judge(group, mutants, survivors, share):
    """What is wrong with a group's outcome."""
    for mutant in mutants:
        if mutant["killer"] and mutant["name"] in survivors:
            yield f"survivors.toml lists a mutant that is killed by '{mutant['killer']}': {mutant['name']}"
        if not mutant["killer"] and mutant["name"] not in survivors:
            yield f"survives, and survivors.toml does not say why: {mutant['name']} (HAPTOGRAM_MUTANT={mutant['number']})"
    killed = sum(1 for mutant in mutants if mutant["killer"])
    can_be = sum(1 for mutant in mutants if mutant["killer"] or mutant["name"] not in survivors)
    if killed < share * can_be:
        yield f"{group}: {killed} of {can_be} that can be noticed are killed, {share:.0%} are asked for"
    if can_be < 0.8 * len(mutants):
        yield f"{group}: {len(mutants) - can_be} of {len(mutants)} are said to change nothing, at most a fifth may"


def run(options):
    t, survivors = table(), listed()
    mutants = json.loads((options.build / "mutants.json").read_text())
    chosen = [m for m in mutants if not options.only or m["number"] in options.only]
    steps = {g["name"]: g["tests"] for g in t["group"]}
    of_model = {m: Tests(options.programs / f"test_cosim_mutants_{m}", ["--rng-seed", str(t["seed"])]) for m in models(t)}
    tests = {g["name"]: of_model[g["model"]] for g in t["group"]}
    problems, start = [], time.monotonic()

    with ThreadPoolExecutor(max_workers=max(1, options.jobs)) as pool:
        wanted = {m["group"] for m in chosen}
        first = {(tests[group], step): None for group in steps if group in wanted for step in steps[group]}
        list(pool.map(lambda pair: pair[0].calibrate(pair[1]), first))
        progress = Progress(len(chosen))
        for mutant in chosen:
            mutant["task"] = pool.submit(tests[mutant["group"]].killer, steps[mutant["group"]], mutant["number"])
            mutant["task"].add_done_callback(progress.step)
        for group in steps:
            members = [m for m in chosen if m["group"] == group]
            for mutant in members:
                mutant["killer"], mutant["seconds"] = mutant.pop("task").result()
            found = list(judge(group, members, survivors, t["killed"])) if members else []
            killed = sum(1 for m in members if m["killer"])
            if members:
                print(f"{group:<18} {len(members)} mutants, {killed} killed, {killed / len(members):.1%}, {time.monotonic() - start:.0f} s", flush=True)
            for problem in found:
                print(f"    {problem}", flush=True)
            problems += found

    names = {m["name"] for m in mutants}
    for name in survivors:
        if name not in names:
            problems.append(name)
            print(f"    survivors.toml lists a mutant that is not there any more: {name}")
    if len(survivors) > 0.1 * len(mutants):
        problems.append("survivors.toml")
        print(f"    survivors.toml lists {len(survivors)} of {len(mutants)} mutants, at most a tenth may be there")
    (options.build / "report.json").write_text(json.dumps(chosen, indent=1) + "\n")
    killed = sum(1 for m in chosen if m["killer"])
    print(f"{killed} of {len(chosen)} mutants killed, {len(chosen) - killed} survive, {time.monotonic() - start:.0f} s")
    return 1 if problems else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    build = ROOT / "build" / "deep" / "tests" / "mutation"
    parser.add_argument("--programs", metavar="DIR", type=Path, default=build, help="where test_cosim_mutants_MODEL are, for each model")
    parser.add_argument("--build", metavar="DIR", type=Path, default=build, help="where netlist.py wrote, and where the report goes")
    parser.add_argument("--only", metavar="N", type=int, action="append", help="this mutant (may be repeated)")
    parser.add_argument("--jobs", metavar="N", type=int, default=2, help="tests at a time (2)")
    options = parser.parse_args()
    try:
        return run(options)
    except (Wrong, OSError, KeyError, tomllib.TOMLDecodeError) as error:
        print(f"run.py: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
