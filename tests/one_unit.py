# SPDX-License-Identifier: Apache-2.0
"""HAPTOGRAM_QUICK compiles many sources as one. Which come together follows from their number, so no two sources of a target may use
one name for two things: all of them are read as one here. Usage: one_unit.py BUILD TARGET…"""
import collections
import json
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

# SKIP_UNITY_BUILD_INCLUSION: the kernel's own termios, and Highway's loops
def is_alone(source):
    return source.name == "serial_rate_linux.cpp" or "foreach_target.h" in source.read_text(encoding="utf-8")


LEFT_OUT = {"-Werror", "-Winvalid-pch", "-c", "-MD"}
WITH_VALUE = {"-o", "-MT", "-MF", "-include"}  # the precompiled header, which is another for each target


def options_of(entry):
    """The compiler and its options, without what names the source, what is written, and the precompiled header."""
    words, skip = shlex.split(entry["command"]), False
    options = []
    for word in words[next(k for k, word in enumerate(words) if word.endswith("++")):]:
        if not skip and word not in LEFT_OUT and word not in WITH_VALUE and word != entry["file"]:
            options.append(word)
        skip = not skip and word in WITH_VALUE
    return tuple(options)


def entries_of(build, target):
    """Its sources, but for those with options of their own, which CMake compiles alone, too."""
    found = [entry for entry in json.loads((build / "compile_commands.json").read_text(encoding="utf-8"))
             if f"/{target}.dir/" in entry["command"] and "cmake_pch" not in entry["file"] and not is_alone(Path(entry["file"]))]
    assert len(found) > 1, f"{target}: compile_commands.json has {len(found)} sources of it"
    usual = collections.Counter(map(options_of, found)).most_common(1)[0][0]
    return [entry for entry in found if options_of(entry) == usual]


def errors_in(build, target):
    entries = entries_of(build, target)
    with tempfile.NamedTemporaryFile("w", suffix=".cpp", encoding="utf-8") as unit:
        unit.writelines(f'#include "{entry["file"]}"\n' for entry in entries)
        unit.flush()
        done = subprocess.run([*options_of(entries[0]), "-w", "-fsyntax-only", unit.name], cwd=entries[0]["directory"], capture_output=True, text=True)
    return [line for line in done.stderr.splitlines() if "error:" in line] if done.returncode else []


def main():
    build, targets = Path(sys.argv[1]).resolve(), sys.argv[2:]
    failed = {target: errors for target in targets if (errors := errors_in(build, target))}
    for target, errors in failed.items():
        print(f"{target}: as one unit it does not compile; rename one of the two in each pair", *errors[:10], sep="\n  ")
    return 1 if failed or not targets else 0


if __name__ == "__main__":
    sys.exit(main())
