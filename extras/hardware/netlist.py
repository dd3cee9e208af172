#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The netlist of a driver tile from a board and an array file, its bill of materials, and its electrical rules.

A netlist is {"parts": {ref: {"kind", "value", "at"}}, "nets": {name: [[ref, pin], ...]}}; an element's `at` is its place in mm.
What the rules expect of pins and places comes from `haptogram board pinout`, which reads the files by itself."""
import argparse
import collections
import csv
import functools
import io
import json
import random
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
import boards  # noqa: E402

CIRCUIT = tomllib.loads((ROOT / "extras/hardware/circuit.toml").read_text(encoding="utf-8"))
PARTS = CIRCUIT["parts"]
BOARD, ARRAY = "colorlight-5a-75e-v7.1", ROOT / "host/arrays/driver-tile.toml"
GROUNDS = ("4", "16")  # of each HUB75 connector
ENABLE_HEADER = "J90"
# A driver's inputs with the outputs that belong to them.
OUTPUT_OF = {"2": "7", "4": "5"}
# How a wire goes on behind a driver's output.
WAY = ("series", "coupling")


class Unfit(Exception):
    """A board or an array that this circuit cannot be made for."""


def places(path):
    """Of the elements, in mm, in the order of the channels."""
    array = tomllib.loads(Path(path).read_text(encoding="utf-8"))["array"]
    if "elements_mm" in array:
        return [tuple(map(float, e[:2])) for e in array["elements_mm"]]
    rows, columns, pitch = array["rows"], array["columns"], array["pitch_mm"]
    return [((c - (columns - 1) / 2) * pitch, (r - (rows - 1) / 2) * pitch) for r in range(rows) for c in range(columns)]


def number(value):
    """Of a part's value: 4.7k, 100n 50 V X7R."""
    text = value.split()[0]
    scale = {"p": 1e-12, "n": 1e-9, "u": 1e-6, "k": 1e3}.get(text[-1])
    return float(text[:-1]) * scale if scale else float(text)


def wire(connector, pin):
    """An output's connector and pin; of a net that all connectors have, the last one's."""
    return connector.split("-")[-1], pin


@functools.cache
def enable_pin(board_name):
    """Connector and pin that the board gives the drivers' enable, or none."""
    board = boards.load(board_name)
    ball = board["pins"].get("driver_enable")
    return next((wire(c, pin) for c, pin, _, b in board["outputs"] if b == ball), None)


class Tile:
    """A netlist that grows part by part."""

    def __init__(self):
        self.parts, self.nets = {}, collections.defaultdict(list)

    def add(self, ref, kind, pins, **more):
        """A part, with the net of each pin that has one."""
        self.parts[ref] = {"kind": kind, "value": PARTS[kind]["value"], **more}
        for pin, net in pins.items():
            self.nets[net].append([ref, pin])

    def channel(self, n, source, driver, half, place):
        pull, element = f"RD{n}", f"T{n}"
        self.nets[f"IN{n}"].append(list(source))
        self.add(pull, "pull-down", {"1": f"IN{n}", "2": "GND"})
        self.nets[f"IN{n}"].append([driver, half])
        self.nets[f"OUT{n}"].append([driver, OUTPUT_OF[half]])
        self.add(f"RS{n}", "series", {"1": f"OUT{n}", "2": f"MID{n}"})
        self.add(f"CS{n}", "coupling", {"1": f"MID{n}", "2": f"EL{n}"})
        self.add(f"RB{n}", "bleeder", {"1": f"EL{n}", "2": "GND"})
        self.add(element, "element", {"1": f"EL{n}", "2": "GND"}, at=list(place))

    def supply(self, enable):
        """Terminal, fuse, clamp and bulk, and a switch that gives the drivers their supply while the enable is high."""
        self.add("J100", "terminal", {"1": "SUPPLY", "2": "GND"})
        self.add("F1", "fuse", {"1": "SUPPLY", "2": "FUSED"})
        self.add("D1", "clamp", {"1": "FUSED", "2": "GND"})
        self.add("C1", "bulk", {"1": "FUSED", "2": "GND"})
        self.add("Q1", "switch", dict.fromkeys("123", "FUSED") | {"4": "GATE"} | dict.fromkeys("5678", "VDD"))
        self.add("R1", "switch-hold", {"1": "FUSED", "2": "GATE"})
        self.add("C2", "switch-slow", {"1": "FUSED", "2": "GATE"})
        self.add("C3", "switch-ramp", {"1": "VDD", "2": "GATE"})
        self.add("R2", "switch-pull", {"1": "GATE", "2": "PULL"})
        self.add("Q2", "enable", {"1": "EN", "2": "GND", "3": "PULL"})
        self.add("R3", "pull-down", {"1": "EN", "2": "GND"})
        if enable:
            self.nets["EN"].append(list(enable))
        else:
            self.add(ENABLE_HEADER, "enable-header", {"1": "EN", "2": "GND"})


def build(board_name, array_path):
    board, where = boards.load(board_name), places(array_path)
    wires = [wire(c, pin) for c, pin, _, _ in board["outputs"]]
    if not any("-" in c for c, _, _, _ in board["outputs"]):
        raise Unfit(f"{board_name}: expected a board of HUB75 connectors, which share nets and have ground on pins 4 and 16; found none: take a Colorlight")
    if len(where) > len(wires):
        raise Unfit(f"{array_path}: {len(where)} elements, but {board_name} has {len(wires)} outputs: take a smaller array")
    if len(where) % 2:
        raise Unfit(f"{array_path}: {len(where)} elements, but a driver has two channels: expected an even number")
    tile = Tile()
    for connector in dict.fromkeys(c for c, _ in wires[: len(where)]):
        tile.add(connector, "connector", dict.fromkeys(GROUNDS, "GND"))
    # Neighbours in a row share a driver, whatever their channels are.
    for k, ch in enumerate(sorted(range(len(where)), key=lambda e: (-where[e][1], where[e][0]))):
        driver = f"U{k // 2 + 1}"
        if k % 2 == 0:
            tile.add(driver, "driver", {"3": "GND", "6": "VDD"})
            tile.add(f"CD{k // 2 + 1}", "decoupling", {"1": "VDD", "2": "GND"})
        tile.channel(ch + 1, wires[ch], driver, "42"[k % 2], where[ch])
    tile.supply(enable_pin(board_name))
    return {"parts": tile.parts, "nets": dict(tile.nets)}


def pinout(program, board, array):
    """What the program reads from the same files."""
    command = [program, "board", "pinout", board, "--array", array, "--json"]
    return json.loads(subprocess.run(list(map(str, command)), check=True, stdout=subprocess.PIPE).stdout)


class Rules:
    """What is wrong with a netlist, as lines. They follow connections, whatever nets are called."""

    def __init__(self, net, expected):
        self.parts, self.nets, self.expected, self.wrong = net["parts"], net["nets"], expected, []
        self.of = {}
        for name, nodes in self.nets.items():
            for ref, pin in nodes:
                if (ref, pin) in self.of:
                    self.say(f"{ref}.{pin} is on {self.of[ref, pin]} and on {name}")
                self.of[ref, pin] = name
        self.ground = self.of.get(("J100", "2"))

    def say(self, line):
        self.wrong.append(line)

    def kind(self, ref):
        return self.parts.get(ref, {}).get("kind")

    def on(self, net, kind=None):
        return [(r, p) for r, p in self.nets.get(net, []) if kind in (None, self.kind(r))]

    def beyond(self, node):
        """The net at the other pin of a part of two."""
        ref, pin = node
        return self.of.get((ref, "12".replace(pin, "")))

    def one(self, net, kind, where):
        found = self.on(net, kind)
        if len(found) != 1:
            self.say(f"{where}: expected one {kind} on {net}, found {len(found)}")
        return found[0] if len(found) == 1 else None

    def only(self, net, kinds, where):
        """Nothing else hangs on a net."""
        found = sorted(str(self.kind(r)) for r, _ in self.on(net))
        if found != sorted(kinds):
            self.say(f"{where}: expected {', '.join(sorted(kinds))} on {net}, found {', '.join(found) or 'nothing'}")

    def to_ground(self, net, kind, where):
        node = self.one(net, kind, where)
        if node and self.beyond(node) != self.ground:
            self.say(f"{where}: {node[0]} does not lead to ground")

    def each_part(self):
        pins = collections.defaultdict(set)
        for ref, pin in self.of:
            pins[ref].add(pin)
        for ref, part in self.parts.items():
            table = PARTS[part["kind"]]
            if part["value"] != table["value"]:
                self.say(f"{ref}: expected {table['value']}, found {part['value']}")
            if part["kind"] == "connector":
                continue
            wanted = {str(p + 1) for p in range(table["pins"])} - set(table.get("open", []))
            found = pins[ref]
            if found != wanted:
                self.say(f"{ref}: expected nets on pins {sorted(wanted)}, found {sorted(found)}")
        for name, nodes in self.nets.items():
            if len(nodes) < 2:
                self.say(f"{name} has one pin only")
            for ref, _ in nodes:
                if ref not in self.parts:
                    self.say(f"{name}: {ref} is no part")

    def channel(self, row, elements):
        """From the connector's pin to the marked pin of the element that is where the array file says."""
        place = (row["x_mm"], row["y_mm"])
        where = f"channel {row['channel']}, {row['connector']}.{row['pin']}"
        net = self.of.get(wire(row["connector"], row["pin"]))
        self.only(net, ["connector", "pull-down", "driver"], where)
        self.to_ground(net, "pull-down", where)
        driver = self.one(net, "driver", where)
        if not driver or driver[1] not in OUTPUT_OF:
            return self.say(f"{where}: reaches no input of a driver")
        net, before = self.of.get((driver[0], OUTPUT_OF[driver[1]])), "driver"
        for kind in WAY:
            self.only(net, [before, kind], where)
            node = self.one(net, kind, where)
            if not node:
                return None
            net, before = self.beyond(node), kind
        self.only(net, [before, "bleeder", "element"], where)
        self.to_ground(net, "bleeder", where)
        element = self.one(net, "element", where)
        if element and element != (elements.get(place), "1"):
            self.say(f"{where}: ends at {element[0]}.{element[1]}, but {elements.get(place)}.1 is at {place}")
        if element and self.of.get((element[0], "2")) != self.ground:
            self.say(f"{where}: the other pin of {element[0]} is not on ground")
        return None

    def supplies(self):
        """Terminal, fuse, switch, drivers; the enable pulls the gate."""
        supply, fused = self.of.get(("J100", "1")), self.beyond(("F1", "1"))
        if self.of.get(("F1", "1")) != supply:
            fused = self.of.get(("F1", "1"))
        rail, gate, pull, enable = (self.of.get(k) for k in (("Q1", "5"), ("Q1", "4"), ("Q2", "3"), ("Q2", "1")))
        drivers = sum(p["kind"] == "driver" for p in self.parts.values())
        self.only(supply, ["terminal", "fuse"], "supply")
        self.only(fused, ["fuse", "clamp", "bulk", "switch", "switch", "switch", "switch-hold", "switch-slow"], "behind the fuse")
        self.only(rail, ["switch"] * 4 + ["switch-ramp"] + ["driver", "decoupling"] * drivers, "drivers' supply")
        self.only(gate, ["switch", "switch-hold", "switch-slow", "switch-ramp", "switch-pull"], "switch's gate")
        self.only(pull, ["switch-pull", "enable"], "switch's pull")
        asked = enable_pin(self.expected["board"])
        self.only(enable, ["enable", "pull-down", "connector" if asked else "enable-header"], "enable")
        self.to_ground(enable, "pull-down", "enable")
        pins = {("C1", "1"): fused, ("D1", "1"): fused, ("C1", "2"): self.ground, ("D1", "2"): self.ground, ("Q2", "2"): self.ground}
        pins |= {("Q1", p): fused for p in "123"} | {("Q1", p): rail for p in "5678"} | {asked or (ENABLE_HEADER, "1"): enable}
        for ref, part in self.parts.items():
            if part["kind"] == "driver":
                pins |= {(ref, "6"): rail, (ref, "3"): self.ground}
            if part["kind"] == "decoupling" and {self.of.get((ref, p)) for p in "12"} != {rail, self.ground}:
                self.say(f"{ref}: not between the drivers' supply and ground")
        for (ref, pin), net in pins.items():
            if self.of.get((ref, pin)) != net or net is None:
                self.say(f"{ref}.{pin}: expected on {net}, found on {self.of.get((ref, pin))}")
        named = [supply, fused, rail, gate, pull, enable, self.ground]
        if len(set(named)) != len(named):
            self.say(f"supply, switch and ground share nets: {named}")

    def connectors(self):
        used = {wire(r["connector"], r["pin"]) for r in self.expected["outputs"]} | {enable_pin(self.expected["board"])}
        for ref in {c for c, _ in filter(None, used)}:
            for pin in map(str, range(1, 17)):
                net = self.of.get((ref, pin))
                if pin in GROUNDS and net != self.ground:
                    self.say(f"{ref}.{pin}: expected ground, found {net}")
                if pin not in GROUNDS and net and (ref, pin) not in used:
                    self.say(f"{ref}.{pin}: expected open, found {net}")

    def all(self):
        elements = {tuple(p["at"]): r for r, p in self.parts.items() if p["kind"] == "element"}
        if len(elements) != len(self.expected["outputs"]):
            self.say(f"expected {len(self.expected['outputs'])} elements in places of their own, found {len(elements)}")
        self.each_part()
        self.supplies()
        self.connectors()
        for row in self.expected["outputs"]:
            self.channel(row, elements)
        return self.wrong


def faults(net, expected):
    return Rules(net, expected).all()


def bill(net):
    """As CSV: parts of one kind and value a row."""
    rows = collections.defaultdict(list)
    for ref, part in net["parts"].items():
        rows[part["kind"], part["value"]].append(ref)
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(["count", "kind", "value", "footprint", "alternates", "references"])
    for (kind, value), refs in sorted(rows.items(), key=lambda r: (-len(r[1]), r[0])):
        writer.writerow([len(refs), kind, value, PARTS[kind]["footprint"], PARTS[kind].get("alternates", ""), " ".join(refs)])
    return out.getvalue()


def _swap_pins(net, rng):
    a, b = rng.sample(sorted(net["nets"]), 2)
    i, j = rng.randrange(len(net["nets"][a])), rng.randrange(len(net["nets"][b]))
    net["nets"][a][i], net["nets"][b][j] = net["nets"][b][j], net["nets"][a][i]


def _drop_pin(net, rng):
    nodes = net["nets"][rng.choice(sorted(net["nets"]))]
    nodes.pop(rng.randrange(len(nodes)))


def _join_nets(net, rng):
    a, b = rng.sample(sorted(net["nets"]), 2)
    net["nets"][a] += net["nets"].pop(b)


def _move_pin(net, rng):
    a, b = rng.sample(sorted(net["nets"]), 2)
    net["nets"][b].append(net["nets"][a].pop(rng.randrange(len(net["nets"][a]))))


def _use_open_pin(net, rng):
    used = {tuple(n) for nodes in net["nets"].values() for n in nodes}
    free = [(r, str(p + 1)) for r, part in net["parts"].items() for p in range(PARTS[part["kind"]]["pins"]) if (r, str(p + 1)) not in used]
    net["nets"][rng.choice(sorted(net["nets"]))].append(list(rng.choice(free)))


def _swap_elements(net, rng):
    a, b = rng.sample([p for p in net["parts"].values() if "at" in p], 2)
    a["at"], b["at"] = b["at"], a["at"]


def _turn(net, rng):
    ref = rng.choice([r for r, p in net["parts"].items() if PARTS[p["kind"]]["pins"] == 2 and not PARTS[p["kind"]].get("swap")])
    for nodes in net["nets"].values():
        for node in nodes:
            if node[0] == ref:
                node[1] = "12".replace(node[1], "")


def _other_value(net, rng):
    net["parts"][rng.choice(sorted(net["parts"]))]["value"] = "100k"


def _lose_part(net, rng):
    ref = rng.choice(sorted(net["parts"]))
    del net["parts"][ref]
    net["nets"] = {k: [n for n in v if n[0] != ref] for k, v in net["nets"].items()}


MUTATIONS = (_swap_pins, _drop_pin, _join_nets, _move_pin, _use_open_pin, _swap_elements, _turn, _other_value, _lose_part)


def same_circuit(net):
    """What netlists have in common that differ only by a part turned whose pins are alike, or by two such parts exchanged."""
    alike = {r for r, p in net["parts"].items() if PARTS[p["kind"]].get("swap")}
    ends, nets = collections.defaultdict(list), {}
    for name, nodes in net["nets"].items():
        nets[name] = frozenset((r, p) for r, p in nodes if r not in alike)
        for ref, _ in nodes:
            ends[ref].append(name)
    parts = {r: p for r, p in net["parts"].items() if r not in alike}
    return nets, parts, collections.Counter((*net["parts"][r].values(), *sorted(ends[r])) for r in alike)


def mutants(net, expected, count=450, seed=1):
    """How many of `count` broken netlists the rules notice, and those that they do not."""
    rng, missed, made = random.Random(seed), [], 0
    while made < count:
        broken, mutation = json.loads(json.dumps(net)), MUTATIONS[made % len(MUTATIONS)]
        mutation(broken, rng)
        if same_circuit(broken) == same_circuit(net):
            continue
        made += 1
        if not faults(broken, expected):
            missed.append(f"{mutation.__name__[1:]}, number {made}")
    return made - len(missed), missed


def wired_places(board_name, columns=10, rows=10, pitch=10.0):
    """Of the elements, so that wires reach the columns in the order in which they leave the connectors.

    Half of the connectors stand above the array and half below. A connector's even pins leave to its left, odd ones to its right."""
    wires = [wire(c, p) for c, p, _, _ in boards.load(board_name)["outputs"]][: rows * columns]
    half = len({c for c, _ in wires}) // 2

    def arrival(ch):
        k, pin = int(wires[ch][0][1:]) - 1, int(wires[ch][1])
        return (k % half, pin % 2 == 0, pin if pin % 2 else -pin)

    above = [ch for ch, (c, _) in enumerate(wires) if int(c[1:]) <= half]
    below = [ch for ch in range(len(wires)) if ch not in above]
    # What the upper half of the rows has more than wires from above is reached from below: the lowest places of the last columns.
    spare = {(rows // 2 - 1, columns - 1 - k) for k in range(rows // 2 * columns - len(above))}
    upper = [(r, c) for r in range(rows // 2) for c in range(columns) if (r, c) not in spare]
    lower = [(r, c) for r in range(rows // 2, rows) for c in range(columns)] + sorted(spare)
    place = {}
    for channels, free, far_first in ((above, upper, True), (below, lower, False)):
        slots = []
        for c in range(columns):
            column = sorted((r for r, at in free if at == c), reverse=far_first != bool(c % 2))
            slots += [(r, c) for r in column]
        place |= dict(zip(sorted(channels, key=arrival), slots))
    return [((c - (columns - 1) / 2) * pitch, ((rows - 1) / 2 - r) * pitch) for r, c in (place[ch] for ch in range(len(wires)))]


def array_file(board_name):
    """tile-10x10 with its channels in the order of the wires."""
    text = (ROOT / "host/arrays/tile-10x10.toml").read_text(encoding="utf-8")
    _, _, after = text.partition("pitch_mm = 10.0\n")
    lines = ",\n".join(f"  [{x:g}, {y:g}]" for x, y in wired_places(board_name))
    return f"""# SPDX-License-Identifier: Apache-2.0
# tile-10x10 with its channels in the order in which wires arrive on the driver tile; extras/hardware/netlist.py --array-file writes this.
name = "driver-tile"

[array]
elements_mm = [
{lines},
]
{after}"""


def main():
    parser = argparse.ArgumentParser(description="Netlist of a driver tile as JSON, checked; exit code 1 when a rule is broken.")
    parser.add_argument("--board", default=BOARD)
    parser.add_argument("--array", default=ARRAY, type=Path, help="array file")
    parser.add_argument("--program", default=ROOT / "build/release/host/cli/haptogram")
    parser.add_argument("--bill", action="store_true", help="the bill of materials as CSV")
    parser.add_argument("--array-file", action="store_true", help="the array file that suits the board's wires")
    o = parser.parse_args()
    if o.array_file:
        print(array_file(o.board), end="")
        return 0
    try:
        net = build(o.board, o.array)
    except (Unfit, boards.Unknown) as error:
        print(f"netlist: {error}", file=sys.stderr)
        return 3
    wrong = faults(net, pinout(o.program, o.board, o.array))
    print("\n".join(wrong), file=sys.stderr, end="\n" if wrong else "")
    print(bill(net) if o.bill else json.dumps(net, indent=1))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
