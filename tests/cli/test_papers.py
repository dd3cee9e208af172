# SPDX-License-Identifier: Apache-2.0
"""docs/papers.md: no item of a paper is missing, what a row names is there, and its numbers come out of a run."""
import json
import re
import subprocess
import sys

import pytest
from support import PROGRAM, ROOT, succeed

sys.path[:0] = [str(ROOT / folder) for folder in ("python", "extras/papers", "extras/studies")]
import papers  # noqa: E402
from haptogram_study import printed as printed_numbers  # noqa: E402

PAPERS = papers.read()
ROWS = [(paper["name"], row) for paper in PAPERS for row in paper["rows"]]
# Of each paper: equations, figures, tables, sections with a system, an experiment or a result.
COUNTS = {"Haptogram": (13, 25, 1, 16), "Hoshi": (10, 17, 0, 18), "Shapes": (0, 4, 0, 14), "Fingers": (4, 17, 0, 8), "Multimodal": (19, 12, 4, 13)}


def named(row):
    return f"{row['at']}: {row['what']}"


def by(kind):
    return [(paper, row, row["by"].partition(" ")[2]) for paper, row in ROWS if row.get("by", "").startswith(f"{kind} ")]


def last_digit(text):
    """The value of the last digit of a number that is written so."""
    digits, _, power = text.partition("e")
    return 10.0 ** (int(power or 0) - len(digits.partition(".")[2]))


def is_as_written(value, text):
    return abs(value - float(text)) <= 0.51 * last_digit(text)


def test_the_page_is_fresh(tmp_path):
    assert papers.PAGE.read_text(encoding="utf-8") == papers.page(PAPERS), "write it again: extras/papers/papers.py"
    (tmp_path / "stale.md").write_text(papers.page(PAPERS).replace("643", "644"), encoding="utf-8")
    for page, code in ((papers.PAGE, 0), (tmp_path / "stale.md", 1)):
        checked = subprocess.run([sys.executable, papers.__file__, "--check", page], check=False, capture_output=True, text=True)
        assert checked.returncode == code and checked.stderr.count("stale.md: is not what papers.toml makes") == code


def test_every_item_of_every_paper_has_a_row():
    assert {p["name"]: (p["equations"], p["figures"], p["tables"], len(p["sections"])) for p in PAPERS} == COUNTS
    for paper in PAPERS:
        assert [at for at in papers.items(paper) if at not in {row["at"] for row in paper["rows"]}] == [], paper["name"]
        assert {row["at"] for row in paper["rows"]} <= set(papers.items(paper)), paper["name"]


def test_rows_are_complete():
    for _, row in ROWS:
        assert set(row) <= {"at", "what", "how", "by", "ours", "printed", "unit", "about", "is", "why"}, named(row)
        assert row["is"] in papers.VERDICTS, named(row)
        assert row.get("how") or "by" in row or row["is"] in ("no data", "not modelled", "not built"), named(row)
        assert "why" in row or "by" in row or row["is"] not in ("differs", "not built"), named(row)
        if row["is"] in ("built", "simulated") and row["what"] not in ("coordinates", "overview of the parts"):  # something would notice if it were not
            assert "by" in row or any(part.split()[0] in ("case", "figure") for part in row["how"]), named(row)
        if "ours" in row:  # somebody makes it
            assert "by" in row or any(part.startswith("case ") for part in row["how"]), named(row)


def test_verdicts_are_those_of_the_numbers():
    for _, row in ROWS:
        if "ours" in row and "printed" in row:
            ours, printed = float(row["ours"]), float(row["printed"])
            near = row["about"] * abs(printed) if "about" in row else 0.501 * last_digit(row["printed"])
            assert row["is"] == ("agrees" if abs(ours - printed) <= near else "differs"), named(row)
        elif row["is"] == "agrees":  # in words: a case or a figure is the judge
            assert any(part.split()[0] in ("case", "figure") for part in [*row.get("how", []), row.get("by", "-")]), named(row)


def test_cases_files_and_figures_are_there():
    figures = set(re.findall(r'^    "([\w-]+)": \(', (ROOT / "extras/papers/figures.py").read_text(encoding="utf-8"), re.MULTILINE))
    for _, row in ROWS:
        for part in [*row.get("how", []), row.get("by", "run ")]:
            kind, _, rest = part.partition(" ")
            path, _, name = rest.partition(" ")
            if kind == "case":
                assert rest in papers.cases(), rest
            elif kind == "figure":
                assert rest.partition(" | ")[0] in figures, rest
            elif kind == "protocol":
                assert (ROOT / papers.PROTOCOLS / f"{rest}.toml").is_file(), rest
            elif kind in ("file", "module"):
                assert (ROOT / rest).is_file() and (kind == "file" or f"module {ROOT.joinpath(rest).stem}" in (ROOT / rest).read_text()), rest
            elif kind == "function":
                assert re.search(rf"\b{name}\b", (ROOT / path).read_text(encoding="utf-8")), rest
            else:
                assert kind in ("haptogram", "run", "printed", "quotient"), part


def test_commands_and_options_are_there():
    helps = {}

    def help_of(*words):
        if words not in helps:
            helps[words] = succeed([*words, "--help"]).stdout.decode()
        return helps[words]

    for _, row in ROWS:
        for command in [part for part in row.get("how", []) if part.startswith("haptogram ")]:
            words = command.split()[1:]
            names = [word for word in words if not word.startswith("-")]
            listed = set(re.findall(r"(?:^|[ ,])(--?[a-z][a-z-]*)(?=[ ,\n]|$)", help_of(*names), re.MULTILINE))
            assert [word for word in words if word.startswith("-") and word not in listed] == [], command


def test_commands_print_our_numbers(tmp_path):
    found = by("run")
    assert len(found) >= 5
    printed = {}
    for _, row, rest in found:
        command, _, pattern = rest.partition(" | ")
        if command not in printed:
            result = succeed(command.split()[1:], cwd=tmp_path)
            printed[command] = result.stdout.decode() + result.stderr.decode()
        match = re.search(pattern, printed[command])
        assert match and is_as_written(float(match[1]), row["ours"]), (named(row), match and match[1])


def test_printed_numbers_are_ours():
    lines = printed_numbers.recompute()
    assert len(by("printed")) >= 30
    for paper, row, rest in by("printed"):
        where, _, what = rest.partition(" | ")
        matching = [line for line in lines if (line.paper, line.where) == (paper, where) and line.what.startswith(what)]
        assert len(matching) == 1, (named(row), [line.what for line in matching])
        assert re.findall(r"-?[0-9.]+", matching[0].ours)[-1] == row["ours"], (named(row), matching[0].ours)
        if "printed" in row and matching[0].printed:
            assert matching[0].printed.replace("−", "-") == row["printed"], named(row)


def test_quotients():
    for _, row, rest in by("quotient"):
        over, under = map(float, rest.split(" / "))
        assert is_as_written(over / under, row["ours"]), named(row)


def test_hoshis_32_frequencies(tmp_path):
    """Each of the device's modulation frequencies is compiled for it, and comes out as near as the page says."""
    (row,) = [row for paper, row in ROWS if paper == "Hoshi" and row["what"].startswith("32 modulation frequencies")]
    worst = 0.0
    for step in range(32):
        hz = 1000.0 ** (step / 31)
        words = ["compile", "--shape", "point", "--center", "0,0,200", "--am", f"square:{hz:.6g}", "--array", "hoshi", "--quantise", "hoshi"]
        (made,) = json.loads(succeed([*words, "--json", "-o", "point.hex"], cwd=tmp_path).stdout)["am_hz"]
        worst = max(worst, 100 * abs(made / hz - 1))
    assert is_as_written(worst, row["ours"])


@pytest.mark.deep
def test_figures_have_our_numbers(tmp_path):
    wanted = by("figure")
    names = sorted({rest.partition(" | ")[0] for _, _, rest in wanted})
    tool = PROGRAM.parents[2] / "extras/papers/haptogram_figures"
    command = [sys.executable, ROOT / "extras/papers/figures.py", "--program", PROGRAM, "--tool", tool, "--output", tmp_path, "--only", *names]
    done = subprocess.run(list(map(str, command)), check=False, capture_output=True, text=True, timeout=900)
    assert done.returncode == 0, done.stderr
    made = {f["id"]: f["rows"] for f in json.loads((tmp_path / "figures.json").read_text(encoding="utf-8"))["figures"]}
    wrong = []
    for _, row, rest in wanted:
        name, _, start = rest.partition(" | ")
        lines = [line for line in made[name] if line["what"].startswith(start)]
        assert lines, rest
        if abs(lines[0]["ours"] - float(row["ours"])) > 1.01 * last_digit(row["ours"]):
            wrong.append((named(row), row["ours"], lines[0]["ours"]))
        if "printed" in row and lines[0]["paper"] is not None:
            assert float(row["printed"]) == pytest.approx(lines[0]["paper"]), named(row)
    assert wrong == []
