# SPDX-License-Identifier: Apache-2.0
"""How the package's programs end, and where the C++ program is."""
import os
import shutil
import sys
from collections.abc import Callable

from ._program import PROGRAM
from .errors import ErrorCode, HaptogramError, bad_input


def exit_code_of(name: str, work: Callable[[], int | None], interrupted: int = ErrorCode.RUN_FAILED) -> int:
    """That of the program `name` once `work` has ended, which may give one, or `interrupted` after Ctrl-C. A pipe that nobody reads
    any more is no error. Standard output that takes not all of what was printed, or of the help, is one."""
    try:
        try:
            return work() or 0
        finally:
            sys.stdout.flush()
    except HaptogramError as error:
        print("; ".join([f"{name}: {error}", *getattr(error, "__notes__", [])]), file=sys.stderr)
        return error.code
    except BrokenPipeError:  # nobody wants more
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # or Python tries again at its end
    except OSError as error:  # all else is told by HaptogramError
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        print(f"{name}: standard output: {error.strerror}; what was printed is incomplete", file=sys.stderr)
        return ErrorCode.BAD_INPUT
    except KeyboardInterrupt:
        return interrupted
    return 0


def find_program(given: str | None = None) -> str:
    """The C++ program: as given, of the environment's HAPTOGRAM_PROGRAM, of the wheel, or `haptogram` on the path."""
    wanted = given or os.environ.get("HAPTOGRAM_PROGRAM") or (str(PROGRAM) if PROGRAM.exists() else "haptogram")
    found = shutil.which(wanted)
    if found is None:
        raise bad_input(wanted, "there is no such program; pip install the wheel, or let HAPTOGRAM_PROGRAM name one")
    return found
