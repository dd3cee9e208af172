#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws what a hand is expected to feel: `haptogram feel -o x.png` calls it with a folder that holds feel.json, and the picture's name."""

import json
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

BLUE, ORANGE, GREY = "#3b6fb6", "#e08a3c", "#777777"


def over_time(panel, feel):
    pressure = np.array(feel["pressure_pa"])
    panel.plot(1e3 * (np.arange(len(pressure)) + 0.5) / feel["carrier_hz"], pressure, color=BLUE, lw=0.8)
    panel.set(xlabel="time / ms", ylabel="radiation pressure / Pa", title="strongest place: pressure on the skin")
    panel.set_ylim(bottom=0)


def spectrum(panel, feel):
    lines = np.array(feel["spectrum"]).reshape(-1, 2)
    panel.vlines(lines[:, 0], 1e-4, 1e3 * lines[:, 1], color=BLUE, lw=1.2, label=f"force on {feel['contact_mm']:g} mm")
    for basis, style, label in (("tables", "-", "least felt, by the tables"), ("displacement", ":", "estimate beyond them")):
        # A gap where the other basis holds.
        force = [1e3 * n if which == basis else np.nan for _, n, which in feel["thresholds"]]
        panel.plot([hz for hz, _, _ in feel["thresholds"]], force, style, color=ORANGE, label=label)
    top = max([1e3 * n for _, n, _ in feel["thresholds"]] + [1e3 * n for n in lines[:, 1]])
    panel.set(xscale="log", yscale="log", xlim=(5, 1000), ylim=(1e-3, 3 * top))
    panel.set(xlabel="frequency / Hz", ylabel="alternating force, peak / mN", title="strongest place: what vibrates")
    panel.legend(loc="lower left", fontsize=8)
    panel.grid(alpha=0.3)


def places(panel, feel):
    at = np.arange(1, len(feel["places"]) + 1)
    panel.bar(at, [place["mean_pa"] for place in feel["places"]], color=BLUE, width=0.6)
    panel.set(xlabel="place", ylabel="mean radiation pressure / Pa", title="all places: pressure")
    number(panel, at)


def number(panel, at):
    panel.set_xlim(0.2, max(8, len(at)) + 0.8)
    panel.set_xticks(at if len(at) <= 20 else at[:: int(np.ceil(len(at) / 16))])


def felt(panel, feel):
    at = np.arange(1, len(feel["places"]) + 1)
    over = np.array([np.nan if place["over_db"] is None else place["over_db"] for place in feel["places"]], dtype=float)
    panel.plot(at, over, "o", color=ORANGE)
    panel.axhline(0, color=ORANGE, lw=0.8, ls="--", label="least felt")
    panel.set(xlabel="place", ylabel="vibration over the least felt / dB", title="all places: what vibrates")
    known = over[np.isfinite(over)]
    panel.set_ylim(min(-3.0, *(known - 3.0)), max(3.0, *(known + 3.0)))
    panel.legend(loc="lower right", fontsize=8)
    panel.grid(alpha=0.3)
    number(panel, at)


def noise(panel, feel):
    lines = np.array(feel["noise"]).reshape(-1, 2)
    level = "steady, no noise" if feel["noise_db"] is None else f"{feel['noise_db']:.1f} dB(A) re a 200 Hz sine at full drive"
    panel.set_xscale("log")
    if len(lines):
        decibels = 20 * np.log10(np.maximum(lines[:, 1], 1e-12))
        panel.plot(lines[:, 0], decibels, ".", ms=3, color=GREY)
        panel.set_ylim(decibels.max() - 80, decibels.max() + 5)
    panel.set(xlim=(20, 16000), xlabel="frequency / Hz", ylabel="A-weighted, relative / dB", title=f"likely audible: {level}")
    panel.grid(alpha=0.3)


def main():
    feel = json.loads((pathlib.Path(sys.argv[1]) / "feel.json").read_text(encoding="utf-8"))
    figure, panels = plt.subplot_mosaic([[over_time, spectrum], [places, felt], [noise, noise]], figsize=(11, 11), constrained_layout=True)
    for draw, panel in panels.items():
        draw(panel, feel)
    x, y, z = feel["at_mm"]
    figure.suptitle(f"{pathlib.Path(feel['title']).name}, {feel['array']}: by models, not measured on people; strongest at ({x:.1f}, {y:.1f}, {z:.1f}) mm")
    figure.savefig(sys.argv[2], dpi=110, format="png")
    plt.close(figure)


if __name__ == "__main__":
    main()
