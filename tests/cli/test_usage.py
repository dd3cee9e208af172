# SPDX-License-Identifier: Apache-2.0
"""Command lines that make no sense: exit code 2, one message that names the option, what was found and what was expected."""
import json
import re

import pytest
from support import BAD_INPUT, OK, USAGE, assert_one_message, read_json, refuse, run, snapshot, succeed, text

CIRCLE = ["compile", "--shape", "circle", "-o", "image.hex"]


@pytest.mark.check
def test_version_and_help_are_data():
    result = succeed(["--version"])
    said = r"haptogram \d+\.\d+\.\d+\ncommit: ([0-9a-f]{7,}(-dirty)?|unknown)\nbuilt with: feel hands serve formats calibration live papers robot scattering studio .*\btile-100 .*\n"
    assert re.fullmatch(said, text(result.stdout)) and result.stderr == b""
    for command in ([], ["compile"], ["inspect"], ["simulate"], ["field"]):
        result = succeed([*command, "--help"])
        assert b"Exit codes: 0 ok, 1 run failed, 2 usage, 3 bad input, 4 device or link." in result.stdout and result.stderr == b""


def test_no_subcommand(tmp_path):
    refuse(tmp_path, [], USAGE)


def test_an_unknown_subcommand(tmp_path):
    refuse(tmp_path, ["compil"], USAGE)


def test_an_unknown_option(tmp_path):
    refuse(tmp_path, [*CIRCLE, "--pionts", "3"], USAGE)


def test_nothing_to_compile(tmp_path):
    refuse(tmp_path, ["compile"], USAGE)


def test_a_subcommand_without_its_file(tmp_path):
    refuse(tmp_path, ["inspect"], USAGE)
    refuse(tmp_path, ["simulate"], USAGE)


NUMBERS = {
    "no rate": ["--rate", "0"],
    "negative rate": ["--rate", "-1"],
    "NaN rate": ["--rate", "nan"],
    "infinite rate": ["--rate", "inf"],
    "minus infinite rate": ["--rate=-inf"],
    "word for a rate": ["--rate", "fast"],
    "no points": ["--points", "0"],
    "negative points": ["--points", "-1"],
    "huge points": ["--points", "99999999999999999999"],
    "65,536 points": ["--points", "65536"],
    "one and a half points": ["--points", "1.5"],
    "word for points": ["--points", "many"],
    "negative seed": ["--seed", "-1"],
    "seed of 65 bits": ["--seed", "18446744073709551616"],
    "loops that 16 bits do not hold": ["--loops", "65536"],
    "negative loops": ["--loops", "-1"],
    "no size": ["--size", "0"],
    "negative size": ["--size", "-5"],
    "NaN size": ["--size", "nan"],
    "infinite size": ["--size", "inf"],
    "word for a size": ["--size", "large"],
    "no scale": ["--scale", "0"],
    "NaN scale": ["--scale", "nan"],
    "infinite scale": ["--scale", "inf"],
    "negative diameter": ["--diameter", "-7"],
    "NaN diameter": ["--diameter", "nan"],
    "two numbers for a centre": ["--center", "0,0"],
    "four numbers for a centre": ["--center", "0,0,100,0"],
    "NaN centre": ["--center", "0,0,nan"],
    "infinite turn": ["--rotate", "0,0,inf"],
    "unknown unit": ["--unit", "furlong"],
}


@pytest.mark.parametrize("case", NUMBERS)
def test_a_value_out_of_range(case, tmp_path):
    arguments = NUMBERS[case]
    refuse(tmp_path, [*CIRCLE, *arguments], USAGE)


MEANINGLESS = {
    "unknown shape": ["compile", "--shape", "blob"],
    "height of a circle": [*CIRCLE, "--height", "5"],
    "sides of a circle": [*CIRCLE, "--sides", "5"],
    "polygon of two sides": ["compile", "--shape", "polygon", "--sides", "2"],
    "size of a point": ["compile", "--shape", "point", "--size", "5"],
    "measure of a shape without a shape": ["compile", "cloud.xyz", "--diameter", "70"],
    "image on stdout without a manifest": ["compile", "--shape", "circle", "-o", "-"],
    "image and manifest in one place": ["compile", "--shape", "circle", "-o", "image.json"],
    "image and manifest in one named place": [*CIRCLE, "--manifest", "image.hex"],
    "image and manifest in one place, spelled twice": [*CIRCLE, "--manifest", "./image.hex"],
    "image and manifest both on stdout": ["compile", "--shape", "circle", "-o", "-", "--manifest", "-"],
    "manifest and words in one place": [*CIRCLE, "--manifest", "a.primary.mem", "--readmemh", "a"],
    "output over the input": ["compile", "cloud.xyz", "-o", "cloud.xyz"],
}


@pytest.mark.parametrize("case", MEANINGLESS)
def test_options_that_make_no_sense_together(case, tmp_path):
    (tmp_path / "cloud.xyz").write_bytes(b"0 0 100\n9 0 100\n0 9 100\n")
    arguments = MEANINGLESS[case]
    refuse(tmp_path, arguments, USAGE)


def test_no_name_for_the_image(tmp_path):
    result = run(["compile", "--shape", "circle", "-o", ""], cwd=tmp_path)
    assert_one_message(result, result.returncode)
    assert result.returncode in (USAGE, BAD_INPUT) and snapshot(tmp_path) == {}


def test_manifest_on_stdout_is_only_the_manifest(tmp_path):
    result = succeed([*CIRCLE, "--points", 4, "--manifest", "-"], cwd=tmp_path)
    assert json.loads(result.stdout)["format"].startswith("haptogram-manifest")


SIMULATE = {
    "passes and duration": ["--passes", "2", "--duration", "3"],
    "no passes": ["--passes", "0"],
    "negative passes": ["--passes", "-1"],
    "negative duration": ["--duration", "-1"],
    "no duration": ["--duration", "0"],
    "NaN duration": ["--duration", "nan"],
    "infinite duration": ["--duration", "inf"],
    "unknown way to load": ["--load", "usb"],
    "pulses and report in one place": ["--pulses", "x", "--report", "x"],
    "pulses and report both on stdout": ["--pulses", "-", "--report", "-"],
    "pulses and JSON both on stdout": ["--pulses", "-", "--json"],
    "pulses over the image": ["--pulses", "image.hex"],
    "report over the manifest": ["--report", "image.json"],
    "trace on stdout": ["--trace", "-"],
}


@pytest.mark.parametrize("case", SIMULATE)
def test_simulate_options_that_make_no_sense(case, small):
    arguments = SIMULATE[case]
    refuse(small.folder, ["simulate", "image.hex", "--load", "direct", *arguments], USAGE, outputs=())


def test_a_rate_too_high(tmp_path):
    refuse(tmp_path, [*CIRCLE, "--points", "200", "--rate", "201"], BAD_INPUT)
    refuse(tmp_path, [*CIRCLE, "--points", "1", "--rate", "40001"], BAD_INPUT)


def test_a_rate_that_no_number_of_points_can_reach(tmp_path):
    arguments = [*CIRCLE, "--rate", "9e5"]
    refuse(tmp_path, arguments, BAD_INPUT)
    assert b"or 0 points" not in run(arguments, cwd=tmp_path).stderr, "it advises to take no points"


@pytest.mark.parametrize("rate", ["0.001", "1e-6"])
def test_a_rate_too_low(rate, tmp_path):
    refuse(tmp_path, [*CIRCLE, "--points", "1", "--rate", rate], BAD_INPUT)


def test_the_lowest_and_the_highest_rate_can_be_reached(tmp_path):
    succeed([*CIRCLE, "--points", 200, "--rate", 200], cwd=tmp_path)
    assert {r["dwell_cycles"] for r in read_json(tmp_path / "image.json")["records"]} == {1}
    succeed([*CIRCLE, "--points", 1, "--rate", 0.6104], cwd=tmp_path)
    assert 65000 < read_json(tmp_path / "image.json")["records"][0]["dwell_cycles"] <= 65535


@pytest.mark.parametrize("count", [1, 2, 3, 400])
def test_odd_numbers_of_points(count, tmp_path):
    for shape in ("line", "circle", "sphere", "plus"):
        if (shape, count) == ("plus", 2):
            continue  # one point in the middle of each stroke, and that is the same place
        succeed(["compile", "--shape", shape, "--points", count, "--size", 40, "-o", "image.hex"], cwd=tmp_path)
        assert len(read_json(tmp_path / "image.json")["records"]) == count
        assert run(["inspect", "image.hex"], cwd=tmp_path).returncode == OK


def test_one_point_more_than_the_board_holds(tmp_path):
    refuse(tmp_path, [*CIRCLE, "--points", "401"], BAD_INPUT)
    refuse(tmp_path, [*CIRCLE, "--points", "65535"], BAD_INPUT)


def test_a_cloud_with_more_points_than_the_board_is_thinned(tmp_path):
    (tmp_path / "cloud.xyz").write_text("".join(f"{i % 30} {i // 30} 120\n" for i in range(900)))
    refuse(tmp_path, ["compile", "cloud.xyz", "--points", "500"], BAD_INPUT)
    succeed(["compile", "cloud.xyz", "--points", 400, "-o", "image.hex"], cwd=tmp_path)
    assert len(read_json(tmp_path / "image.json")["records"]) == 400


@pytest.mark.parametrize(("typed", "plain"), [("4cm", "40"), ("0.04 m", "40"), ("40mm", "40"), ("40000um", "40"), ("2in", "50.8"), ("4,2cm", None), ("4furlong", None), ("cm", None), ("", None)])
def test_a_length_may_carry_its_unit(typed, plain, tmp_path):
    if plain is None:
        assert_one_message(run([*CIRCLE, "--diameter", typed], cwd=tmp_path), USAGE)
        return
    for words in (typed, plain):
        succeed([*CIRCLE, "--diameter", words], cwd=tmp_path)
        (tmp_path / "image.hex").rename(tmp_path / f"{words}.hex")
    assert (tmp_path / f"{typed}.hex").read_bytes() == (tmp_path / f"{plain}.hex").read_bytes()


def test_other_values_may_carry_their_units():
    for typed, plain in ((["--volts", "9V"], ["--volts", "9"]), (["--volts", "9000 mV"], ["--volts", "9"])):
        one, other = (succeed(["board", "power", "ice40-hx8k-breakout", *words]).stdout for words in (typed, plain))
        assert one == other
    one, other = (succeed(["magnitude", "2", "--frequency", words]).stdout for words in ("0.2kHz", "200"))
    assert one == other


# What a help mentions beside the unit of its value.
@pytest.mark.parametrize("words", [["align", "--still", "70cm"], ["analyze", "--measured-mn", "5m"], ["live", "--damping", "2N"], ["robot", "explore", "--speed", "5cm"],
                                   ["robot", "tell", "--low", "2kHz"], ["feel", "--level", "2mm"], ["feel", "--volts", "2s"]], ids=str)  # fmt: skip
def test_a_unit_of_another_kind_is_refused(words, tmp_path):
    result = run(words, cwd=tmp_path)
    assert_one_message(result, USAGE)
    assert words[-1] in text(result.stderr)


@pytest.mark.parametrize("words", [["align", "--still", "700ms"], ["live", "--latency", "0.02s"], ["feel", "--grip", "900 mN"], ["field", "--extent", "8cm"]], ids=str)
def test_a_unit_of_the_same_kind_is_taken(words, tmp_path):
    result = run(words, cwd=tmp_path)
    assert result.returncode == USAGE and words[-1] not in text(result.stderr), "what is missing is something else"


def test_a_place_is_in_one_unit(tmp_path):
    assert_one_message(run(["compile", "--shape", "circle", "--center", "0,0,15cm"], cwd=tmp_path), USAGE)


@pytest.mark.parametrize("words", [["compile", "--rate"], ["board", "power"], ["field", "--focus", 0, 0, 150], [], ["compile", "--diametre", 4], ["compile", "--center", "1,2"]], ids=str)
def test_a_wrong_use_is_told_in_one_form(words, tmp_path):
    assert_one_message(run(words, cwd=tmp_path), USAGE)


@pytest.mark.parametrize(("typed", "meant"), [("complie", "compile"), ("simulat", "simulate"), ("device inof", "info"), ("play x", None), ("zzzzzzzz", None)])
def test_a_mistyped_command(typed, meant, tmp_path):
    result = run(typed.split(), cwd=tmp_path)
    assert_one_message(result, USAGE)
    assert (b"did you mean" in result.stderr) == (meant is not None)


def test_a_project_and_a_shape_beside_it(tmp_path):
    (tmp_path / "ring.toml").write_text('format = "haptogram-project-1"\npoints = 8\n[[shape]]\nkind = "circle"\n')
    succeed(["compile", "ring.toml", "-o", "image.hex"], cwd=tmp_path)
    refuse(tmp_path, ["compile", "ring.toml", "--shape", "circle"], USAGE)


@pytest.mark.parametrize("number", ["1e300", "-2e6", "1000001"])
def test_a_place_beyond_all_bounds_is_not_printed_in_300_digits(number, tmp_path):
    assert_one_message(run(["field", f"--focus=0,0,{number}"], cwd=tmp_path), USAGE)
