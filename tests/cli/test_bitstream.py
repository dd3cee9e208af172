# SPDX-License-Identifier: Apache-2.0
"""`haptogram bitstream`: what is read back from the bitstream by the tools that unpack it is the image, bit for bit."""
import binascii
import json
import random
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest
import support
from intelhex import IntelHex
from support import BAD_INPUT, ROOT, RUN_FAILED, USAGE

sys.path.insert(0, str(ROOT / "tools"))
import boards  # noqa: E402


def run(*args):
    return support.succeed(args)


def fails(code, *args):
    result = support.run(args)
    assert result.returncode == code, result.stderr.decode()
    return result.stderr.decode()


PLACED = ROOT / "build" / "boards"
VENV = ROOT / "build" / "venv" / "bin"
FILES = {name: boards.load(name) for name in boards.names()}
FPGAS = {name: file["fpga"] for name, file in FILES.items()}
BOARDS = {board: "asc" if file["fpga"]["family"] == "ice40" else "config" for board, file in FILES.items() if "sdram" not in file}
IDCODES = {"25k": "0x41111043", "85k": "0x41113043"}  # of the ECP5s


def fingerprint(board, name):
    return [int(word, 16) for word in (PLACED / board / f"{name}_init.hex").read_text().split()]


def columns_ice40(text):
    """{(tile, lane): 256 bits as an integer}: what one bit of 256 words in a row looks like, in any width of block RAM."""
    found, lines = {}, iter(text.splitlines())
    for line in lines:
        if not line.startswith(".ram_data"):
            continue
        rows = "".join(f"{int(next(lines), 16):0256b}"[::-1] for _ in range(16))
        for lane in range(16):
            found[line, lane] = int(rows[lane::16], 2)
    return found


def columns_ecp5(text):
    """The same of an ECP5: 2048 rows of 9 bits; words of up to 36 bits are one, two or four rows."""
    found, lines = {}, iter(text.splitlines())
    for line in lines:
        if not line.startswith(".bram_init"):
            continue
        rows = [int(word, 16) for _ in range(256) for word in next(lines).split()]
        for stride in (1, 2, 4):
            for phase in range(stride):
                for bit in range(9):
                    found[line, stride, phase, bit] = int("".join(str(row >> bit & 1) for row in rows[phase::stride]), 2)
    return found


def memory(family, before, after, words, width):
    """Reads a memory out of `after`, at the places where `before`, the placed design, has its fingerprint `words`."""
    contents = [0] * len(words)
    # How many words a column has one bit of, and how far these are apart: narrow words share a row.
    shapes = [(256, 1), (256, 2), (256, 4), (256, 8)] if family == "asc" else [(2048, 1), (1024, 1), (512, 1), (2048, 2), (2048, 4), (2048, 8)]
    for length, step in shapes:
        slices = {}
        for start in (block + phase for block in range(0, len(words), length * step) for phase in range(step)):
            part = words[start:start - start % step + length * step:step]
            for bit in range(width):
                slices[int("".join(str(word >> bit & 1) for word in part).ljust(length, "0"), 2)] = (start, bit)
        places = [(key, slices[value]) for key, value in before.items() if value and value in slices]
        if len(places) != len(slices):
            continue
        for key, (start, bit) in places:
            for i, digit in enumerate(f"{after[key]:0{length}b}"):
                if start + i * step < len(words):
                    contents[start + i * step] |= int(digit) << bit
                else:
                    assert digit == "0"
        return contents
    raise AssertionError("the placed design does not hold the fingerprint")


def unpack(board, bitstream, folder):
    if BOARDS[board] == "asc":
        return columns_ice40(subprocess.run(["iceunpack", bitstream], capture_output=True, text=True, check=True).stdout)
    tool = shutil.which("ecpunpack") or VENV / "yowasp-ecpunpack"
    shutil.copy(bitstream, folder / "unpack.bit")
    subprocess.run([tool, "--idcode", IDCODES[FPGAS[board]["device"]], "unpack.bit", "unpack.config"], cwd=folder, capture_output=True, check=True)
    return columns_ecp5((folder / "unpack.config").read_text())


@pytest.fixture(params=BOARDS)
def board(request):
    if not (PLACED / request.param / "report.json").exists():
        pytest.skip(f"not placed here: make bitstream BOARD={request.param}")
    return request.param


@pytest.fixture
def image(board, tmp_path):
    shown = json.loads(support.succeed(["board", "pinout", board, "--json"]).stdout)
    records = ["--records"] if shown["parameters"]["FOCI"] else []  # a bitstream holds no foci
    run("compile", "--shape", "circle", "--points", "20", "--board", board, *records, "-o", tmp_path / "image.hex")
    return tmp_path / "image.hex"


@pytest.mark.parametrize("autostart", [False, True])
def test_the_bitstream_holds_the_image(board, image, tmp_path, autostart):
    out = tmp_path / "out.bin"
    start = time.monotonic()
    run("bitstream", "--board", board, "--image", image, *(["--autostart"] if autostart else []), "-o", out, "--placed", PLACED)
    seconds = time.monotonic() - start
    print(f"{board}: patched in {seconds:.2f} s")
    columns = columns_ice40 if BOARDS[board] == "asc" else columns_ecp5
    before = columns((PLACED / board / f"placed.{BOARDS[board]}").read_text())
    after = unpack(board, out, tmp_path)
    hexfile = IntelHex(str(image))
    for name, base, width in (("primary", 0x00000000, 16), ("sequence", 0x10000000, 32)):
        words = fingerprint(board, name)
        found = memory(BOARDS[board], before, after, words, width)
        size = width // 8
        expected = [0] * len(words)
        for address in hexfile.addresses():
            if base <= address < base + len(words) * size:
                expected[(address - base) // size] |= hexfile[address] << 8 * ((address - base) % size)
        if name == "sequence" and autostart:
            expected[0] |= 1 << 15
        assert found == expected
    said = json.loads((tmp_path / "out.bin.json").read_text())
    assert said["autostart"] is autostart
    assert said["watchdog_ms"] == (0 if autostart else 500)


def test_what_cannot_be_patched(board, image, tmp_path):
    out = tmp_path / "out.bin"
    assert "make bitstream BOARD=" in fails(BAD_INPUT, "bitstream", "--board", board, "--image", image, "-o", out, "--placed", tmp_path)
    assert "--empty" in fails(USAGE, "bitstream", "--board", board, "-o", out)
    assert "(--image)" in fails(USAGE, "bitstream", "--board", board, "--empty", "--autostart", "-o", out)
    run("compile", "--shape", "circle", "--points", "20", "--array", "tile-10x10", "-o", tmp_path / "other.hex")
    other = "ice40-hx8k-breakout"  # another clock than the array's own board
    if board == other:
        assert "Hz" in fails(BAD_INPUT, "bitstream", "--board", other, "--image", tmp_path / "other.hex", "-o", out, "--placed", PLACED)
    (tmp_path / "bad.hex").write_text(":00000001FF\n")
    fails(BAD_INPUT, "bitstream", "--board", board, "--image", tmp_path / "bad.hex", "-o", out, "--placed", PLACED)
    assert not out.exists()
    assert not (tmp_path / "out.bin.json").exists()


def frames(data):
    """The frames of a line, decoded and without their CRC, which is right."""
    found = []
    for code in data.split(b"\0"):
        if not code:
            continue
        frame, at = b"", 0
        while at < len(code):
            frame += code[at + 1 : at + code[at]] + (b"\0" if code[at] != 255 else b"")
            at += code[at]
        frame = frame[:-1]
        assert binascii.crc_hqx(frame, 0xFFFF) == 0
        found.append(frame[:-2])
    return found


@pytest.mark.parametrize("autostart", [False, True])
@pytest.mark.parametrize("board", sorted(FPGAS.keys() - BOARDS.keys()))
def test_an_image_for_the_flash_of_a_board_with_an_sdram(tmp_path, board, autostart):
    run("compile", "--shape", "circle", "--points", "20", "--board", board, "-o", tmp_path / "image.hex")
    out = tmp_path / "out.raw"
    run("bitstream", "--board", board, "--image", tmp_path / "image.hex", *(["--autostart"] if autostart else []), "-o", out)
    data = out.read_bytes()
    assert data[:1] == b"\0" and data[-2:] == b"\0\0" and b"\0\0" not in data[:-2]
    written = {}
    for number, frame in enumerate(frames(data)):
        assert frame[0] == number % 256 and frame[1] == (2 if number else 1)  # IDENTIFY, then WRITEs
        for i, byte in enumerate(frame[6:] if number else b""):
            written[int.from_bytes(frame[2:6], "little") + i] = byte
    expected = IntelHex(str(tmp_path / "image.hex"))
    wanted = {address: expected[address] for address in expected.addresses() if address >> 28 != 4}  # the description is for hosts
    if autostart:
        wanted[0x10000001] |= 0x80
    assert written == wanted
    said = json.loads((tmp_path / "out.raw.json").read_text())
    assert (said["autostart"], said["watchdog_ms"], said["flash_offset"]) == (autostart, 0 if autostart else 500, 0x100000)
    dry = subprocess.run([sys.executable, ROOT / "tools/flash.py", board, "--program", "haptogram", "--image", "i.hex", "--autostart", "--write", "--dry-run"],
                         capture_output=True, text=True, check=True)  # fmt: skip
    assert [line.split()[0] for line in dry.stdout.splitlines()] == ["haptogram", "openFPGALoader", "openFPGALoader"]
    assert "--offset 1048576 --file-type raw" in dry.stdout.splitlines()[2]


def test_flashing_says_how_the_jumpers_must_be():
    command = [sys.executable, ROOT / "tools/flash.py", "ice40-hx8k-breakout", "--program", "haptogram", "--dry-run"]
    load, write = (subprocess.run([*command, *more], capture_output=True, text=True, check=True).stderr for more in ([], ["--write"]))
    assert load.endswith("jumpers: J7 off, both of J6 parallel to the board's text\n") and write.endswith("jumpers: J7 on, both of J6 turned by 90 degrees\n")


def test_what_does_not_go_into_a_flash(tmp_path):
    board = "colorlight-5a-75e-v6.0-sdram"
    run("compile", "--shape", "circle", "--points", "20", "--board", board, "-o", tmp_path / "image.hex")
    command = ["bitstream", "--board", board, "--image", tmp_path / "image.hex", "-o", tmp_path / "out.raw"]
    assert "--empty" in fails(USAGE, *command, "--rx-delay", "3")
    loads = subprocess.run([sys.executable, ROOT / "tools/flash.py", board, "--program", "haptogram", "--image", "i.hex", "--dry-run"],
                           capture_output=True, text=True)  # fmt: skip
    assert loads.returncode == USAGE and "--write" in loads.stderr
    assert not (tmp_path / "out.raw").exists()


def test_a_damaged_placed_design_is_noticed(board, image, tmp_path):
    folder = tmp_path / "placed" / board
    shutil.copytree(PLACED / board, folder, ignore=shutil.ignore_patterns("*.json", "core.v", "*.log"))
    for name in ("primary.hex", "primary_init.hex"):
        words = (folder / name).read_text().split()
        words[0] = f"{int(words[0], 16) ^ 1:04x}"
        (folder / name).write_text("\n".join(words) + "\n")
    message = fails(RUN_FAILED, "bitstream", "--board", board, "--image", image, "-o", tmp_path / "out.bin", "--placed", tmp_path / "placed")
    assert "make bitstream" in message
    assert not (tmp_path / "out.bin").exists()


def test_another_delay_of_the_inputs_needs_no_placing(tmp_path, monkeypatch):
    board = "colorlight-5a-75e-v7.1-sdram"
    (tmp_path / "placed" / board).mkdir(parents=True)
    (tmp_path / "ecppack").write_text('#!/bin/sh\ncp "$2" "$3"\n')  # what is to be packed
    (tmp_path / "ecppack").chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    generator = random.Random(1)
    words = [generator.getrandbits(32) for _ in range(1024)]
    rows = [word >> 9 * part & 0x1FF for word in words for part in range(4)]
    lines = [" ".join(f"{row:03x}" for row in rows[at : at + 8]) + "\n" for at in range(0, len(rows), 8)]
    delays = ["1010000"] * 5 + ["0000000"] * 3
    config = "".join(f"word: IOLOGICA.DELAY.DEL_VALUE {bits}\n" for bits in delays)
    config += "".join(f".bram_init {n}\n{''.join(lines[256 * n : 256 * n + 256])}\n" for n in range(2))
    (tmp_path / "placed" / board / "placed.config").write_text(config)
    (tmp_path / "placed" / board / "sequence_init.hex").write_text("".join(f"{word:08x}\n" for word in words))
    command = ["bitstream", "--board", board, "--empty", "--placed", tmp_path / "placed", "-o", tmp_path / "out.bit"]
    run(*command, "--rx-delay", "16")
    found = [line.split()[-1] for line in (tmp_path / "out.bit").read_text().splitlines() if "DEL_VALUE" in line]
    assert found == ["0010000"] * 5 + ["0000000"] * 3
    assert json.loads((tmp_path / "out.bit.json").read_text())["rx_delay"] == 16
    assert "0 to 127" in fails(USAGE, *command, "--rx-delay", "128")
    assert "no network" in fails(USAGE, "bitstream", "--board", "ulx3s-85f", "--empty", "-o", tmp_path / "no.bit", "--rx-delay", "1")
    (tmp_path / "placed" / board / "placed.config").write_text(config.replace("1010000", "1010001", 1))
    assert "found 4 inputs" in fails(RUN_FAILED, *command, "--rx-delay", "16")
