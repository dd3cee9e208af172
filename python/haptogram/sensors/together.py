# SPDX-License-Identifier: Apache-2.0
"""Which frames of several cameras make a shot. Cameras need not be synchronised: each gives a frame a period, whenever it does."""
from collections.abc import Sequence
from dataclasses import dataclass

LOST = 1.5  # periods without a frame, after which nobody waits for a camera
WAIT = 0.5  # periods that a shot waits for the other cameras' frames
SAME = 0.6  # periods: no older than this is a frame of the same shot


@dataclass(frozen=True)
class Frame:
    number: int  # of the camera's own count
    time_s: float  # of the exposure, by the machine's clock
    arrived_s: float  # by the same clock
    picture: bytes


@dataclass(frozen=True)
class Shot:
    number: int
    time_s: float
    frames: Sequence[Frame | None]  # one a camera; None where it gave none in time


class Together:
    """A shot begins with a frame of the first camera that gives any, and has of each other camera the frame nearest to it."""

    def __init__(self, cameras: int, rate_hz: float) -> None:
        self._period_s = 1 / rate_hz
        self._newest: list[Frame | None] = [None] * cameras
        self._begun: tuple[int, Frame] | None = None  # the camera that leads a shot that is not complete
        self._last: tuple[int, Frame] | None = None  # of the last shot
        self._number = 0

    def add(self, camera: int, frame: Frame) -> list[Shot]:
        """@return the shots that this frame completes, up to two"""
        shots = []
        if self._begun and self._begun[0] == camera:
            shots.append(self._end())
        self._newest[camera] = frame
        if not self._begun and self._leads(camera, frame):
            self._begun = camera, frame
        return shots + self.due(frame.arrived_s)

    def due(self, now_s: float) -> list[Shot]:
        """The shot that is complete, or for which the time to wait is over."""
        if not self._begun:
            return []
        begun_s = self._begun[1].arrived_s
        waits = any(not self._silent(i, now_s) and self._of_shot(i) is None for i in range(len(self._newest)))
        return [] if waits and now_s < begun_s + WAIT * self._period_s else [self._end()]

    def _leads(self, camera: int, frame: Frame) -> bool:
        if self._last and self._last[0] != camera and frame.arrived_s < self._last[1].arrived_s + WAIT * self._period_s:
            return False  # of the shot that another camera has led, it comes too late
        return all(self._silent(other, frame.arrived_s) for other in range(camera))

    def _silent(self, camera: int, now_s: float) -> bool:
        frame = self._newest[camera]
        return frame is None or now_s - frame.arrived_s > LOST * self._period_s

    def _of_shot(self, camera: int) -> Frame | None:
        frame = self._newest[camera]
        assert self._begun
        return None if frame is None or frame.arrived_s < self._begun[1].arrived_s - SAME * self._period_s else frame

    def _end(self) -> Shot:
        assert self._begun
        camera, frame = self._begun
        if self._last:
            # Frames that the same camera took and that did not come are lost shots; of another camera the time tells.
            led, last = self._last
            passed = frame.number - last.number if camera == led else round((frame.arrived_s - last.arrived_s) / self._period_s)
            self._number += max(1, passed)
        shot = Shot(self._number, frame.time_s, [self._of_shot(i) for i in range(len(self._newest))])
        self._last, self._begun = self._begun, None
        return shot
