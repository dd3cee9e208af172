# SPDX-License-Identifier: Apache-2.0
"""Images in files: the compiler's read and written as they were, damaged ones refused."""
import json
import os

import processes
import pytest
from haptogram import HaptogramError, Image, Record, hexfile
from intelhex import IntelHex
from messages import refusal


def test_an_image_is_what_the_manifest_says(compiled, image):
    manifest = json.loads(compiled.with_suffix(".json").read_text())
    timer = manifest["timer"]
    assert len(image.records) == len(manifest["records"]) == 8
    expected = (timer["cycle_ticks"], timer["prescaler"], timer["pulse_ticks"])
    assert {(r.cycle_length, r.prescaler, r.pulse_length) for r in image.records} == {expected}
    assert [index for index, _ in image.entries] == list(range(1, 9))
    assert all(len(r.timings) == image.channels == 100 for r in image.records)


def test_a_saved_image_is_the_same_to_both_programs(folder, image):
    image.save(str(folder / "saved.hex"))
    assert Image.load(str(folder / "saved.hex")) == image
    assert IntelHex(str(folder / "saved.hex")).todict() == IntelHex(str(folder / "image.hex")).todict()
    assert processes.haptogram(folder, "inspect", "saved.hex") == processes.haptogram(folder, "inspect", "image.hex")


def test_bytes_are_read_as_a_file_is(compiled, image):
    assert Image.from_bytes(compiled.read_bytes()) == image
    assert repr(image) == "<Image: 8 records, 8 entries, 100 channels at 50 MHz>"
    with refusal(HaptogramError):
        Image.from_bytes(compiled.read_bytes()[:-20], "what was sent")


def test_a_record_goes_round():
    record = Record(0x123456, 0x345678, 0x9A, [1, 2, 0xFFFF])
    assert record.pack() == bytes.fromhex("5634129a7856340001000200ffff")
    assert Record.unpack(record.pack()) == record


def test_pieces_are_records_and_parts_of_the_sequence():
    image = Image(6, 1, 16, 8, bytes(40), bytes(48))
    assert [(p.address, len(p.data)) for p in image.pieces()] == [(0, 20), (20, 20), (0x10000000, 20), (0x10000014, 20), (0x10000028, 8)]


def put16(file, address, value):
    file[address], file[address + 1] = value & 0xFF, value >> 8


@pytest.mark.parametrize(("address", "value"), [
    (0x40000000, 0x1234),
    (0x40000002, 2),
    (0x40000004, 0),
    (0x40000006, 9),
    (0x40000008, 8),
    (0x10000000, 7),
    (0x10000004, 9),
    (0x1000000A, 0),
    (0x00000004, 0),
    (0x00000006, 0x100),
    (0x00000000, 125),
    (0x00000006, 0xFF),
    (0x50000000, 0),
])  # fmt: skip
def test_what_an_image_cannot_say(address, value, compiled, tmp_path):
    file = IntelHex(str(compiled))
    put16(file, address, value)
    file.write_hex_file(str(tmp_path / "bad.hex"))
    with refusal(HaptogramError) as error:
        Image.load(str(tmp_path / "bad.hex"))
    assert error.value.code == processes.BAD_INPUT


@pytest.mark.parametrize(("damage", "where"), [
    (lambda text: "", "bad.hex"),
    (lambda text: text[:1000], "bad.hex"),
    (lambda text: text + text, "bad.hex"),
    (lambda text: text.replace("\n", "\nx", 1), "bad.hex:2"),
    (lambda text: text[:15] + ("1" if text[15] != "1" else "2") + text[16:], "bad.hex:1"),
    (lambda text: text[: text.index("\n") + 1] + text, "bad.hex:2"),
    (lambda text: "".join(text.splitlines(True)[1:]), "bad.hex"),
    (lambda text: ":0400000300003800C1\n" + text, "bad.hex"),
    (lambda text: "\xff" + text, "bad.hex"),
])  # fmt: skip
def test_a_damaged_file(damage, where, compiled, tmp_path):
    (tmp_path / "bad.hex").write_text(damage(compiled.read_text()), encoding="latin-1")
    with refusal(HaptogramError) as error:
        Image.load(str(tmp_path / "bad.hex"))
    assert error.value.code == processes.BAD_INPUT
    assert error.value.where == str(tmp_path / where)


def test_a_file_is_written_whole_or_not_at_all(tmp_path):
    target = tmp_path / "file"
    target.write_text("old")
    target.chmod(0o640)
    link = tmp_path / "link"
    link.symlink_to(target)
    hexfile.write_file(str(link), "new")
    assert link.is_symlink() and target.read_text() == "new" and target.stat().st_mode & 0o777 == 0o640
    for path in ("/dev/full", str(tmp_path / "no" / "file")):
        with refusal(HaptogramError):
            hexfile.write_file(path, "x")
    assert sorted(os.listdir(tmp_path)) == ["file", "link"]
