# SPDX-License-Identifier: Apache-2.0
"""Speed of a focus and spectra of waveforms, from the pulses at the pins of the simulated core and nothing else."""
import numpy as np
import pytest
from support import read_json, succeed

PERIOD, CLOCK_HZ = 1250, 50e6


def pulses_of(folder, *arguments, passes=1):
    succeed(["compile", *arguments, "-o", "image.hex"], cwd=folder)
    succeed(["simulate", "image.hex", "--load", "direct", "--passes", passes, "--pulses", "pulses.csv"], cwd=folder, timeout=300)
    return np.loadtxt(folder / "pulses.csv", delimiter=",", skiprows=1, dtype=np.int64)


def found_focus(manifest, phases, start):
    """Where the waves of such phases (turns) add up most, by small steps up from a place some millimetres off."""
    elements = np.array(manifest["array"]["elements_mm"])
    k = 2 * np.pi * manifest["array"]["carrier_hz"] / manifest["medium"]["speed_m_s"] * 1e-3

    def height(at):
        return abs(np.exp(2j * np.pi * phases - 1j * k * np.linalg.norm(elements - at, axis=1)).sum())

    at, step = np.array(start, dtype=float), 2.0
    while step > 1e-3:
        around = [at + step * np.array(way) for way in ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1))]
        best = max(around, key=height)
        at, step = (best, step) if height(best) > height(at) else (at, step / 2)
    assert height(at) > 0.995 * len(elements)
    return at


@pytest.mark.parametrize("speed", [1.5, 7, 11.5])
def test_the_focus_at_the_pins_has_the_asked_speed(speed, tmp_path):
    points, radius = 48, 12
    pulses = pulses_of(tmp_path, "--shape", "circle", "--diameter", 2 * radius, "--points", points, "--speed", speed, passes=2)
    manifest = read_json(tmp_path / "image.json")
    # A change of record moves the pulses of all channels: the time from one first pulse of record 1 to the next is a pass.
    first = pulses[pulses[:, 0] == 0]
    first = first[np.argsort(first[:, 1])]
    begins = first[1:][(first[1:, 3] == 1) & (first[:-1, 3] != 1)][:, 1]
    begins = np.concatenate([first[:1, 1], begins])
    assert len(begins) == 2
    places = []
    for index in range(1, points + 1):
        own = pulses[pulses[:, 3] == index]
        turns = np.exp(-2j * np.pi * own[:, 1:3].sum(axis=1) / 2 / PERIOD)  # a pulse's middle is where its wave is highest
        phases = np.array([np.angle(turns[own[:, 0] == channel].mean()) / 2 / np.pi for channel in range(100)])
        start = places[-1] if places else manifest["records"][0]["focus_mm"] + np.array([1.5, -1, 2])
        places.append(found_focus(manifest, phases, start))
    way = np.linalg.norm(np.array(places) - np.roll(places, -1, axis=0), axis=1)
    way *= np.pi / points / np.sin(np.pi / points)  # along the circle, of which these are chords
    assert np.linalg.norm(np.array(places)[:, :2], axis=1) == pytest.approx(radius, abs=0.2)
    assert way.sum() * 1e-3 / ((begins[1] - begins[0]) / CLOCK_HZ) == pytest.approx(speed, rel=0.005)


def lines_of(waveform, hz, count):
    """The lines at hz, 2·hz, … of a waveform from 0 to 1, as peak values, by sums over a fine period."""
    t = (np.arange(200_000) + 0.5) / 200_000
    kind, *duty = waveform.split(":")[0], *[float(x) for x in waveform.split(":")[2:]]
    values = {
        "sine": 0.5 + 0.5 * np.sin(2 * np.pi * t),
        "square": (t < (duty or [0.5])[0]).astype(float),
        "abs-sine": abs(np.sin(np.pi * t)),
        "triangle": 1 - abs(2 * t - 1),
        "sawtooth": t,
    }[kind]
    return np.abs(np.fft.rfft(values))[1 : count + 1] / len(t) * 2


def spectrum_at_the_pins(folder, waveform):
    """Frequencies and lines, as peak values, of the carrier's level from pulse to pulse: pulses of one length, repeated."""
    pulses = pulses_of(folder, "--shape", "point", "--am", waveform)
    channels = []
    for channel in (0, 37, 99):
        own = pulses[pulses[:, 0] == channel]
        middle = own[:, 1:3].sum(axis=1) / 2 / PERIOD
        number = np.rint(middle - middle[0]).astype(int)
        level = np.zeros(number.max() + 1)
        level[number] = np.sin(np.pi * (own[:, 2] - own[:, 1]) / PERIOD)  # Hoshi, eq. 7
        channels.append(level)
    assert all(np.array_equal(level, channels[0]) for level in channels)
    manifest = read_json(folder / "image.json")
    length = round(manifest["array"]["carrier_hz"] / manifest["rendering"]["rate_hz"])  # of the pass, in carrier periods
    level = np.pad(channels[0], (0, length - len(channels[0])))
    return np.arange(length // 2 + 1) * 40_000 / length, np.abs(np.fft.rfft(level)) / length * 2


SINGLE = ["sine:200", "square:200", "square:200:0.25", "abs-sine:200", "triangle:200", "sawtooth:200", "sine:80", "square:210.175"]


@pytest.mark.parametrize("text", [*SINGLE, "sine:200+sine:80", "triangle:100+square:250+sine:400"])
def test_the_spectrum_at_the_pins(text, tmp_path):
    """The fundamental within 0.1 dB, and below 1 kHz nothing that the waveform has not, to 40 dB under it; of a sum, which is the
    mean of its waveforms, the fundamental of each."""
    frequency, found = spectrum_at_the_pins(tmp_path, text)
    waveforms = text.split("+")
    expected, fundamentals = np.zeros(len(found)), []
    for waveform in waveforms:
        hz = float(waveform.split(":")[1])
        cycles = int(np.abs(frequency - hz).argmin())
        assert frequency[cycles] == pytest.approx(hz, rel=1e-3)
        harmonics = np.arange(1, int(1000 // hz) + 2)
        expected[harmonics * cycles] += lines_of(waveform, hz, len(harmonics)) / len(waveforms)
        fundamentals.append(cycles)
    assert 20 * np.log10(found[fundamentals] / expected[fundamentals]) == pytest.approx(np.zeros(len(waveforms)), abs=0.1)
    below = (frequency > 0) & (frequency <= 1000)
    assert np.abs(found - expected)[below].max() <= 0.01 * found[fundamentals].max()
