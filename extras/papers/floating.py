#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What Hoshi et al. 2010 (section 5) let float above the array, live: a bouncing ball, raindrops, or a small creature, for a hand that
`haptogram live` follows. It reads the scene of that session, and writes where the things are from now on:

    mkfifo scene objects
    haptogram live --from leap-pipe:- --algorithm C --object sphere --size 30 --center 0,0,400 --scene scene --scene-in objects …
    python3 extras/papers/floating.py ball scene objects

Each thing is a sphere of 30 mm; skin inside it is felt, as the algorithm has it. The ball bounces once a second, a drop falls 200 mm in a
second: slower than on earth, so that they are felt for several frames."""
import argparse
import json
import math
import os
import random
import sys
from collections.abc import Iterator

SIZE_MM, FALL_MM, FALL_S, CREATURE_MM_S, PALM_MM, DROPS = 30.0, 200.0, 1.0, 30.0, 40.0, 3
AWAY = (0.0, 0.0, 400.0)  # where no hand is
Place = tuple[float, float, float]


class Ball:
    """Falls on the palm and bounces without loss."""

    def __init__(self, seed: int) -> None:
        del seed
        self.began = 0.0

    def places(self, now: float, palm: Place) -> dict[str, Place]:
        share = math.modf((now - self.began) / FALL_S)[0] * 2 - 1  # −1 and 1 on the palm, 0 at the top
        return {"ball": (palm[0], palm[1], palm[2] + FALL_MM * (1 - share * share))}


class Rain:
    """Drops fall at random places of the palm, one after the other."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.drops = {f"drop {number}": (number / DROPS * FALL_S, 0.0, 0.0) for number in range(DROPS)}  # began, beside the palm's middle

    def places(self, now: float, palm: Place) -> dict[str, Place]:
        found = {}
        for name, (began, x, y) in self.drops.items():
            if now - began >= FALL_S:
                radius, angle = PALM_MM * math.sqrt(self.random.random()), self.random.uniform(0.0, 2 * math.pi)
                began, x, y = began + FALL_S * math.floor((now - began) / FALL_S), radius * math.cos(angle), radius * math.sin(angle)
                self.drops[name] = (began, x, y)
            fallen = (now - began) / FALL_S
            found[name] = (palm[0] + x, palm[1] + y, palm[2] + FALL_MM * (1 - fallen * fallen)) if fallen >= 0 else AWAY
        return found


class Creature:
    """Walks on the palm, turns now and then, and turns back at its rim."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.at, self.way, self.then = [0.0, 0.0], self.random.uniform(0.0, 2 * math.pi), None

    def places(self, now: float, palm: Place) -> dict[str, Place]:
        passed = 0.0 if self.then is None else now - self.then
        self.then = now
        self.way += self.random.gauss(0.0, 1.0) * math.sqrt(max(passed, 0.0))
        ahead = [self.at[0] + CREATURE_MM_S * passed * math.cos(self.way), self.at[1] + CREATURE_MM_S * passed * math.sin(self.way)]
        if math.hypot(*ahead) > PALM_MM:
            self.way = math.atan2(-self.at[1], -self.at[0])
        else:
            self.at = ahead
        return {"creature": (palm[0] + self.at[0], palm[1] + self.at[1], palm[2])}


THINGS = {"ball": Ball, "rain": Rain, "creature": Creature}


def lines(scene: Iterator[str], thing: Ball | Rain | Creature) -> Iterator[str]:
    """Lines for --scene-in, one for each thing and frame; without a hand all are away."""
    names: set[str] = set()
    for text in scene:
        if not text.endswith("\n"):
            return  # the session has ended within a line
        frame = json.loads(text)
        if frame["hands"]:
            x, y, z = frame["hands"][0]["palm_mm"]
            found = thing.places(frame["time_s"], (x, y, z))
            names |= set(found)
        else:
            found = dict.fromkeys(sorted(names), AWAY)
        for name, place in found.items():
            yield json.dumps({"name": name, "object": "sphere", "size_mm": SIZE_MM, "center_mm": [round(value, 3) for value in place]})


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("thing", choices=THINGS)
    parser.add_argument("scene", help="named pipe or file of the session's --scene; - is standard input")
    parser.add_argument("objects", help="named pipe or file of its --scene-in; - is standard output")
    parser.add_argument("--seed", type=int, default=1, help="of rain and creature")
    arguments = parser.parse_args()
    # Reading and writing: so neither end of a pipe waits for the other one to be opened.
    objects = sys.stdout if arguments.objects == "-" else os.fdopen(os.open(arguments.objects, os.O_RDWR | os.O_CREAT), "w", encoding="utf-8")
    scene = sys.stdin if arguments.scene == "-" else open(arguments.scene, encoding="utf-8")
    try:
        for line in lines(scene, THINGS[arguments.thing](arguments.seed)):
            print(line, file=objects, flush=True)
    except (BrokenPipeError, KeyboardInterrupt):
        pass  # the session has ended
    return 0


if __name__ == "__main__":
    sys.exit(main())
