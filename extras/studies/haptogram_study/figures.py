# SPDX-License-Identifier: Apache-2.0
"""Pictures of studies: confusion matrices, and a staircase. Each function draws and returns what it drew from."""
import random
from collections.abc import Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from . import inference, printed, protocol, tables
from .observers import felt, simulated
from .session import Record, Session
from .staircase import Rule, Staircase
from .stimulus import Presenter


def draw_confusion(axes: Any, counts: ArrayLike, names: Sequence[str], title: str) -> None:
    """Shares of each row as shades, with counts; a row for what was shown."""
    matrix = np.asarray(counts, dtype=float)
    share = matrix / matrix.sum(1, keepdims=True)
    axes.imshow(share, cmap="Blues", vmin=0.0, vmax=1.0)
    for row, column in np.ndindex(*matrix.shape):
        dark = share[row, column] > 0.6
        axes.text(column, row, f"{share[row, column]:.1%}\n{matrix[row, column]:.0f}", ha="center", va="center", fontsize=9, color="white" if dark else "black")
    axes.set_xticks(range(len(names)), names)
    axes.set_yticks(range(len(names)), names)
    axes.set(xlabel="answered", ylabel="shown", title=title)


def confusion() -> tuple[Figure, inference.Confusion, inference.Confusion]:
    """Haptogram's Table 1 beside one simulated study by its protocol: the printed matrix, the simulated one."""
    table = tables.load(printed.DATA).rest()["table"]["haptogram_1"]
    names, given = table["rows"], printed.counts_of(table)
    study = protocol.read(protocol.shipped()["haptogram_shapes"])
    records: list[Record] = []
    for participant in range(1, study.participants + 1):
        Session(study, participant, 1, simulated(study, "simulated:protocol"), Presenter(study), records.append).run()
    made = np.zeros((len(names), len(names)), dtype=int)
    for record in records:
        answer = record["answers"]["answer"]["value"]
        if answer is not None:  # time was up
            made[names.index(record["factors"]["shape"]), names.index(answer)] += 1
    figure, axes = plt.subplots(1, 2, figsize=(11.5, 5.2), constrained_layout=True)
    for panel, counts, title in ((axes[0], given, "Haptogram, Table 1"), (axes[1], made, "simulated people with these rates, one study")):
        found = inference.confusion(counts)
        draw_confusion(panel, counts, names, f"{title}\n{found.share:.2%} right, κ = {found.kappa:.3f}, {found.bits:.3f} bit")
    return figure, inference.confusion(given), inference.confusion(made)


def staircase(threshold_db: float = -18.0, sd_db: float = 1.0, seed: int = 3) -> tuple[Figure, dict[str, float]]:
    """Multimodal's task T3 on a simulated person, begun high and low: the thresholds that were found, dB."""
    rule: Rule | None = protocol.read(protocol.shipped()["multimodal_threshold"]).staircase
    assert rule is not None
    figure, axes = plt.subplots(1, len(rule.starts_db), figsize=(11.5, 4.6), sharey=True, constrained_layout=True)
    found = {}
    for panel, (name, start) in zip(axes, rule.starts_db.items()):
        stairs, dice = Staircase(rule, start), random.Random(f"{seed} {name}")
        levels, answers, turns = [], [], []
        while stairs.state == "running":
            before = len(stairs.reversals_db)
            levels.append(stairs.level_db)
            answers.append(dice.random() < felt(stairs.level_db, threshold_db, sd_db, 0.0, 0.0))
            stairs.answer(answers[-1])
            if len(stairs.reversals_db) > before:
                turns.append(len(levels))
        steps = range(1, len(levels) + 1)
        panel.plot(steps, levels, color="#888888", lw=0.8)
        for yes, marker, label in ((True, "o", "felt"), (False, "x", "not felt")):
            panel.plot([s for s, a in zip(steps, answers) if a == yes], [v for v, a in zip(levels, answers) if a == yes], marker, color="#174a7c", ms=5, label=label)
        counted = turns[rule.first_reversals :]
        panel.plot(counted, [levels[t - 1] for t in counted], "o", ms=11, mfc="none", mec="#c0392b", label="reversals that count")
        threshold = stairs.threshold_db
        assert threshold is not None
        found[name] = threshold
        panel.axhline(threshold, color="#c0392b", lw=1, label=f"their mean, {threshold:.2f} dB")
        panel.axhline(threshold_db, color="#2e7d32", lw=1, ls="--", label=f"the simulated threshold, {threshold_db:g} dB")
        panel.xaxis.get_major_locator().set_params(integer=True)
        panel.set(xlabel="stimulus", title=f"begun {name}, at {start:g} dB")
        panel.grid(alpha=0.3)
        panel.legend(fontsize=8)
    axes[0].set_ylabel("amplitude over the full one / dB")
    return figure, found
