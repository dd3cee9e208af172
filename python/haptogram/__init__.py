# SPDX-License-Identifier: Apache-2.0
"""Feel shapes in mid-air: compile them, see their sound fields and what is felt, and play them on a board. Lengths are metres.

    import haptogram

    ring = haptogram.compile(shape="circle", diameter_m=0.02, points=20, rate_hz=150)  # or points_m=… with times_s=…, path=…, project=…
    haptogram.field(ring, z_m=0.13).plot()             # radiation pressure on the plane z = 0.13 m
    haptogram.analyze(ring).force_n                    # of each focus, N
    haptogram.feel(ring).answer                        # by a palm: "felt", "perhaps" or "not felt"
    haptogram.simulate(ring).contract_violations       # on the Verilated FPGA

    with haptogram.Board.open("/dev/ttyUSB0") as board:
        board.upload(ring)
        haptogram.play(board, loops=3)                 # outputs on, play, outputs off

Make:   compile() -> Compiled; solve() -> Drives of several foci at a time; Array
See:    field() and workspace() -> Field; pressure(); compare() draws fields on one scale
Tell:   analyze(), feel(), simulate() -> Table
Play:   Board, play(), stream(), PatternStream; simulated_board()

Compiled, Field, Drives and Table go through np.asarray() and pickle; Field and Table have to_pandas() and to_xarray(), Field, Compiled and Array
plot(). What goes wrong is a HaptogramError of one line. The computing half needs numpy; without it this is the client of boards.
"""
import importlib
from importlib import metadata
from typing import TYPE_CHECKING, Any

from .board import Identity, Status
from .client import Board
from .client import Client as Client  # as in earlier versions; help() has only Board
from .driving import end_like_ctrl_c, play, stream
from .errors import ErrorCode, HaptogramError
from .foci import Focus
from .image import Image, Record
from .interface import Event, Test
from .patterns import PatternStream
from .trigger import ClockFit, ClockSample, Trigger, TriggerSettings, fit_clocks

if TYPE_CHECKING:
    from .computing import Array, Compiled, Drives, analyze, array_names, compile, feel, field, pressure, simulate, simulated_board, solve, workspace
    from .results import Field, Table, compare

try:
    __version__ = metadata.version("haptogram")
except metadata.PackageNotFoundError:
    __version__ = "of the sources, not installed"
__all__ = ["Array", "Board", "ClockFit", "ClockSample", "Compiled", "Drives", "ErrorCode", "Event", "Field", "Focus", "HaptogramError", "Identity",
           "Image", "PatternStream", "Record", "Status", "Table", "Test", "Trigger", "TriggerSettings", "analyze", "array_names", "compare", "compile",
           "end_like_ctrl_c", "feel", "field", "fit_clocks", "play", "pressure", "simulate", "simulated_board", "solve", "stream", "workspace"]  # fmt: skip
_OF_RESULTS = {"Field", "Table", "compare"}
_OF_COMPUTING = {"Array", "Compiled", "Drives", "analyze", "array_names", "compile", "feel", "field", "pressure", "simulate", "simulated_board", "solve", "workspace"}


def __getattr__(name: str) -> Any:
    """The computing half is imported, and numpy with it, when it is first used."""
    if name not in _OF_RESULTS | _OF_COMPUTING:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    try:
        value = getattr(importlib.import_module(".results" if name in _OF_RESULTS else ".computing", __name__), name)
    except ImportError as error:
        raise HaptogramError(ErrorCode.RUN_FAILED, error.name or name, "is not installed, and the computing half needs it; pip install numpy") from error
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
