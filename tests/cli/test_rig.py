# SPDX-License-Identifier: Apache-2.0
"""Rigs: the files that `compile --rig` writes, what the commands refuse, and two boards that play and are streamed to."""
import contextlib
import json
import os
import select
import re
import signal
import subprocess
import threading
import tty

import pytest
from patience import until
from support import BAD_INPUT, DEVICE, PROGRAM, USAGE, assert_one_message, board_run, open_raw, path_file, run, succeed, text

MADE_ONCE = ["boards"]
PAIR = """format = "haptogram-rig-1"
name = "pair"
[[unit]]
array = "tile-10x10"
origin_mm = [-50, 0, 0]
board = "tile-100-wide"
{first}
[[unit]]
array = "tile-10x10"
origin_mm = [50, 0, 0]
board = "tile-100-wide"
{second}
"""


@pytest.fixture(scope="module")
def pair(tmp_path_factory):
    """A rig of two tiles whose file names the ports, and a small shape on it."""
    folder = tmp_path_factory.mktemp("pair")
    (folder / "pair.toml").write_text(PAIR.format(first='port = "port-1"', second='port = "port-2"'))
    told = succeed(["compile", "--shape", "circle", "--points", 4, "--rate", 500, "--center", "0,0,180", "--rig", "pair.toml", "-o", "wall.hex", "--json"], cwd=folder)
    report = json.loads(told.stdout)
    assert report["rig"] == "pair" and report["images"] == ["wall.tile-1.hex", "wall.tile-2.hex"] and report["manifest"] == "wall.json"
    return folder


def test_the_files_of_a_rig(pair):
    manifest = json.loads((pair / "wall.json").read_text())
    assert manifest["format"] == "haptogram-rig-manifest-1" and manifest["rig"]["name"] == "pair"
    assert [(t["image"], t["elements"], t["port"]) for t in manifest["tiles"]] == [("wall.tile-1.hex", 100, "port-1"), ("wall.tile-2.hex", 100, "port-2")]
    # A tile's image is one that programs for one board read.
    about = text(succeed(["inspect", "wall.tile-2.hex"], cwd=pair).stdout)
    assert "100" in about
    # At a focus, the pressures of the two add up.
    record = json.loads((pair / "wall.tile-1.json").read_text())["records"][0]
    x, y, z = record["foci"][0]["position_mm"] if "foci" in record else record["focus_mm"]
    field = ["field", "--line", f"z@x={x},y={y}", "--z", f"{z}:{z + 1}", "--step", 1, "--quantity", "rms"]
    both, one = (float(text(succeed([*field, name], cwd=pair).stdout).splitlines()[-1].split(",")[-1]) for name in ("wall.json", "wall.tile-1.hex"))
    assert 1.5 * one < both < 2.5 * one


@pytest.mark.parametrize(
    "args, code",
    [
        (["compile", "--shape", "circle", "--rig", "3x3"], BAD_INPUT),
        (["compile", "--shape", "circle", "--rig", "2x2", "-o", "-"], USAGE),
        (["compile", "--shape", "circle", "--rig", "2x2", "--array", "hoshi"], USAGE),
        (["compile", "--shape", "circle", "--rig", "2x2", "--board", "tile-100"], BAD_INPUT),
        (["upload", "--rig", "wall.tile-1.json"], BAD_INPUT),
        (["upload", "--rig", "wall.json", *["--port", "a"] * 3], USAGE),
        (["upload", "--rig", "wall.json", "--port", "a"], DEVICE),
        (["device", "info", "--port", "a#0"], USAGE),
        (["device", "info", "--port", "a#1#2"], USAGE),
        (["device", "list", "--port", "a"], DEVICE),
        (["board", "run", "--chain"], USAGE),
        (["play", "--rig", "wall.json", "--port", "a", "--port", "a"], USAGE),
        (["play", "--rig", "wall.json", "--rate", 3], USAGE),
        (["play"], USAGE),
        (["stream", "--rig", "wall.json", "--foci"], USAGE),
        (["stream", "--rig", "wall.json", "--am", "sine:200"], USAGE),
        (["stream", "--rig", "wall.json", *["--port", "a"] * 3], USAGE),
        (["stream", "--rig", "wall.tile-1.json"], BAD_INPUT),
        (["stream", "--port", "a", "--on-loss", "rest"], USAGE),
        (["stream", "--rig", "wall.json", "--foci"], USAGE),
        (["stream", "--path", "p.json", "--rig", "2x2", "--array", "hoshi"], USAGE),
        (["stream", "--port", "a", "--port", "b"], USAGE),
        (["stream"], USAGE),
        (["play", "--port", "a", "--port", "b"], USAGE),
        (["upload", "--port", "a"], USAGE),
        (["simulate"], USAGE),
        (["board", "run", "--tiles", 2, "--model", "reference", "--chain"], USAGE),
        (["board", "run", "--tiles", 2, "--fault", "silent:3@1"], USAGE),
        (["board", "run", "--tiles", 2, "--channels", 16], USAGE),
    ],
)
def test_what_cannot_be_done(pair, args, code):
    assert_one_message(run(args, cwd=pair), code)


STATUS, ENABLE, DISABLE = 0x0B, 0x04, 0x05  # rtl/INTERFACE.md
PATIENT = ["--watchdog", "60000"]  # which lets a busy machine pause
SILENT_SOON = ["--watchdog", "3000"]  # a tile that answers nothing for a part of this is silent
PATIENCE_S = 500  # two Verilated boards take long


def commands_in(data):
    """The numbers and commands of whole frames: a frame is COBS, its first byte a number, its second the command."""
    for frame in data.split(b"\0")[:-1]:
        plain, at = bytearray(), 0
        while at < len(frame):
            code = frame[at]
            plain += frame[at + 1 : at + code]
            at += code
            if code < 255 and at < len(frame):
                plain.append(0)
        if len(plain) > 1:
            yield plain[0], plain[1]


class Cable:
    """A serial line from a program to a board that can be cut and mended. Its port has a name of its own."""

    def __init__(self, board):
        self.board = open_raw(board)
        self.host, self.end = os.openpty()
        tty.setraw(self.end)
        self.name = os.ttyname(self.end)
        self.cut, self.playing, self.over = threading.Event(), threading.Event(), threading.Event()
        self.asked = None
        self.thread = threading.Thread(target=self.carry, daemon=True)
        self.thread.start()

    def carry(self):
        sent = b""
        while not self.over.is_set():
            for source in select.select([self.host, self.board], [], [], 0.05)[0]:
                data = os.read(source, 4096)
                if self.cut.is_set():
                    continue
                os.write(self.board if source == self.host else self.host, data)
                if source == self.host:
                    sent += data
                    self.look(commands_in(sent))
                    sent = sent[sent.rfind(b"\0") + 1 :]

    def look(self, commands):
        """Plays once it was asked for a second status since ENABLE: after the first the tiles may still be told to begin again."""
        for number, command in commands:
            if command == ENABLE:
                self.asked = set()
            elif command == DISABLE:
                self.asked = None
            elif command == STATUS and self.asked is not None:
                self.asked.add(number)
                if len(self.asked) == 2:
                    self.playing.set()

    def mend(self):
        self.cut.clear()
        self.playing.clear()
        self.asked = None

    def close(self):
        self.over.set()
        self.thread.join()
        for descriptor in (self.board, self.host, self.end):
            os.close(descriptor)


def test_reference_boards_play_a_rig(pair, tmp_path):
    (tmp_path / "pair.toml").write_text((pair / "pair.toml").read_text().replace('"port-', f'"{tmp_path}/port-'))
    succeed(["compile", "--shape", "circle", "--points", 4, "--rate", 500, "--am", "sine:200", "--center", "0,0,180", "--rig", "pair.toml", "-o", "wall.hex"], cwd=tmp_path)
    command = [str(PROGRAM), "board", "run", "--tiles", "2", "--model", "reference", "--pty", "port", "--json"]
    process = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    try:
        started = json.loads(process.stdout.readline())
        assert started["model"] == "reference" and started["configuration"] == "tile-100-wide"
        succeed(["upload", "--rig", "wall.json"], cwd=tmp_path)
        told = text(succeed(["play", "--rig", "wall.json", *PATIENT, "--loops", 100], cwd=tmp_path).stdout)
        assert told.startswith("0 underruns, 0 refused records, begun together in carrier period"), told
        for tile, role in (("port-1", "master"), ("port-2", "slave")):
            status = json.loads(succeed(["device", "status", "--port", tile, "--json"], cwd=tmp_path).stdout)
            assert status["role"] == role and status["sync_misses"] == 0 and status["underruns"] == 0
    finally:
        process.send_signal(signal.SIGINT)
        said, _ = process.communicate(timeout=300)
    assert json.loads(said)["enabled"] == [False, False]


@pytest.fixture(scope="module")
def boards(pair):
    """Two boards on one wire, with their images. @return the cables to them, and the options that name their ports"""
    command = board_run("--tiles", "2")
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    cables = [Cable(port) for port in json.loads(process.stdout.readline())["ports"]]
    try:
        ports = [word for cable in cables for word in ("--port", cable.name)]
        succeed(["upload", "--rig", "wall.json", *ports], cwd=pair, timeout=PATIENCE_S)
        yield cables, ports
    finally:
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=300)
        for cable in cables:
            cable.close()


@contextlib.contextmanager
def cut_while(folder, cables, args):
    """Runs a command, cuts the second cable once the tiles play, and mends it at the end. @return the process, which still runs"""
    process = subprocess.Popen([str(PROGRAM), *map(str, args)], cwd=folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    try:
        assert cables[1].playing.wait(PATIENCE_S), f"it never played: {text(process.stderr.read() if process.poll() is not None else b'it still runs')}"
        cables[1].cut.set()
        yield process
    finally:
        process.kill()
        process.wait()
        for cable in cables:
            cable.mend()


def outputs(folder, cable):
    return json.loads(succeed(["device", "status", "--port", cable.name, "--json"], cwd=folder, timeout=PATIENCE_S).stdout)["outputs"]


def test_a_tile_that_falls_silent_takes_the_others_with_it(pair, boards):
    cables, ports = boards
    with cut_while(pair, cables, ["play", "--rig", "wall.json", *ports, *SILENT_SOON, "--loops", 0]) as process:
        said, warned = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == DEVICE and said == b"", text(warned)
    assert "tile 2" in text(warned) and re.search("does not answer|no answer", text(warned)) and "all tiles are switched off" in text(warned)
    assert outputs(pair, cables[0]) == "off"


def test_a_stream_goes_on_without_a_tile_that_falls_silent(pair, boards):
    cables, ports = boards
    (pair / "long.txt").write_text("401 60\n402 60\n" * 20000)
    stream = ["stream", "long.txt", "--rig", "wall.json", *ports, *SILENT_SOON, "--on-loss", "rest", "--json"]
    with cut_while(pair, cables, stream) as process:
        # Before it may come a port's rate, and that the tile did not confirm that it is off.
        warning = next(line for line in map(text, process.stderr) if "the others go on" in line)
        assert "tile 2" in warning
        assert process.poll() is None
        process.send_signal(signal.SIGINT)
        said, warned = process.communicate(timeout=PATIENCE_S)
    if process.returncode:  # on a busy machine tile 1 may take longer to confirm than the host waits
        assert process.returncode == DEVICE and "tile 1" in text(warned) and "does not confirm that its outputs are off" in text(warned), text(warned)
        until(lambda: outputs(pair, cables[0]) == "off", "its watchdog's end of the outputs")
        return
    report = json.loads(said)
    assert report["lost"] == [f"tile 2 ({cables[1].name})"] and report["interrupted"] and report["sent"] > 0
    assert outputs(pair, cables[0]) == "off"


def test_lines_go_to_all_tiles(pair, boards):
    cables, ports = boards
    lines = [f"{401 + n % 4} {(40, 80, 120)[n % 3]}" for n in range(15)] + ["0 40"]
    stream = ["stream", "--rig", "wall.json", *ports, *PATIENT, "--json"]
    report = json.loads(succeed(stream, cwd=pair, timeout=PATIENCE_S, stdin=None, input="\n".join(lines).encode()).stdout)
    assert (report["sent"], report["refused_records"], report["lost"], report["interrupted"]) == (16, 0, [], False)
    assert report["period"] > 0
    result = run(stream, cwd=pair, timeout=PATIENCE_S, stdin=None, input=b"401 40\n405 40\n")
    assert_one_message(result, BAD_INPUT)
    result = run(stream, cwd=pair, timeout=PATIENCE_S, stdin=None, input=b"1 40\n")
    assert_one_message(result, BAD_INPUT)
    assert [outputs(pair, cable) for cable in cables] == ["off", "off"]


def test_a_path_goes_to_a_rig(pair, boards):
    path = path_file(pair, [([(10 * n, 0, 180, 1.0)], 60) for n in range(5)])
    stream = ["stream", "--path", path, "--rig", "pair.toml", *boards[1], *PATIENT, "--loops", 2, "--json"]
    report = json.loads(succeed(stream, cwd=pair, timeout=PATIENCE_S).stdout)
    assert (report["sent"], report["refused_records"], report["lost"]) == (10, 0, [])


@contextlib.contextmanager
def chain(folder, *options):
    """Two boards behind one pseudo-terminal, called port."""
    process = subprocess.Popen(board_run("--tiles", "2", "--chain", "--model", "rtl", "--pty", "port", *options), cwd=folder, stdout=subprocess.PIPE)
    try:
        assert json.loads(process.stdout.readline())["ports"] == ["port#1", "port#2"]
        yield process
    finally:
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=300)


RATE = ["--baud", "1000000"]  # is not asked for, which a Verilated board on a busy machine would be too slow for


@pytest.mark.deep
def test_a_rig_behind_one_port(pair):
    with chain(pair):
        listed = json.loads(succeed(["device", "list", "--port", "port", *RATE, "--json"], cwd=pair, timeout=PATIENCE_S).stdout)
        assert [(tile["port"], tile["channels"]) for tile in listed] == [("port#1", 100), ("port#2", 100)]
        succeed(["upload", "--rig", "wall.json", "--port", "port", *RATE], cwd=pair, timeout=PATIENCE_S)
        states = json.loads(succeed(["device", "status", "--rig", "wall.json", "--port", "port", *RATE, "--json"], cwd=pair, timeout=PATIENCE_S).stdout)
        assert [(tile["port"], tile["holds_its_image"]) for tile in states] == [("port#1", True), ("port#2", True)]
        played = json.loads(succeed(["play", "--rig", "wall.json", "--port", "port", *RATE, *PATIENT, "--loops", 2, "--json"], cwd=pair, timeout=PATIENCE_S).stdout)
        assert (played["lost"], played["refused_records"]) == ([], 0)
        # The ports in the wrong order: each tile holds the other's image.
        result = run(["play", "--rig", "wall.json", "--port", "port#2", "--port", "port#1", *RATE], cwd=pair, timeout=PATIENCE_S)
        assert_one_message(result, DEVICE)


def test_a_board_alone_is_listed_as_one(pair):
    process = subprocess.Popen(board_run("--pty", "alone"), cwd=pair, stdout=subprocess.PIPE)
    try:
        process.stdout.readline()
        found = text(succeed(["device", "list", "--port", "alone"], cwd=pair, timeout=PATIENCE_S).stdout)
        assert found == "alone 100 channels, 400 records, 50 MHz\n"
    finally:
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=300)
