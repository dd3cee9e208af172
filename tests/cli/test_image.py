# SPDX-License-Identifier: Apache-2.0
"""The Intel HEX image, read by Python's intelhex and judged by a focal law of its own; and what inspect says about it."""
import json
import re

import numpy as np
import pytest
from intelhex import IntelHex
from support import BAD_INPUT, DESCRIPTION, OK, RUN_FAILED, SEQUENCE, SILENT, Image, assert_one_message, exact_ticks, foci_mm, read_json, refuse, run, succeed, text


@pytest.fixture(scope="module")
def images(tmp_path_factory):
    """Images of several boards, rates and shapes."""
    folder = tmp_path_factory.mktemp("images")
    (folder / "odd.toml").write_text(
        "[array]\nrows = 3\ncolumns = 4\npitch_mm = 8.5\ncarrier_hz = 31250.0\nduty = 0.25\n[medium]\nspeed_m_s = 331.7\n"
        "[board]\nchannels = 16\nclock_hz = 40_000_000\nrecords = 40\nsequence_depth = 64\ntiming_bits = 12\n")
    (folder / "prime.toml").write_text("[array]\nrows = 5\ncolumns = 5\npitch_mm = 11.3\nduty = 0.3\n[board]\nclock_hz = 27_000_000\nchannels = 31\n")
    cases = {
        "circle": ["--shape", "circle", "--points", "8", "--rate", "500"],
        "sphere": ["--shape", "sphere", "--points", "400", "--loops", "7"],
        "hoshi": ["--shape", "cube", "--points", "50", "--center", "0,0,200", "--array", "hoshi-18x18"],
        "odd": ["--shape", "helix", "--points", "40", "--array", "odd.toml", "--rate", "20"],
        "prime": ["--shape", "cone", "--points", "60", "--array", "./prime.toml", "--size", "70"],
        "one": ["--shape", "point"],
    }
    for name, arguments in cases.items():
        succeed(["compile", *arguments, "-o", f"{name}.hex"], cwd=folder)
    return folder


NAMES = ["circle", "sphere", "hoshi", "odd", "prime", "one"]


@pytest.mark.parametrize("name", NAMES)
def test_the_address_map(name, images):
    """Dense records from address 0 on, the sequence, the description, and nothing else."""
    image = Image(images / f"{name}.hex")
    manifest = read_json(images / f"{name}.json")
    records = len(manifest["records"])
    board = manifest["board"]
    assert image.hex.segments() == [
        (0, 2 * records * (board["channels"] + 4)),
        (SEQUENCE, SEQUENCE + 4 * (records + 1)),
        (DESCRIPTION, DESCRIPTION + 16),
    ]
    clock = int(board["clock_hz"])
    assert image.described.tolist() == [0x4748, 1, board["channels"], records, records + 1, board["pulse_bits"] << 8 | board["timing_bits"],
                                        clock & 0xFFFF, clock >> 16]


@pytest.mark.parametrize("name", NAMES)
def test_every_record_says_the_timer_and_the_focal_law(name, images):
    image = Image(images / f"{name}.hex")
    manifest = read_json(images / f"{name}.json")
    timer = manifest["timer"]
    elements = len(manifest["array"]["elements_mm"])
    exact = exact_ticks(manifest, foci_mm(manifest))
    records = image.records()
    for record in records:
        assert (record["cycle_length"], record["prescaler"], record["pulse_length"]) == (timer["cycle_ticks"], timer["prescaler"], timer["pulse_ticks"])
        assert record["timings"][elements:] == [SILENT] * (image.channels - elements)
    ticks = np.array([record["timings"][:elements] for record in records])
    assert ticks.min() >= 0 and ticks.max() < timer["cycle_ticks"]
    expected = np.floor(exact + 0.5) % timer["cycle_ticks"]
    certain = np.abs(exact % 1 - 0.5) > 0.02  # not where rounding turns
    assert certain.mean() > 0.9
    assert np.array_equal(ticks[certain], expected[certain])
    apart = np.abs(ticks - exact)
    assert np.minimum(apart, timer["cycle_ticks"] - apart).max() <= 0.52
    assert ticks.std() > 1 or name == "one", "all timings alike would be no focus"


@pytest.mark.parametrize("name", NAMES)
def test_the_timer_makes_the_carrier(name, images):
    manifest = read_json(images / f"{name}.json")
    timer, board = manifest["timer"], manifest["board"]
    assert timer["tick_s"] == pytest.approx(timer["prescaler"] / board["clock_hz"], rel=1e-12)
    carrier = board["clock_hz"] / (timer["prescaler"] * timer["cycle_ticks"])
    assert carrier == pytest.approx(manifest["array"]["carrier_hz"], rel=100e-6)
    assert timer["pulse_ticks"] == pytest.approx(manifest["array"]["duty"] * timer["cycle_ticks"], abs=0.5)
    assert timer["pulse_ticks"] < 1 << board["pulse_bits"] and timer["cycle_ticks"] < 1 << board["timing_bits"]


@pytest.mark.parametrize("name", NAMES)
def test_the_sequence_plays_every_record_for_its_dwell(name, images):
    words = Image(images / f"{name}.hex").sequence()
    manifest = read_json(images / f"{name}.json")
    assert words[0] & 0xFFFF == len(manifest["records"]) and words[0] >> 16 == (7 if name == "sphere" else 0)
    assert [(int(w) & 0xFFFF, int(w) >> 16) for w in words[1:]] == [(r["index"], r["dwell_cycles"]) for r in manifest["records"]]


@pytest.mark.parametrize("name", NAMES)
def test_inspect_reads_the_same_bits(name, images):
    image = Image(images / f"{name}.hex")
    seen = json.loads(succeed(["inspect", f"{name}.hex", "--json"], cwd=images).stdout)
    assert seen["records"] == image.records()
    words = image.sequence()
    assert seen["loops"] == words[0] >> 16
    assert [(e["index"], e["dwell_cycles"]) for e in seen["sequence"]] == [(int(w) & 0xFFFF, int(w) >> 16) for w in words[1:]]
    described = image.described.astype(int)
    assert (seen["channels"], seen["clock_hz"]) == (described[2], described[6] | described[7] << 16)
    assert (seen["pulse_bits"], seen["timing_bits"]) == (described[5] >> 8, described[5] & 0xFF)
    assert seen["problems"] == []


@pytest.mark.check
def test_inspect_as_text(compiled):
    shown = text(succeed(["inspect", "image.hex"], cwd=compiled).stdout)
    assert "100 channels, 50000000 Hz clock" in shown and "8 records" in shown and "8 sequence entries, repeated for ever" in shown
    timings = Image(compiled / "image.hex").records()[4]["timings"]
    assert re.search(rf"^ +5 +250 +5 +125 +100 +{min(timings)}…{max(timings)}$", shown, re.M)
    assert re.search(r"^ +8 +8 +10$", shown, re.M)
    assert "checks: checksums, regions, records and sequence are in order" in shown


@pytest.mark.check
def test_a_file_that_another_program_wrote(small):
    """The same bytes in intelhex's own arrangement, with Windows line ends and small letters."""
    before = json.loads(succeed(["inspect", "image.hex", "--json"], cwd=small.folder).stdout)
    IntelHex(str(small.hex)).write_hex_file(str(small.folder / "other.hex"), byte_count=7, eolstyle="CRLF")
    (small.folder / "lower.hex").write_bytes((small.folder / "other.hex").read_bytes().lower())
    for name in ("other.hex", "lower.hex"):
        assert json.loads(succeed(["inspect", name, "--json"], cwd=small.folder).stdout) == before
    result = run(["inspect", "-"], cwd=small.folder, stdin=(small.folder / "other.hex").open("rb"))
    assert result.returncode == OK


# Images that could be read but would not play.

PROBLEMS = {
    "pulse as long as the cycle": (lambda i: (i.put16(i.record_word(3, 0), 125), i.put16(i.record_word(3, 1), 125 << 8)), "record 3.*125"),
    "pulse longer than the cycle": (lambda i: i.put16(i.record_word(3, 0), 100), "record 3.*125.*100"),
    "cycle 0": (lambda i: (i.put16(i.record_word(8, 0), 0), i.put16(i.record_word(8, 1), 0)), "record 8.*0"),
    "prescaler 0": (lambda i: i.put16(i.record_word(5, 2), 0), "record 5.*prescaler 0"),
    "index beyond the records": (lambda i: i.put32(SEQUENCE + 4 * 2, 9 | 10 << 16), "entry 2.*index 9.*8 records"),
    "dwell 0": (lambda i: i.put32(SEQUENCE + 4 * 4, 4), "entry 4.*dwell 0"),
}


@pytest.mark.parametrize("case", PROBLEMS)
def test_inspect_finds_what_would_not_play(case, small):
    change, needle = PROBLEMS[case]
    image = Image(small.hex)
    change(image)
    image.save(small.hex)
    result = run(["inspect", "image.hex"], cwd=small.folder)
    assert result.returncode == RUN_FAILED and result.stderr == b""
    assert re.search("checks: 1 problems?\n +.*" + needle, text(result.stdout))
    result = run(["inspect", "image.hex", "--json"], cwd=small.folder)
    found = json.loads(result.stdout)["problems"]
    assert result.returncode == RUN_FAILED and len(found) == 1 and re.search(needle, found[0])


@pytest.mark.parametrize("case", PROBLEMS)
def test_simulate_refuses_what_would_not_play(case, small):
    image = Image(small.hex)
    PROBLEMS[case][0](image)
    image.save(small.hex)
    refuse(small.folder, ["simulate", "image.hex", "--pulses", "pulses.csv"], BAD_INPUT, outputs=("pulses.csv",))


# Images that cannot be read.


def line_of(folder, number):
    return (folder / "image.hex").read_text().splitlines()[number - 1]


def with_line(content, number, line):
    lines = content.decode().splitlines(keepends=True)
    lines[number - 1] = line + "\n"
    return "".join(lines).encode()


def record(kind, offset, data=b""):
    body = bytes([len(data), offset >> 8, offset & 0xFF, kind]) + data
    return ":" + (body + bytes([-sum(body) & 0xFF])).hex().upper() + "\n"


def change_digit(content, number):
    line = content.decode().splitlines()[number - 1]
    return with_line(content, number, line[:12] + ("0" if line[12] != "0" else "1") + line[13:])


UNREADABLE = {
    "empty": lambda c: b"",
    "only line ends": lambda c: b"\n\n",
    "garbage": lambda c: b"\x7fELF\x02\x01\x01\0\xff\xfe",
    "bad checksum": lambda c: change_digit(c, 5),
    "a digit that is none": lambda c: with_line(c, 7, c.decode().splitlines()[6][:20] + "X" + c.decode().splitlines()[6][21:]),
    "a line cut short": lambda c: with_line(c, 9, c.decode().splitlines()[8][:-6]),
    "a line without its colon": lambda c: with_line(c, 4, c.decode().splitlines()[3][1:]),
    "cut between two lines": lambda c: b"".join(c.splitlines(keepends=True)[:20]),
    "cut within a line": lambda c: c[: len(c) // 2 + 5],
    "no end record": lambda c: c.replace(b":00000001FF\n", b""),
    "text after the end": lambda c: c + b"and more\n",
    "two files in one": lambda c: c + c,
    "overlapping records": lambda c: c.replace(b":00000001FF\n", (record(4, 0, b"\0\0") + record(0, 8, b"\1\2") + ":00000001FF\n").encode()),
    "overlap by one byte": lambda c: with_line(c, 2, record(0, 0x0F, b"\1" * 16).strip()),
    "a line left out": lambda c: with_line(c, 6, ""),
    "unknown record type": lambda c: record(9, 0).encode() + c,
    "a start address": lambda c: record(5, 0, b"\0\0\1\0").encode() + c,
    "an address of one byte": lambda c: record(4, 0, b"\0").encode() + c,
    "data where no region is": lambda c: record(4, 0, b"\x55\x55").encode() + record(0, 0, b"\1\2").encode() + record(4, 0, b"\0\0").encode() + c,
    "over the end of the address space": lambda c: record(4, 0, b"\xff\xff").encode() + record(0, 0xFFFF, b"\1\2").encode() + c,
    "no image at all": lambda c: record(0, 0, b"\1\2\3\4").encode() + b":00000001FF\n",
    "a manifest": lambda c: b'{\n "format": "haptogram-manifest-1"\n}\n',
    "a shape": lambda c: b"ply\nformat ascii 1.0\n",
}


@pytest.mark.parametrize("case", UNREADABLE)
@pytest.mark.parametrize("command", ["inspect", "simulate"])
def test_an_image_that_cannot_be_read(case, command, small):
    damage = UNREADABLE[case]
    small.hex.write_bytes(damage(small.hex.read_bytes()))
    refuse(small.folder, [command, "image.hex"], BAD_INPUT, outputs=())


DESCRIPTIONS = {
    "another magic": (0, 0x1234),
    "another format": (1, 2),
    "no channels": (2, 0),
    "more channels than there are": (2, 101),
    "no records": (3, 0),
    "more records than there are": (3, 9),
    "more sequence words than there are": (4, 10),
}


@pytest.mark.parametrize("case", DESCRIPTIONS)
def test_a_description_that_does_not_fit(case, small):
    word, value = DESCRIPTIONS[case]
    image = Image(small.hex)
    image.put16(DESCRIPTION + 2 * word, value)
    image.save(small.hex)
    refuse(small.folder, ["inspect", "image.hex"], BAD_INPUT, outputs=())


def test_a_sequence_header_that_does_not_fit(small):
    image = Image(small.hex)
    image.put16(SEQUENCE, 7)
    image.save(small.hex)
    refuse(small.folder, ["inspect", "image.hex"], BAD_INPUT, outputs=())


def test_reserved_bits_in_a_record(small):
    image = Image(small.hex)
    image.put16(image.record_word(2, 3), 0x0200)
    image.save(small.hex)
    refuse(small.folder, ["inspect", "image.hex"], BAD_INPUT, outputs=())


@pytest.mark.parametrize("command", ["inspect", "simulate"])
def test_no_such_image(command, tmp_path):
    refuse(tmp_path, [command, "nowhere.hex"], BAD_INPUT, outputs=())
    (tmp_path / "folder.hex").mkdir()
    refuse(tmp_path, [command, "folder.hex"], BAD_INPUT, outputs=())


def test_the_first_bad_line_is_named_among_many(small):
    small.hex.write_bytes(change_digit(change_digit(small.hex.read_bytes(), 30), 12))
    assert_one_message(run(["inspect", "image.hex"], cwd=small.folder), BAD_INPUT)
