# SPDX-License-Identifier: Apache-2.0
"""A board's trigger block in Python, its clock as host time, and marks of entries."""
import random
import struct
from types import SimpleNamespace

import haptogram
import pytest
from haptogram import ClockSample, Event, HaptogramError, Trigger, TriggerSettings, fit_clocks
from haptogram.image import Image
from messages import refusal

BOARD = SimpleNamespace(channels=100, clock_hz=50_000_000)


def test_the_settings_are_the_words_of_the_page():
    block = TriggerSettings(Event.MARK, 7, 1.5e-3, active_low=True, gates=True, settle_s=20e-6, test=haptogram.Test.CARRIER, channel=99).block(BOARD)
    assert struct.unpack("<8H", block) == (2, 7, 75000 & 0xFFFF, 75000 >> 16, 0b101, 1000, 1, 99)


@pytest.mark.parametrize("settings", [
    TriggerSettings(pulse_s=0.34), TriggerSettings(settle_s=0.0014), TriggerSettings(settle_s=-1.0),
    TriggerSettings(channel=100), TriggerSettings(every_periods=0)])  # fmt: skip
def test_what_the_board_cannot_have_is_refused_by_name(settings):
    with refusal(HaptogramError):
        settings.block(BOARD)


def test_what_it_tells_has_clocks_of_48_bits():
    told = struct.pack("<HHHHHHHHHHH", 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11)
    clock = [low | middle << 16 | high << 32 for low, middle, high in ((1, 2, 3), (5, 6, 7), (9, 10, 11))]
    assert Trigger.of(told) == Trigger(now=clock[0], out_count=4, out=clock[1], in_count=8, in_=clock[2])


def test_a_crystal_that_is_off_is_fitted_within_the_error():
    draw = random.Random(7)
    hz = 50e6 * (1 + 8e-5)
    samples = []
    for i in range(200):
        asked, out, back = 100 + 0.05 * i, draw.uniform(5e-5, 2e-2 if i % 9 == 0 else 4e-4), draw.uniform(5e-5, 4e-4)
        samples.append(ClockSample(asked, asked + out + back, int(hz * (asked + out))))
    fit = fit_clocks(samples)
    assert fit.error_s < 4e-4
    for s in (100.0, 105.0, 110.0):
        assert abs(fit.host_s(int(hz * s)) - s) < fit.error_s


def test_clocks_that_cannot_be_are_refused():
    for samples in ([], [ClockSample(1, 0, 5), ClockSample(2, 3, 9)], [ClockSample(0, 1, 50), ClockSample(2, 3, 9)]):
        with refusal(HaptogramError):
            fit_clocks(samples)


def test_a_mark_is_no_part_of_an_index():
    image = Image(2, 50_000_000, 16, 8, b"", struct.pack("<IHHHH", 2, 1, 3, 0x8002, 4))
    assert image.entries == [(1, 3), (2, 4)]
    assert image.has_marks
