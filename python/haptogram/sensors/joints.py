# SPDX-License-Identifier: Apache-2.0
"""Hands of any tracker for `haptogram live --from joints-pipe:-`, and for recordings NAME.jsonl that --hand takes: a frame a line, as JSON.

    for frame in frames:                                        # an OpenXR program, by the names of its joints
        sys.stdout.buffer.write(line(frame.time_s, [of_openxr("right", frame.joints)]))

    hands = of_mediapipe(result, 640, 480, focal_px=600)        # MediaPipe's result, from a camera of that focal length
    sys.stdout.buffer.write(line(time.monotonic(), hands))

The frame has x to the right, y up and z to the user, in metres, as OpenXR and the Leap have it. A camera of MediaPipe lies in its middle and looks along -z.
"""
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from ..errors import ErrorCode, HaptogramError

FINGERS = ("thumb", "index", "middle", "ring", "little")
BONES = ("metacarpal", "proximal", "intermediate", "distal", "tip")
NAMES = ("palm", "wrist", *(f"{finger}_{bone}" for finger in FINGERS for bone in BONES if (finger, bone) != ("thumb", "intermediate")))
MEDIAPIPE = ("wrist", *(f"{finger}_{bone}" for finger in FINGERS for bone in BONES if bone != ("intermediate" if finger == "thumb" else "metacarpal")))

Hand = dict[str, Any]
Place = Sequence[float]


def hand(side: str, joints: Mapping[str, Place], **more: Any) -> Hand:
    """Joints by their names in NAMES, in metres. `more`: id, confidence, normal and others of extras/hands/README.md."""
    if side not in ("left", "right"):
        raise HaptogramError(ErrorCode.USAGE, "side", f"found {side!r}, expected left or right")
    places = {}
    for name, place in joints.items():
        if name not in NAMES:
            raise HaptogramError(ErrorCode.USAGE, "joints", f"found {name!r}, expected one of {', '.join(NAMES)}")
        places[name] = [float(number) for number in place]
        if len(places[name]) != 3 or not all(map(math.isfinite, places[name])):
            raise HaptogramError(ErrorCode.USAGE, "joints", f"{name} is {places[name]}, expected three finite numbers in metres")
    return {"side": side, "joints_m": places, **more}


def line(time_s: float, hands: Iterable[Hand]) -> bytes:
    """A frame. Times are seconds of any clock that does not go back."""
    return json.dumps({"time_s": float(time_s), "hands": list(hands)}, separators=(",", ":"), allow_nan=False).encode() + b"\n"


def openxr_name(name: str) -> str:
    """Of XR_HAND_JOINT_INDEX_TIP_EXT, of WebXR's index-finger-tip, and of index_tip itself: index_tip."""
    plain = name.lower().replace("-", "_").removeprefix("xr_hand_joint_").removesuffix("_ext")
    return plain.replace("_finger", "").replace("_phalanx", "").replace("pinky", "little")


def of_openxr(side: str, joints: Mapping[str, Place], **more: Any) -> Hand:
    """Joints of OpenXR or WebXR by their names there."""
    return hand(side, {openxr_name(name): place for name, place in joints.items()}, **more)


def of_mediapipe(result: Any, width: int, height: int, focal_px: float, mirrored: bool = False) -> list[Hand]:
    """The hands of a result of MediaPipe, of its tasks (HandLandmarker) or its solutions (Hands).

    A picture alone does not say where a hand is. Its landmarks in the world, of which MediaPipe knows the size, and where the camera shows them, do.
    `mirrored`: the picture is that of a mirror, for which MediaPipe says which hand it is; of another picture it says the wrong one.
    """
    if not (width > 0 and height > 0 and focal_px > 0):
        raise HaptogramError(ErrorCode.USAGE, "focal_px", f"found {width} x {height} pixels and a focal length of {focal_px} pixels, expected numbers above 0")
    tasks = hasattr(result, "hand_landmarks")
    pictures = result.hand_landmarks if tasks else [each.landmark for each in result.multi_hand_landmarks or ()]
    worlds = result.hand_world_landmarks if tasks else [each.landmark for each in result.multi_hand_world_landmarks or ()]
    said = [each[0] for each in result.handedness] if tasks else [each.classification[0] for each in result.multi_handedness or ()]
    found = []
    for picture, world, which in zip(pictures, worlds, said, strict=True):
        flip = -1.0 if mirrored else 1.0
        seen = np.array([[flip * (mark.x - 0.5) * width, (mark.y - 0.5) * height] for mark in picture]) / focal_px
        around = np.array([[flip * mark.x, mark.y, mark.z] for mark in world])
        # The camera shows a place p + t where (p + t)'s x and y over its z say: linear equations for t.
        rows = np.zeros((2 * len(around), 3))
        rows[0::2, 0] = rows[1::2, 1] = 1.0
        rows[:, 2] = -seen.reshape(-1)
        wanted = (seen * around[:, 2:] - around[:, :2]).reshape(-1)
        place = np.linalg.lstsq(rows, wanted, rcond=None)[0]
        label = (which.category_name if tasks else which.label).lower()
        side = label if mirrored else {"left": "right", "right": "left"}[label]
        found.append(hand(side, dict(zip(MEDIAPIPE, (around + place) * [1.0, -1.0, -1.0], strict=True)), confidence=min(1.0, max(0.0, float(which.score)))))
    return found
