#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What a microphone would record of a calibration's code, played by an array whose elements differ as bought ones do.

record_calibration.py CODE.hex --at X,Y,Z -o TAKE.wav [--seed N] [--echo DB] [--noise DB] [--clock PPM] [--microphone MM] [--clip SHARE] [--truth FAULTS.json]

For tests, and to rehearse. The array is tile-10x10. Of one seed it is always the same one, wherever the microphone is. The image is read
and the sound computed without the program, from the pulses' phases: ring-up of each transducer, its piston's directivity, one wall,
and the recorder's clock. The microphone is within 2 mm of the place that is named.
"""

import argparse
import dataclasses
import json

import numpy as np
from intelhex import IntelHex
from scipy.io import wavfile
from scipy.special import j1

CARRIER_HZ, RATE_HZ, BANDWIDTH_HZ, RADIUS_M = 40e3, 192000, 2000.0, 4.5e-3
CHANNELS, HEADER_WORDS, SILENT = 100, 4, 0xFFFF
GRID = (np.arange(10) - 4.5) * 0.01
ELEMENTS = np.array([(x, y, 0.0) for y in GRID for x in GRID])
# An open TTL input beside wires that swing from 0 to 3.3 V: its own capacitance, and what it takes to turn it.
INPUT_PF, SWING_V, HYSTERESIS_V = 15.0, 3.3, 0.4


def read_code(path):
    """Each record's phases as complex numbers, one a channel, and how many carrier periods it plays."""
    image = IntelHex(str(path))
    words = lambda base, count, size: np.frombuffer(bytes(image[base + i] for i in range(count * size)), f"<u{size}")  # noqa: E731
    header = int(words(0x10000000, 1, 4)[0])
    entries = words(0x10000004, (header & 0x7FFF), 4)
    records = words(0, int((entries & 0xFFFF).max()) * (CHANNELS + HEADER_WORDS), 2).reshape(-1, CHANNELS + HEADER_WORDS).astype(int)
    cycle = records[:, 0] + ((records[:, 1] & 0xFF) << 16)
    ticks = records[:, HEADER_WORDS:]
    phases = np.where(ticks == SILENT, 0.0, np.exp(-2j * np.pi * ticks / cycle[:, None]))
    return phases[(entries & 0xFFFF) - 1], entries >> 16


def open_input(phases, near):
    """What a driver makes of an input that nothing drives or pulls down: `near` has the picofarads to wires beside it. Each record's
    fundamental, over that of a driven one."""
    steps = 64
    times = np.arange(steps) / steps
    volts = np.zeros((len(phases), steps))
    for channel, capacitance in near.items():
        wire = phases[:, channel]
        high = ((times + np.angle(wire)[:, None] / (2 * np.pi)) % 1 < 0.5) & (abs(wire) > 0)[:, None]
        volts += capacitance / (INPUT_PF + sum(near.values())) * SWING_V * (high - high.mean(axis=1, keepdims=True))
    is_high, out = np.zeros(len(phases), bool), np.zeros((len(phases), steps))
    for step in range(2 * steps):  # the first period settles
        is_high = np.where(abs(volts[:, step % steps]) > HYSTERESIS_V / 2, volts[:, step % steps] > 0, is_high)
        out[:, step % steps] = is_high
    turns = np.exp(-2j * np.pi * times)
    return out @ turns / ((times < 0.5) @ turns)


@dataclasses.dataclass
class Bought:
    """An array with faults. `response` is an element's; `channel` is what it is wired to; `speed` is the air's; `open` has elements whose
    drivers' inputs are open and not pulled down, with the picofarads to the wires of channels beside them."""

    response: np.ndarray
    channel: np.ndarray
    speed: float
    dead: list
    reversed: list
    exchanged: list
    open: dict = dataclasses.field(default_factory=dict)

    def drives(self, phases):
        """What each element's driver gives it, of the channels' phases."""
        played = phases[:, self.channel]
        for element, near in self.open.items():
            played[:, element] = open_input(phases, near)
        return played

    @classmethod
    def random(cls, seed, dead=2, reversed_=10, exchanged=0):
        rng = np.random.default_rng(seed)
        response = rng.normal(1, 0.12, CHANNELS).clip(0.5) * np.exp(1j * rng.normal(0, 0.25, CHANNELS))
        order = rng.permutation(CHANNELS)
        # As many as are asked for on average, but a whole number, so that an array may have none.
        dead, turned = sorted(order[: rng.poisson(dead)]), sorted(order[50 : 50 + rng.binomial(40, reversed_ / 40)])
        response[dead] = 0
        response[turned] *= -1
        channel = np.arange(CHANNELS)
        pairs = order[10 : 10 + 2 * exchanged].reshape(-1, 2)
        for a, b in pairs:
            channel[[a, b]] = channel[[b, a]]
        speed = 343.2 * (1 + rng.normal(0, 0.003))
        return cls(response, channel, speed, *(list(map(int, some)) for some in (dead, turned, sorted(pairs.ravel()))))


def transfer(place, speed, elements=ELEMENTS, microphone_m=0.0):
    """What a microphone at a place, a piston of this radius that faces the array, hears of each element, at the carrier, as if it were its
    kind, and how long its sound takes."""
    ray = np.asarray(place) - elements
    range_m = np.linalg.norm(ray, axis=1)
    ka_sin = 2 * np.pi * CARRIER_HZ / speed * RADIUS_M * np.hypot(ray[:, 0], ray[:, 1]) / range_m + 1e-9
    heard = ka_sin / RADIUS_M * microphone_m + 1e-9
    return 2 * j1(ka_sin) / ka_sin * 2 * j1(heard) / heard / range_m * np.exp(-2j * np.pi * CARRIER_HZ / speed * range_m), range_m / speed


def record(code, bought, place, rng, echo_db=-20.0, noise_db=-20.0, clock_ppm=100.0, lead_s=None, passes=2.0, microphone_m=0.0):
    """@param noise_db  of one pattern's sound in a bandwidth of 1 / 8 ms, which is what is told apart from it"""
    phases, periods = code
    played = bought.drives(phases)
    waves, flights = transfer(place, bought.speed, microphone_m=microphone_m)
    paths = [(1.0, waves, flights)]
    if echo_db is not None:  # a wall at x = 0.6 m, as a second microphone behind it
        mirrored, later = transfer((1.2 - place[0], place[1], place[2]), bought.speed, microphone_m=microphone_m)
        strength = 10 ** (echo_db / 20) * np.sqrt((abs(waves) ** 2).sum() / (abs(mirrored) ** 2).sum())
        paths.append((strength, mirrored, later))
    seconds = float(periods.sum()) / CARRIER_HZ
    lead_s = rng.uniform(0, seconds) if lead_s is None else lead_s
    times = np.arange(int(passes * seconds * RATE_HZ)) / RATE_HZ / (1 + clock_ppm * 1e-6) + lead_s  # by the board's clock
    envelope = np.zeros(len(times), complex)
    changes = np.cumsum(periods) / CARRIER_HZ
    decay = np.pi * BANDWIDTH_HZ
    for strength, wave, flight in paths:
        sources = strength * wave * bought.response
        steady = played @ sources
        first, last = np.floor((times[0] - flight.max()) / seconds), np.ceil(times[-1] / seconds)
        for turn in np.arange(first, last):
            for i in range(len(periods)):
                begin = turn * seconds + (changes[i - 1] if i else 0.0)
                end = turn * seconds + changes[i]
                a, b = np.searchsorted(times, (begin + flight.min(), end + flight.min()))
                if a == b:
                    continue
                envelope[a:b] += steady[i]
                # Each element goes over from when its sound arrives; when all have arrived, they fall alike.
                change = sources * (played[i - 1] - played[i])
                c = int(np.searchsorted(times[a:b], begin + flight.max())) + a
                envelope[a:c] += np.exp(-decay * np.maximum(times[a:c, None] - begin - flight, 0)) @ change
                d = min(b, c + int(0.004 * RATE_HZ))
                envelope[c:d] += np.exp(-decay * (times[c:d] - begin - flight.max())) * (np.exp(-decay * (flight.max() - flight)) @ change)
    sound = (envelope * np.exp(2j * np.pi * CARRIER_HZ * times + 1j * rng.uniform(0, 6.28))).real
    size = np.sqrt((abs(envelope) ** 2).mean())
    sound += rng.normal(0, size * 10 ** (noise_db / 20) * np.sqrt(RATE_HZ * 8e-3) / 2, len(sound))
    return sound / abs(sound).max()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("code")
    parser.add_argument("--at", required=True, help="x,y,z in mm")
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--exchanged", type=int, default=0, help="pairs of elements on each other's channels")
    parser.add_argument("--echo", type=float, default=-20.0, help="dB")
    parser.add_argument("--noise", type=float, default=-20.0, help="dB")
    parser.add_argument("--clock", type=float, default=100.0, help="ppm")
    parser.add_argument("--microphone", type=float, default=0.0, help="its radius, mm; 0 hears all directions alike")
    parser.add_argument("--clip", type=float, default=1.0, help="share of the largest value at which the recorder clips")
    parser.add_argument("--truth", help="JSON of the array's faults")
    options = parser.parse_args()
    bought = Bought.random(options.seed, exchanged=options.exchanged)
    place = np.array([float(part) for part in options.at.split(",")]) * 1e-3
    rng = np.random.default_rng([options.seed, *(int(1e6 + 1e6 * part) for part in place)])
    sound = record(read_code(options.code), bought, place + rng.uniform(-2e-3, 2e-3, 3), rng, options.echo, options.noise, options.clock,
                   microphone_m=options.microphone * 1e-3)  # fmt: skip
    wavfile.write(options.output, RATE_HZ, (np.clip(sound, -options.clip, options.clip) * 0.9 * 2**31).astype(np.int32))
    if options.truth:
        with open(options.truth, "w", encoding="utf-8") as file:
            json.dump({"dead": bought.dead, "reversed": bought.reversed, "exchanged": bought.exchanged}, file)


if __name__ == "__main__":
    main()
