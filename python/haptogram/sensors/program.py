# SPDX-License-Identifier: Apache-2.0
"""How a program ends that feeds `haptogram live` through a pipe."""
import os
import sys
from collections.abc import Callable

from ..errors import ErrorCode, HaptogramError


def exit_code_of(name: str, work: Callable[[], None]) -> int:
    """That of the program `name` once `work` has ended. Ctrl-C, and a pipe that nobody reads any more, are no errors."""
    try:
        work()
    except HaptogramError as error:
        print(f"{name}: {error}", file=sys.stderr)
        return error.code
    except BrokenPipeError:  # nobody wants more
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    except OSError as error:  # all else is told by HaptogramError
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        print(f"{name}: standard output: {error.strerror}; what was written is incomplete", file=sys.stderr)
        return ErrorCode.BAD_INPUT
    except KeyboardInterrupt:
        pass
    return 0
