# SPDX-License-Identifier: Apache-2.0
"""rtl/INTERFACE.md is enough to write a client from: page_client.py, on virtual boards, judged at their pins."""
import contextlib
import json
import math
import os
import signal
import subprocess
from pathlib import Path

import page_client as page
import pytest
from patience import until

PROGRAM = Path(os.environ.get("HAPTOGRAM_PROGRAM", Path(__file__).resolve().parents[2] / "build/release/host/cli/haptogram")).resolve()
CYCLE, SILENT = 1250, 0xFFFF  # clocks of a carrier period at 50 MHz
WAVELENGTH_MM = 8.58
PLACES = [(10.0 * (k % 4) - 15, 10.0 * (k // 4) - 15, 0.0) for k in range(16)]
CLIENT_LINES = 150


@pytest.fixture(autouse=True)
def patient(monkeypatch):
    """No line here loses anything; a Verilated board on a busy machine answers late."""
    monkeypatch.setattr(page, "PATIENCE_S", 60)


class Bench:
    """A virtual board of `configuration` as a process, its port, and in the end the pulses at its pins."""

    def __init__(self, folder, *options):
        self.port, self._csv = folder / "port", folder / "pulses.csv"
        self._process = subprocess.Popen([str(PROGRAM), "board", "run", "--json", "--pty", "port", *options], cwd=folder, stdout=subprocess.PIPE)
        self.baud = json.loads(self._process.stdout.readline())["baud"]

    def close(self):
        if self._process.poll() is None:
            self._process.send_signal(signal.SIGINT)
        self._process.communicate(timeout=300)

    def pulses(self):
        """Of each channel (rise, fall, index), in clocks."""
        self.close()
        rows = [[int(n) for n in line.split(",")] for line in self._csv.read_text().splitlines()[1:]]
        return [sorted(row[1:] for row in rows if row[0] == channel) for channel in range(16)]


@pytest.fixture
def wide(tmp_path):
    """The reference board with everything, a session on it, and outputs that go off in the end."""
    bench = Bench(tmp_path, "--board", "small-16-wide", "--model", "reference", "--pulses", "pulses.csv")
    with contextlib.closing(bench):
        line = page.Line(str(bench.port), bench.baud)
        board = page.Board(line)
        board.ask(page.WATCHDOG, 60000)
        board.ask(page.ENABLE)
        yield board, bench
        line.port.close()


def play(board, index, cycles=40):
    board.ask(page.SELECT, index, cycles)
    until(lambda: not (board.status()["index"] or board.status()["mode"]), "the end of playing")
    now = board.status()
    assert (now["enabled"], now["underruns"], now["refused_records"], now["far_foci"]) == (1, 0, 0, 0)
    board.ask(page.DISABLE)


def steady(channel, index=None):
    """A pulse of a channel away from changes: rise, fall. It is the same one for all channels, but for whole cycles."""
    rise, fall, played = channel[-2]
    assert index is None or played == index
    return rise, fall


def middles(pulses):
    """Where in the cycle the middles of the last pulses lie, against channel 0's; in clocks."""
    each = [sum(steady(channel)) / 2 for channel in pulses]
    return [(middle - each[0]) % CYCLE for middle in each]


def width(amplitude):
    """Of a pulse whose fundamental has this fraction of the largest."""
    return CYCLE / math.pi * math.asin(amplitude)


def apart(a, b):
    return abs((a - b + CYCLE / 2) % CYCLE - CYCLE / 2)


def test_a_record_of_timings(wide):
    board, bench = wide
    ticks = [0, *range(40, 1240, 80)]
    board.write_record(3, [*ticks[:15], SILENT], CYCLE, pulse=125)
    assert board.read(page.PRIMARY + 2 * 40, 8) == bytes.fromhex("e204007d01000000")
    play(board, 3)
    pulses = bench.pulses()
    assert pulses[15] == []
    first = steady(pulses[0], 3)
    for channel, tick in zip(pulses[:15], ticks[:15], strict=True):
        rise, fall = steady(channel, 3)
        assert (fall - rise, (rise - first[0]) % CYCLE) == (125, tick)


def test_a_record_of_amplitudes(wide):
    board, bench = wide
    phases, amplitudes = [16 * k for k in range(16)], [255 - 15 * k for k in range(16)]
    board.write_record(1, [phase | amplitude << 8 for phase, amplitude in zip(phases, amplitudes, strict=True)], CYCLE, kind=1)
    play(board, 1)
    pulses = bench.pulses()
    for channel, middle, phase, amplitude in zip(pulses, middles(pulses), phases, amplitudes, strict=True):
        rise, fall = steady(channel, 1)
        assert abs(fall - rise - width(amplitude / 255)) <= 2
        assert apart(middle, CYCLE * phase / 256) <= 1.5


@pytest.mark.parametrize("focus", [(0, 0, 100), (20, -35, 80), (-150.5, 260.25, 300), (0, 0, -60)])
def test_a_focus(focus, wide):
    """All waves arrive in phase: a channel that is farther plays earlier, by its distance in wavelengths."""
    board, bench = wide
    board.write_foci([[(*focus, 1.0)]], PLACES, WAVELENGTH_MM)
    play(board, board.records + 1)
    pulses = bench.pulses()
    arrivals = [middle + CYCLE * math.dist(place, focus) / WAVELENGTH_MM for middle, place in zip(middles(pulses), PLACES, strict=True)]
    assert max(apart(arrival, arrivals[0]) for arrival in arrivals) <= 3
    assert all(abs(fall - rise - CYCLE / 2) <= 1 for rise, fall in (steady(channel, 257) for channel in pulses))


def test_two_foci(wide):
    """Phase and amplitude of each channel are those of the sum of the two waves, cut off at full."""
    board, bench = wide
    foci = [(20, 5, 90, 0.6), (-25, 0, 110, 0.4)]
    board.write_foci([foci], PLACES, WAVELENGTH_MM)
    play(board, board.records + 1)
    pulses = bench.pulses()
    sums = [sum(a * complex(math.cos(p), math.sin(p)) for *focus, a in foci for p in [-2 * math.pi * math.dist(place, focus) / WAVELENGTH_MM]) for place in PLACES]
    found = [middle / CYCLE * 2 * math.pi for middle in middles(pulses)]
    first = math.atan2(sums[0].imag, sums[0].real)
    for value, channel, turn in zip(sums, pulses, found, strict=True):
        rise, fall = steady(channel, 257)
        assert abs(math.sin(math.pi * (fall - rise) / CYCLE) - min(1.0, abs(value))) <= 0.01
        if abs(value) > 0.2:
            assert apart(CYCLE * (math.atan2(value.imag, value.real) - first - turn) / (2 * math.pi), 0) <= 5


def test_a_modulation(wide):
    board, bench = wide
    board.write_record(1, [128 | 255 << 8] * 16, CYCLE, kind=1)
    board.modulate([255, 128, 51, 128], divider=5)
    assert board.status()["modulated"]
    play(board, 1, 80)
    widths = [fall - rise for rise, fall, _ in bench.pulses()[0]][8:72]
    expected = {round(width(sample / 255)) for sample in (255, 128, 51)}
    assert all(min(abs(w - e) for e in expected) <= 2 for w in widths)
    changes = [n for n, (a, b) in enumerate(zip(widths, widths[1:], strict=False)) if abs(a - b) > 5]
    assert len(changes) > 10 and all(b - a == 5 for a, b in zip(changes, changes[1:], strict=False))


def test_a_sequence(wide):
    board, bench = wide
    for index in (1, 2, 3):
        board.write_record(index, [100 * index] * 16, CYCLE, pulse=100)
    board.write_sequence([(1, 4), (3, 2), (2, 3), (0, 2)], loops=2)
    board.ask(page.START, 1, 0, 0)
    until(lambda: not board.status()["mode"], "the end of the sequence")
    board.ask(page.DISABLE)
    assert [index for _, _, index in bench.pulses()[5]] == 2 * [1, 1, 1, 1, 3, 3, 2, 2, 2]


def test_a_chain_whose_tiles_play_in_step(tmp_path):
    bench = Bench(tmp_path, "--tiles", "2", "--chain", "--speed", "max")
    with contextlib.closing(bench):
        line = page.Line(str(bench.port), bench.baud)
        line.make_chain(2)
        tiles = [page.Board(line, number) for number in (1, 2)]
        for tile, role in zip(tiles, (page.MASTER, page.SLAVE), strict=True):
            tile.ask(page.SYNC, role)
        for number, tile in enumerate(tiles):
            tile.write_record(1, [(7 * k + number) % CYCLE for k in range(tile.channels)], CYCLE, pulse=125)
            tile.ask(page.WATCHDOG, 60000)
        until(lambda: tiles[1].status()["in_step"] and tiles[1].status()["numbered"], "the slave being in step")
        for tile in tiles:
            tile.ask(page.ENABLE)
            tile.ask(page.SELECT, 1, 0)
        found = [tile.status() for tile in tiles]
        assert [(f["enabled"], f["index"], f["role"], f["refused_records"]) for f in found] == [(1, 1, page.MASTER, 0), (1, 1, page.SLAVE, 0)]
        line.shut_off()
        until(lambda: [tile.status()["enabled"] for tile in tiles] == [0, 0], "all outputs off")
        line.port.close()


def test_the_client_is_short_and_imports_nothing_of_ours():
    text = Path(page.__file__).read_text()
    assert len(text.splitlines()) <= CLIENT_LINES
    imported = {line.split()[1] for line in text.splitlines() if line.startswith(("import", "from"))}
    assert imported <= {"binascii", "random", "struct", "time", "serial"}
