# SPDX-License-Identifier: Apache-2.0
"""A picture of a sweep: a panel for each quantity, over one key of the plan, with a line for each value of another."""

import pathlib
from typing import Any

from .errors import bad_input
from .plan import Plan
from .store import Row


def _axes(plan: Plan) -> tuple[str, str | None]:
    varied = plan.varied
    x = plan.plot.get("x") or next((key for key in varied if isinstance(plan.configurations[0][key], (int, float))), "")
    rest = [key for key in varied if key != x]
    lines = plan.plot.get("lines") or (rest[0] if rest else None)
    others = [key for key in rest if key != lines]
    if not x or not isinstance(plan.configurations[0][x], (int, float)):
        raise bad_input(f"{plan.path}: plot", "found no numbers to draw along x; give plot.x a key of [vary] that has numbers")
    if others:
        raise bad_input(f"{plan.path}: plot", f"found {', '.join(others)} varied beside x and lines; a picture shows two keys")
    return x, lines


def check(plan: Plan) -> None:
    """@raises SweepError when the plan cannot be drawn"""
    _axes(plan)


def draw(plan: Plan, rows: dict[str, Row], output: pathlib.Path) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    x, lines = _axes(plan)
    count = len(plan.quantities)
    columns = min(3, count)
    figure, grid = plt.subplots(-(-count // columns), columns, figsize=(4.6 * columns, 3.8 * -(-count // columns)), squeeze=False, constrained_layout=True)
    groups: dict[str, list[tuple[float, Row]]] = {}
    for configuration in plan.configurations:
        label = "" if lines is None else f"{lines} {configuration[lines]}"
        groups.setdefault(label, []).append((configuration[x], rows[plan.key_of(configuration)]))
    shades: Any = matplotlib.colormaps["viridis"]
    for panel, quantity in zip(grid.flat, plan.quantities):
        for number, (label, points) in enumerate(groups.items()):
            colour = shades(0.9 * number / max(1, len(groups) - 1))
            drawn = sorted((at, row[quantity]) for at, row in points if "error" not in row)
            panel.plot([p[0] for p in drawn], [p[1] for p in drawn], "o-", ms=3.5, lw=1.2, color=colour, label=label)
        panel.set(xlabel=x, ylabel=quantity)
        panel.set_ylim(bottom=0.0 if panel.get_ylim()[0] > 0.0 and panel.get_ylim()[0] < 0.5 * panel.get_ylim()[1] else None)
        panel.grid(alpha=0.3)
    for panel in list(grid.flat)[count:]:
        panel.set_axis_off()
    if lines is not None:
        figure.legend(*grid.flat[0].get_legend_handles_labels(), loc="outside right upper", fontsize=8)
    figure.suptitle(plan.path.name)
    figure.savefig(output, dpi=110, format=output.suffix.removeprefix(".") or "png")
    plt.close(figure)
