# SPDX-License-Identifier: Apache-2.0
"""What Python and notebooks ask of the program, as it stands in their sources: each verb is there, and each option is one of that verb. Tests run
most of it; this also sees what only `make bench`, `make demo`, `make figures` and `make hardware` run."""
import ast
import functools
import json
import re
import sys

import pytest
from support import ROOT, succeed, text

sys.path.insert(0, str(ROOT / "extras/studio"))
import gallery  # noqa: E402

FOLDERS = ("python", "extras", "tools", "docs")
PROGRAM = re.compile(r"\b\w*program\b|^'haptogram'$", re.IGNORECASE)  # what stands before the verb: program, self.program, str(program), 'haptogram'
ASKS = ("run", "ask", "Popen")  # functions that get a program and its words; other words stand in lists
# Each of these files calls the program; one that is missed here would be looked at in vain.
CALLERS = {"extras/papers/figures/work.py", "extras/hardware/netlist.py", "extras/hardware/spice.py", "extras/studio/gallery.py", "tools/bench.py",
           "tools/demo.py", "tools/docs/commands.py", "extras/studies/haptogram_study/cli.py", "extras/studies/haptogram_study/stimulus.py"}  # fmt: skip


@functools.cache
def help_of(*verbs):
    return text(succeed([*verbs, "--help"]).stdout)


@functools.cache
def options_of(*verbs):
    return frozenset(re.findall(r"(?<![\w-])--?[a-z][\w-]*", help_of(*verbs)))


def source_of(path):
    if path.suffix == ".ipynb":
        cells = ["".join(cell["source"]) for cell in json.loads(path.read_text(encoding="utf-8"))["cells"] if cell["cell_type"] == "code"]
        return "\n".join(cell for cell in cells if not re.search(r"^[%!]", cell, re.MULTILINE))
    return path.read_text(encoding="utf-8")


def calls_in(source):
    """The words of each command in a source, as far as they are written there; None where one is computed."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Call) and getattr(node.func, "attr", getattr(node.func, "id", "")) in ASKS:
            given = node.args
        else:
            given = node.elts if isinstance(node, (ast.List, ast.Tuple)) else []
        for before, at in zip(given, range(1, len(given))):
            verb = given[at]
            if isinstance(verb, ast.List) and verb.elts:  # ask(program, ["compile", …])
                words = verb.elts
            else:
                words = given[at:]
            named = PROGRAM.search(ast.unparse(before.args[0] if isinstance(before, ast.Call) and before.args else before))
            if named and isinstance(words[0], ast.Constant) and isinstance(words[0].value, str):
                yield [word.value if isinstance(word, ast.Constant) else None for word in words]


SOURCES = [path for folder in FOLDERS for kind in ("py", "ipynb") for path in sorted((ROOT / folder).rglob(f"*.{kind}"))]
CALLS = [(str(path.relative_to(ROOT)), words) for path in SOURCES for words in calls_in(source_of(path))]


def test_calls_are_found():
    assert {file for file, _ in CALLS} >= CALLERS, CALLERS - {file for file, _ in CALLS}


@pytest.mark.parametrize("file", sorted({file for file, _ in CALLS}))
def test_the_program_knows_what_it_is_asked(file):
    for words in (words for one, words in CALLS if one == file):
        if words[0].startswith("-"):
            assert words[0] in options_of(), words
            continue
        assert re.search(rf"^  {words[0]} ", help_of(), re.MULTILINE), f"{file}: the program has no {words[0]}"
        nested = "Subcommands:" in help_of(words[0]) and words[1]
        known = options_of(*words[: 2 if nested else 1])
        strange = [word for word in words[1:] if isinstance(word, str) and word.startswith("--") and word.split("=")[0] not in known]
        assert not strange, f"{file}: {' '.join(map(str, words))}: the program has no {', '.join(strange)} there"


@pytest.mark.parametrize("name", sorted(path.parent.name for path in (ROOT / "extras/studio/gallery").glob("*/project.toml")))
def test_a_picture_of_the_gallery_is_what_its_design_makes(name, program):
    design = ROOT / "extras/studio/gallery" / name
    made = gallery.picture(gallery.points_of(program, design / "project.toml"))
    assert made.split("-->")[1] == (design / "picture.svg").read_text(encoding="utf-8").split("-->")[1]
