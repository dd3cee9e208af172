# SPDX-License-Identifier: Apache-2.0
"""Depth pictures to `haptogram live --from depth-pipe:-`, from any camera. The format is extras/live/README.md's."""
import math
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from typing import BinaryIO

from ..errors import bad_input

MOST_CAMERAS = 32
Vector = tuple[float, float, float]
Picture = bytes | bytearray | memoryview  # of a numpy array: its .data


@dataclass(frozen=True)
class Pose:
    """Where a camera is in the array's frame: x to the right, z up, both from the array's middle."""

    position_mm: Vector = (0.0, 0.0, 0.0)
    right: Vector = (1.0, 0.0, 0.0)  # the camera's x axis
    forward: Vector = (0.0, 0.0, 1.0)  # its z axis, along which it looks


@dataclass(frozen=True)
class Camera:
    """Without distortion: a pixel (u, v) of depth z is the point ((u − cx)·z/fx, (v − cy)·z/fy, z)."""

    width: int
    height: int
    focal_px: tuple[float, float]
    centre_px: tuple[float, float]
    unit_mm: float  # of a count; the count 0 is "not seen"
    pose: Pose = Pose()
    baseline_mm: float = 50.0


class DepthPipe:
    """Says what the cameras are, and then writes shots."""

    def __init__(self, stream: BinaryIO, cameras: Sequence[Camera], rate_hz: float) -> None:
        if not 1 <= len(cameras) <= MOST_CAMERAS:
            raise bad_input("cameras", f"found {len(cameras)}, expected 1 to {MOST_CAMERAS}")
        self._stream, self._cameras = stream, tuple(cameras)
        stream.write(_head(cameras, rate_hz).encode() + b"\0")
        stream.flush()

    def write(self, number: int, time_s: float, pictures: Sequence[Picture | None]) -> None:
        """A shot: its number, which counts up by one, the time of its exposure, and what each camera saw: rows of unsigned 16-bit
        counts, little-endian, or None where it gave no picture."""
        if len(pictures) != len(self._cameras):
            raise bad_input(f"shot {number}", f"found {len(pictures)} pictures, expected {len(self._cameras)}, one a camera")
        if not math.isfinite(time_s):
            raise bad_input(f"shot {number}", f"its time is {time_s}, expected a finite number of seconds")
        seen = 0
        for i, (camera, picture) in enumerate(zip(self._cameras, pictures, strict=True)):
            if picture is None:
                continue
            found, expected = memoryview(picture).nbytes, 2 * camera.width * camera.height
            if found != expected:
                raise bad_input(f"shot {number}", f"the picture of camera {i + 1} has {found} bytes, expected {expected}")
            seen |= 1 << i
        self._stream.write(struct.pack("<4sIQd", b"SHOT", seen, number, time_s))
        for picture in pictures:
            if picture is not None:
                self._stream.write(picture)
        self._stream.flush()


def _head(cameras: Sequence[Camera], rate_hz: float) -> str:
    """cameras.toml, as a recording has it."""

    def numbers(values: Sequence[float]) -> str:
        return f"[{', '.join(repr(float(value)) for value in values)}]"

    text = f'format = "haptogram-depth-1"\nrate_hz = {float(rate_hz)!r}\n'
    for i, camera in enumerate(cameras):
        text += (
            f'\n[[camera]]\nfolder = "camera{i + 1}"\nwidth = {camera.width}\nheight = {camera.height}\n'
            f"focal_px = {numbers(camera.focal_px)}\ncentre_px = {numbers(camera.centre_px)}\n"
            f"unit_mm = {float(camera.unit_mm)!r}\nbaseline_mm = {float(camera.baseline_mm)!r}\n"
            f"position_mm = {numbers(camera.pose.position_mm)}\nright = {numbers(camera.pose.right)}\n"
            f"forward = {numbers(camera.pose.forward)}\n"
        )
    return text
