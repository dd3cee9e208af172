# SPDX-License-Identifier: Apache-2.0
"""The driver tile's board, placed and routed by rule: board.py FOLDER BOARD ARRAY, under a Python that has KiCad 6's module pcbnew.

Into FOLDER go the board, Gerbers, drill file, KiCad's list of violations, and pads.csv: reference, pin, place and side of each pad, without
nets, so that who reads the Gerbers must find those by the copper. Front: elements, and wires from the connectors down the columns. Back:
everything else. Inside: ground, and the drivers' supply. The array's x is to the right and its y up, seen from the front.
For 10 x 10 elements 10 mm apart and 16 connectors, eight above and eight below."""
import csv
import random
import re
import sys
from pathlib import Path

import netlist
import pcbnew

FOOTPRINTS = Path("/usr/share/kicad/footprints")
FRONT, GROUND, SUPPLY, BACK = pcbnew.F_Cu, pcbnew.In1_Cu, pcbnew.In2_Cu, pcbnew.B_Cu
ROWS = COLUMNS = 10
PITCH = 10.0
# The connectors' height, that of the channel between them and the array, and the distance of its lines.
STRIP, CHANNEL, LINE = 23.0, 11.0, 0.7
X0, Y0 = 20.0, 20.0
TOP = Y0 + STRIP + CHANNEL           # upper edge of the first row's cells
BOTTOM = TOP + PITCH * ROWS + 5      # below the last row's drivers
END = BOTTOM + CHANNEL + STRIP
EDGE = X0 + 120.0
STRIP_X = X0 + 110.0                 # middle of the strip of the supply, right of the array
VIA, HOLE, WIRE, POWER = 0.5, 0.3, 0.18, 0.4


def mm(value):
    return pcbnew.FromMM(value)


def point(x, y):
    return pcbnew.wxPoint(mm(x), mm(y))


class Board:
    """KiCad's board, in millimetres, with nets by their names."""

    def __init__(self, net):
        self.parts, self.board, self.footprints = net["parts"], pcbnew.BOARD(), {}
        self.board.SetCopperLayerCount(4)
        settings = self.board.GetDesignSettings()
        settings.m_TrackMinWidth, settings.m_MinClearance, settings.m_CopperEdgeClearance = mm(0.15), mm(0.15), mm(0.3)
        settings.m_ViasMinSize, settings.m_MinThroughDrill = mm(0.45), mm(0.25)
        self.nets, self.of = {}, {}
        for name, nodes in net["nets"].items():
            self.nets[name] = pcbnew.NETINFO_ITEM(self.board, name)
            self.board.Add(self.nets[name])
            self.of |= {(ref, pin): name for ref, pin in nodes}

    def element(self, name):
        """Two holes 5.08 mm apart, the marked one square."""
        footprint = pcbnew.FOOTPRINT(self.board)
        footprint.SetFPID(pcbnew.LIB_ID("tile", name))
        for number, x in (("1", -2.54), ("2", 2.54)):
            pad = pcbnew.PAD(footprint)
            pad.SetNumber(number)
            pad.SetAttribute(pcbnew.PAD_ATTRIB_PTH)
            pad.SetLayerSet(pad.PTHMask())
            pad.SetShape(pcbnew.PAD_SHAPE_RECT if number == "1" else pcbnew.PAD_SHAPE_CIRCLE)
            pad.SetSize(pcbnew.wxSize(mm(2.2), mm(2.2)))
            pad.SetDrillSize(pcbnew.wxSize(mm(1.5), mm(1.5)))
            pad.SetPos0(point(x, 0))
            pad.SetPosition(point(x, 0))
            footprint.Add(pad)
        mark = pcbnew.FP_TEXT(footprint)
        mark.SetText("+")
        mark.SetPos0(point(-2.54, -1.9))
        mark.SetPosition(point(-2.54, -1.9))
        mark.SetLayer(pcbnew.F_SilkS)
        footprint.Add(mark)
        return footprint

    def put(self, ref, x, y, pin, at, back=True):
        """A part at x, y, turned so that a pin of it is at `at`; on the back pins may lie the other way round than a drawing shows."""
        library, name = netlist.PARTS[self.parts[ref]["kind"]]["footprint"].split(":")
        footprint = self.element(name) if library == "tile" else pcbnew.FootprintLoad(str(FOOTPRINTS / f"{library}.pretty"), name)
        footprint.SetReference(ref)
        footprint.SetValue(self.parts[ref]["value"])
        footprint.Reference().SetVisible(False)
        footprint.Value().SetLayer(pcbnew.F_Fab)
        footprint.SetPosition(point(x, y))
        self.board.Add(footprint)
        if back:
            footprint.Flip(point(x, y), False)
        self.footprints[ref] = footprint
        for turn in (0, 90, 180, 270):
            footprint.SetOrientationDegrees(turn)
            found = self.pad(ref, pin)
            if abs(found[0] - at[0]) + abs(found[1] - at[1]) < 0.6:
                break
        else:
            raise ValueError(f"{ref}: no turn brings pin {pin} to {at}")
        for pad in footprint.Pads():
            if (ref, pad.GetNumber()) in self.of:
                pad.SetNet(self.nets[self.of[ref, pad.GetNumber()]])

    def pad(self, ref, number):
        place = next(p for p in self.footprints[ref].Pads() if p.GetNumber() == str(number)).GetPosition()
        return pcbnew.ToMM(place.x), pcbnew.ToMM(place.y)

    def track(self, net, layer, *points, width=WIRE):
        for a, z in zip(points, points[1:]):
            if max(abs(a[0] - z[0]), abs(a[1] - z[1])) < 1e-6:
                continue
            track = pcbnew.PCB_TRACK(self.board)
            track.SetStart(point(*a))
            track.SetEnd(point(*z))
            track.SetWidth(mm(width))
            track.SetLayer(layer)
            track.SetNet(self.nets[net])
            self.board.Add(track)

    def via(self, net, x, y):
        via = pcbnew.PCB_VIA(self.board)
        via.SetPosition(point(x, y))
        via.SetWidth(mm(VIA))
        via.SetDrill(mm(HOLE))
        via.SetNet(self.nets[net])
        self.board.Add(via)

    def to_plane(self, ref, number, x, y, width=WIRE):
        """A pin to the plane of its net, by a track on the back and a via."""
        net = self.of[ref, str(number)]
        self.track(net, BACK, self.pad(ref, number), (x, y), width=width)
        self.via(net, x, y)

    def area(self, net, layer, left, top, right, bottom, pads=pcbnew.ZONE_CONNECTION_THERMAL):
        zone = pcbnew.ZONE(self.board)
        zone.SetLayer(layer)
        zone.SetNet(self.nets[net])
        outline = zone.Outline()
        outline.NewOutline()
        for x, y in ((left, top), (right, top), (right, bottom), (left, bottom)):
            outline.Append(mm(x), mm(y))
        zone.SetLocalClearance(mm(0.2))
        zone.SetMinThickness(mm(0.2))
        zone.SetPadConnection(pads)
        zone.SetThermalReliefGap(mm(0.25))
        zone.SetThermalReliefSpokeWidth(mm(0.4))
        self.board.Add(zone)

    def outline(self):
        corners = [(X0 - 4, Y0 - 2), (EDGE, Y0 - 2), (EDGE, END), (X0 - 4, END)]
        for a, z in zip(corners, corners[1:] + corners[:1]):
            line = pcbnew.PCB_SHAPE(self.board)
            line.SetShape(pcbnew.SHAPE_T_SEGMENT)
            line.SetStart(point(*a))
            line.SetEnd(point(*z))
            line.SetLayer(pcbnew.Edge_Cuts)
            line.SetWidth(mm(0.1))
            self.board.Add(line)

    def text(self, words, x, y):
        text = pcbnew.PCB_TEXT(self.board)
        text.SetText(words)
        text.SetPosition(point(x, y))
        text.SetLayer(pcbnew.F_SilkS)
        self.board.Add(text)


class Tile:
    """Where the elements' channels are, and the wires that lead to them."""

    def __init__(self, net, board_name, array):
        self.b = Board(net)
        self.wires = [netlist.wire(c, p) for c, p, _, _ in netlist.boards.load(board_name)["outputs"]]
        self.cell = {}  # row and column of a channel, from the upper left
        for ch, (x, y) in enumerate(netlist.places(array)):
            self.cell[ch] = round((ROWS - 1) / 2 - y / PITCH), round(x / PITCH + (COLUMNS - 1) / 2)
        self.channel_at = {cell: ch for ch, cell in self.cell.items()}
        if sorted(self.cell.values()) != [(r, c) for r in range(ROWS) for c in range(COLUMNS)]:
            raise ValueError(f"{array}: expected {ROWS} x {COLUMNS} elements {PITCH:g} mm apart")
        self.enable = netlist.enable_pin(board_name)
        # Lane of a channel beside its column's middle: the row that ends first is next to its driver.
        self.lane = {}
        for c in range(COLUMNS):
            for above in (True, False):
                rows = [r for r in range(ROWS) if self.above(self.channel_at[r, c]) == above]
                for k, r in enumerate(rows if above else reversed(rows)):
                    self.lane[self.channel_at[r, c]] = k
        self.lane_x, self.column_x = {}, {}

    def above(self, ch):
        return int(self.wires[ch][0][1:]) <= 8

    def pair(self, row, pair):
        """A driver between two elements: the left one is on its half B, the right one on half A."""
        b, left, y = self.b, X0 + 2 * PITCH * pair, TOP + 5 + PITCH * row
        n = row * COLUMNS // 2 + pair + 1
        driver, capacitor = f"U{n}", f"CD{n}"

        def at(dx, dy):
            return left + dx, y + dy

        b.put(driver, *at(10, 5), 1, at(11.905, 7.475))
        b.put(capacitor, *at(15.6, 7.7), 1, at(14.65, 7.7))
        self.half(driver, "5", self.channel_at[row, 2 * pair], at, mirrored=False)
        self.half(driver, "7", self.channel_at[row, 2 * pair + 1], at, mirrored=True)
        b.to_plane(driver, 6, b.pad(driver, 6)[0], y + 3.95, POWER)
        b.to_plane(driver, 3, b.pad(driver, 3)[0], y + 6.1, POWER)
        b.to_plane(capacitor, 1, left + 13.25, y + 7.7, POWER)
        b.to_plane(capacitor, 2, left + 17.6, y + 7.7, POWER)

    def half(self, driver, output, ch, at, mirrored):
        """What is between a driver's half and its element."""
        b, n = self.b, ch + 1
        element, series, coupling, bleeder, pull = f"T{n}", f"RS{n}", f"CS{n}", f"RB{n}", f"RD{n}"
        if mirrored:
            spots = [(series, (13.6, 3.525), (13.6, 4.3)), (coupling, (16.0, 2.75), (15.225, 2.75))]
            spots += [(bleeder, (18.9, 3.5), (18.9, 2.725)), (pull, (14.6, 5.8), (13.825, 5.8))]
        else:
            spots = [(series, (6.4, 3.3), (6.4, 2.525)), (coupling, (4.0, 4.075), (4.775, 4.075))]
            spots += [(bleeder, (1.1, 3.3), (1.1, 2.525)), (pull, (5.4, 5.8), (6.175, 5.8))]
        for ref, middle, first in spots:
            b.put(ref, *at(*middle), 1, at(*first))
        b.put(element, *at(15 if mirrored else 5, 0), 1, at(17.54 if mirrored else 2.46, 0), back=False)
        out, first = b.pad(driver, output), b.pad(series, 1)
        b.track(f"OUT{n}", BACK, out, (out[0], first[1]) if mirrored else (first[0], out[1]), first)
        b.track(f"MID{n}", BACK, b.pad(series, 2), b.pad(coupling, 1))
        second, leg, end = b.pad(coupling, 2), b.pad(element, 1), b.pad(bleeder, 1)
        b.track(f"EL{n}", BACK, second, (leg[0], second[1]), leg)
        b.track(f"EL{n}", BACK, end, (leg[0], end[1]))
        b.to_plane(bleeder, 2, b.pad(bleeder, 2)[0], at(0, 5.2 if mirrored else 5.0)[1])
        # The input's via is below the driver; on the front a stub leads to the lane.
        pin = b.pad(driver, 2 if mirrored else 4)
        x, y = pin[0], at(0, 5.8)[1]
        b.track(f"IN{n}", BACK, pin, (x, y), b.pad(pull, 1))
        b.via(f"IN{n}", x, y)
        b.to_plane(pull, 2, *at(16.6 if mirrored else 3.4, 5.8))
        side, middle = (-1, at(15, 0)[0]) if mirrored else (1, at(5, 0)[0])
        self.lane_x[ch] = middle + side * (1.0 - 0.4 * self.lane[ch])
        self.column_x[ch] = middle + (self.lane_x[ch] - middle) * 1.5
        b.track(f"IN{n}", FRONT, (x, y), (self.lane_x[ch], y))

    def connectors(self, above):
        """Eight side by side, pin 1 far from the array; each channel's pin, and the x at which its wire leaves them."""
        b, leave, edge = self.b, {}, Y0 + STRIP if above else END - STRIP
        for k in range(8):
            ref, x, y = f"J{k + 1 if above else k + 9}", X0 + 6.5 + 12.4 * k, Y0 + 2.5 if above else END - 2.5
            b.put(ref, x, y, 15, (x, y + 17.78 if above else y - 17.78))
            mine = [(ch, int(pin)) for ch, (c, pin) in enumerate(self.wires[: len(self.cell)]) if c == ref]
            for odd in (0, 1):
                side = 1 if b.pad(ref, 2 - odd)[0] > b.pad(ref, 1 + odd)[0] else -1
                column = sorted((ch for ch, pin in mine if pin % 2 == odd), key=lambda ch: abs(b.pad(*self.wires[ch])[1] - edge))
                leave |= {ch: b.pad(*self.wires[ch])[0] + side * (1.3 + 0.6 * j) for j, ch in enumerate(column)}
        return leave

    def route(self, above):
        """Wires from the connectors to the columns: each gets a line of the channel, on the back, and goes down on the front."""
        b, edge, inward = self.b, Y0 + STRIP if above else END - STRIP, 1 if above else -1
        leave = self.connectors(above)
        shift, lines = plan(leave, self.column_x, "above" if above else "below")
        for ref in {self.wires[ch][0] for ch in lines}:
            b.footprints[ref].Move(pcbnew.wxPoint(mm(shift), 0))
        for ch, k in lines.items():
            net, enter, out = f"IN{ch + 1}", leave[ch] + shift, self.column_x[ch]
            pin, y = b.pad(*self.wires[ch]), edge + inward * (0.8 + LINE * k)
            b.track(net, FRONT, pin, (enter, pin[1]), (enter, y))
            near = abs(enter - out) < 0.75  # two vias would touch
            b.track(net, FRONT if near else BACK, (enter, y), (out, y))
            for x in () if near else (enter, out):
                b.via(net, x, y)
            turn, lane = (TOP - 3.6, TOP - 1.2) if above else (BOTTOM + 2.4, BOTTOM)
            stub = TOP + 5 + PITCH * self.cell[ch][0] + 5.8
            b.track(net, FRONT, (out, y), (out, turn), (self.lane_x[ch], lane), (self.lane_x[ch], stub))

    def supply(self):
        """Terminal, fuse, clamp, bulk and switch in the strip right of the array, and the enable's transistor beside its connector."""
        b, x, q = self.b, STRIP_X, TOP + 52
        b.put("J100", x - 2.54, TOP + 6, 2, (x + 2.54, TOP + 6))
        b.put("F1", x - 2.54, TOP + 18, 1, (x - 2.54, TOP + 15.9))
        b.put("D1", x, TOP + 27, 1, (x - 2.15, TOP + 27))
        b.put("C1", x, TOP + 38, 1, (x - 4.0, TOP + 38))
        b.put("Q1", x - 3, q, 1, (x - 4.905, q - 2.475))
        b.put("C2", x - 0.6, q - 7, 1, (x - 1.4, q - 7))
        b.put("R1", x - 0.6, q - 5, 1, (x - 1.4, q - 5))
        b.put("C3", x - 0.6, q + 5.2, 1, (x - 1.4, q + 5.2))
        gate = b.pad("R1", 2)[0]
        b.put("R2", gate + 0.825, q + 7.4, 1, (gate, q + 7.4))
        b.track("SUPPLY", BACK, b.pad("J100", 1), b.pad("F1", 1), width=2.0)
        b.area("FUSED", BACK, x - 8, TOP + 19, x - 0.5, q - 1.3, pcbnew.ZONE_CONNECTION_FULL)
        b.area("VDD", BACK, x - 8, q + 1.3, x - 0.5, q + 7.4, pcbnew.ZONE_CONNECTION_FULL)
        b.area("GND", BACK, x + 1, TOP + 24, x + 8.5, TOP + 44, pcbnew.ZONE_CONNECTION_FULL)
        for k in range(6):
            b.via("VDD", x - 7.2 + k, q + 6.4)
            b.via("GND", x + 8, TOP + 25 + 3 * k)
        b.track("GATE", BACK, b.pad("C2", 2), (gate, q - 2.475), b.pad("Q1", 4))
        b.track("GATE", BACK, (gate, q - 2.475), b.pad("R2", 1))
        pull = b.pad("R2", 2)
        _, y = b.pad(*self.enable)
        b.put("Q2", pull[0], y - 3, 3, (pull[0], y - 3.94))
        b.track("PULL", BACK, pull, b.pad("Q2", 3))
        gate_pin, ground = b.pad("Q2", 1), b.pad("Q2", 2)
        b.put("R3", gate_pin[0] + 0.825, y, 1, (gate_pin[0], y))
        b.track("EN", BACK, b.pad(*self.enable), b.pad("R3", 1), gate_pin)
        b.to_plane("Q2", 2, ground[0] - 1.2, ground[1])
        b.to_plane("R3", 2, b.pad("R3", 2)[0] + 1.2, y)

    def make(self):
        for row in range(ROWS):
            for pair in range(COLUMNS // 2):
                self.pair(row, pair)
        for above in (True, False):
            self.route(above)
        self.supply()
        self.b.outline()
        self.b.text("Haptogram driver tile. Never built.", X0 + 20, Y0 - 0.9)
        self.b.area("GND", GROUND, X0 - 3.5, Y0 - 1.5, EDGE - 0.5, END - 0.5)
        self.b.area("VDD", SUPPLY, X0 - 3.5, Y0 - 1.5, EDGE - 0.5, END - 0.5)


def plan(leave, enter, where):
    """A line of the channel for each wire, and by how much the connectors move so that all find one."""
    for step in sorted(range(-18, 19), key=abs):
        lines = assign_lines({ch: x + 0.05 * step for ch, x in leave.items()}, enter)
        if lines:
            return 0.05 * step, lines
    raise ValueError(f"the wires {where} the array do not fit: use an array file whose order suits the board")


def assign_lines(leave, enter):
    """First come, first served; wires that found no line come first in the next round. None when no round serves all."""
    count, first = int((CHANNEL - 5.4) / LINE), []
    for seed in range(12):
        rest = sorted(set(leave) - set(first))
        random.Random(seed).shuffle(rest)
        if seed == 0:
            rest.sort(key=lambda ch: -abs(leave[ch] - enter[ch]))
        line, busy, failed = {}, [[] for _ in range(count)], []
        for ch in first + rest:
            left, right = sorted((leave[ch], enter[ch]))
            for k in range(count):
                taken = any(left - 0.8 < z and a < right + 0.8 for a, z in busy[k])
                # Where a wire going down comes near another's via, the order of their lines is given.
                crossed = any((abs(leave[ch] - enter[o]) < 0.56 and k >= at) or (abs(enter[ch] - leave[o]) < 0.56 and at >= k) for o, at in line.items())
                if not taken and not crossed:
                    line[ch] = k
                    busy[k].append((left, right))
                    break
            else:
                failed.append(ch)
        if not failed:
            return line
        first = failed + [ch for ch in first if ch not in failed][:6]
    return None


def violations(board, report):
    """Of KiCad's rules, and pads that are not connected."""
    pcbnew.WriteDRCReport(board, str(report), pcbnew.EDA_UNITS_MILLIMETRES, True)
    return sum(map(int, re.findall(r"Found (\d+) (?:DRC violations|unconnected pads)", report.read_text(encoding="utf-8"))))


def write_pads(board, path):
    rows = []
    for footprint in board.GetFootprints():
        for pad in footprint.Pads():
            place = pad.GetPosition()
            side = "both" if pad.GetAttribute() == pcbnew.PAD_ATTRIB_PTH else "back" if pad.IsOnLayer(BACK) else "front"
            rows.append([footprint.GetReference(), pad.GetNumber(), f"{pcbnew.ToMM(place.x):.4f}", f"{-pcbnew.ToMM(place.y):.4f}", side])
    with open(path, "w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([["ref", "pin", "x_mm", "y_mm", "side"], *sorted(rows)])


def plot(board, folder):
    folder.mkdir(exist_ok=True)
    control = pcbnew.PLOT_CONTROLLER(board)
    options = control.GetPlotOptions()
    options.SetOutputDirectory(str(folder.resolve()))
    options.SetUseGerberX2format(False)
    options.SetIncludeGerberNetlistInfo(False)
    options.SetPlotFrameRef(False)
    layers = {"F_Cu": FRONT, "In1_Cu": GROUND, "In2_Cu": SUPPLY, "B_Cu": BACK, "F_Mask": pcbnew.F_Mask, "B_Mask": pcbnew.B_Mask}
    layers |= {"B_Paste": pcbnew.B_Paste, "F_SilkS": pcbnew.F_SilkS, "B_SilkS": pcbnew.B_SilkS, "Edge_Cuts": pcbnew.Edge_Cuts}
    for name, layer in layers.items():
        control.SetLayer(layer)
        control.OpenPlotfile(name, pcbnew.PLOT_FORMAT_GERBER, name)
        control.PlotLayer()
    control.ClosePlot()
    drill = pcbnew.EXCELLON_WRITER(board)
    drill.SetFormat(True)
    drill.SetOptions(False, False, pcbnew.wxPoint(0, 0), True)
    drill.CreateDrillandMapFilesSet(str(folder.resolve()), True, False)


def planted(path, folder):
    """Violations after a fault each: how many of some faults KiCad's rules notice."""
    rng, noticed = random.Random(1), 0
    faults = ["lose a track", "lose a via", "widen a track", "move a via"]
    for n, fault in enumerate(faults):
        board = pcbnew.LoadBoard(str(path))
        vias = [t for t in board.GetTracks() if t.GetClass() == "PCB_VIA" and t.GetNetname().startswith("IN")]
        tracks = [t for t in board.GetTracks() if t.GetClass() == "PCB_TRACK" and t.GetNetname().startswith("IN") and t.GetLength() > mm(4)]
        item = rng.choice(vias if "via" in fault else tracks)
        if fault.startswith("lose"):
            board.Delete(item)
        elif fault.startswith("widen"):
            item.SetWidth(mm(1.2))
        else:
            item.Move(pcbnew.wxPoint(mm(0.45), mm(0.45)))
        noticed += violations(board, folder / f"fault-{n}.txt") > 0
    return noticed, len(faults)


def main():
    folder, board_name, array = Path(sys.argv[1]), sys.argv[2], sys.argv[3]
    folder.mkdir(parents=True, exist_ok=True)
    tile = Tile(netlist.build(board_name, array), board_name, array)
    tile.make()
    path = folder / "driver-tile.kicad_pcb"
    pcbnew.SaveBoard(str(path), tile.b.board)
    board = pcbnew.LoadBoard(str(path))
    pcbnew.ZONE_FILLER(board).Fill(board.Zones())
    pcbnew.SaveBoard(str(path), board)
    found = violations(board, folder / "violations.txt")
    write_pads(board, folder / "pads.csv")
    plot(board, folder / "gerber")
    noticed, made = planted(path, folder) if "--planted" in sys.argv else (0, 0)
    print(found, noticed, made)


if __name__ == "__main__":
    main()
