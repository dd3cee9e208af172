# SPDX-License-Identifier: Apache-2.0
"""Images of foci and modulation: read, written, uploaded, and foci changed while they play, on a virtual board that computes them."""
import dataclasses
import json
import zlib

import processes
import numpy as np
import pytest
from messages import refusal
from processes import BAD_INPUT, DEVICE, USAGE, ask, assert_refused, python_command, run, virtual_board
from haptogram import Client, Focus, HaptogramError, Image
from haptogram.interface import MODULATION_BASE, PARAMETERS_BASE, PRIMARY_BASE, RING_BASE, RING_FIELDS, unpack

SMALL = (processes.ROOT / "tests/data/arrays/tile-4x4.toml").read_text()


@pytest.fixture(scope="session")
def foci_images(tmp_path_factory):
    """Eight foci in turn, and two foci at a time with a modulation; made once."""
    folder = tmp_path_factory.mktemp("foci")
    (folder / "small.toml").write_text(SMALL)
    path = {"format": "haptogram-path-1", "carrier_hz": 40000, "modulation": {"periods_a_sample": 3, "samples": [0, 0.5, 1]},
            "steps": [{"periods": 5, "foci": [{"position_mm": [1, -2, 100], "amplitude": 1}, {"position_mm": [9, 0, 90], "amplitude": 0.3}]},
                      {"periods": 4, "foci": []}]}  # fmt: skip
    (folder / "path.json").write_text(json.dumps(path))
    on = ("--board", "small-16-wide", "--array", "small.toml")
    processes.haptogram(folder, "compile", "--shape", "circle", "--diameter", 20, "--points", 8, "--rate", 500, *on, "-o", "circle.hex")
    processes.haptogram(folder, "compile", "--path", "path.json", *on, "-o", "two.hex")
    return folder


@pytest.fixture
def wide(foci_images, tmp_path):
    """A folder with the images, and a client of a virtual board that computes foci."""
    for name in ("circle.hex", "two.hex"):
        (tmp_path / name).write_bytes((foci_images / name).read_bytes())
    with virtual_board(tmp_path, "--image", "circle.hex"), Client.open(str(tmp_path / "port")) as client:
        yield tmp_path, client


def test_an_image_is_read_as_it_was_written(foci_images, tmp_path):
    two = Image.load(str(foci_images / "two.hex"))
    assert two.records == [] and (two.foci.count, two.foci.each, two.foci.board_records) == (1, 2, 256)
    assert two.foci.records == [[Focus(1, -2, 100, 1), Focus(9, 0, 90, 77 / 255)]]  # 0.3 · 255 = 76.5
    assert (two.modulation.divider, list(two.modulation.samples)) == (3, [0, 128, 255])
    for name in ("two.hex", "circle.hex"):
        image = Image.load(str(foci_images / name))
        image.save(str(tmp_path / name))
        assert Image.load(str(tmp_path / name)) == image
    assert processes.haptogram(tmp_path, "inspect", "two.hex", "--json") == processes.haptogram(foci_images, "inspect", "two.hex", "--json")


def test_words_of_a_focus():
    rng = np.random.default_rng(5)
    for x, y, z, a in rng.uniform((-1023, -1023, -1023, 0), (1023, 1023, 1023, 1), (200, 4)):
        back = Focus.unpack(Focus(x, y, z, a).pack())
        assert max(abs(back[0] - x), abs(back[1] - y), abs(back[2] - z)) <= 1 / 256 and abs(back.amplitude - a) <= 0.5 / 255
    assert Focus(1, -1, 130, 1).pack() == bytes.fromhex("8000 80ff 0041 0cff")  # by rtl/INTERFACE.md
    for wrong in (Focus(1024, 0, 0), Focus(0, -1024.01, 0), Focus(0, 0, float("nan")), Focus(0, 0, 100, 1.01), Focus(0, 0, 100, -0.1)):
        with refusal(HaptogramError):
            wrong.pack()


def test_upload_writes_what_differs_and_the_geometry(wide):
    folder, board = wide
    circle, two = Image.load(str(folder / "circle.hex")), Image.load(str(folder / "two.hex"))
    assert board.upload(circle) == len(circle.unread_pieces()) == 4
    assert board.upload(two) > 4 and board.status().modulated
    board.compare(two)
    assert board.digest(PARAMETERS_BASE, 22) == zlib.crc32(two.foci.parameters)
    assert board.read(MODULATION_BASE, 4) == b"\x00\x80\xff\xff"
    assert board.highest_index() == 257 and board.parameters()["foci_last"] == 1
    board.upload(circle)
    assert not board.status().modulated and board.highest_index() == 264
    with refusal(HaptogramError):
        board.download()


def test_foci_are_changed_while_they_play(wide):
    folder, board = wide
    board.upload(Image.load(str(folder / "two.hex")))
    with board.outputs():
        board.select(257)
        for x in range(-5, 6):
            board.write_foci(257, [Focus(x, 0, 95, 0.5)])
        assert board.status().present_index == 257
    assert board.read(0, 8) == Focus(5, 0, 95, 0.5).pack() and board.read(8, 8) == Focus(5, 0, 95, 0).pack()
    for index, foci in ((258, [Focus(0, 0, 90)]), (256, [Focus(0, 0, 90)]), (257, []),
                             (257, [Focus(0, 0, 90)] * 3)):  # fmt: skip
        with refusal(HaptogramError):
            board.write_foci(index, foci)
    status = board.status()
    assert (status.refused_records, status.underruns, status.far_foci) == (0, 0, 0)


def test_the_program_plays_streams_and_modulates_foci(wide):
    folder, board = wide
    board.__exit__(None, None, None)
    said = json.loads(ask(folder, "upload", "two.hex", "--verify", "--json"))
    assert (said["records"], said["sequence_entries"], said["verified"]) == (1, 2, True)
    (folder / "lines").write_text("257 9\n0 3\n257\n")
    assert json.loads(ask(folder, "stream", "lines", "--json"))["sent"] == 3
    now = json.loads(ask(folder, "device", "status", "--json"))
    assert (now["refused_records"], now["far_foci"], now["outputs"]) == (0, 0, "off")
    (folder / "lines").write_text("258\n")
    assert_refused(run(python_command("stream", "lines", "--port", "port"), folder), BAD_INPUT)
    ask(folder, "device", "modulate", "--off")
    assert json.loads(ask(folder, "device", "status", "--json"))["modulated"] is False
    ask(folder, "device", "modulate", "--divider", 5, "--samples", 2, "--once")
    assert_refused(run(python_command("device", "modulate", "--samples", 65, "--port", "port"), folder), USAGE)


def test_another_board_is_refused(wide):
    folder, board = wide
    two = Image.load(str(folder / "two.hex"))
    for change in (two.foci._replace(board_records=300),
                        two.foci._replace(data=bytes(8 * 1280 + 8))):  # fmt: skip
        with refusal(HaptogramError):
            dataclasses.replace(two, foci=change).require_fits(board.identity, "image")
    with refusal(HaptogramError):
        dataclasses.replace(two, modulation=two.modulation._replace(samples=bytes(65))).require_fits(board.identity, "image")
    older = dataclasses.replace(board.identity, version=(2, 4))
    phase = bytes([0, 0, 0, 0, 0, 0, 0, 0x40]) + two.foci.geometry[8:]
    dataclasses.replace(two, foci=two.foci._replace(geometry=phase)).require_fits(older, "image")
    with refusal(HaptogramError):
        dataclasses.replace(two, foci=two.foci._replace(geometry=b"\0" * 6 + b"\1" + phase[7:])).require_fits(older, "image")
    plain = dataclasses.replace(board.identity, foci=0, width_bits=0, modulation_words=0)
    with refusal(HaptogramError):
        two.require_fits(plain, "image")


def test_a_board_without_modulation(folder):
    with virtual_board(folder):
        assert_refused(run(python_command("device", "modulate", "--port", "port"), folder), DEVICE)


def test_foci_are_pushed_while_they_play(wide):
    """What the ring holds is what was pushed, and the image stays."""
    folder, client = wide
    with refusal(HaptogramError):
        client.push_foci([Focus(0, 0, 100, 1)], 1)
    client.make_ring()
    client.make_ring()
    pushed = [Focus(i / 8, -i / 8, 100 + i / 8, (255 - i) / 255) for i in range(30)]
    with client.outputs():
        client.push_foci(pushed, 3)
        while client.status().live_level:
            pass
    ring = unpack(RING_FIELDS, client.read(RING_BASE, 6))
    assert ring["count"] == client.identity.live_depth + 1 and ring["first"] + ring["count"] - 1 == client.highest_index()
    held = b"".join(client.read(PRIMARY_BASE + 8 * (ring["base"] + at), 40) for at in range(0, 30, 5))
    assert [Focus.unpack(held[at : at + 8]) for at in range(0, 240, 8)] == pushed
    assert client.status().refused_records == client.status().far_foci == 0
    assert client.different(Image.load(str(folder / "circle.hex")).pieces()[:1]) == []


def test_changes_wait_for_a_period_or_the_end(wide):
    _, client = wide
    client.set_watchdog(0)
    client.enable()
    client.start(1, 4)
    client.start(5, 4, at_end=True)
    period = client.status().period
    client.start(1, 2, period=period + 10**9)
    assert client.status().waiting and client.status().period > period
    with refusal(HaptogramError):
        client.push([257], 1, period=period + 10**9 + 1)
    client.stop()
    assert not client.status().waiting
    # What was refused, or never sent, leaves nothing that the next command would wait in place of.
    for wrong in (lambda: client.push([70000], 1, period=period + 10**9), lambda: client.start(9999, 3, period=period + 10**9)):
        with pytest.raises(HaptogramError):
            wrong()
        client.modulate(1)
        assert not client.status().waiting
    client.push([257], 0, period=1)
    assert client.status().late_changes == 1 and client.status().mode == "live"
    client.modulate(2, 8, first=4, at_end=True)
    for wrong in (dict(period=0), dict(period=5, at_end=True)):
        with refusal(HaptogramError):
            client.start(1, 2, **wrong)
    with refusal(HaptogramError):
        client.modulate(2, first=3)


def test_the_program_gives_a_board_a_role(folder):
    processes.haptogram(folder, "compile", "--shape", "point", "--am", "sine:1000", "--board", "tile-100-wide", "--array", "tile-10x10", "-o", "sync.hex")
    with virtual_board(folder, "--image", "sync.hex"):
        assert json.loads(ask(folder, "device", "status", "--json"))["role"] == "alone"
        ask(folder, "device", "sync", "slave")
        now = json.loads(ask(folder, "device", "status", "--json"))
        assert (now["role"], now["in_step"], now["numbered"], now["sync_misses"]) == ("slave", False, False, 0)
        assert_refused(run(python_command("device", "enable", "--port", "port"), folder), DEVICE)
        ask(folder, "device", "sync", "alone")
        ask(folder, "device", "enable")
    with virtual_board(folder):
        assert_refused(run(python_command("device", "sync", "master", "--port", "port"), folder), DEVICE)
