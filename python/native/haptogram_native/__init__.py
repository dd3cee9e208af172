# SPDX-License-Identifier: Apache-2.0
"""Haptogram's compiler, fields, solvers and analyses for numpy.

Lengths are metres, pressures are complex peak values in Pa with the time factor e^{jwt}, and drives are complex source
strengths in Pa m, as in the C++ libraries. The interpreter's lock is released while anything computes, and Ctrl-C ends
the work. Errors are HaptogramError and its subclasses.
"""

from haptogram_native import pictures
from haptogram_native._native import (
    Array,
    Compiled,
    Excitation,
    Field,
    FocusAnalysis,
    ImageAnalysis,
    MeanSquareField,
    Pose,
    PressureField,
    Quality,
    analyze,
    analyze_focus,
    array_names,
    compile_project,
    compile_text,
    field,
    gradient,
    ideal_drives,
    join,
    mean_square,
    mean_square_on,
    pressure,
    pressure_on,
    quality,
    solve,
    workspace,
)
from haptogram_native.errors import BadArgument, BadInput, DeviceError, Failed, HaptogramError

__all__ = [
    "Array",
    "BadArgument",
    "BadInput",
    "Compiled",
    "DeviceError",
    "Excitation",
    "Failed",
    "Field",
    "FocusAnalysis",
    "HaptogramError",
    "ImageAnalysis",
    "MeanSquareField",
    "Pose",
    "PressureField",
    "Quality",
    "analyze",
    "analyze_focus",
    "array_names",
    "compile_project",
    "compile_text",
    "field",
    "gradient",
    "ideal_drives",
    "join",
    "mean_square",
    "mean_square_on",
    "pressure",
    "pressure_on",
    "quality",
    "solve",
    "workspace",
]

pictures.attach()
