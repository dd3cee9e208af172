#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How many cases each suite has in each size, as the table of tests/README.md. Writes that table; --check says whether the page is stale."""
import argparse
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent
PAGE = HERE / "README.md"
PYTEST = ("cli", "python", "torture", "serve", "c", "native", "sweep", "client_from_the_page", "hardware", "install")
SIZES = ("check", "test", "deep", "real_time")
# Cases before they were sorted, of which `make test` ran all but planted bugs and long proofs.
BEFORE = {
    "cli": 1658, "python": 380, "torture": 613, "serve": 18, "c": 24, "native": 52, "sweep": 30, "client_from_the_page": 11, "hardware": 18, "install": 32,
    "cosim": 160, "ftdi": 10, "live": 30, "modules": 77, "reference": 26, "studio": 49, "tiles": 38, "torture (C++)": 5, "unit": 631, "formal": 234,
}  # fmt: skip


class Counter:
    """A plugin of pytest. What is marked neither deep nor real_time is of `make test`, also when `make check` has it, too."""

    def __init__(self):
        self.found = {}

    def pytest_collection_modifyitems(self, items):
        for item in items:
            row = self.found.setdefault(item.path.relative_to(HERE).parts[0], dict.fromkeys(SIZES, 0))
            marks = {mark.name for mark in item.iter_markers()} & {"check", "deep", "real_time"}
            for size in marks or {"test"}:
                row[size] += 1
            if marks == {"check"}:
                row["test"] += 1


def of_pytest(build):
    os.environ["PYTHONPATH"] = str(HERE.parent / "python")
    sys.path.insert(0, os.environ["PYTHONPATH"])
    counter = Counter()
    code = pytest.main(["--collect-only", "-qq", "--rootdir", str(HERE.parent), *(str(HERE / suite) for suite in PYTEST)], plugins=[counter, Silence()])
    if code != pytest.ExitCode.OK:
        sys.exit(f"sizes: the suites cannot be collected (pytest ended with {code}); build first, or name a build with --build")
    return {suite: counter.found[suite] for suite in PYTEST}


class Silence:
    """Of the names of all cases."""

    @staticmethod
    @pytest.hookimpl(trylast=True)
    def pytest_configure(config):
        config.pluginmanager.unregister(name="terminalreporter")


def listed(executable, *tags):
    done = subprocess.run([executable, "--list-test-names-only", *tags], capture_output=True, text=True)
    return len([line for line in done.stdout.splitlines() if line])  # the exit code is their number


def of_catch(build):
    """All of the modules' executables are one row."""
    found = {}
    for executable in sorted([*build.glob("tests/test_*"), *build.glob("tests/modules/test_*")]):
        if not executable.is_file() or not os.access(executable, os.X_OK) or executable.suffix or executable.name.startswith("test_small"):  # cosim's, again
            continue
        name = "modules" if executable.parent.name == "modules" else executable.name.removeprefix("test_")
        row = found.setdefault(name + (" (C++)" if name in PYTEST else ""), dict.fromkeys(SIZES, 0))
        row["check"] += listed(executable, "[check]")
        row["deep"] += listed(executable, "[deep]~[real-time]")
        row["real_time"] += listed(executable, "[real-time]")
        row["test"] += listed(executable, "~[deep]~[real-time]")
    return found


def of_proofs():
    """A proof, its covers, and each of its planted bugs, which must fail, are a case each."""
    proofs = tomllib.loads((HERE / "formal/proofs.toml").read_text(encoding="utf-8"))["proof"]
    long = sum(bool(proof.get("long")) for proof in proofs)
    return {"formal": {"check": 0, "test": len(proofs) - long, "deep": long + sum(1 + len(proof.get("bugs", [])) for proof in proofs), "real_time": 0}}


def table(build):
    rows = {**of_pytest(build), **of_catch(build), **of_proofs()}
    lines = ["| suite | before | check | test | deep | real-time |", "|:--|--:|--:|--:|--:|--:|"]
    lines += [f"| {name} | {BEFORE.get(name, '')} | " + " | ".join(str(row[size] or "") for size in SIZES) + " |" for name, row in rows.items()]
    totals = [sum(row[size] for row in rows.values()) for size in SIZES]
    return "\n".join([*lines, f"| all | {sum(BEFORE.values())} | " + " | ".join(map(str, totals)) + " |"])


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", type=Path, default=HERE.parent / "build/release", help="whose executables are asked (build/release)")
    parser.add_argument("--check", action="store_true", help="write nothing; exit code 1 when the page is stale")
    options = parser.parse_args()
    page = PAGE.read_text(encoding="utf-8")
    made = re.sub(r"(?<=<!-- sizes -->\n).*(?=<!-- sizes end -->)", lambda _: table(options.build.resolve()) + "\n", page, flags=re.DOTALL)
    if options.check and made != page:
        sys.exit("sizes: the table of tests/README.md is stale; run tests/sizes.py")
    if made == page:
        return
    PAGE.write_text(made, encoding="utf-8")


if __name__ == "__main__":
    main()
