# SPDX-License-Identifier: Apache-2.0
"""`make figures`: some of the figures, their pictures, and their numbers against what the papers' formulas give."""
import html.parser
import json
import struct
import subprocess
import sys

import numpy as np
import pytest
from support import PROGRAM, ROOT, USAGE

MADE_ONCE = ["made"]
ONLY = ["haptogram-11", "haptogram-13", "hoshi-force", "hoshi-7", "hoshi-12c", "hoshi-eq9", "fingers-7"]


def figures(folder, *arguments):
    tool = PROGRAM.parents[2] / "extras/papers/haptogram_figures"
    command = [sys.executable, ROOT / "extras/papers/figures.py", "--program", PROGRAM, "--tool", tool, "--output", folder, *arguments]
    return subprocess.run([str(a) for a in command], capture_output=True, text=True, timeout=300)


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


@pytest.mark.deep
def test_the_focus_of_hoshi(made):
    assert ours(made, "hoshi-force", "focal diameter") == pytest.approx(2 * 8.5 * 200 / 180)
    assert ours(made, "hoshi-force", "focal depth") == pytest.approx(42, abs=0.05)
    assert ours(made, "hoshi-force", "force (eq. 5") == pytest.approx(143, abs=0.5)
    half = np.pi * 10 / (8.5 * 200) * np.arange(9.5, 20, 0.001)  # kdx/2r
    assert ours(made, "hoshi-force", "first side lobe") == pytest.approx(((np.sin(18 * half) / np.sin(half) / 18) ** 2).max(), rel=1e-3)


@pytest.mark.deep
def test_the_quantised_drive(made):
    clocks = 25.6e6 / 40e3
    assert ours(made, "hoshi-7", "clocks of 25.6 MHz") == clocks / 16
    x = np.pi / 16  # phases that are off by up to half a step, evenly
    assert ours(made, "hoshi-7", "pressure that 16 phases keep") == pytest.approx(100 * np.sin(x) / x, abs=0.07)


@pytest.mark.deep
def test_the_frequency_response(made):
    """A one-pole envelope that follows the switched carrier, and the fundamental of its square."""

    def fundamental(bandwidth, f):
        tau, t = 1 / (np.pi * bandwidth), (np.arange(20000) + 0.5) / 20000 / f
        half = 0.5 / f
        low = np.exp(-half / tau) / (1 + np.exp(-half / tau))
        envelope = np.where(t < half, 1 - (1 - low) * np.exp(-t / tau), (1 - low) * np.exp(-(t - half) / tau))
        return abs((envelope**2 * np.exp(-2j * np.pi * t * f)).mean())

    def decibels(bandwidth, f):
        return 20 * np.log10(fundamental(bandwidth, f) / fundamental(bandwidth, 10))

    for f in (200, 500, 1000):
        assert ours(made, "hoshi-12c", f"at {f} Hz") == pytest.approx(decibels(2000, f), abs=0.03)
    fitted = ours(made, "hoshi-12c", "bandwidth that gives")
    assert decibels(fitted, 1000) == pytest.approx(-5.8, abs=0.02)


@pytest.mark.deep
def test_two_spots(made):
    grid = (np.arange(18) - 8.5) * 10.0
    x, y = np.meshgrid(grid, grid)
    near = np.sqrt(x**2 + y**2 + 200.0**2)
    drives = np.cos(2 * np.pi / 8.5 * x * 20 / 200) * np.exp(2j * np.pi / 8.5 * near)

    def pressure(at, drives):
        r = np.sqrt((at - x) ** 2 + y**2 + 200.0**2)
        return abs((drives * np.exp(-2j * np.pi / 8.5 * r) / r).sum())

    places = np.arange(15, 30, 0.1)
    found = [pressure(at, drives) for at in places]
    assert ours(made, "hoshi-eq9", "spot's place by spherical waves") == pytest.approx(places[int(np.argmax(found))], abs=0.15)
    assert ours(made, "hoshi-eq9", "spot's place by eq. 9") == pytest.approx(20.4, abs=0.06)
    assert ours(made, "hoshi-eq9", "first copy of a single focus") == pytest.approx(170, abs=0.3)


@pytest.mark.deep
def test_a_single_point(made):
    assert ours(made, "haptogram-13", "width of the radiation pressure at half maximum, piston") == pytest.approx(10.8, abs=0.1)
    assert ours(made, "haptogram-13", "the same, point sources") == pytest.approx(10.6, abs=0.1)
    assert ours(made, "haptogram-13", "the same, from the pins") == pytest.approx(10.8, abs=0.1)


@pytest.mark.deep
def test_formation(made):
    place = np.arange(-4.5, 5) * 10
    flight = np.sqrt(100.0**2 + place[:, None] ** 2 + place**2) / 343.2e-3
    assert ours(made, "haptogram-11", "flight-time spread") == pytest.approx(np.ptp(flight), rel=2e-3)
    assert ours(made, "haptogram-11", "to 90 % at 10 cm") == pytest.approx(394, abs=0.5)  # as host/haptogram/acoustics/README.md says
    tau = 1e6 / (np.pi * 2000)
    air, heard = (ours(made, "haptogram-11", start) for start in ("to 90 % of the pressure at 15 cm", "the same as a receiver"))
    assert tau * np.log(10) < air < tau * np.log(10) + 50
    assert 3.89 * tau < heard < 3.89 * tau + 50  # 1 − (1 + x)e^(−x) = 0.9 at x = 3.89, and what the flight adds


@pytest.mark.deep
def test_a_finger(made):
    assert ours(made, "fingers-7", "triangles a wavelength") > 7
    assert ours(made, "fingers-7", "highest pressure on the back") < 0.5
    assert 3 < ours(made, "fingers-7", "width of the strong skin") < 5.5


@pytest.mark.deep
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


@pytest.mark.deep
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
