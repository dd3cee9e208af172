# SPDX-License-Identifier: Apache-2.0
"""What the tests of the command line program share: running it, judging its errors, and images built without its code."""
import contextlib
import hashlib
import json
import os
import re
import subprocess
import termios
import tty
from pathlib import Path

import numpy as np
from intelhex import IntelHex
from messages import program_said
from patience import PATIENCE_S, Board

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = Path(os.environ.get("HAPTOGRAM_PROGRAM", ROOT / "build/release/host/cli/haptogram")).resolve()

RATE_NOTE = r"haptogram: \S+: it answers at \d+ baud, which is remembered\n"  # once, of the first command at a port
OK, RUN_FAILED, USAGE, BAD_INPUT, DEVICE = range(5)

# rtl/INTERFACE.md
PRIMARY, SEQUENCE, DESCRIPTION = 0x00000000, 0x10000000, 0x40000000
HEADER_WORDS = 4
SILENT = 0xFFFF


def run(args, cwd=None, env=None, timeout=PATIENCE_S, stdout=subprocess.PIPE, **more):
    """Runs the program without a terminal; output is bytes, as programs see it."""
    environment = {**os.environ, **(env or {})}
    more.setdefault("stdin", subprocess.DEVNULL)
    more.setdefault("stderr", subprocess.PIPE)
    return subprocess.run(
        [str(PROGRAM), *map(str, args)], cwd=cwd, env=environment, timeout=timeout, stdout=stdout, check=False, **more
    )


def succeed(args, **more):
    result = run(args, **more)
    assert result.returncode == OK, f"{args}: exit {result.returncode}\n{(result.stderr or b'').decode()}"
    return result


def text(stream):
    return stream.decode("utf-8")  # a message that is no UTF-8 is an error of its own


def snapshot(folder):
    """Every file and folder below `folder`, with its contents."""
    return {
        str(p.relative_to(folder)): os.readlink(p) if p.is_symlink() else p.read_bytes() if p.is_file() else None
        for p in sorted(Path(folder).rglob("*"))
    }


def assert_one_message(result, code):
    """Exit code, silence on stdout, and one readable message, of which ../messages.py asserts the place."""
    message = re.sub(r"\A" + RATE_NOTE, "", text(result.stderr))
    assert result.returncode == code, f"exit {result.returncode}, expected {code}: {message}"
    assert result.stdout in (b"", None), f"stdout holds {result.stdout[:200]!r}"
    assert message.endswith("\n"), f"no message, or no whole line: {message!r}"
    lines = message.splitlines()
    assert all(len(line) < 600 for line in lines) and not re.search(r"\d{40}", message), f"nobody reads a line like this: {message}"
    assert not re.search(r"[\x00-\x09\x0b-\x1f\x7f]", message), f"control characters: {message!r}"
    assert "terminate called" not in message and "Traceback" not in message
    assert sum(line.startswith("haptogram: ") for line in lines) == 1 and lines[0].startswith("haptogram: "), message
    assert all(line.startswith("  ") for line in lines[1:-1]), f"more than one message: {message}"
    program_said(code, message)


def refuse(folder, args, code, *, outputs=("image.hex", "image.json"), **more):
    """The program must refuse, and leave `folder` as it was: of several outputs the first is there, and old, the others are not; a single one is tried both ways."""
    for old in ((), outputs) if len(outputs) == 1 else (outputs[:1],):
        for name in old:
            (folder / name).write_bytes(b"old")
        before = snapshot(folder)
        result = run(args, cwd=folder, **more)
        after = snapshot(folder)
        assert_one_message(result, code)
        assert after == before, f"left behind or altered: {sorted(k for k in before.keys() | after.keys() if before.get(k, 0) != after.get(k, 0))}"


class Image:
    """An image as Python's intelhex sees it; words are read and written by the address map alone."""

    def __init__(self, path):
        self.hex = IntelHex(str(path))
        self.described = self.words16(DESCRIPTION, 8)
        self.channels, self.count = int(self.described[2]), int(self.described[3])
        self.sequence_words = int(self.described[4])
        self.stride = self.channels + HEADER_WORDS

    def words16(self, base, count):
        return np.frombuffer(self.hex.tobinarray(start=base, size=2 * count).tobytes(), dtype="<u2")

    def words32(self, base, count):
        return np.frombuffer(self.hex.tobinarray(start=base, size=4 * count).tobytes(), dtype="<u4")

    def primary(self):
        return self.words16(PRIMARY, self.count * self.stride)

    def sequence(self):
        return self.words32(SEQUENCE, self.sequence_words)

    def records(self):
        """Cycle, prescaler, pulse and timings of every record, by INTERFACE.md."""
        rows = self.primary().reshape(self.count, self.stride).astype(np.int64)
        return [
            {
                "index": i + 1,
                "cycle_length": int(row[0] | (row[1] & 0xFF) << 16),
                "prescaler": int(row[2] | (row[3] & 0xFF) << 16),
                "pulse_length": int(row[1] >> 8),
                "timings": [int(t) for t in row[HEADER_WORDS:]],
            }
            for i, row in enumerate(rows)
        ]

    def put16(self, address, value):
        self.hex[address], self.hex[address + 1] = value & 0xFF, value >> 8 & 0xFF

    def put32(self, address, value):
        self.put16(address, value)
        self.put16(address + 2, value >> 16)

    def record_word(self, record, word):
        """The address of a word of a record, both counted as in INTERFACE.md: records from 1, words from 0."""
        return PRIMARY + 2 * ((record - 1) * self.stride + word)

    def save(self, path):
        self.hex.write_hex_file(str(path), write_start_addr=False)


def read_json(path):
    return json.loads(Path(path).read_text(encoding="utf-8"))


def adopt(image, manifest):
    """Makes a manifest vouch for an image that was changed, so that only the physics can tell."""
    content = read_json(manifest)
    content["image_sha256"] = hashlib.sha256(Path(image).read_bytes()).hexdigest()
    Path(manifest).write_text(json.dumps(content), encoding="utf-8")


def foci_mm(manifest):
    return np.array([record["focus_mm"] for record in manifest["records"]], dtype=float)


def exact_ticks(manifest, foci):
    """The focal law (Haptogram III-A) in float64 and not yet rounded: ticks in [0, cycle), a row a focus."""
    elements = np.array(manifest["array"]["elements_mm"], dtype=float) * 1e-3
    flight_s = np.linalg.norm(foci[:, None, :] * 1e-3 - elements[None], axis=2) / manifest["medium"]["speed_m_s"]
    delay_s = flight_s.max(axis=1, keepdims=True) - flight_s
    return delay_s / manifest["timer"]["tick_s"] % manifest["timer"]["cycle_ticks"]


SMALL = (ROOT / "tests/data/arrays/tile-4x4.toml").read_text()




def array_for(board, folder):
    """An array with an element for each channel of a board that computes foci."""
    if board == "tile-100-wide":
        return "tile-10x10"
    (folder / "small.toml").write_text(SMALL)
    return "small.toml"


def path_file(folder, steps, modulation=None):
    """A path of (foci, periods); each focus is (x, y, z in mm, amplitude)."""
    path = {"format": "haptogram-path-1", "carrier_hz": 40000,
            "steps": [{"periods": periods, "foci": [{"position_mm": list(f[:3]), "amplitude": f[3]} for f in foci]} for foci, periods in steps]}
    if modulation:
        path["modulation"] = modulation
    (folder / "path.json").write_text(json.dumps(path))
    return "path.json"


def open_raw(port):
    """The port of a virtual board of 1 Mbaud, for a test that speaks to it byte by byte."""
    descriptor = os.open(port, os.O_RDWR | os.O_NOCTTY)
    tty.setraw(descriptor)
    settings = termios.tcgetattr(descriptor)
    settings[4] = settings[5] = termios.B1000000
    termios.tcsetattr(descriptor, termios.TCSANOW, settings)
    return descriptor


# Most cases are about the host, and their boards are the reference board. HAPTOGRAM_MODEL=rtl runs all of them on Verilated ones.
MODEL = os.environ.get("HAPTOGRAM_MODEL", "reference")


def board_run(*options):
    """The command of a virtual board: a Verilated one runs as fast as it can, which is slower than a real one."""
    model = [] if "--model" in options else ["--model", MODEL]
    speed = [] if "--speed" in options or "reference" in (*model, *options) else ["--speed", "max"]
    return [str(PROGRAM), "board", "run", "--json", *model, *speed, *map(str, options)]


@contextlib.contextmanager
def virtual_board(folder, *options):
    """A running board; its port is `folder`/port, which it leaves behind."""
    board = Board(board_run("--pty", "port", *options), folder)
    try:
        yield board
    finally:
        board.end()


def ask(folder, *args, **more):
    """A command at the board of `folder`, which must succeed. Where nothing is said of a watchdog, it lets a busy machine pause."""
    if args[0] in ("play", "stream") and "--watchdog" not in args and "--live" not in args:
        args = (*args, "--watchdog", 60000)
    return succeed([*args, "--port", "port"], cwd=folder, **more)


def status(folder):
    return json.loads(ask(folder, "device", "status", "--json").stdout)
