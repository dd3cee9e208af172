# SPDX-License-Identifier: Apache-2.0
"""Drives a Haptogram board over its serial line: see Client."""
from importlib import metadata

from .board import Identity, Status
from .client import Client
from .driving import end_like_ctrl_c, play, stream
from .errors import ErrorCode, HaptogramError
from .foci import Focus
from .image import Image, Record
from .interface import Event, Test
from .patterns import PatternStream
from .trigger import ClockFit, ClockSample, Trigger, TriggerSettings, fit_clocks

try:
    __version__ = metadata.version("haptogram")
except metadata.PackageNotFoundError:
    __version__ = "of the sources, not installed"
__all__ = ["Client", "ClockFit", "ClockSample", "ErrorCode", "Event", "Focus", "HaptogramError", "Identity", "Image", "PatternStream", "Record", "Status", "Test",
           "Trigger", "TriggerSettings", "end_like_ctrl_c", "fit_clocks", "play", "stream"]  # fmt: skip
