#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What is said to people is asserted by what it is: exit code and place. The words stand in messages.txt alone, and only the case `messages` compares them.

messages.txt has, sorted, the file and the name of each case that hears a message; below it what that asserts, in order: code and place of an error, and what
could mend it; below that the words, of which there are several when one identity is heard several times in a row. Cases write what they heard into
build/release/messages, a file a case, where this compares it with messages.txt; refusal.hpp and refusal.cpp do the same in C++."""
import argparse
import contextlib
import difflib
import functools
import hashlib
import os
import re
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
RECORDED = HERE / "messages.txt"
HEAD = "# What the tests hear, written by `make messages`; tests/messages.py says how it is read.\n"


def folder_of_this_run():
    named = os.environ.get("HAPTOGRAM_MESSAGES")
    return Path(named) if named else Path(os.environ.get("HAPTOGRAM_BUILD", ROOT / "build/release")) / "messages"


def text_of(path):
    """Bytes that are no text, which some messages quote, as \\xNN."""
    return re.sub(r"[\x00-\x09\x0b-\x1f\x7f]", lambda found: f"\\x{ord(found[0]):02x}", path.read_bytes().decode("utf-8", "backslashreplace"))


def read(path):
    """{name: [(identity, [text, …]), …]}; a text of several lines is one string."""
    found = {}
    for line in map(str.rstrip, text_of(path).split("\n")):
        if line == "    |" or line.startswith("    | "):
            texts[-1] += "\n" + line[6:]
        elif line.startswith("    "):
            texts.append(line[4:])
        elif line.startswith("  "):
            texts = []
            entries.append((line[2:], texts))
        elif line and not line.startswith("#"):
            entries = found.setdefault(line, [])
    return found


def written(messages):
    """The same as text, sorted by name."""
    lines = []
    for name, entries in sorted(messages.items()):
        lines.append(name)
        for identity, texts in entries:
            lines += ["  " + identity, *("    " + text.replace("\n", "\n    | ") for text in texts)]
    return "".join(line.rstrip() + "\n" for line in lines)


# ---- in a case of pytest: conftest.py begins and ends each

class Case:
    def __init__(self, name, folder):
        self.name, self.folder, self.loose, self.entries = name, folder, False, []


running = None


@functools.cache
def recorded():
    return read(RECORDED) if RECORDED.is_file() else {}


def begin(name, folder):
    """`folder` is that of all temporary files."""
    global running
    running = Case(name, folder)


def end():
    """The running case passed: what it heard is told."""
    folder = folder_of_this_run()
    folder.mkdir(parents=True, exist_ok=True)
    name = hashlib.sha256(running.name.encode()).hexdigest()[:16] + ".txt"
    said = {running.name: running.entries} if running.entries else {}
    (folder / name).write_text(f"# {running.name}\n" + written(said), encoding="utf-8")


def left_out(names):
    """These cases do not run, and keep what messages.txt has of them."""
    folder = folder_of_this_run()
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{os.getpid()}.left_out").write_text("".join(name + "\n" for name in names), encoding="utf-8")


def loose_numbers():
    """The digits in the messages of the running case are left out from here on: they are other ones in another run."""
    running.loose = True


def without_chance(text):
    """Without what is different in another checkout, another folder, another process."""
    text = text.replace(str(ROOT), "ROOT").replace(str(running.folder), "TMP").replace(tempfile.gettempdir(), "TMP")
    text = re.sub(r"TMP/[^/:;,'\"\s)]+", "TMP/#", text)
    text = re.sub(r"(/dev/pts/|127\.0\.0\.1:|pid |process |: port )\d+", r"\1#", text)
    return re.sub(r"\d+(\.\d+)?(e[-+]?\d+)?", "#", text) if running.loose else text


def said(identity, words):
    """Tells the words, and asserts the identity: the next one of the running case in messages.txt, if that has it."""
    identity, words = without_chance(identity).replace("\n", " "), without_chance(words).rstrip("\n")
    if running.entries and running.entries[-1][0] == identity:
        texts = running.entries[-1][1]
        if words not in texts:
            texts.append(words)
        return
    running.entries.append((identity, [words]))
    expected = recorded().get(running.name, [])
    if len(expected) < len(running.entries) or os.environ.get("HAPTOGRAM_RECORD_MESSAGES"):
        return
    wanted = expected[len(running.entries) - 1][0]
    assert identity == wanted, f"found '{identity}', tests/messages.txt has '{wanted}' for this message. If that was meant, run make messages. The text: {words}"


# What stands before the words: a setting, a file, a line, a thing with its number. Words before a colon that are longer are words.
PLACE = re.compile(r"(?:haptogram[-a-z]*: |(?=--))([^\s:]\S*?|[^\s:]+ \S+?|[^\s:]+ [^\s:]+ \S+?|[^\s:]+, [a-z]+ \d+ of \d+(?: \(line \d+\))?): ")


def program_said(code, words):
    """The same of a program's message on stderr, and its exit code."""
    words = words.decode("utf-8") if isinstance(words, bytes) else words
    assert words.strip(), f"exit {code}, and nothing was said"
    place = PLACE.match(words)
    said(f"exit {code}" + (f" at {place[1]}" if place else ""), words)


def notice(words):
    """The same of a text that comes with no error."""
    assert words, "nothing was said"
    said("notice", words.decode("utf-8") if isinstance(words, bytes) else words)


@contextlib.contextmanager
def refusal(kind=Exception):
    """What is inside raises an exception of this kind; yields that as pytest.raises does."""
    import pytest

    with pytest.raises(kind) as caught:
        yield caught
    error_said(caught.value)


def error_said(error):
    code, where = getattr(error, "code", ""), getattr(error, "where", "")
    identity = type(error).__name__ + (f" {int(code)}" if isinstance(code, int) else "") + (f" at {where}" if where else "")
    remedies = getattr(error, "remedies", ())
    said(identity + (f"; mend {', '.join(remedies)}" if remedies else ""), str(getattr(error, "message", error)))


# ---- the case `messages`, and the command `make messages`

def heard(folder):
    """Names of the cases that ran, and of those that were left out, and what was heard."""
    ran, messages = set(), {}
    without = {line for path in folder.glob("*.left_out") for line in path.read_text(encoding="utf-8").splitlines()}
    for path in sorted(folder.glob("*.txt")):
        ran.add(text_of(path).partition("\n")[0].removeprefix("# "))
        messages |= read(path)
    return ran, without - ran, messages


def case_of(name, ran):
    """The case whose section `name` may be."""
    while name not in ran and " / " in name:
        name = name.rpartition(" / ")[0]
    return name if name in ran else None


@functools.cache
def source(name):
    text = "\n".join(path.read_text(encoding="utf-8") for path in HERE.rglob(name))
    return re.sub(r'"\s*\n\s*"', "", text)


def exists(name):
    """Whether there is a case of this name: one that did not run keeps its messages."""
    file, _, case = name.partition(": ")
    if file.endswith(".py"):
        return f"def {case.partition('[')[0]}(" in source(file)
    parts = case.split(" / ")
    return any('"' + " / ".join(parts[:k]).replace("\\", "\\\\").replace('"', '\\"') + '"' in source(file) for k in range(1, len(parts) + 1))


def lost(name, ran, without, messages, whole):
    """Whether messages.txt has a message that no case hears any more."""
    if name in messages or name in without:
        return False
    one_of_many = whole and "[" in name and any(other.partition("[")[0] == name.partition("[")[0] for other in ran)  # of a parametrized case
    return case_of(name, ran) is not None or not exists(name) or one_of_many


def differences(old, new):
    """Of one case: lines with - and +, below its name."""
    lines = difflib.unified_diff(written(old).splitlines(), written(new).splitlines(), lineterm="", n=1)
    return [line for line in lines if not line.startswith(("---", "+++", "@@"))]


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--heard", type=Path, default=folder_of_this_run(), help="what cases have written (build/release/messages)")
    parser.add_argument("--record", action="store_true", help="write messages.txt; cases that did not run keep theirs")
    parser.add_argument("--whole", action="store_true", help="all of make test has run: what was not heard is gone")
    options = parser.parse_args()
    ran, without, messages = heard(options.heard)
    if not ran:
        sys.exit(f"messages: {options.heard} has nothing: no case has run")
    old = recorded()
    gone = [name for name in old if lost(name, ran, without, messages, options.whole)]
    if options.record:
        kept = {name: entries for name, entries in old.items() if name not in gone}
        text = HEAD + written(kept | messages)
        if not RECORDED.is_file() or RECORDED.read_text(encoding="utf-8") != text:
            RECORDED.write_text(text, encoding="utf-8")
        return
    changed = [name for name in messages if old.get(name) != messages[name]]
    for name in sorted({*changed, *gone}):
        print(name, *differences({name: old[name]} if name in old else {}, {name: messages[name]} if name in messages else {}), sep="\n  ")
    if changed or gone:
        sys.exit(f"\nmessages: {len(changed)} cases hear what tests/messages.txt does not have, {len(gone)} no longer hear what it has. "
                 "If that is meant, run `make messages`, and read what git diff tests/messages.txt shows.")
    print(f"messages: {sum(len(texts) for entries in messages.values() for _, texts in entries)} texts in {len(messages)} cases are as recorded")


if __name__ == "__main__":
    main()
