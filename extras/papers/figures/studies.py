# SPDX-License-Identifier: Apache-2.0
"""Figures of the studies: printed confusions, and a staircase on a simulated person."""

from haptogram_study import figures as study_figures

from .work import row, save


def study_confusion(work, name):
    figure, paper, made = study_figures.confusion()
    save(work, figure, name)
    simulated = "no person answered: one draw of people with the paper's rates"
    return [
        row("right answers over all", 100 * paper.share, "%", 59.44, "text", "223 of 360 by the paper's own Table 1"),
        row("Cohen's κ of Table 1", paper.kappa),
        row("information in Table 1, of 2 bit", paper.bits, "bit"),
        row("right answers of the simulated study", 100 * made.share, "%", why=simulated),
        row("its κ", made.kappa, why=simulated),
    ]


def study_staircase(work, name):
    figure, found = study_figures.staircase()
    save(work, figure, name)
    return [row(f"threshold, begun {start}", level, "dB", -18.0, "theory", "the simulated person's; one run has an SD of about 0.5 dB") for start, level in found.items()]
