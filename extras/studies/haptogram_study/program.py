# SPDX-License-Identifier: Apache-2.0
"""The C++ program. What a study asks of it and waits for, it asks here."""
import os
import shutil
import subprocess
from collections.abc import Iterable

from haptogram.errors import ErrorCode, HaptogramError, bad_input


def find(given: str | None) -> str:
    """As given, or of the environment's HAPTOGRAM_PROGRAM, or `haptogram` on the path."""
    wanted = given or os.environ.get("HAPTOGRAM_PROGRAM") or "haptogram"
    found = shutil.which(wanted)
    if not found:
        raise bad_input(wanted, "there is no such program; give --program, or set HAPTOGRAM_PROGRAM")
    return found


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
