#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws how a board is wired, for `haptogram board pinout BOARD -o x.svg`.

plot_wiring.py FOLDER PICTURE, with pinout.json in the folder as the program writes it. Above, which pin of which connector drives which
element: the array is seen from where it is wired, from behind, with x to the left; each element has the colour of its connector, and the
number of its pin. Below, one channel, the supplies, the serial line and the grounds, of a board whose file says where they are.
"""

import json
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

PLUS, LOGIC, GROUND = "#b04a2f", "#2f5d9b", "#1b1b1b"


def draw_elements(array, table, pinout):
    rows = pinout["outputs"]
    connectors = list(dict.fromkeys(row["connector"] for row in rows))
    colours = {name: plt.cm.tab20(i % 20) for i, name in enumerate(connectors)}
    distances = [((a["x_mm"] - b["x_mm"]) ** 2 + (a["y_mm"] - b["y_mm"]) ** 2) ** 0.5 for i, a in enumerate(rows) for b in rows[:i]]
    radius = 0.47 * min(distances, default=10)
    for row in rows:
        place = (-row["x_mm"], row["y_mm"])
        array.add_patch(plt.Circle(place, radius, color=colours[row["connector"]], alpha=0.55))
        array.annotate(f"{row['connector']}\n{row['pin']}", place, ha="center", va="center", fontsize=7)
    array.set(title=f"{pinout['array']} from behind, where it is wired: connector and pin of each element", xlabel="x / mm: from behind, so to the left", ylabel="y / mm")
    array.set_aspect("equal")
    array.autoscale_view()
    array.set_xticks(array.get_xticks(), [f"{0.0 - tick:g}" for tick in array.get_xticks()])
    array.grid(alpha=0.2)

    # A column a connector: pin, channel and net.
    table.axis("off")
    table.set_title(f"{pinout['board']}: pin, channel, net")
    across = 4
    down = (len(connectors) + across - 1) // across
    most = max(sum(row["connector"] == name for row in rows) for name in connectors)
    for i, name in enumerate(connectors):
        left, top = i % across / across, 1 - i // across / down
        table.text(left, top, name, transform=table.transAxes, va="top", fontsize=10, weight="bold", color=[0.7 * c for c in colours[name][:3]])
        own = [row for row in rows if row["connector"] == name]
        step = 1 / down / (most + 2)
        for line, row in enumerate(own, 1):
            table.text(left, top - line * step, f"{row['pin']:>3} {row['channel']:>3} {row['net']}", transform=table.transAxes, va="top", fontsize=min(8, 500 * step), family="monospace")


class Circuit:
    """Boxes and wires on axes of 170 by 70; the ground that all share is the line near the bottom."""

    GROUND = 6

    def __init__(self, axes):
        self.axes = axes
        axes.set(xlim=(0, 170), ylim=(0, 70))
        axes.axis("off")

    def text(self, x, y, text, **style):
        self.axes.text(x, y, text, **({"fontsize": 8.5, "ha": "left", "va": "bottom"} | style))

    def box(self, x, y, wide, high, text, bold=None):
        self.axes.add_patch(plt.Rectangle((x, y), wide, high, facecolor="#eaf1fb", edgecolor=LOGIC))
        self.text(x + wide / 2, y + high / 2, text, ha="center", va="center")
        if bold:
            self.text(x + wide / 2, y + high - 1.5, bold, ha="center", va="top", fontsize=10, weight="bold")

    def wire(self, *points, colour=LOGIC):
        self.axes.plot(*zip(*points), color=colour, linewidth=1.6, solid_capstyle="round")

    def part(self, x, y, wide, high):
        self.axes.add_patch(plt.Rectangle((x, y), wide, high, facecolor="white", edgecolor=GROUND, zorder=3))

    def node(self, x, y):
        self.axes.plot(x, y, "o", color=GROUND, markersize=4)

    def to_ground(self, x, y):
        self.wire((x, y), (x, self.GROUND), colour=GROUND)
        self.node(x, self.GROUND)


def draw_board(c, pinout):
    """The FPGA board, what feeds it, and what speaks to it."""
    wiring, places, pins, network = (pinout[key] for key in ("wiring", "places", "pins", "network"))
    lines = []
    if pins["stop"]:
        lines += ["", "stop, off while " + ("high:" if pins["stop_level"] else "low:"), places.get("stop", "ball " + pins["stop"])]
    if pins["alive"]:
        lines += ["", "alive:", places.get("alive", "ball " + pins["alive"])]
    c.box(38, 16, 28, 48, "\n".join(lines), bold=f"{pinout['board']}\n{pinout['fpga']['family']} {pinout['fpga']['device']}")
    c.to_ground(48, 16)
    c.text(49, c.GROUND + 0.7, "ground: " + wiring["ground"].replace(" of ", "\nof ", 1))
    usb = network is None and "rx" not in places
    c.box(2, 50, 24, 12, wiring["power"].replace(", never", ",\nnever").replace(" by ", "\nby ").replace(" at ", "\nat "))
    c.wire((26, 58), (38, 58), colour=PLUS)
    c.text(27, 58.4, "+", color=PLUS, fontsize=11)
    if "USB" in wiring["power"]:
        c.text(27, 53, "and ground,\nby its cable")
    else:
        c.wire((26, 53), (32, 53), (32, c.GROUND), colour=GROUND)
        c.node(32, c.GROUND)
        c.text(27, 53.4, "−", fontsize=11)
    if network is not None:
        c.box(2, 28, 24, 12, f"network, 1 Gbit/s\n{network['ip']}")
        c.wire((26, 34), (38, 34))
    elif usb:
        c.box(2, 28, 24, 12, "computer:\nserial line " + wiring["serial"].replace(", ", ",\n"))
        c.wire((26, 34), (38, 34))
    else:
        c.text(2, 41.5, wiring["serial"].split(":")[0].removeprefix("by a "), color=PLUS)
        c.box(2, 24, 13, 16, "TX\n\n\nRX")
        c.text(3, 32, "USB", va="center")
        c.wire((15, 36), (38, 36))
        c.text(15.5, 36.3, f"to {places.get('rx', 'ball ' + pins['rx'])}")
        c.wire((15, 28), (38, 28))
        c.text(15.5, 28.3, f"from {places.get('tx', 'ball ' + pins['tx'])}")
        c.to_ground(8.5, 24)
    said = [f"to {verb}: {pinout['flash'][key]}" for verb, key in (("load", "load_jumpers"), ("write the flash", "write_jumpers")) if key in pinout["flash"]]
    if said:
        c.text(2, 19, "\n".join(["jumpers", *said]), va="center")


def draw_channel(c, pinout):
    """A pin, its driver and its element; and the drivers' supply with what switches it."""
    driven, places, pins = pinout["wiring"]["before_configuration"] == "driven", pinout["places"], pinout["pins"]
    first = pinout["outputs"][0]
    c.wire((66, 36), (90, 36))
    c.text(66.7, 36.3, f"{first['connector']} pin {first['pin']}, and\nso each channel")
    # Also where the pins always drive, for a cable that is pulled off.
    level = c.GROUND if pins["active"] == "high" else 50
    c.wire((84, 36), (84, level), colour=GROUND)
    c.node(84, 36)
    c.node(84, level)
    c.part(82.9, 20 if level == c.GROUND else 40, 2.2, 7)
    c.text(85.7, 23.5 if level == c.GROUND else 43.5, "4.7 kΩ", va="center")
    if level != c.GROUND:
        c.text(84, 51, "logic's supply", ha="center")
    c.box(90, 28, 17, 16, "half of a driver,\nas TC4427A\n1 µF at its supply")
    c.to_ground(98, 28)
    c.wire((107, 36), (142, 36))
    c.part(111, 34.8, 8, 2.4)
    c.text(115, 37.8, "22 Ω", ha="center")
    c.part(124.6, 33, 1.4, 6)  # a capacitor's plates, and the wire between them hidden
    c.text(125.3, 39.6, "100 nF", ha="center")
    for x in (124.6, 126):
        c.axes.plot((x, x), (33, 39), color=GROUND, linewidth=2.2, zorder=4)
    c.axes.add_patch(plt.Rectangle((124.7, 32.9), 1.2, 6.2, facecolor="white", edgecolor="white", zorder=3.5))
    c.to_ground(133, 36)
    c.node(133, 36)
    c.part(131.9, 18, 2.2, 7)
    c.text(130.8, 21.5, "22 kΩ", va="center", ha="right")
    c.to_ground(142, 36)
    c.axes.add_patch(plt.Circle((142, 21.5), 5.5, facecolor="#f6e2bd", edgecolor=GROUND, zorder=3))
    c.text(142, 21.5, "element", ha="center", va="center", zorder=4)
    c.text(142.8, 29, "marked leg,\nalike on all")

    c.box(147, 46, 21, 16, "18 V, amperes by\nboard power, its own\nfuse, for drivers alone")
    c.wire((147, 56), (138, 56), colour=PLUS)
    c.wire((112, 56), (98, 56), (98, 44), colour=PLUS)
    c.text(144.5, 56.4, "+", color=PLUS, fontsize=11)
    c.to_ground(164, 46)
    c.text(164.8, 43, "−", fontsize=11)
    enable = places.get("driver_enable", "ball " + pins["driver_enable"]) if pins["driver_enable"] else None
    if driven and enable:
        c.box(112, 50, 26, 10, "P-channel switch, as extras/hardware/ has:\noff unless the line above is " + ("high" if pins["driver_enable_level"] else "low"))
        c.wire((66, 62.5), (125, 62.5), (125, 60))
        c.text(66.7, 62.8, f"driver enable: {enable}")
    else:
        c.box(112, 50, 26, 10, "switch by hand:\non last, off first")
        if enable:
            c.text(66.7, 62.8, f"driver enable: {enable}, for a transistor in the place of the hand's switch")
            c.wire((66, 62.5), (72, 62.5))


def draw_circuit(axes, pinout):
    c = Circuit(axes)
    axes.set_title("A channel, supplies and grounds: find each ground by a meter first", fontsize=12)
    c.wire((2, c.GROUND), (168, c.GROUND), colour=GROUND)
    c.text(168, c.GROUND - 1, "one ground: board, drivers, supplies, adapter", ha="right", va="top", weight="bold")
    c.text(2, c.GROUND - 1, "Off at power-up: " + pinout["off"], va="top", color=PLUS)
    draw_board(c, pinout)
    draw_channel(c, pinout)


def main():
    folder, output = pathlib.Path(sys.argv[1]), sys.argv[2]
    pinout = json.loads((folder / "pinout.json").read_text(encoding="utf-8"))
    if pinout["wiring"] is None:
        figure, top = plt.subplots(1, 2, figsize=(17, 10), width_ratios=[10, 7], constrained_layout=True)
    else:
        figure = plt.figure(figsize=(17, 17), constrained_layout=True)
        grid = figure.add_gridspec(2, 2, width_ratios=[10, 7], height_ratios=[10, 7])
        top = figure.add_subplot(grid[0, 0]), figure.add_subplot(grid[0, 1])
        draw_circuit(figure.add_subplot(grid[1, :]), pinout)
    draw_elements(*top, pinout)
    figure.savefig(output, format="svg")


if __name__ == "__main__":
    main()
