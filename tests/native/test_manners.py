# SPDX-License-Identifier: Apache-2.0
"""How the module behaves: no copies, the interpreter's lock, Ctrl-C, errors, types."""
import importlib
import os
import pickle
import signal
import threading
import time
import types

import haptogram_native as native
import numpy as np
import pytest
from haptogram import calls
from messages import refusal


@pytest.fixture(scope="module")
def array():
    return native.Array.find("tile-10x10")


def test_positions_are_a_view_that_outlives_its_array():
    made = native.Array.find("tile-10x10")
    positions, normals = made.positions_m, made.normals
    assert positions.shape == normals.shape == (100, 3)
    assert not positions.flags.owndata and not positions.flags.writeable
    assert positions.strides == (72, 8)  # position, normal, response and weight of an element lie beside each other
    del made
    assert np.allclose(positions[0], (-0.045, -0.045, 0.0)) and np.all(normals == (0, 0, 1))


def test_results_are_not_copied(array):
    field = native.pressure_on(array, native.ideal_drives(array, (0, 0, 0.13)), np.linspace(-0.02, 0.02, 50), np.linspace(-0.02, 0.02, 40), [0.13])
    assert not field.values.flags.owndata and field.values.flags.c_contiguous
    assert field.values is field.values


def large(array, threads=1):
    axis = np.linspace(-0.1, 0.1, 260)
    return native.pressure_on(array, native.ideal_drives(array, (0, 0, 0.15)), axis, axis, np.linspace(0.05, 0.25, 200), threads=threads, interpolation_error=0.0)


def test_others_run_while_it_computes(array):
    """Within one call another thread runs again and again. With the lock held it would once or twice, however often it is called."""
    ticks = 0
    over = threading.Event()

    def count():
        nonlocal ticks
        while not over.is_set():
            ticks += 1
            time.sleep(1e-3)

    other = threading.Thread(target=count)
    other.start()
    most, tries = 0, 0
    while most < 10 and tries < 100:  # a busy machine may give the other none of a call's time
        before = ticks
        large(array)
        most, tries = max(most, ticks - before), tries + 1
    over.set()
    other.join()
    assert most >= 10


def test_control_c_ends_it(array):
    handler = signal.signal(signal.SIGINT, signal.default_int_handler)
    timer = threading.Timer(0.05, os.kill, (os.getpid(), signal.SIGINT))
    try:
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            for _ in range(1000):
                large(array)
    finally:
        timer.join()
        signal.signal(signal.SIGINT, handler)


def test_other_signals_are_heard_while_it_computes(array):
    heard = []
    handler = signal.signal(signal.SIGUSR1, lambda *_: heard.append(time.monotonic()))
    timer = threading.Timer(0.02, os.kill, (os.getpid(), signal.SIGUSR1))
    try:
        timer.start()
        assert np.isfinite(large(array).values).all()
        ended = time.monotonic()
        timer.join()
    finally:
        signal.signal(signal.SIGUSR1, handler)
    assert heard[0] < ended


def test_the_same_bytes_for_any_number_of_threads(array):
    drives = native.ideal_drives(array, (0, 0, 0.13))
    axis = np.linspace(-0.05, 0.05, 120)
    first, *others = [native.pressure_on(array, drives, axis, axis, [0.1, 0.13], threads=n).values.tobytes() for n in (1, 2, 0)]
    assert all(other == first for other in others)


def test_errors_are_one_family(array, tmp_path):
    drives = native.ideal_drives(array, (0, 0, 0.13))
    with refusal(native.BadInput) as caught:
        native.pressure(array, drives[:3], [[0, 0, 0.1]])
    assert caught.value.code == 3 and caught.value.where == "field" and caught.value.message in str(caught.value)
    again = pickle.loads(pickle.dumps(caught.value))
    assert type(again) is native.BadInput and str(again) == str(caught.value)
    with refusal(native.BadInput):
        native.pressure(array, drives, array.positions_m[:1])
    with refusal(native.BadArgument):
        native.pressure(array, drives, [0.0, 0.0, 0.1, 0.2])
    with refusal(native.BadArgument):
        native.pressure(array, drives.reshape(2, 50), [[0, 0, 0.1]])
    with pytest.raises(ValueError, match="must be one of radiation"):
        native.field(native.Excitation.of_focus(array, (0, 0, 0.13)), quantity="warmth")
    with refusal(native.BadArgument):
        native.field(native.Excitation.of_focus(array, (0, 0, 0.13)), plane="xy@z=100", volume=True)
    with refusal(native.HaptogramError):
        native.compile_project(str(tmp_path / "nowhere.toml"))
    with refusal(native.BadInput):
        native.compile_text('format = "haptogram-project-1"\ncolour = 3\n')
    with refusal(native.BadArgument):
        array.with_elements([[0, 0, 0]], [[0, 0, 2.0]])
    with refusal(native.BadArgument):
        array.with_elements([[0, 0, 0]], [[0, 0, 1.0], [0, 0, 1.0]])
    for lost in ((0, 0, 130), (0, 0, -0.1), (0.5, 0, 0.1)):
        for focus in (native.ideal_drives, native.Excitation.of_focus, lambda array, at: native.solve(array, [(0, 0, 0.13), at]),
                      lambda array, at: native.analyze_focus(array, drives, at)):  # fmt: skip
            with refusal(native.BadArgument) as caught:
                focus(array, lost)
            assert caught.value.where in ("focus_m", "foci_m[1]") and (lost[2] < 100 or "did you mean (0, 0, 0.13)?" in caught.value.message)
    assert issubclass(native.Failed, native.HaptogramError) and issubclass(native.DeviceError, native.HaptogramError)


def test_all_that_is_public_is_named_and_described():
    there = {name for name, value in vars(calls).items() if not name.startswith("_") and getattr(value, "__module__", "").startswith("haptogram.") and isinstance(value, (type, types.FunctionType))}
    assert there - {"call", "library", "sized", "ErrorCode"} == set(calls.__all__)
    assert all(getattr(native, name) is getattr(calls, name) and getattr(calls, name).__doc__ for name in calls.__all__)
    for module in ("_native", "errors", "pictures"):
        assert importlib.import_module(f"haptogram_native.{module}") is getattr(native, module)


def test_what_is_in_the_library_is_not_pickled(array):
    with pytest.raises(TypeError):
        pickle.dumps(array)
