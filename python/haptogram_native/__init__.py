# SPDX-License-Identifier: Apache-2.0
"""The name that haptogram.calls had before; it stays for this version."""
import sys

from haptogram import calls as _native
from haptogram import errors, pictures
from haptogram.calls import *  # noqa: F403
from haptogram.calls import __all__ as __all__

sys.modules |= {f"{__name__}.{module.__name__.rpartition('.')[2]}": module for module in (errors, pictures)} | {f"{__name__}._native": _native}
