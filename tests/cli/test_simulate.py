# SPDX-License-Identifier: Apache-2.0
"""Playing an image on the Verilated core: what comes out of the pins, and what is refused or found wrong."""
import json
import math
import re
import resource
import struct

import numpy as np
import pytest
from support import BAD_INPUT, OK, RUN_FAILED, USAGE, Image, adopt, assert_one_message, exact_ticks, foci_mm, read_json, refuse, run, succeed, text

HEADER = "channel,rise_clk,fall_clk,index"


def pulses_of(path):
    lines = path.read_text().splitlines()
    assert lines[0] == HEADER
    return np.array([[int(field) for field in line.split(",")] for line in lines[1:]])


def in_order(pulses):
    return pulses[np.lexsort((pulses[:, 1], pulses[:, 0]))]


def expected_pulses(image, passes=1, cycles=None):
    """From the image's bits alone: a pulse in every cycle of every step, clocks from the first cycle on; those that touch are one, and
    so are those of two different records with one tick between them."""
    records = image.records()
    steps = [(int(w) & 0xFFFF, int(w) >> 16) for w in image.sequence()[1:]] * passes
    plays = [index for index, dwell in steps for _ in range(dwell)][:cycles]
    rows = []
    for channel in range(image.channels):
        start, last = 0, None
        for before, index in zip([None, *plays], plays):
            r = records[index - 1]
            timing, prescaler = r["timings"][channel], r["prescaler"]
            if timing < r["cycle_length"]:
                rise, fall = start + timing * prescaler, start + (timing + r["pulse_length"]) * prescaler
                if last and last[2] + (prescaler if before not in (None, index) else 0) >= rise:
                    last[2] = max(last[2], fall)
                else:
                    last = [channel, rise, fall, index]
                    rows.append(last)
            start += r["cycle_length"] * prescaler
    return np.array(rows)


def first_cycle(image, pulses):
    """The clock at which the first cycle began, from the first pulse of the channel that fires first."""
    first = image.records()[(int(image.sequence()[1]) & 0xFFFF) - 1]
    channel = int(np.argmin(first["timings"]))
    return pulses[pulses[:, 0] == channel, 1].min() - first["timings"][channel] * first["prescaler"]


MADE_ONCE = ["played"]


@pytest.fixture(scope="module")
def played(compiled, tmp_path_factory):
    """The small image, played once in each way."""
    folder = tmp_path_factory.mktemp("played")
    for name in ("image.hex", "image.json"):
        (folder / name).write_bytes((compiled / name).read_bytes())
    for load in ("direct", "uart"):
        arguments = ["simulate", "image.hex", "--load", load, "--pulses", f"{load}.csv", "--report", f"{load}.json", "--trace", f"{load}.fst"]
        result = succeed(arguments if load == "direct" else arguments[:-2], cwd=folder)
        assert result.stderr == b""
        (folder / f"{load}.txt").write_bytes(result.stdout)
    return folder


@pytest.mark.parametrize("load", ["direct", "uart"])
def test_every_pulse_is_the_image_s_to_the_clock(load, played):
    image = Image(played / "image.hex")
    pulses = in_order(pulses_of(played / f"{load}.csv"))
    expected = expected_pulses(image)
    assert len(expected) > 7000
    expected[:, 1:3] += first_cycle(image, pulses)
    assert np.array_equal(pulses, in_order(expected))


def test_both_ways_of_loading_give_the_same_pulses_shifted(played):
    direct, uart = (in_order(pulses_of(played / f"{load}.csv")) for load in ("direct", "uart"))
    shift = uart[0, 1] - direct[0, 1]
    assert shift > 100_000, "the upload takes ten bits a byte at 1 Mbaud"
    direct[:, 1:3] += shift
    assert np.array_equal(direct, uart)


def test_clocks_are_counted_from_the_first_of_the_simulation(played):
    report = read_json(played / "uart.json")
    pulses = pulses_of(played / "uart.csv")
    upload = 10 * 8 * 104 * 2 * 50  # bits of the records alone, 50 clocks each
    assert upload < pulses[:, 1].min() and pulses[:, 2].max() < report["clocks"]


def test_the_report(played):
    report = read_json(played / "direct.json")
    pulses = pulses_of(played / "direct.csv")
    assert report["points"] == report["points_checked"] == 8 and report["points_off"] == 0
    assert report["contract_violations"] == 0 and report["violations"] == []
    assert report["pulses"] == len(pulses) and report["image_bytes"] == (played / "image.hex").stat().st_size
    assert 0 < report["pulses_equal_to_image"] <= report["pulses"]
    assert 0.999 <= report["least_pressure_kept"] <= report["mean_pressure_kept"] < 1.001 and report["worst_focus_error_mm"] <= 0.2
    assert set(report["board"].values()) == {0}
    assert [r["index"] for r in report["records"]] == list(range(1, 9)) and all(8 <= r["cycles"] <= 10 for r in report["records"])
    assert report["timer"] == {key: read_json(played / "image.json")["timer"][key] for key in ("prescaler", "cycle_ticks", "pulse_ticks")}
    assert report["mclk_per_s"] > 0 and report["simulated_s"] == pytest.approx(report["clocks"] / 50e6)
    shown = text((played / "direct.txt").read_bytes())
    assert re.search(r"^contract violations +0$", shown, re.M) and re.search(rf"^clocks simulated +{report['clocks']} ", shown, re.M)


def test_the_pressure_is_that_of_the_piston_model(played):
    """Absolute pressure at each point from the image's ticks: A·Σ D(θ)/R·e^{j…}, A for the whole duty (Haptogram eq. 6 and 9)."""
    manifest = read_json(played / "image.json")
    image = Image(played / "image.hex")
    ticks = np.array([r["timings"] for r in image.records()])
    foci = foci_mm(manifest)
    expected = [np.abs(pressure_at(manifest, ticks[i], foci[i] * 1e-3)) for i in range(8)]
    assert np.allclose([r["pressure_pa"] for r in read_json(played / "direct.json")["records"]], expected, rtol=1e-3)


def bessel_j1(x):
    """By its integral, since numpy has none."""
    angle = (np.arange(400) + 0.5) * np.pi / 400
    return np.cos(angle - np.multiply.outer(x, np.sin(angle))).mean(axis=-1)


def pressure_at(manifest, ticks, point):
    elements = np.array(manifest["array"]["elements_mm"]) * 1e-3
    timer = manifest["timer"]
    k = 2 * np.pi * manifest["array"]["carrier_hz"] / manifest["medium"]["speed_m_s"]
    ray = point - elements
    distance = np.linalg.norm(ray, axis=1)
    x = k * manifest["transducer"]["radius_mm"] * 1e-3 * np.hypot(ray[:, 0], ray[:, 1]) / distance
    directivity = np.where(x < 1e-6, 1.0, 2 * bessel_j1(x) / np.maximum(x, 1e-9))
    duty = timer["pulse_ticks"] / timer["cycle_ticks"]
    phase = -2 * np.pi * ticks / timer["cycle_ticks"] - k * distance
    return np.sum(manifest["transducer"]["source_pa_m"] * np.sin(np.pi * duty) * directivity / distance * np.exp(1j * phase))


def test_the_trace_is_an_fst_file(played):
    trace = (played / "direct.fst").read_bytes()
    assert len(trace) > 10_000
    kind, length, start, end, mark = struct.unpack(">BQQQ", trace[:25]) + struct.unpack("=d", trace[25:33])
    assert (kind, length) == (0, 329) and mark == math.e, "an FST file begins with a header block of 329 bytes, and in it Euler's number"
    assert start < end, "no time passes"


@pytest.mark.check
def test_the_report_on_standard_output(small):
    result = succeed(["simulate", "image.hex", "--load", "direct", "--json"], cwd=small.folder)
    assert json.loads(result.stdout)["contract_violations"] == 0
    assert sorted(p.name for p in small.folder.iterdir()) == ["image.hex", "image.json"]
    result = succeed(["simulate", "image.hex", "--load", "direct", "--pulses", "-"], cwd=small.folder)
    assert result.stdout.startswith(HEADER.encode() + b"\n0,") and result.stdout.count(b"\n") > 7000
    result = succeed(["simulate", "image.hex", "--load", "direct", "--report", "-"], cwd=small.folder)
    assert json.loads(result.stdout)["points"] == 8


def test_two_runs_give_the_same_pulses(played, small):
    succeed(["simulate", "image.hex", "--load", "direct", "--pulses", "again.csv"], cwd=small.folder)
    assert (small.folder / "again.csv").read_bytes() == (played / "direct.csv").read_bytes()


def test_passes(small):
    succeed(["simulate", "image.hex", "--load", "direct", "--passes", "3", "--pulses", "p.csv"], cwd=small.folder)
    image = Image(small.hex)
    pulses = in_order(pulses_of(small.folder / "p.csv"))
    expected = expected_pulses(image, passes=3)
    expected[:, 1:3] += first_cycle(image, pulses)
    assert np.array_equal(pulses, in_order(expected))


@pytest.mark.parametrize("duration_ms", [0.6, 5.0])
def test_duration(duration_ms, small):
    """Shorter than a pass, and longer: the sequence repeats, and stops at a cycle's end soon after."""
    succeed(["simulate", "image.hex", "--load", "direct", "--duration", duration_ms, "--pulses", "p.csv"], cwd=small.folder)
    image = Image(small.hex)
    pulses = in_order(pulses_of(small.folder / "p.csv"))
    played_cycles = [round((pulses[:, 2].max() - first_cycle(image, pulses)) / 1250) + more for more in (-1, 0, 1)]
    assert duration_ms * 40 - 3 <= played_cycles[1] <= duration_ms * 40 + 60, "played for much longer or shorter than asked"
    for cycles in played_cycles:
        expected = expected_pulses(image, passes=8, cycles=cycles)
        expected[:, 1:3] += first_cycle(image, pulses)
        if np.array_equal(pulses, in_order(expected)):
            return
    pytest.fail("the pulses are not those of any whole number of cycles")


def test_another_board(tmp_path):
    """Sixteen channels with 12-bit timings, three of them silent, and duty below a half."""
    (tmp_path / "array.toml").write_text("[array]\nelements_mm = [" + ", ".join(f"[{7 * i - 42}, {3 * (i % 4)}]" for i in range(13)) + "]\nduty = 0.3\n"
                                         "[board]\nchannels = 16\nrecords = 40\nsequence_depth = 64\ntiming_bits = 12\nbaud = 3000000\n")
    succeed(["compile", "--shape", "circle", "--points", 5, "--rate", 800, "--center", "0,0,90", "--array", "./array.toml", "-o", "image.hex"], cwd=tmp_path)
    succeed(["simulate", "image.hex", "--pulses", "p.csv"], cwd=tmp_path)
    image = Image(tmp_path / "image.hex")
    pulses = in_order(pulses_of(tmp_path / "p.csv"))
    expected = expected_pulses(image)
    expected[:, 1:3] += first_cycle(image, pulses)
    assert np.array_equal(pulses, in_order(expected)) and set(pulses[:, 0]) == set(range(13))


@pytest.mark.check
def test_one_point(tmp_path):
    succeed(["compile", "--shape", "point", "--rate", 1000, "-o", "image.hex"], cwd=tmp_path)
    report = json.loads(succeed(["simulate", "image.hex", "--load", "direct", "--json"], cwd=tmp_path).stdout)
    assert report["points_checked"] == 1 and report["pulses"] == 40 * 100


# Wrong images that only physics can tell.


def put_timings(image, record, timings):
    for channel, timing in enumerate(timings):
        image.put16(image.record_word(record, 4 + channel), int(timing))


def tampered(small, change):
    image = Image(small.hex)
    change(image)
    image.save(small.hex)
    adopt(small.hex, small.manifest)
    return run(["simulate", "image.hex", "--load", "direct", "--json", "--pulses", "p.csv", "--report", "r.json"], cwd=small.folder)


def test_half_of_the_channels_out_of_phase(small):
    def flip(image):
        timings = np.array(image.records()[2]["timings"])
        timings[:50] = (timings[:50] + 125) % 250
        put_timings(image, 3, timings)

    result = tampered(small, flip)
    report = json.loads(result.stdout)
    assert result.returncode == RUN_FAILED and report["points_off"] == 1 and report["contract_violations"] == 0
    assert report["records"][2]["pressure_kept"] < 0.5 and report["records"][3]["pressure_kept"] > 0.999
    assert read_json(small.folder / "r.json") == report and len(pulses_of(small.folder / "p.csv")) == report["pulses"]


def test_a_focus_one_millimetre_beside(small):
    manifest = read_json(small.manifest)
    beside = foci_mm(manifest)[4:5] + [1.0, 0.0, 0.0]
    result = tampered(small, lambda image: put_timings(image, 5, np.round(exact_ticks(manifest, beside)[0]) % 250))
    report = json.loads(result.stdout)
    assert result.returncode == RUN_FAILED and report["points_off"] == 1 and report["contract_violations"] == 0
    assert report["records"][4]["focus_error_mm"] == pytest.approx(1.0, abs=0.1)


def test_a_common_shift_of_all_channels_is_the_same_focus(small):
    result = tampered(small, lambda image: put_timings(image, 5, (np.array(image.records()[4]["timings"]) + 40) % 250))
    assert result.returncode == OK, text(result.stderr)
    assert json.loads(result.stdout)["points_off"] == 0


@pytest.mark.check
def test_a_channel_that_is_silent(small):
    def silence(image):
        timings = image.records()[0]["timings"]
        put_timings(image, 1, [0xFFFF if channel in (44, 45, 54, 55) else t for channel, t in enumerate(timings)])

    result = tampered(small, silence)
    report = json.loads(result.stdout)
    assert result.returncode == RUN_FAILED and report["points_off"] == 1 and 0.9 < report["records"][0]["pressure_kept"] < 0.999


def test_the_words_say_which_points_are_off(small):
    image = Image(small.hex)
    put_timings(image, 2, [0] * 100)
    image.save(small.hex)
    adopt(small.hex, small.manifest)
    result = run(["simulate", "image.hex", "--load", "direct"], cwd=small.folder)
    assert result.returncode == RUN_FAILED
    assert re.search(r"^1 points? (is|are) off: .*", text(result.stdout + result.stderr), re.M)
    assert re.search(r"record 2|point 2", text(result.stdout + result.stderr)), "it does not say which"


# Images and manifests that do not belong together.

QUIETLY = ["simulate", "image.hex", "--load", "direct", "--pulses", "p.csv", "--report", "r.json"]


def test_an_image_for_another_array(small):
    refuse(small.folder, [*QUIETLY, "--array", "hoshi-18x18"], BAD_INPUT, outputs=("p.csv", "r.json"))
    succeed([*QUIETLY, "--array", "tile-10x10"], cwd=small.folder)


def test_an_array_of_the_same_size_but_another_pitch(small):
    (small.folder / "wide.toml").write_text("[array]\nrows = 10\ncolumns = 10\npitch_mm = 12\n")
    refuse(small.folder, [*QUIETLY, "--array", "./wide.toml"], BAD_INPUT, outputs=("p.csv",))


def test_the_manifest_of_another_image(small):
    succeed(["compile", "--shape", "line", "--points", "8", "-o", "other.hex"], cwd=small.folder)
    refuse(small.folder, [*QUIETLY, "--manifest", "other.json"], BAD_INPUT, outputs=("p.csv",))


def test_a_missing_manifest(small):
    small.manifest.unlink()
    refuse(small.folder, QUIETLY, BAD_INPUT, outputs=("p.csv",))


def drop(*path):
    def change(content):
        for key in path[:-1]:
            content = content[key]
        del content[path[-1]]

    return change


def put(value, *path):
    def change(content):
        for key in path[:-1]:
            content = content[key]
        content[path[-1]] = value

    return change


MANIFESTS = {
    "another format": put("something", "format"),
    "no format": drop("format"),
    "no elements": put([], "array", "elements_mm"),
    "too many elements": put([[i, 0, 0] for i in range(101)], "array", "elements_mm"),
    "fewer elements than channels that fire": put([[0, 0, 0], [10, 0, 0]], "array", "elements_mm"),
    "element of two numbers": put([0, 0], "array", "elements_mm", 3),
    "element of text": put("far", "array", "elements_mm", 3),
    "no timer": drop("timer", "cycle_ticks"),
    "text for a number": put("many", "timer", "cycle_ticks"),
    "timer of zero": put(0, "timer", "cycle_ticks"),
    "another timer": put(200, "timer", "cycle_ticks"),
    "another prescaler": put(4, "timer", "prescaler"),
    "negative prescaler": put(-5, "timer", "prescaler"),
    "another clock": put(40e6, "board", "clock_hz"),
    "another board": put(64, "board", "channels"),
    "one record less": drop("records", 7),
    "focus of text": put(["a", "b", "c"], "records", 2, "focus_mm"),
    "focus that is null": put([None, 0, 130], "records", 2, "focus_mm"),
    "sound that stands still": put(0, "medium", "speed_m_s"),
    "an array instead of an object": put([], "medium"),
    "other dwells": put(3, "records", 2, "dwell_cycles"),
}


@pytest.mark.parametrize("case", MANIFESTS)
def test_a_manifest_that_is_wrong(case, small):
    change = MANIFESTS[case]
    content = read_json(small.manifest)
    change(content)
    small.manifest.write_text(json.dumps(content))
    refuse(small.folder, QUIETLY, BAD_INPUT, outputs=("p.csv",))


@pytest.mark.parametrize("content", [b"", b"{", b"[]", b"null", b"\xff\xfe", b"haptogram", b"{}"], ids=repr)
def test_a_manifest_that_is_none(content, small):
    small.manifest.write_bytes(content)
    refuse(small.folder, QUIETLY, BAD_INPUT, outputs=("p.csv",))


def test_a_manifest_that_is_cut_short(small):
    small.manifest.write_bytes(small.manifest.read_bytes()[:3000])
    refuse(small.folder, QUIETLY, BAD_INPUT, outputs=("p.csv",))


def test_an_image_for_a_clock_that_no_model_has(tmp_path):
    (tmp_path / "slow.toml").write_text("[array]\nrows = 2\ncolumns = 2\npitch_mm = 10\n[board]\nclock_hz = 40000000\nchannels = 16\n")
    succeed(["compile", "--shape", "point", "--array", "./slow.toml", "-o", "image.hex"], cwd=tmp_path)
    refuse(tmp_path, QUIETLY, BAD_INPUT, outputs=("p.csv",))


# The field that measured pulses make.


@pytest.fixture(scope="module")
def single(tmp_path_factory):
    folder = tmp_path_factory.mktemp("single")
    succeed(["compile", "--shape", "point", "--center", "10,-5,130", "--rate", 2000, "-o", "image.hex"], cwd=folder)
    succeed(["simulate", "image.hex", "--load", "direct", "--pulses", "p.csv"], cwd=folder)
    return folder


def field_of(folder, *arguments):
    result = succeed(["field", "--pulses", "p.csv", "--manifest", "image.json", *arguments], cwd=folder)
    header, *rows = text(result.stdout).splitlines()
    computed, level = result.stderr.splitlines()
    assert b" points by " in computed and level.startswith(b"nominal level")
    return header, np.array([[float(value) for value in row.split(",")] for row in rows])


@pytest.mark.check
def test_the_field_peaks_at_the_focus(single):
    header, field = field_of(single, "--extent", "20", "--step", "1")
    assert header == "x_mm,y_mm,radiation_pressure_pa" and len(field) == 41 * 41
    assert np.array_equal(field[:3, :2], [[-20, -20], [-19, -20], [-18, -20]]) and np.all(field[:, 2] >= 0)
    assert np.abs(field[np.argmax(field[:, 2]), :2] - [10, -5]).max() <= 1


@pytest.mark.check
def test_the_field_is_that_of_the_piston_model(single):
    """P = α p_rms² / (ρ c²), α = 2 (Hoshi eq. 1–2), from the image's ticks."""
    _, field = field_of(single, "--extent", "60", "--step", "20")
    manifest = read_json(single / "image.json")
    ticks = np.array(Image(single / "image.hex").records()[0]["timings"])
    medium = manifest["medium"]
    expected = [np.abs(pressure_at(manifest, ticks, np.array([x, y, 130]) * 1e-3)) ** 2 / (medium["density_kg_m3"] * medium["speed_m_s"] ** 2) for x, y in field[:, :2]]
    assert np.allclose(field[:, 2], expected, rtol=2e-3, atol=1e-5 * max(expected))


def test_other_planes_and_a_file(single):
    header, field = field_of(single, "--plane", "xz@y=-5", "--extent", "100", "--step", "10")
    assert header == "x_mm,z_mm,radiation_pressure_pa" and field[:, 1].min() == 10 and field[:, 1].max() == 200
    assert abs(field[np.argmax(field[:, 2]), 0] - 10) <= 10
    header, _ = field_of(single, "--plane", "yz@x=10", "--extent", "100", "--step", "50")
    assert header == "y_mm,z_mm,radiation_pressure_pa"
    shown = succeed(["field", "--pulses", "p.csv", "--manifest", "image.json", "--step", "40"], cwd=single).stdout
    assert succeed(["field", "--pulses", "p.csv", "--manifest", "image.json", "--step", "40", "-o", "f.csv"], cwd=single).stdout == b""
    assert (single / "f.csv").read_bytes() == shown


FIELD = {
    "unknown plane": ["--plane", "ab@c=1"],
    "NaN plane": ["--plane", "xy@z=nan"],
    "plane behind the array": ["--plane", "xy@z=-5"],
    "no step": ["--step", "0"],
    "NaN step": ["--step", "nan"],
    "step beyond the extent": ["--step", "90"],
    "negative extent": ["--extent", "-1"],
    "infinite extent": ["--extent", "inf"],
    "NaN extent": ["--extent", "nan"],
    "step too small": ["--step", "0.001"],
    "step absurdly small": ["--step", "1e-12"],
}


@pytest.mark.parametrize("case", FIELD)
def test_field_options_out_of_range(case, single):
    arguments = FIELD[case]
    # With little memory and time, so that one that tries all the same hurts nobody else.
    result = run(["field", "--pulses", "p.csv", "--manifest", "image.json", *arguments], cwd=single, timeout=300,
                 preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (1 << 30, 1 << 30)))
    assert_one_message(result, USAGE)


PULSES = {
    "empty": "",
    "cut short": f"{HEADER}\n0,10,20,1\n0,1260,12",
    "no pulses": f"{HEADER}\n",
    "no header": "0,10,20,1\n",
    "three columns": f"{HEADER}\n0,10,20\n",
    "a fraction": f"{HEADER}\n0,10,20.5,1\n",
    "negative": f"{HEADER}\n0,-10,20,1\n",
    "fall before rise": f"{HEADER}\n0,20,10,1\n",
    "another array's": f"{HEADER}\n100,10,20,1\n",
    "another image's": f"{HEADER}\n0,10,20,2\n",
    "index that 16 bits do not hold": f"{HEADER}\n0,10,20,65537\n",
}


@pytest.mark.parametrize("case", PULSES)
def test_pulses_that_cannot_be_used(case, single, tmp_path):
    content = PULSES[case]
    (tmp_path / "p.csv").write_text(content)
    (tmp_path / "image.json").write_bytes((single / "image.json").read_bytes())
    refuse(tmp_path, ["field", "--pulses", "p.csv", "--manifest", "image.json", "--step", "40", "-o", "f.csv"], BAD_INPUT, outputs=("f.csv",))


def test_sixteen_phases_are_what_was_asked_for(tmp_path):
    """The limit follows from the segments that the image declares: sin(x)/x of the pressure at x = π/16 is expected."""
    succeed(["compile", "--shape", "circle", "--diameter", 40, "--points", 6, "--rate", 500, "--quantise", "hoshi", "-o", "segments.hex"], cwd=tmp_path)
    result = run(["simulate", "segments.hex", "--load", "direct", "--json"], cwd=tmp_path, timeout=300)
    report = json.loads(result.stdout)
    assert result.returncode == OK and report["points_off"] == 0 and report["contract_violations"] == 0
    x = np.pi / 16
    assert report["mean_pressure_kept"] == pytest.approx(np.sin(x) / x, abs=0.003) and report["least_pressure_kept"] < 0.999
    assert all(record["least_kept_allowed"] == pytest.approx(0.9861, abs=2e-4) for record in report["records"])
    exact = read_json(tmp_path / "segments.json")
    del exact["quantise"]
    (tmp_path / "segments.json").write_text(json.dumps(exact), encoding="utf-8")
    assert run(["simulate", "segments.hex", "--load", "direct", "--json"], cwd=tmp_path, timeout=300).returncode == RUN_FAILED
