# SPDX-License-Identifier: Apache-2.0
"""The exceptions of the package."""
import enum
from collections.abc import Sequence
from typing import Any


class ErrorCode(enum.IntEnum):
    """What went wrong, as the exit code that a command ends with."""

    RUN_FAILED = 1  # a signal ended it before it was done; also Python's own exceptions, which are bugs
    USAGE = 2  # the command line makes no sense
    BAD_INPUT = 3  # a file or a value in it cannot be used, or an output cannot be written
    DEVICE = 4  # the board or the link to it


class HaptogramError(Exception):
    """`where` names the file, line or record; `message` says what was found, what was expected and what to do; `remedies` are settings that could mend it."""

    def __init__(self, code: ErrorCode, where: str, message: str, remedies: Sequence[str] = ()) -> None:
        super().__init__(f"{where}: {message}" if where else message)
        self.code, self.where, self.message, self.remedies = code, where, message, tuple(remedies)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.code, self.where, self.message, self.remedies)


class Failed(HaptogramError):
    """The work was done, and its result is not good; or it was cancelled."""


class BadArgument(HaptogramError, ValueError):
    """What was asked for makes no sense."""


class BadInput(HaptogramError):
    """A file, or a value in it, cannot be used, or an output cannot be written."""


class DeviceError(HaptogramError):
    """The board, or the link to it."""


class Interrupted(HaptogramError):
    """The user wanted an end before all was done."""

    def __init__(self, where: str) -> None:
        super().__init__(ErrorCode.RUN_FAILED, where, "interrupted before it was done")

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.where,)


def bad_input(where: str, message: str) -> HaptogramError:
    return HaptogramError(ErrorCode.BAD_INPUT, where, message)


def device_error(where: str, message: str) -> HaptogramError:
    return HaptogramError(ErrorCode.DEVICE, where, message)
