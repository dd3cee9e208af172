# SPDX-License-Identifier: Apache-2.0
"""What `make docs` is made of: dead links are found, the page of commands has them all, and a maker's questions are answered."""
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools/docs"))
sys.path.insert(0, str(ROOT / "tools"))
import commands  # noqa: E402
import configurations  # noqa: E402
import docs  # noqa: E402
import generate_interface  # noqa: E402
import links  # noqa: E402

MARKDOWN = "# One, `two`\n\n[here](#one-two) [there](other.md#three-1)\n\n```sh\n[code](nowhere)\n```\n"


def dead(folder, text):
    (folder / "page.md").write_text(text, encoding="utf-8")
    (folder / "other.md").write_text("## Three\n\n## Three\n", encoding="utf-8")
    return list(links.dead_in_markdown(folder, ["page.md", "other.md"]))


def test_links_that_lead_somewhere_are_no_finding(tmp_path):
    assert dead(tmp_path, MARKDOWN + "[net](https://example.org/#x) `[code](nowhere)`\n") == []


@pytest.mark.parametrize("link", ["[a](nowhere.md)", "[a](#two)", "[a](other.md#three-2)", "![a](picture.svg)", '<img src="picture.png">', "[a [b]](no)"])
def test_a_dead_link_is_found_with_its_line(tmp_path, link):
    assert [message.split(": ")[0] for message in dead(tmp_path, MARKDOWN + f"text {link}\n")] == ["page.md:8"]


def test_a_dead_link_of_the_site_is_found(tmp_path):
    (tmp_path / "in").mkdir()
    (tmp_path / "in/page.html").write_text('<a href="../index.html#top">a</a><a href="../index.html#no">a</a><img src="no.png">', encoding="utf-8")
    (tmp_path / "index.html").write_text('<h1 id="top">a</h1><a href="in/page.html?x#">a</a>', encoding="utf-8")
    found = [message.split(": ")[1] for message in links.dead_in_site(tmp_path)]
    assert found == ["../index.html#no", "no.png"]


@pytest.fixture
def stage(tmp_path, monkeypatch, program):
    monkeypatch.setattr(docs, "PAGES", tmp_path)
    return docs.Stage(["docs/foci.md", "rtl/README.md", "host/README.md"], Path(program))


def staged(stage, folder, text):
    stage.page("docs/page.md", text)
    return (folder / "docs/page.md").read_text(encoding="utf-8")


def test_a_page_is_laid_out_for_the_site(stage, tmp_path):
    text = "<!-- SPDX-License-Identifier: Apache-2.0 -->\n# A\n\n- a\n  - b\n\n```sh board\n  x [a](b)\n```\n```toml ring.toml\n```\n"
    made = '# A\n\n- a\n    - b\n\n```sh\n  x [a](b)\n```\n```toml title="ring.toml"\n```\n'
    assert staged(stage, tmp_path, text) == made


def test_links_lead_to_pages_folders_to_their_readme_and_sources_become_pages(stage, tmp_path):
    text = "[a](foci.md#rules) [b](../rtl/) [c](../host/cli/inspect.cpp) [d](https://example.org) ![e](cycle.svg)\n"
    assert staged(stage, tmp_path, text) == "[a](foci.md#rules) [b](../rtl/README.md) [c](../host/cli/inspect.cpp.md) [d](https://example.org) ![e](cycle.svg)\n"
    assert (tmp_path / "docs/cycle.svg").exists()
    assert "````cpp\n// SPDX" in (tmp_path / "host/cli/inspect.cpp.md").read_text(encoding="utf-8")
    with pytest.raises(SystemExit, match="docs/page.md: nowhere.md: there is no such file"):
        staged(stage, tmp_path, "[a](nowhere.md)\n")


def test_a_picture_is_what_its_command_draws(stage, tmp_path):
    made = staged(stage, tmp_path, "<!-- picture w.svg: haptogram board pinout ulx3s-85f -o w.svg -->\n")
    assert made == "![haptogram board pinout ulx3s-85f -o w.svg](w.svg)\n"
    assert "</svg>" in (tmp_path / "docs/w.svg").read_text(encoding="utf-8")
    with pytest.raises(SystemExit, match="the command of the picture w.svg failed"):
        staged(stage, tmp_path, "<!-- picture w.svg: haptogram board pinout nothing -o w.svg -->\n")


def test_the_page_of_commands_has_every_command_and_option(program):
    page = commands.write(str(program))
    listed = subprocess.run([str(program), "--help"], check=True, capture_output=True, text=True).stdout.partition("--version")[2]
    names = re.findall(r"^  ([a-z-]+)  ", listed, re.MULTILINE)
    assert len(names) > 20
    for name in names:
        part = page.partition(f"\n## haptogram {name}\n")[2].partition("\n## ")[0]
        shown = subprocess.run([str(program), name, "--help"], check=True, capture_output=True, text=True).stdout
        for option in set(re.findall(r"^  (?:-\w,)?(--[a-z-]+)", shown, re.MULTILINE)) - {"--help"}:
            assert f"{option} " in part.replace("`", " "), (name, option)


def test_every_page_of_docs_is_in_the_sites_order():
    order = (ROOT / "tools/docs/mkdocs.yml").read_text(encoding="utf-8")
    pages = [*links.tracked("docs/*.md"), *(str(path.relative_to(ROOT).with_suffix(".md")) for path in docs.notebooks.all_notebooks())]
    assert len(pages) > 10 and [page for page in pages if f": {page}\n" not in order] == []


def test_a_makers_questions_have_an_answer_and_lead_to_its_page():
    """That the page and its section are there, tools/lint checks."""
    text = (ROOT / "docs/README.md").read_text(encoding="utf-8")
    questions = re.findall(r"^- \*\*[^*]+\*\* (.*(?:\n  .*)*)", text, re.MULTILINE)
    assert len(questions) >= 20
    for answer in questions:
        assert re.search(r"\w+\. *\n? *\[[^]]+\]\([^)]+\)", answer), answer


@pytest.mark.parametrize(
    ("what", "change"),
    [
        ("status.", lambda table: words(table, "status").insert(3, "new")),
        ("status.", lambda table: words(table, "status").remove("underruns")),
        ("command.enable", lambda table: by_name(table, "command", "enable").update(code=0x7F)),
        ("feature.watchdog", lambda table: by_name(table, "feature", "watchdog").update(bit=30)),
        ("sequence_entry.", lambda table: table["sequence_entry"]["fields"][0].update(width=1)),
        (None, lambda table: words(table, "status").append("new")),
        (None, lambda table: (words(table, "status").insert(3, "new"), table["protocol"].update(version_major=99))),
    ],
    ids=["in between", "gone", "another code", "another bit", "narrower", "at the end", "another version"],
)
def test_a_published_number_of_the_interface_stays(what, change):
    table = configurations.load()
    published = generate_interface.numbers(table)
    assert published == (ROOT / generate_interface.NUMBERS).read_text(encoding="utf-8")
    change(table)
    found = generate_interface.renumbered(published, generate_interface.numbers(table))
    assert all(line.startswith(what) for line in found) and found if what else found == []


def test_the_generator_writes_nothing_that_renumbers(tmp_path, monkeypatch):
    (tmp_path / "tools").mkdir()
    other = (ROOT / generate_interface.NUMBERS).read_text(encoding="utf-8").replace("command.enable ", "command.enable_all ")
    (tmp_path / generate_interface.NUMBERS).write_text(other, encoding="utf-8")
    monkeypatch.setattr(generate_interface, "ROOT", tmp_path)
    monkeypatch.setattr(sys, "argv", ["generate_interface.py"])
    with pytest.raises(SystemExit, match=r"command\.enable_all was published as 0x\w+, and has gone"):
        generate_interface.main()
    assert [path.name for path in (tmp_path / "tools").iterdir()] == ["interface_numbers.txt"] and not (tmp_path / "rtl").exists()


def words(table, region):
    return by_name(table, "block", region, "region")["words"]


def by_name(table, part, name, key="name"):
    return next(entry for entry in table[part] if entry[key] == name)
