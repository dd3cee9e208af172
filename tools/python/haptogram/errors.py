# SPDX-License-Identifier: Apache-2.0
"""The one exception of the package."""
import enum


class ErrorCode(enum.IntEnum):
    """What went wrong, as the exit code that a command ends with. 1 is left to Python's own exceptions: they are bugs."""

    USAGE = 2  # the command line makes no sense
    BAD_INPUT = 3  # a file or a value in it cannot be used, or an output cannot be written
    DEVICE = 4  # the board or the link to it


class HaptogramError(Exception):
    """`where` names the file, line or record; `message` says what was found, what was expected and what to do."""

    def __init__(self, code: ErrorCode, where: str, message: str) -> None:
        super().__init__(f"{where}: {message}")
        self.code, self.where, self.message = code, where, message


def bad_input(where: str, message: str) -> HaptogramError:
    return HaptogramError(ErrorCode.BAD_INPUT, where, message)


def device_error(where: str, message: str) -> HaptogramError:
    return HaptogramError(ErrorCode.DEVICE, where, message)
