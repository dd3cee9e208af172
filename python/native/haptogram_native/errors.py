# SPDX-License-Identifier: Apache-2.0
"""The one family of exceptions. Whatever the C++ libraries throw arrives as one of these."""


class HaptogramError(Exception):
    """What went wrong, in words: what was found, what was expected, and what to do.

    code: the exit code that the program has for it (1 failed or cancelled, 2 argument, 3 input, 4 device).
    where: the file, line, record or setting.
    message: the words without `where`, which str() puts in front.
    remedies: names of settings that could mend it.
    """

    def __init__(self, code: int, where: str, message: str, remedies: tuple[str, ...] = ()) -> None:
        super().__init__(f"{where}: {message}" if where else message)
        self.code, self.where, self.message, self.remedies = code, where, message, remedies

    def __reduce__(self) -> tuple[type, tuple[int, str, str, tuple[str, ...]]]:
        return type(self), (self.code, self.where, self.message, self.remedies)


class Failed(HaptogramError):
    """The work was done, and its result is not good; or it was cancelled."""


class BadArgument(HaptogramError, ValueError):
    """What was asked for makes no sense."""


class BadInput(HaptogramError):
    """A file, or a value in it, cannot be used, or an output cannot be written."""


class DeviceError(HaptogramError):
    """The board, or the link to it."""
