# SPDX-License-Identifier: Apache-2.0
"""Drives a Haptogram board over its serial line: see Client."""
from .board import Identity, Status
from .client import Client
from .driving import end_like_ctrl_c, play, stream
from .errors import ErrorCode, HaptogramError
from .foci import Focus
from .image import Image, Record

__version__ = "0.1.0"
__all__ = ["Client", "ErrorCode", "Focus", "HaptogramError", "Identity", "Image", "Record", "Status", "end_like_ctrl_c", "play", "stream"]
