# SPDX-License-Identifier: Apache-2.0
"""HAPTOGRAM_UNITY and HAPTOGRAM_QUICK compile many sources as one. Which come together follows from their number, so no two sources of a
target may use one name for two things: all of them are read as one here, again when one of the files has changed that were read. Configures a
build of each source alone in build/alone, and makes there only what is generated."""
import collections
import hashlib
import json
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
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


def key_of(entries, read):
    """What the verdict follows from: compiler, options, sources, and every file that was read. None when one of those is gone."""
    options = options_of(entries[0])
    digest = hashlib.sha256(json.dumps([options, [entry["file"] for entry in entries], read]).encode())
    for file in [shutil.which(options[0]), __file__, *read]:
        if not Path(file).is_file():
            return None
        digest.update(hashlib.sha256(Path(file).read_bytes()).digest())
    return digest.hexdigest()


def errors_in(build, target):
    entries = entries_of(build, target)
    good = build / "one_unit" / f"{target}.json"  # of the last run without errors
    if good.is_file():
        was = json.loads(good.read_text(encoding="utf-8"))
        if was["key"] == key_of(entries, was["read"]):
            return []
    began = time.time()
    with tempfile.TemporaryDirectory() as folder:
        unit, rule = Path(folder, "unit.cpp"), Path(folder, "unit.d")
        unit.write_text("".join(f'#include "{entry["file"]}"\n' for entry in entries), encoding="utf-8")
        directory = Path(entries[0]["directory"])
        done = subprocess.run([*options_of(entries[0]), "-w", "-fsyntax-only", "-MD", "-MF", rule, unit], cwd=directory, capture_output=True, text=True)
        if done.returncode:
            return [line for line in done.stderr.splitlines() if "error:" in line] or done.stderr.splitlines()
        words = rule.read_text(encoding="utf-8").replace("\\\n", " ").split()[1:]
    read = sorted({str(directory / word) for word in words if word != str(unit)})
    assert len(read) > len(entries), f"{target}: the compiler named {len(read)} files that it read, expected more than its {len(entries)} sources"
    if all(Path(file).stat().st_mtime < began for file in read):  # else the compiler may have read what was there before
        good.parent.mkdir(exist_ok=True)
        whole = good.with_suffix(".new")
        whole.write_text(json.dumps({"key": key_of(entries, read), "read": read}), encoding="utf-8")
        whole.replace(good)
    return []


def main():
    root = Path(__file__).resolve().parents[1]
    build = root / "build/alone"
    for command in (["cmake", "--preset", "release", "-B", build, "-DHAPTOGRAM_UNITY=OFF"], ["cmake", "--build", build, "--target", "haptogram_commit"]):
        subprocess.run(command, cwd=root, check=True, stdout=subprocess.DEVNULL)
    commands = (build / "compile_commands.json").read_text(encoding="utf-8")
    targets = sorted(t for t in set(re.findall(r"/(haptogram\w*)\.dir/", commands)) if len(re.findall(f"/{t}\\.dir/\\S+\\.o -c ", commands)) > 1
                     and not re.search("model|test|sdram|bench|verilated|measure|net_receiver", t))
    failed = {target: errors for target in targets if (errors := errors_in(build, target))}
    for target, errors in failed.items():
        print(f"{target}: as one unit it does not compile; rename one of the two in each pair", *errors[:10], sep="\n  ")
    print(f"{len(targets) - len(failed)} of {len(targets)} targets compile as one unit")
    return 1 if failed or not targets else 0


if __name__ == "__main__":
    sys.exit(main())
