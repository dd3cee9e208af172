# SPDX-License-Identifier: Apache-2.0
"""The tasks of Fingers' experiments: `haptogram task`."""

import json

import pytest
from support import BAD_INPUT, USAGE, refuse, succeed


def test_a_seen_cube_is_lifted_and_makes_no_energy():
    found = json.loads(succeed(["task", "lift", "--trials", "1", "--seed", "3", "--json"]).stdout)
    assert found["task"] == "lift" and found["sight"] == "seen" and found["lifted"] == 1
    trial = found["trials"][0]
    assert trial["lifted_mm"] >= 50 and trial["time_s"] > 1.5 and trial["mean_force_n"] > 0.1 * 9.8
    assert found["energy_made_mj"] < 0.02


@pytest.mark.deep
def test_the_same_seed_gives_the_same_trials():
    first, second = (succeed(["task", "surface", "--trials", "1", "--seed", "5", "--json"]).stdout for _ in range(2))
    assert first == second
    trial = json.loads(first)["trials"][0]
    assert abs(trial["answer_deg"] - trial["asked_deg"]) == abs(trial["angle_error_deg"])


@pytest.mark.deep
def test_a_ring_helps_a_finger_and_nothing_leaves_it_guessing():
    found = {}
    for felt in ("dynamic", "none"):
        words = ["task", "surface", "--trials", "4", "--seed", "2", "--angle", "-30", "--height", "4", "--felt", felt, "--json"]
        found[felt] = json.loads(succeed(words, timeout=300).stdout)
    assert all(t["asked_deg"] == -30 and t["asked_mm"] == 4 and not t["guessed"] and t["felt_places"] >= 2 for t in found["dynamic"]["trials"])
    assert all(t["guessed"] and t["felt_places"] == 0 for t in found["none"]["trials"])
    assert found["dynamic"]["level"]["note"].startswith("nominal") and "level" not in found["none"]  # of what is felt
    assert found["none"]["answered"] == 0 and found["dynamic"]["answered"] == 4
    assert found["dynamic"]["mean_angle_error_deg"] < 25 < found["none"]["mean_angle_error_deg"]


def test_what_it_cannot_use_is_named(tmp_path):
    refuse(tmp_path, ["task", "lift", "--rig", "nothing"], BAD_INPUT)
    refuse(tmp_path, ["task", "lift", "--felt", "warm"], USAGE)
    refuse(tmp_path, ["task", "surface", "--felt", "warm"], USAGE)
    refuse(tmp_path, ["task"], USAGE)
