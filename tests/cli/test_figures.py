# SPDX-License-Identifier: Apache-2.0
"""`make figures`: three of the figures, their pictures, and their numbers against what the papers' formulas give."""
import html.parser
import json
import struct
import subprocess
import sys

import numpy as np
import pytest
from support import PROGRAM, ROOT, USAGE

ONLY = ["haptogram-11", "haptogram-13", "hoshi-force"]


def figures(folder, *arguments):
    tool = PROGRAM.parents[2] / "tools/figures/haptogram_figures"
    command = [sys.executable, ROOT / "tools/figures.py", "--program", PROGRAM, "--tool", tool, "--output", folder, *arguments]
    return subprocess.run([str(a) for a in command], capture_output=True, text=True, timeout=120)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("figures")
    result = figures(folder, "--only", *ONLY)
    assert result.returncode == 0, result.stderr
    return folder


def rows(folder, name):
    found = {f["id"]: f for f in json.loads((folder / "figures.json").read_text(encoding="utf-8"))["figures"]}
    assert list(found) == ONLY
    return found[name]["rows"]


def ours(folder, name, start):
    (value,) = [r["ours"] for r in rows(folder, name) if r["what"].startswith(start)]
    return value


def test_the_focus_of_hoshi(made):
    assert ours(made, "hoshi-force", "focal diameter") == pytest.approx(2 * 8.5 * 200 / 180)
    assert ours(made, "hoshi-force", "focal depth") == pytest.approx(42, abs=0.05)
    assert ours(made, "hoshi-force", "force (eq. 5") == pytest.approx(143, abs=0.5)
    half = np.pi * 10 / (8.5 * 200) * np.arange(9.5, 20, 0.001)  # kdx/2r
    assert ours(made, "hoshi-force", "first side lobe") == pytest.approx(((np.sin(18 * half) / np.sin(half) / 18) ** 2).max(), rel=1e-3)


def test_a_single_point(made):
    assert ours(made, "haptogram-13", "width of the radiation pressure at half maximum, piston") == pytest.approx(10.8, abs=0.1)
    assert ours(made, "haptogram-13", "the same, point sources") == pytest.approx(10.6, abs=0.1)
    assert ours(made, "haptogram-13", "the same, from the pins") == pytest.approx(10.8, abs=0.1)


def test_formation(made):
    place = np.arange(-4.5, 5) * 10
    flight = np.sqrt(100.0**2 + place[:, None] ** 2 + place**2) / 343.2e-3
    assert ours(made, "haptogram-11", "flight-time spread") == pytest.approx(np.ptp(flight), rel=2e-3)
    tau = 1e6 / (np.pi * 2000)
    air, heard = (ours(made, "haptogram-11", start) for start in ("to 90 % of the pressure at 15 cm", "the same as a receiver"))
    assert tau * np.log(10) < air < tau * np.log(10) + 50
    assert 3.89 * tau < heard < 3.89 * tau + 50  # 1 − (1 + x)e^(−x) = 0.9 at x = 3.89, and what the flight adds


def test_the_pictures(made):
    for name in ONLY:
        content = (made / f"{name}.png").read_bytes()
        width, height = struct.unpack(">II", content[16:24])
        assert content.startswith(b"\x89PNG") and width > 500 and height > 300 and len(content) > 10_000


class Page(html.parser.HTMLParser):
    def __init__(self):
        super().__init__()
        self.tags, self.text = [], ""

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data):
        self.text += data


def test_the_page(made):
    page = Page()
    page.feed((made / "index.html").read_text(encoding="utf-8"))
    assert ("html", {"lang": "en"}) in page.tags
    assert "Haptogram: the papers' figures" in page.text
    pictures = [a for tag, a in page.tags if tag == "img"]
    assert [a["src"] for a in pictures] == [f"{name}.png" for name in ONLY] and all(a["alt"] for a in pictures)
    assert not [a for _, a in page.tags for key in ("src", "href") if a.get(key, "").startswith("http")]
    for name in ONLY:
        for row in rows(made, name):
            assert row["what"] in page.text and f"{row['ours']:.4g}" in page.text


def test_an_unknown_figure(tmp_path):
    result = figures(tmp_path, "--only", "haptogram-99")
    assert result.returncode == USAGE and "haptogram-99" in result.stderr and not (tmp_path / "index.html").exists()
