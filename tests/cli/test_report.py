# SPDX-License-Identifier: Apache-2.0
"""`haptogram report`: a page that another program's parser takes, with the numbers of the manifest and of `analyze`, and the paragraph for a paper."""
import base64
import json
from html.parser import HTMLParser

import pytest
from support import BAD_INPUT, USAGE, path_file, read_json, refuse, succeed, text

VOID = {"meta", "img"}


class Page(HTMLParser):
    """The cells of all tables, the points of all lists, paragraphs and pictures. Every element must be closed in its place."""

    def __init__(self, page):
        super().__init__()
        self.open, self.found, self.pictures = [], {"th": [], "td": [], "li": [], "p": [], "h1": [], "title": []}, []
        self.feed(page)
        self.close()
        assert self.open == [], f"not closed: {self.open}"

    def handle_starttag(self, tag, attributes):
        if tag == "img":
            self.pictures.append(dict(attributes)["src"])
        if tag in VOID:
            return
        self.open.append(tag)
        if tag in self.found:
            self.found[tag].append("")

    def handle_endtag(self, tag):
        assert self.open and self.open.pop() == tag, f"</{tag}> in the wrong place"

    def handle_data(self, data):
        for tag in self.open:
            if tag in self.found:
                self.found[tag][-1] += data


@pytest.fixture(scope="module")
def ring(tmp_path_factory):
    folder = tmp_path_factory.mktemp("ring")
    succeed(["compile", "--shape", "circle", "--points", 12, "--rate", 20, "-o", "ring <&> \"1\".hex"], cwd=folder)
    return folder


NAME = 'ring <&> "1".hex'


def test_the_page(ring):
    succeed(["report", NAME], cwd=ring, timeout=300)
    page = Page((ring / "report.html").read_text())
    manifest = read_json(ring / NAME.replace(".hex", ".json"))
    points = json.loads(succeed(["analyze", NAME, "--json"], cwd=ring).stdout)["points"]
    assert page.found["h1"] == [f"Report on {NAME}"] and page.found["title"] == page.found["h1"]
    paragraph = text(succeed(["report", NAME, "--methods"], cwd=ring).stdout)
    assert page.found["p"][0] + "\n" == paragraph
    for number in ("12 focal points", "100 transducers MA40S4S", "20 times a second", manifest["image_sha256"], manifest["inputs_sha256"], "eq. 2 to 5", "at least 10 mm apart", "z = 130.0 mm", "nominal level: 4 Pa·m"):
        assert number in paragraph
    # A row of nine cells for each focus, behind the cells of the numbers.
    rows = page.found["td"][-9 * len(points) :]
    assert len(points) == 12 and len(page.found["td"]) == 9 * len(points) + len(page.found["th"]) - 9
    for n, point in enumerate(points):
        row = rows[9 * n : 9 * n + 9]
        assert [float(x) for x in row[1].split(",")] == pytest.approx(point["focus_mm"], abs=0.051)
        assert float(row[3]) == pytest.approx(point["pressure_pa"], abs=0.6)
        assert float(row[5]) == pytest.approx(point["width_mm"], abs=0.051)
        assert float(row[8]) == pytest.approx(point["force_mn"], abs=6e-4)
    assert any("keep ears away" in finding for finding in page.found["li"])
    (picture,) = page.pictures
    kind, data = picture.split(",", 1)
    png = base64.b64decode(data, validate=True)
    assert kind == "data:image/png;base64" and png.startswith(b"\x89PNG\r\n") and png.endswith(b"IEND\xaeB`\x82")


def test_without_a_picture_and_to_standard_output(ring):
    page = Page(text(succeed(["report", NAME, "--no-picture", "-o", "-"], cwd=ring).stdout))
    assert page.pictures == [] and len(page.found["td"]) > 100


def test_a_project_with_modulation_and_foci_computed_by_the_board(tmp_path):
    (tmp_path / "ring.toml").write_text('format = "haptogram-project-1"\narray = "tile-10x10"\nboard = "tile-100-wide"\nam = "sine:200"\n[[shape]]\nkind = "circle"\n')
    paragraph = text(succeed(["report", "ring.toml", "--methods"], cwd=tmp_path).stdout)
    assert "200 samples of 1 carrier period each" in paragraph and "(200 Hz)" in paragraph and "computes the phase" in paragraph


def test_a_modulation_by_silence(tmp_path):
    succeed(["compile", "--shape", "circle", "--points", 40, "--rate", 10, "--am", "square:100", "-o", "beat.hex"], cwd=tmp_path)
    assert "Nothing was played for 50 % of the time." in text(succeed(["report", "beat.hex", "--methods"], cwd=tmp_path).stdout)


def test_a_page_is_html(ring, tmp_path):
    for name in ("report.pdf", "report.svg"):
        refuse(tmp_path, ["report", ring, "-o", name], USAGE)
        assert not (tmp_path / name).exists()


def test_several_foci_at_the_same_time(tmp_path):
    path = path_file(tmp_path, [([(-20, 0, 150, 1.0), (20, 5 * n, 150, 1.0)], 40 + 40 * n) for n in range(3)])
    succeed(["compile", "--path", path, "--array", "tile-10x10", "--records", "-o", "two.hex"], cwd=tmp_path)
    paragraph = text(succeed(["report", "two.hex", "--methods"], cwd=tmp_path).stdout)
    for needle in ("6 focal points", "Up to 2 focal points were made at the same time", "weighted GS and a Gauss-Newton step", "The 3 sets of focal points", "40 to 120 carrier periods (1000 to 3000 µs)"):
        assert needle in paragraph, paragraph


@pytest.mark.parametrize(
    "args, code",
    [
        (["report"], USAGE),
        (["report", "none.hex"], BAD_INPUT),
        (["report", NAME, "--methods", "-o", "x.html"], USAGE),
        (["report", NAME, "--no-picture", "-o", NAME], USAGE),
        (["report", NAME, "--no-picture", "-o", NAME.replace(".hex", ".json")], USAGE),
        (["report", NAME, "--no-picture", "-o", "no/such/folder.html"], BAD_INPUT),
    ],
)
def test_what_is_refused(ring, args, code):
    refuse(ring, args, code, outputs=("report.html",))
