#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the proofs of proofs.toml with yosys and z3: bounded check, induction and cover; and every planted bug, which must fail.
SymbiYosys, which also runs proofs, is not in Debian 12, and knows no planted bugs. A failure leaves bounded.vcd or induction.vcd in
build/formal/NAME; look one clock before the trace's end, because Yosys samples clocked assertions a clock late.

Exit code 0 when every proof holds and every planted bug is caught, 1 otherwise, 2 on a wrong table or command line.
"""
import argparse
import hashlib
import json
import re
import shutil
import subprocess
import sys
import threading
import time
import tomllib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
TOOLS = ("yosys", "yosys-smtbmc", "z3")
COVER = -1


class Wrong(Exception):
    """The table, a source or a tool is not as expected."""


def with_bug(proof, bug):
    """The proof's one mutated file; the text to replace must occur exactly once."""
    text = (ROOT / bug["file"]).read_text()
    if text.count(bug["old"]) != 1 or "\n" in bug["old"]:
        raise Wrong(f"{proof['name']}: '{bug['old']}' occurs {text.count(bug['old'])} times in {bug['file']}, expected once in one line")
    return text.replace(bug["old"], bug["new"])


def model(proof, folder, bug=None):
    """The SMT2 model of a proof, with a planted bug if one is given."""
    folder.mkdir(parents=True, exist_ok=True)
    changed = None
    if bug:
        changed = folder / Path(bug["file"]).name
        changed.write_text(with_bug(proof, bug))
    sources, plain = ([changed if bug and s == bug["file"] else ROOT / s for s in proof.get(key, [])] for key in ("sources", "plain"))
    defines = " ".join(f"-D{d}" for d in ["FORMAL", *proof.get("defines", [])])
    parameters = " ".join(f"-chparam {k} {v}" for k, v in proof.get("parameters", {}).items())
    # A changed include file is found first; the others by the folder of rtl/.
    script = f"""
        {f"read_verilog -defer -I{folder} -I{ROOT}/rtl {' '.join(str(s) for s in plain)}" if plain else ''}
        read_verilog -formal -defer {defines} -I{folder} -I{ROOT}/rtl {' '.join(str(s) for s in sources)}
        hierarchy -check -top {proof['top']} {parameters}
        proc
        {'chformal -cover -remove * A:top %d' if proof.get('own_covers') else ''}
        prep -flatten -nordff
        memory_nordff
        memory_map
        {'clk2fflogic' if proof.get('clocks') else 'async2sync'}
        dffunmap
        opt_clean
        check -assert
        write_smt2 -wires model.smt2
    """
    (folder / "model.ys").write_text("\n".join(line.strip() for line in script.strip().splitlines()) + "\n")
    done = subprocess.run(["yosys", "-q", "-l", "yosys.log", "model.ys"], cwd=folder, capture_output=True, text=True)
    if done.returncode != 0:
        raise Wrong(f"{proof['name']}: yosys failed{' with the bug ' + bug['new'] if bug else ''}\n{done.stdout}{done.stderr}")
    return folder / "model.smt2"


def solve(smt2, kind, depth, *options, step=1):
    """True when yosys-smtbmc says PASSED, False when FAILED; anything else is an error. Traces are left beside the model."""
    trace = [] if kind == "cover" else ["--dump-vcd", f"{kind}.vcd"]
    command = ["yosys-smtbmc", "-s", "z3", "--unroll", "--noprogress", "-t", f"0:{step}:{depth}", *options, *trace, smt2.name]
    done = subprocess.run(command, cwd=smt2.parent, capture_output=True, text=True)
    (smt2.parent / f"{kind}.log").write_text(done.stdout + done.stderr)
    verdict = re.search(r"Status: (\w+)", done.stdout)
    if not verdict or verdict[1] not in ("PASSED", "FAILED", "passed", "failed"):
        raise Wrong(f"no verdict, see {smt2.parent / kind}.log\n{done.stdout[-1000:]}{done.stderr[-1000:]}")
    return verdict[1].lower() == "passed"


class Proof:
    """One row of the table: its steps, and what they found."""

    def __init__(self, row, build, steps):
        """steps: 0 is the proof, COVER that its assertions are looked at, n its planted bug n."""
        self.row, self.folder = row, build / row["name"]
        self.steps, self.left = steps, len(steps)
        self.seconds, self.problems, self.covers = 0.0, [], 0
        self.lock = threading.Lock()

    def run(self, step):
        start = time.monotonic()
        try:
            self.prove() if step == 0 else self.cover() if step == COVER else self.catch(step)
        except Wrong as error:
            self.problem(str(error))
        with self.lock:
            self.seconds += time.monotonic() - start
            self.left -= 1
            return self.left == 0

    def key(self):
        """What its verdict follows from: the row, this program, the tools, its sources, and all that those may include."""
        row, digest = self.row, hashlib.sha256(json.dumps(self.row, sort_keys=True).encode())
        files = {HERE / "run.py", *(ROOT / source for key in ("sources", "plain") for source in row.get(key, [])), *(ROOT / "rtl").rglob("*.vh")}
        for file in sorted(files | {ROOT / bug["file"] for bug in row.get("bugs", [])}):
            digest.update(f"{file.relative_to(ROOT)}\n".encode() + hashlib.sha256(file.read_bytes()).digest())
        for tool in TOOLS:
            digest.update(Path(shutil.which(tool)).resolve().read_bytes())
        return digest.hexdigest()

    def problem(self, text):
        with self.lock:
            self.problems.append(text)

    def prove(self):
        row, smt2 = self.row, model(self.row, self.folder)
        for bug in row.get("bugs", []):
            with_bug(row, bug)  # raises when a planted bug no longer fits
        # With an induction over k clocks, the first k clocks are all of its base; covers and planted bugs may need more.
        base = row.get("induction", row["depth"])
        if not solve(smt2, "bounded", base + 1, step=row.get("step", 1)):
            self.problem(f"an assertion fails within {base} clocks, see {self.folder}/bounded.log and bounded.vcd")
        if "induction" in row and not solve(smt2, "induction", row["induction"], "-i"):
            self.problem(f"induction over {row['induction']} clocks fails, see {self.folder}/induction.log and induction.vcd")

    def cover(self):
        row, folder = self.row, self.folder / "cover"
        if not solve(model(row, folder), "cover", row.get("reach", row["depth"]) + 1, "-c"):
            self.problem(f"a cover point is never reached, see {folder}/cover.log")
        self.covers = len(set(re.findall(r"Reached cover statement at (\S+)", (folder / "cover.log").read_text())))
        if not self.covers:
            self.problem("no cover point at all: nothing shows that the assertions are ever looked at")

    def catch(self, step):
        bug = self.row["bugs"][step - 1]
        if solve(model(self.row, self.folder / f"bug_{step}", bug), "bounded", self.row.get("reach", self.row["depth"]) + 1, step=self.row.get("step", 1)):
            self.problem(f"the planted bug {step} is not found ({bug['why']}: '{bug['old']}' -> '{bug['new']}' in {bug['file']})")

    def held(self):
        """Where the key of the last run of these steps without a problem is kept."""
        return self.folder / f"held_{'_'.join(map(str, self.steps))}"

    def line(self):
        row, said = self.row, []
        if 0 in self.steps:
            how = f"induction {row['induction']}" if "induction" in row else f"bounded {row['depth']} only"
            said.append(how)
        if COVER in self.steps:
            said.append(f"covers {self.covers}")
        if bugs := sum(step > 0 for step in self.steps):
            said.append(f"planted bugs {bugs}")
        return f"{row['name']:<18} {'FAILED' if self.problems else 'holds':<7} {self.seconds:6.1f} s   contract {row['contract']}, {', '.join(said)}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", metavar="NAME", action="append", help="this proof (may be repeated)")
    parser.add_argument("--part", choices=("all", "quick", "rest"), default="all",
                        help="quick: the proofs, without those that proofs.toml calls long; rest: those, and the covers and planted bugs of all (all)")  # fmt: skip
    parser.add_argument("--changed", action="store_true", help="without what held in this working folder before, with the same sources, table and tools")
    parser.add_argument("--jobs", metavar="N", type=int, default=2, help="solvers at a time (2)")
    parser.add_argument("--build", metavar="DIR", type=Path, default=ROOT / "build" / "formal", help="working folder")
    options = parser.parse_args()

    rows = tomllib.loads((HERE / "proofs.toml").read_text())["proof"]
    unknown = set(options.only or []) - {row["name"] for row in rows}
    if unknown:
        parser.error(f"no such proof: {', '.join(sorted(unknown))}; there are {', '.join(row['name'] for row in rows)}")
    missing = [tool for tool in TOOLS if not shutil.which(tool)]
    if missing:
        parser.error(f"not installed: {', '.join(missing)} (tools/setup installs them)")

    proofs = []
    for row in rows:
        every = [0, COVER, *range(1, 1 + len(row.get("bugs", [])))]
        quick = [] if row.get("long") else [0]
        steps = {"all": every, "quick": quick, "rest": [step for step in every if step not in quick]}[options.part]
        if steps and (not options.only or row["name"] in options.only):
            proofs.append(Proof(row, options.build.resolve(), steps))
    start = time.monotonic()

    def run(proof, step):
        if not proof.run(step):
            return
        print("\n    ".join([proof.line(), *proof.problems]), flush=True)
        if not proof.problems:
            proof.held().write_text(keys[proof.row["name"]])

    keys = {proof.row["name"]: proof.key() for proof in proofs}
    if options.changed:
        known = [proof for proof in proofs if proof.held().is_file() and proof.held().read_text() == keys[proof.row["name"]]]
        proofs = [proof for proof in proofs if proof not in known]
        if known:
            print(f"{len(known)} proofs held before, and nothing of theirs has changed")

    with ThreadPoolExecutor(max_workers=max(1, options.jobs)) as pool:
        for task in [pool.submit(run, proof, step) for proof in proofs for step in proof.steps]:
            task.result()
    failed = [proof for proof in proofs if proof.problems]
    print(f"{len(proofs) - len(failed)} of {len(proofs)} proofs hold, {time.monotonic() - start:.0f} s")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
