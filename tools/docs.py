#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`make docs`: the repository's Markdown as a site in build/site, with pages that are made from the program, the sources and the
notebooks. A warning of a generator and a dead link are errors."""
import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tools/docs"))
import commands  # noqa: E402
import links  # noqa: E402
import notebooks  # noqa: E402

PAGES, SITE = ROOT / "build/docs/pages", ROOT / "build/site"
PICTURE = re.compile(r"^<!-- picture (\S+): (.+) -->$", re.MULTILINE)
LANGUAGES = {".cpp": "cpp", ".hpp": "cpp", ".py": "python", ".v": "verilog", ".vh": "verilog", ".toml": "toml", ".json": "json"}


def put(name: str, text: str) -> None:
    (PAGES / name).parent.mkdir(parents=True, exist_ok=True)
    (PAGES / name).write_text(text, encoding="utf-8")


class Stage:
    """Lays pages out as they lie in the repository, and with them what they link to."""

    def __init__(self, pages: list[str], program: Path) -> None:
        self.pages, self.program = set(pages), program

    def page(self, name: str, text: str) -> None:
        """Links lead to pages of the site; fences and lists are written as Python's Markdown wants them."""
        text = PICTURE.sub(lambda found: self.picture(name, found[1], found[2]), text)
        lines = dict(links.prose(text))
        for number, line in lines.items():
            line = links.LINK.sub(lambda found: found[0].replace(found[1] or found[2], self.link(name, found[1] or found[2])), line)
            lines[number] = re.sub(r"^( +)(?=\S)", r"\1\1", line)
        titled = {number: re.sub(r"^```(toml) (\S+)", r'```\1 title="\2"', line) for number, line in enumerate(text.splitlines(), 1)}
        rest = {number: line.replace("```sh board", "```sh") for number, line in titled.items()}
        put(name, re.sub(r"<!-- SPDX.*-->\n", "", "\n".join((rest | lines).values()) + "\n"))

    def picture(self, page: str, name: str, command: str) -> str:
        """What a command of the program draws, in the place of a comment that says it."""
        with tempfile.TemporaryDirectory() as folder:
            Path(folder, "haptogram").symlink_to(self.program)
            Path(folder, "tools").symlink_to(ROOT / "tools")
            Path(folder, "python3").write_text(f"#!/bin/sh\nexec '{sys.executable}' \"$@\"\n")
            Path(folder, "python3").chmod(0o755)
            environment = {**os.environ, "PATH": f"{folder}:{os.environ['PATH']}", "HAPTOGRAM_PYTHON": sys.executable}
            if subprocess.run(["bash", "-ec", command], cwd=folder, check=False, env=environment, stdout=subprocess.DEVNULL).returncode:
                sys.exit(f"docs: {page}: the command of the picture {name} failed: {command}")
            (PAGES / page).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(Path(folder, name), (PAGES / page).with_name(name))
        return f"![{command.replace('[', '(').replace(']', ')')}]({name})"

    def link(self, name: str, link: str) -> str:
        path, _, anchor = link.partition("#")
        if not links.is_local(link) or not path:
            return link
        target = (ROOT / name).parent.joinpath(path).resolve().relative_to(ROOT)
        target = target / "README.md" if (ROOT / target).is_dir() else target
        if not (ROOT / target).exists() and not (PAGES / target).exists():
            sys.exit(f"docs: {name}: {link}: there is no such file")
        return os.path.relpath(self.target(target), Path(name).parent) + (f"#{anchor}" if anchor else "")

    def target(self, file: Path) -> str:
        """The page of a file; a picture is itself, and any other source gets a page."""
        if str(file) in self.pages or (PAGES / file).exists():
            return str(file)
        if file.suffix in (".svg", ".png", ".css"):
            (PAGES / file).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / file, PAGES / file)
            return str(file)
        text = (ROOT / file).read_text(encoding="utf-8")
        put(f"{file}.md", f"# {file}\n\n````{LANGUAGES.get(file.suffix, 'text')}\n{text}````\n")
        return f"{file}.md"


CPP = """# C++

[The C++ libraries](cpp/annotated.html), from the comments in their headers: [by folder](cpp/files.html), [by namespace](cpp/namespaces.html).
[Small programs](../host/README.md#programs-of-your-own) show how they are used.
"""
PYTHON = {
    "Compute": ("results.Field", "results.Table", "results.compare", *(f"computing.{name}" for name in (
        "compile", "field", "feel", "solve", "simulate", "analyze", "pressure", "workspace", "Array", "Compiled", "Drives", "array_names", "simulated_board"))),
    "Play": ("Board", "Image", "Record", "Focus", "Identity", "Status", "play", "stream", "end_like_ctrl_c", "HaptogramError", "ErrorCode"),
}  # fmt: skip


def python_page() -> str:
    """Names that the package exports, as mkdocstrings reads them in its sources, and what they stand on below."""
    page = "# Python\n\n[How to use it](../python/README.md). Names are of the package `haptogram`: `haptogram.compile`.\n\n"
    for title, names in PYTHON.items():
        page += f"## {title}\n\n" + "".join(f"::: haptogram.{name}\n\n" for name in names)
    page += "## haptogram.calls\n\nThe C++ library, on which the others stand.\n\n::: haptogram.calls\n"
    return page


def cpp_pages() -> bool:
    """By Doxygen, beside the page that leads there; whether there was no warning."""
    put("reference/cpp.md", CPP)
    settings = (ROOT / "tools/docs/Doxyfile").read_text(encoding="utf-8") + f"INPUT = {ROOT}/host/haptogram\nOUTPUT_DIRECTORY = {PAGES}/reference\n"
    return subprocess.run(["doxygen", "-"], input=settings, text=True, check=False, cwd=ROOT).returncode == 0


def notebook_pages(stage: Stage, build: Path) -> None:
    for path in notebooks.all_notebooks():
        print(f"docs: running {path.name}", file=sys.stderr)
        name = str(path.relative_to(ROOT))
        text, pictures = notebooks.page(notebooks.run(path, build / "host/cli/haptogram", build / "host/c/libhaptogram.so"), path.stem)
        for picture, content in pictures.items():
            (PAGES / name).parent.mkdir(parents=True, exist_ok=True)
            (PAGES / name).with_name(picture).write_bytes(content)
        shutil.copy(path, PAGES / name)
        stage.page(name.replace(".ipynb", ".md"), text)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", type=Path, default=ROOT / "build/release", help="what `make build` made: program and library")
    build = parser.parse_args().build.resolve()
    shutil.rmtree(PAGES, ignore_errors=True)
    pages = links.tracked("*.md")
    stage = Stage(pages, build / "host/cli/haptogram")
    for name in pages:
        stage.page(name, (ROOT / name).read_text(encoding="utf-8"))
    stage.target(Path("tools/docs/site.css"))
    notebook_pages(stage, build)
    put("reference/commands.md", commands.write(str(build / "host/cli/haptogram")))
    put("reference/python.md", python_page())
    if not cpp_pages():
        return 1
    mkdocs = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--clean", "-f", str(ROOT / "tools/docs/mkdocs.yml")]
    if subprocess.run(mkdocs, check=False).returncode:
        return 1
    dead = sorted(set(links.dead_in_site(SITE, without="reference/cpp")))
    for message in dead:
        print(f"docs: {message}", file=sys.stderr)
    return 1 if dead else 0


if __name__ == "__main__":
    sys.exit(main())
