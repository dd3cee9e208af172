# SPDX-License-Identifier: Apache-2.0
"""What ends a sweep, with the program's exit codes (docs/conventions.md)."""

FAILED, USAGE, BAD_INPUT = 1, 2, 3


class SweepError(Exception):
    def __init__(self, code: int, where: str, message: str):
        super().__init__(f"{where}: {message}")
        self.code, self.where, self.message = code, where, message


def bad_input(where: str, message: str) -> SweepError:
    return SweepError(BAD_INPUT, where, message)
