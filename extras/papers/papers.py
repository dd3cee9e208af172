#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes docs/papers.md from papers.toml, with `--check FILE` only compares. A row of that table:

- `at`: the paper's item, `what`: what it says
- `how`: what does it here, a list of
  - `haptogram COMMAND --option …`, options without their values
  - `case NAME`: a case of the C++ tests by its name, of the Python tests as FILE::FUNCTION
  - `figure NAME` of `make figures`, `protocol NAME` of a study
  - `file PATH`, `module PATH` in rtl/, `function PATH NAME`
- `by`: what makes our number, besides `how`
  - `run haptogram … | PATTERN`: the first group of a regular expression in what the command prints
  - `figure NAME | ROW`: the row of a figure's table that begins so
  - `printed WHERE | WHAT`: the row of `haptogram-study printed`
  - `quotient A / B`
- `ours`, `printed`: numbers as text, of one `unit`; `about`: by which share of the printed number ours may differ and still agree
- `is`: the verdict, one of VERDICTS; `why`

tests/cli/test_papers.py finds what is missing, stale or does not exist."""
import argparse
import functools
import re
import sys
import tomllib
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TABLE, PAGE = ROOT / "extras/papers/papers.toml", ROOT / "docs/papers.md"
PROTOCOLS = "extras/studies/haptogram_study/protocols"
VERDICTS = {
    "agrees": "ours rounds to the printed digits, or is as near as \"about\" allows",
    "differs": "it does not, and why",
    "built": "done and tested; the paper prints no number to compare with",
    "simulated": "a device or a person of the paper that we only simulate",
    "interface only": "what would be connected to it; the device is not here",
    "protocol only": "the study can be run; we asked nobody",
    "no data": "it does not follow from what the paper prints",
    "not modelled": "we compute no such thing",
    "not built": "missing",
}


def read(path: Path = TABLE) -> list[dict]:
    return tomllib.loads(path.read_text(encoding="utf-8"))["paper"]


def items(paper: dict) -> list[str]:
    """All that must have a row."""
    numbered = (("eq.", "equations"), ("fig.", "figures"), ("table", "tables"))
    return [f"{kind} {number}" for kind, key in numbered for number in range(1, paper[key] + 1)] + paper["sections"]


@functools.cache
def cases() -> dict[str, str]:
    """The file of each case of the tests, by name; Python's as FILE::FUNCTION."""
    found = {}
    for path in sorted((ROOT / "tests").rglob("*.cpp")):
        for literals in re.findall(r'TEST_CASE\(\s*((?:"(?:[^"\\]|\\.)*"\s*)+)', path.read_text(encoding="utf-8")):
            found["".join(re.findall(r'"((?:[^"\\]|\\.)*)"', literals))] = str(path.relative_to(ROOT))
    for path in sorted((ROOT / "tests").rglob("test_*.py")):
        name = str(path.relative_to(ROOT))
        found.update({f"{name}::{function}": name for function in re.findall(r"^def (test_\w+)", path.read_text(encoding="utf-8"), re.MULTILINE)})
    return found


def link(text: str, path: str) -> str:
    return f"[{text}](../{path})"


def shown(part: str) -> str:
    """An entry of `how` or `by`, as the page has it."""
    kind, _, rest = part.partition(" ")
    if kind == "haptogram":
        return f"`{part}`"
    if kind == "run":
        return "`" + re.sub(r" (--json|-o \S+)(?= |$)", "", rest.partition(" | ")[0]) + "`"
    if kind == "case":
        name = rest.partition("::")[2].removeprefix("test_").replace("_", " ") or rest
        return link("test: " + " ".join(re.split(r"[:,] ", name)[0].split()[:5]), cases().get(rest, "?"))
    if kind == "figure":
        return f"figure {rest.partition(' | ')[0]}"
    if kind == "protocol":
        return link(rest, f"{PROTOCOLS}/{rest}.toml")
    if kind == "printed":
        return "`haptogram-study printed`"
    if kind == "quotient":
        return rest.replace("/", "∕")
    path, _, name = rest.partition(" ")
    return link(f"`{name}`" if name else path.removesuffix("/README.md").rpartition("/")[2], path)


def number(text: str, unit: str) -> str:
    text = re.sub(r"e\+0*(\d+)", lambda found: "·10" + found[1].translate(str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")), text.replace("-", "−"))
    return f"{text}{'' if unit == '°' else ' '}{unit}".strip() if text else ""


def line(row: dict) -> str:
    how = list(dict.fromkeys(shown(part) for part in ([row["by"]] if "by" in row else []) + row.get("how", [])))
    verdict = f"**{row['is']}**" + (f": {row['why']}" if "why" in row else "")
    numbers = [number(row.get(key, ""), row.get("unit", "")) for key in ("ours", "printed")]
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in (row["at"], row["what"], ", ".join(how), *numbers, verdict)) + " |"


def page(papers: list[dict]) -> str:
    rows = [row for paper in papers for row in paper["rows"]]
    counts = Counter(row["is"] for row in rows)
    parts = [
        "<!-- SPDX-License-Identifier: Apache-2.0 -->",
        "# The five papers, item by item",
        "",
        "Every equation, figure, table and protocol of the [papers](references.md#the-papers): what does it here, our number, the printed number.",
        "`extras/papers/papers.py` writes this page from `papers.toml`; tests run the commands and compare. `make figures` draws the figures.",
        "`haptogram-study printed --differing` prints all numbers that do not follow from a paper's own data, and why.",
        "",
        f"{len(rows)} rows:",
        "",
        *(f"- **{verdict}** ({counts[verdict]}): {meaning}" for verdict, meaning in VERDICTS.items()),
    ]
    for paper in papers:
        parts += ["", f"## {paper['name']}", ""]
        parts += [f"{paper['note']}", ""] if "note" in paper else []
        parts += ["| item | what | how | ours | printed | verdict |", "|---|---|---|---|---|---|", *map(line, paper["rows"])]
    return "\n".join(parts) + "\n"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", type=Path, metavar="FILE", help="say whether this page is what papers.toml makes; writes nothing")
    arguments = parser.parse_args()
    text = page(read())
    if arguments.check is None:
        PAGE.write_text(text, encoding="utf-8")
    elif arguments.check.read_text(encoding="utf-8") != text:
        print(f"{arguments.check}: is not what papers.toml makes; write it again with extras/papers/papers.py", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
