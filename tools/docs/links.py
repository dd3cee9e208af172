# SPDX-License-Identifier: Apache-2.0
"""Finds links that lead nowhere: in the repository's Markdown (`tools/docs/links.py`), and in the pages of a built site
(`tools/docs/links.py SITE`). Addresses on the network are not asked for."""
import re
import subprocess
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

ROOT = Path(__file__).resolve().parents[2]
LINK = re.compile(r'!?\[(?:[^\]\[]|\[[^\]]*\])*\]\(([^()\s]+(?:\([^()]*\)[^()\s]*)*)\)|<img [^>]*src="([^"]+)"')
CODE = re.compile(r"`[^`]*`")


def tracked(*patterns: str) -> list[str]:
    """Names of the files of the checkout, new ones too, that match."""
    listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard", *patterns], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    return sorted(name for name in listed.splitlines() if (ROOT / name).exists())


def is_local(link: str) -> bool:
    return not urlsplit(link).scheme and not link.startswith("//")


def prose(text: str) -> Iterator[tuple[int, str]]:
    """Number and text of each line outside of blocks of code."""
    inside = False
    for number, line in enumerate(text.splitlines(), 1):
        if line.lstrip().startswith("```"):
            inside = not inside
        elif not inside:
            yield number, line


def slug(heading: str) -> str:
    """The anchor of a heading, as the forges and the site make it."""
    shown = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading)
    return re.sub(r"[^\w\- ]", "", shown.strip().lower()).replace(" ", "-")


def anchors(text: str) -> set[str]:
    headings = [slug(line.lstrip("#")) for _, line in prose(text) if re.match(r"#{1,6} ", line)]
    again = {f"{name}-{count}" for name in headings for count in range(1, headings.count(name))}
    return {*headings, *again}


def dead_in_markdown(root: Path, names: list[str]) -> Iterator[str]:
    """A message for each link of these files of a folder whose file or anchor is not there."""
    for name in names:
        for number, line in prose((root / name).read_text(encoding="utf-8")):
            for found in LINK.finditer(CODE.sub("", line)):
                link = found[1] or found[2]
                if is_local(link) and (why := _dead(root, name, link)):
                    yield f"{name}:{number}: {link}: {why}"


def _dead(root: Path, name: str, link: str) -> str:
    path, _, anchor = unquote(link).partition("#")
    target = (root / name).parent / path if path else root / name
    if not target.exists():
        return "there is no such file"
    if anchor and (target.suffix != ".md" or anchor not in anchors(target.read_text(encoding="utf-8"))):
        return f"{target.name} has no heading of that anchor"
    return ""


class Page(HTMLParser):
    """What a page of the site links to, and what can be linked to in it."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.anchors: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for key, value in attrs:
            if key == "id" or (key == "name" and tag == "a"):
                self.anchors.add(value or "")
            elif key == "src" or (key == "href" and tag in ("a", "link")):
                self.links.append(value or "")


def dead_in_site(site: Path, without: str = "") -> Iterator[str]:
    """The same of all pages but those in a folder that another generator wrote, to which others may lead."""
    pages = {path.resolve(): Page(path.read_text(encoding="utf-8")) for path in site.rglob("*.html")}
    for path, page in pages.items():
        for link in filter(is_local, page.links if not without or (site / without).resolve() not in path.parents else ()):
            way, _, anchor = link.partition("#")
            way = unquote(urlsplit(way).path)  # from the site's root in the page of what is not found
            target = (site / way[1:] if way.startswith("/") else path.parent / way).resolve() if way else path
            target = target / "index.html" if target.is_dir() else target
            if not target.exists():
                yield f"{path.relative_to(site.resolve())}: {link}: there is no such file"
            elif anchor and target in pages and unquote(anchor) not in pages[target].anchors:
                yield f"{path.relative_to(site.resolve())}: {link}: {target.name} has no such anchor"


def main() -> int:
    dead = sorted(set(dead_in_site(Path(sys.argv[1])) if len(sys.argv) > 1 else dead_in_markdown(ROOT, tracked("*.md"))))
    for message in dead:
        print(f"links: {message}", file=sys.stderr)
    return 1 if dead else 0


if __name__ == "__main__":
    sys.exit(main())
