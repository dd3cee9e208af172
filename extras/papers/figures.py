#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The papers' figures, computed now: a picture each, and a page with each picture beside a table of the paper's numbers and
ours. Haptogram is the paper of the system; Hoshi is "Noncontact Tactile Display Based on Radiation Pressure of Airborne
Ultrasound"; Multimodal is the paper of the cable robot beside the ultrasound (docs/references.md). The fields of played shapes
come from the pulses that the Verilated board makes. Nothing is tuned to agree, but for one bandwidth in Hoshi's Fig. 12c, which
is named where it is used."""

import argparse
import json
import pathlib
import sys
import time

import matplotlib
import numpy as np

matplotlib.use("Agg")
ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / folder) for folder in ("python", "extras/studies", "extras/scattering", "tools")]
from figures import haptogram_paper, hoshi, multimodal, page, scattering, shapes, studies  # noqa: E402
from figures.work import Work  # noqa: E402

FIGURES = {
    "haptogram-6": (haptogram_paper.haptogram_6, "Haptogram, Fig. 6: pulses of sample transducers"),
    "haptogram-11": (haptogram_paper.haptogram_11, "Haptogram, Fig. 11: how long a focal point takes to form"),
    "haptogram-switching": (haptogram_paper.switching, "Haptogram III-G: what fast switching costs"),
    "haptogram-13": (haptogram_paper.haptogram_13, "Haptogram, Fig. 13 (and 14, measured): a single point at 13 cm"),
    "haptogram-15": (haptogram_paper.haptogram_15, "Haptogram, Fig. 15: pressure against elevation"),
    "haptogram-16": (haptogram_paper.haptogram_16, "Haptogram, Fig. 16 (and 17, measured): a line at 12 cm"),
    "haptogram-18": (haptogram_paper.haptogram_18, "Haptogram, Fig. 18 (and 19, measured): a circle at 12 cm"),
    "haptogram-20": (haptogram_paper.haptogram_20, "Haptogram, Fig. 20 (and 21, measured): a hemisphere about 14 cm"),
    "hoshi-3": (hoshi.hoshi_3, "Hoshi, Fig. 3: loss of energy in air"),
    "hoshi-force": (hoshi.hoshi_row, "Hoshi 2.2 and 3.2: size and force of the focus"),
    "hoshi-6": (hoshi.hoshi_6, "Hoshi, Fig. 6: distribution in the focal plane"),
    "hoshi-7": (hoshi.hoshi_7, "Hoshi 3.1 and eq. 7: the quantised drive"),
    "hoshi-11": (hoshi.hoshi_11, "Hoshi, Fig. 11b–c: cuts through the focus"),
    "hoshi-12": (hoshi.hoshi_12, "Hoshi, Fig. 12a–b: modulation at 100 Hz"),
    "hoshi-12c": (hoshi.hoshi_12c, "Hoshi, Fig. 12c: frequency characteristics, with one bandwidth fitted"),
    "hoshi-eq9": (hoshi.hoshi_eq9, "Hoshi, eq. 9: two spots by a Fourier transform, and what repeats"),
    "fingers-7": (scattering.fingers_7, "Fingers, Fig. 7: radiation pressure on a finger, ten foci in turn"),
    "fingers-8": (scattering.fingers_8, "Fingers, Fig. 8: dynamic and static focus over the depth of the finger"),
    "shapes-strength": (shapes.shapes_strength, "Shapes: strength over speed, spacing and dwell of a drawn circle"),
    "shapes-algorithms": (shapes.shapes_algorithms, "Shapes, section IV: how long and how strong the lines of A, E, F and G are"),
    "multimodal-1": (multimodal.multimodal_1, "Multimodal, eq. 1: a focused cap beside the sum over the array"),
    "multimodal-magnitude": (multimodal.multimodal_magnitude, "Multimodal, eq. 10 and 11, Tables I–III: command, output, perceived magnitude, thresholds"),
    "multimodal-waveforms": (multimodal.multimodal_waveforms, "Multimodal, eq. 8, 9 and 13: waveforms and duties"),
    "multimodal-workspace": (multimodal.multimodal_workspace, "Multimodal, Fig. 4: useful workspace of the cable robot"),
    "multimodal-4bc": (multimodal.multimodal_4bc, "Multimodal, Fig. 4b–c: where the robot and the ultrasound both reach"),
    "multimodal-admittance": (multimodal.multimodal_admittance, "Multimodal, eq. 17: the handle under a force, zone by zone"),
    "multimodal-8": (multimodal.multimodal_8, "Multimodal, Fig. 8: the story of task T1"),
    "multimodal-t4": (multimodal.multimodal_t4, "Multimodal, task T4: a cube is placed by touch, mappings G1 to G3"),
    "study-confusion": (studies.study_confusion, "Haptogram, Table 1: which shape was taken for which"),
    "study-staircase": (studies.study_staircase, "Multimodal, task T3: a staircase on a simulated person"),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", type=pathlib.Path, required=True, help="haptogram")
    parser.add_argument("--tool", type=pathlib.Path, required=True, help="haptogram_figures")
    parser.add_argument("--output", type=pathlib.Path, required=True, help="folder of pictures and page")
    parser.add_argument("--only", nargs="+", choices=FIGURES, default=list(FIGURES), metavar="NAME", help="of " + ", ".join(FIGURES))
    arguments = parser.parse_args()
    work = Work(arguments.program.resolve(), arguments.tool.resolve(), arguments.output)
    begun, figures = time.perf_counter(), []
    for name in (n for n in FIGURES if n in arguments.only):
        draw, title = FIGURES[name]
        rows = draw(work, name)
        for line in rows:
            if not np.isfinite(line["ours"]):
                sys.exit(f"figures: {name}: {line['what']} is {line['ours']}")
        figures.append({"id": name, "title": title, "picture": f"{name}.png", "rows": rows})
    (arguments.output / "figures.json").write_text(json.dumps({"figures": figures}, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    (arguments.output / "index.html").write_text(page.page(figures), encoding="utf-8")
    print(f"{arguments.output}/index.html: {len(figures)} figures in {time.perf_counter() - begun:.0f} s")


if __name__ == "__main__":
    main()
