# SPDX-License-Identifier: Apache-2.0
"""The C++ program. What a study asks of it and waits for, it asks here."""
import subprocess
from collections.abc import Iterable

from haptogram.errors import ErrorCode, HaptogramError, bad_input


def ask(program: str, words: Iterable[str], where: str, code: ErrorCode = ErrorCode.BAD_INPUT) -> str:
    """What it prints. Raises HaptogramError at `where`, with the command and what the program said, when it fails."""
    words = list(words)
    try:
        done = subprocess.run([program, *words], capture_output=True, text=True, stdin=subprocess.DEVNULL, check=False)
    except OSError as error:
        raise bad_input(program, f"cannot be started: {error.strerror}; is it a program of this machine?") from error
    if done.returncode:
        raise HaptogramError(code, where, f"'haptogram {' '.join(words)}' failed: {done.stderr.strip() or done.stdout.strip()}")
    return done.stdout
