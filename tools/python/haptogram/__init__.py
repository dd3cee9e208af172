# SPDX-License-Identifier: Apache-2.0
"""Drives a Haptogram board over its serial line: see Client."""
from importlib import metadata

from .board import Identity, Status
from .client import Client
from .driving import end_like_ctrl_c, play, stream
from .errors import ErrorCode, HaptogramError
from .foci import Focus
from .image import Image, Record
from .patterns import PatternStream

try:
    __version__ = metadata.version("haptogram")
except metadata.PackageNotFoundError:
    __version__ = "of the sources, not installed"
__all__ = ["Client", "ErrorCode", "Focus", "HaptogramError", "Identity", "Image", "PatternStream", "Record", "Status", "end_like_ctrl_c", "play", "stream"]
