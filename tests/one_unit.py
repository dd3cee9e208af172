# SPDX-License-Identifier: Apache-2.0
"""HAPTOGRAM_QUICK compiles many sources as one. Which come together follows from their number, so no two sources of a target may use
one name for two things: all of them are read as one here. Usage: one_unit.py BUILD TARGET…"""
import json
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

LEFT_OUT = {"-Werror", "-Winvalid-pch", "-c"}
ALONE = {"serial_rate_linux.cpp"}  # SKIP_UNITY_BUILD_INCLUSION
WITH_VALUE = {"-o", "-include"}  # the precompiled header, which is another for each target


def command_of(entries):
    """The compiler's command for all of the entries at once, without what says the output."""
    words = [word for entry in entries for word in shlex.split(entry["command"])]
    first = shlex.split(entries[0]["command"])
    begin = next(k for k, word in enumerate(first) if word.endswith("++"))
    command, skip = [], False
    for word in first[begin:] + sorted({word for word in words if word.startswith("-D")} - set(first)):
        if not skip and word not in LEFT_OUT and word not in WITH_VALUE and word != entries[0]["file"]:
            command.append(word)
        skip = not skip and word in WITH_VALUE
    return command + ["-w", "-fsyntax-only"]


def entries_of(build, target):
    found = [entry for entry in json.loads((build / "compile_commands.json").read_text(encoding="utf-8"))
             if f"/{target}.dir/" in entry["command"] and "cmake_pch" not in entry["file"] and Path(entry["file"]).name not in ALONE]
    assert len(found) > 1, f"{target}: compile_commands.json has {len(found)} sources of it"
    return found


def errors_in(build, target):
    entries = entries_of(build, target)
    with tempfile.NamedTemporaryFile("w", suffix=".cpp", encoding="utf-8") as unit:
        unit.writelines(f'#include "{entry["file"]}"\n' for entry in entries)
        unit.flush()
        done = subprocess.run([*command_of(entries), unit.name], cwd=entries[0]["directory"], capture_output=True, text=True)
    return [line for line in done.stderr.splitlines() if "error:" in line] if done.returncode else []


def main():
    build, targets = Path(sys.argv[1]).resolve(), sys.argv[2:]
    failed = {target: errors for target in targets if (errors := errors_in(build, target))}
    for target, errors in failed.items():
        print(f"{target}: as one unit it does not compile; rename one of the two in each pair", *errors[:10], sep="\n  ")
    return 1 if failed or not targets else 0


if __name__ == "__main__":
    sys.exit(main())
