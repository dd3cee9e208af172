# SPDX-License-Identifier: Apache-2.0
"""What a trial presents: its description and hash, its image by `haptogram compile`, and playing it on a board while a person answers."""
import ctypes
import datetime
import hashlib
import math
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Container, Mapping, Sequence
from pathlib import Path

from haptogram.client import Client
from haptogram.driving import play
from haptogram.errors import HaptogramError, bad_input, device_error
from haptogram.image import Image
from haptogram.interface import Event
from haptogram.trigger import ClockSample, fit_clocks
from .protocol import PathPlan, Protocol, Stimulus, Value, canonical, fill, names_in

MOST_ROWS = 100_000
MOST_CLOCKS = 200


def _number(value: Value, values: Mapping[str, object], where: str) -> float:
    text = fill(value, values) if isinstance(value, str) else str(value)
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise bad_input(where, f"{value} stands for {text!r}, expected a number; give the factor's levels such a number")
    return number


def path_rows(plan: PathPlan, values: Mapping[str, object], where: str) -> list[tuple[float, float, float, float, float]]:
    """Rows of a path file: time_ms, x_mm, y_mm, z_mm, intensity. A focus lasts until the next row's time."""
    corners = [tuple(_number(v, values, where) for v in point) for point in plan.waypoints_mm]
    intensity = _number(plan.intensity, values, where)
    if not 0.0 <= intensity <= 1.0:
        raise bad_input(where, f"the intensity is {intensity:g}, expected 0 to 1")
    square_hz = _number(plan.square_hz, values, where)
    if square_hz < 0.0:
        raise bad_input(where, f"square_hz is {square_hz:g}, expected a rate, or 0 for none")
    lengths = [math.dist(begin, end) for begin, end in zip(corners, corners[1:])]
    travel_s = sum(lengths) / plan.speed_mm_s if lengths else 0.0
    rows = (travel_s + plan.hold_s) * 2.0 * square_hz if square_hz else sum(lengths) / plan.step_mm
    if not rows < MOST_ROWS:
        raise bad_input(where, f"needs {rows:.3g} points, expected at most {MOST_ROWS}; make step_mm larger, or the path shorter")
    if square_hz:
        halves = math.ceil(rows - 1e-9)
        # The place is that of the period's beginning.
        times = [(k / (2.0 * square_hz), (k - k % 2) / (2.0 * square_hz), 0.0 if k % 2 else intensity) for k in range(halves)]
    else:
        steps = max(math.ceil(rows), 1)
        moving = [travel_s * k / steps for k in range(steps + 1)] if lengths else [0.0]
        # The last row lasts as long as the one before it.
        times = [(t, t, intensity) for t in moving + ([travel_s + plan.hold_s / 2.0] if plan.hold_s else [])]
    found = [(1e3 * t, *_place(corners, lengths, plan.speed_mm_s * at), level) for t, at, level in times]
    return [tuple(round(number, 6) for number in row) for row in found]  # type: ignore[misc]


def _place(corners: list[tuple[float, ...]], lengths: list[float], gone_mm: float) -> tuple[float, float, float]:
    """Where a focus is that has gone so far; at the end it stays."""
    for begin, end, length in zip(corners, corners[1:], lengths):
        if gone_mm < length:
            x, y, z = (b + gone_mm / length * (e - b) for b, e in zip(begin, end))
            return x, y, z
        gone_mm -= length
    x, y, z = corners[-1]
    return x, y, z


def describe(stimulus: Stimulus, values: Mapping[str, object], where: str) -> dict[str, object]:
    """All that determines the stimulus of a trial."""
    found: dict[str, object] = {"text": fill(stimulus.text, values)}
    if stimulus.compile:
        found["compile"] = [fill(word, values) for word in stimulus.compile]
    if stimulus.live:
        found["live"] = [[fill(word, values) for word in words] for words in stimulus.live]
    if stimulus.path:
        found["path"] = path_rows(stimulus.path, values, where)
    if stimulus.array:
        found["array"] = stimulus.array
    return found


def used_places(stimulus: Stimulus, known: Container[str]) -> set[str]:
    """Names of the placeholders that a stimulus depends on."""
    path = stimulus.path
    numbers = [v for point in path.waypoints_mm for v in point] + [path.intensity, path.square_hz] if path else []
    texts = (stimulus.text, *stimulus.compile, *(word for words in stimulus.live for word in words), *(v for v in numbers if isinstance(v, str)))
    return {name for text in texts for name in names_in(text, known)}


def program(given: str | None) -> str:
    """The C++ program: as given, or of the environment's HAPTOGRAM_PROGRAM, or `haptogram` on the path."""
    wanted = given or os.environ.get("HAPTOGRAM_PROGRAM") or "haptogram"
    found = shutil.which(wanted)
    if not found:
        raise bad_input(wanted, "there is no such program; give --program, or set HAPTOGRAM_PROGRAM")
    return found


class Presenter:
    """Plays nothing: what there is without a port. A trial that is asked without a stimulus says so in its results."""

    def __init__(self, protocol: Protocol) -> None:
        self.protocol = protocol
        self._hashes: dict[tuple[str, ...], dict[str, object]] = {}
        self.began_s = self.ended_s = 0.0  # of the last stimulus, by time.monotonic()
        self.began_by = "host"
        self.began_clock: int | None = None  # of the board, when it tells
        self.began_error_s: float | None = None  # of began_s, from the board's clock

    def began(self) -> dict[str, object]:
        """When the last stimulus began, as the results have it."""
        at = datetime.datetime.fromtimestamp(time.time() + self.began_s - time.monotonic(), datetime.UTC)
        found: dict[str, object] = {"at": at.isoformat(timespec="microseconds"), "by": self.began_by}
        if self.began_error_s is not None:
            found |= {"error_s": round(self.began_error_s, 7), "clock": self.began_clock}
        return found

    def prepare(self, values: Mapping[str, object]) -> dict[str, object]:
        """What the results say of the stimulus: `sha256` of its description, and `played`."""
        key = tuple(str(values[name]) for name in sorted(used_places(self.protocol.stimulus, values)))
        if key not in self._hashes:
            found = describe(self.protocol.stimulus, values, f"{self.protocol.path}: stimulus")
            self._hashes[key] = {"sha256": hashlib.sha256(canonical(found)).hexdigest(), **self._more(found)}
        return self._hashes[key] | {"played": False}

    def _more(self, description: dict[str, object]) -> dict[str, object]:
        return {}

    def start(self) -> None:
        self.began_s = time.monotonic()

    def stop(self) -> None:
        self.ended_s = time.monotonic()

    def close(self) -> None: ...


class Compiler(Presenter):
    """Makes the images of the stimuli in a folder, and plays none."""

    def __init__(self, protocol: Protocol, folder: Path, program: str) -> None:
        super().__init__(protocol)
        self._folder, self.program = folder, program
        if not protocol.stimulus.compile:
            raise bad_input(str(protocol.path), "its stimuli have no images: they are live, or presented by another apparatus; run it without --images, "
                            "and a live one with --port and --from")  # fmt: skip
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise bad_input(str(folder), f"cannot be made: {error.strerror}; choose another folder") from error

    def _more(self, description: dict[str, object]) -> dict[str, object]:
        name = hashlib.sha256(canonical(description)).hexdigest()[:16]
        image, words = self._folder / f"{name}.hex", [str(w) for w in description["compile"]]  # type: ignore[attr-defined]
        rows = description.get("path")
        if isinstance(rows, list):
            path = self._folder / f"{name}.csv"
            path.write_text("time_ms,x_mm,y_mm,z_mm,intensity\n" + "".join(",".join(map(repr, row)) + "\n" for row in rows), encoding="utf-8")
            words += ["--path", str(path), "--points", str(len(rows))]
        if "array" in description:
            words += ["--array", str(description["array"])]
        before = image.read_bytes() if image.exists() else None  # files that a stimulus names may have been others then
        done = subprocess.run([self.program, "compile", *words, "-o", str(image)], capture_output=True, text=True, stdin=subprocess.DEVNULL, check=False)
        if done.returncode:
            raise bad_input(f"{self.protocol.path}: stimulus", f"'haptogram compile {' '.join(words)}' failed: {done.stderr.strip() or done.stdout.strip()}")
        if before not in (None, image.read_bytes()):
            print(f"haptogram-study: {image}: 'haptogram compile {' '.join(words)}' makes another image than it did before; image_sha256 tells which was played",
                  file=sys.stderr, flush=True)
        return {"image_sha256": hashlib.sha256(image.read_bytes()).hexdigest(), "image": image.name}


class Board(Compiler):
    """Plays the images on a board: from start(), or the trigger input after it, to stop(), or to the image's end. When the board's trigger output tells each start, a
    stimulus began when the board says so, and otherwise when this computer knew that it plays."""

    def __init__(self, protocol: Protocol, folder: Path, program: str, port: str, baud: int | None, on_trigger: bool = False) -> None:
        super().__init__(protocol, folder, program)
        self._client, self._on_trigger = Client.open(port, baud), on_trigger
        if on_trigger:
            self._client.trigger()  # says so of a board that has no trigger input
        self._thread: threading.Thread | None = None
        self._asked, self._begun = threading.Event(), threading.Event()
        self._failed: BaseException | None = None
        self._clocks: deque[ClockSample] | None = None
        if self._client.trigger_event() == Event.START:
            self._clocks, self.began_by = deque(maxlen=MOST_CLOCKS), "board"

    def prepare(self, values: Mapping[str, object]) -> dict[str, object]:
        found = super().prepare(values)
        path = self._folder / str(found["image"])
        self._client.upload(Image.load(str(path)), str(path))
        self._sample_clock()
        return found | {"played": True}

    def _sample_clock(self) -> None:
        if self._clocks is not None:
            self._clocks.append(self._client.clock_sample())

    def start(self) -> None:
        """Returns when the board plays, or has failed to, of which stop() tells."""
        self._asked.clear()
        self._begun.clear()
        self._failed = None
        self._thread = threading.Thread(target=self._play, daemon=True)
        self._thread.start()
        self._begun.wait()

    def _play(self) -> None:
        try:
            play(self._client, on_trigger=self._on_trigger, stopped=self._asked.is_set, started=self._begin)
        except BaseException as error:
            self._failed = error
        finally:
            self._begun.set()

    def _begin(self) -> None:
        super().start()
        self._begun.set()

    def stop(self) -> None:
        """Outputs off. Raises HaptogramError when playing had failed."""
        if self._thread:
            self._asked.set()
            self._thread.join()
            self._thread = None
        if isinstance(self._failed, HaptogramError):
            raise self._failed
        if self._failed:
            raise device_error("board", f"playing failed: {self._failed}") from self._failed
        super().stop()
        if self._clocks is not None:
            self._sample_clock()
            fit, self.began_clock = fit_clocks(list(self._clocks)), self._client.trigger().out
            self.began_s, self.began_error_s = fit.host_s(self.began_clock), fit.error_s

    def close(self) -> None:
        try:
            if self._thread:
                self.stop()
        finally:
            self._client.__exit__(None, None, None)


def _ends_with_us() -> Callable[[], None] | None:
    """What a child does first, so that it gets SIGTERM when this program is killed: it drives a board. Linux alone can."""
    if sys.platform != "linux":
        return None
    library, us, set_death_signal = ctypes.CDLL(None), os.getpid(), 1  # PR_SET_PDEATHSIG

    def first() -> None:
        library.prctl(set_death_signal, signal.SIGTERM)
        if os.getppid() != us:  # it was killed before that
            os._exit(1)

    return first


class _Session:
    """One `haptogram live`, from its making to stop(). It is made when the board is about to play, or the program has failed to, of which stop() tells."""

    def __init__(self, command: Sequence[str]) -> None:
        self._command, self._said, self._begun = command, list[str](), threading.Event()
        self._plays = self._asked = False
        # In a session of its own Ctrl-C does not reach it: one signal asks it to turn the outputs off and to wait for the board's word,
        # and a second one not to wait.
        self._running = subprocess.Popen(command, text=True, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                         start_new_session=True, preexec_fn=_ends_with_us())  # fmt: skip
        self._reading = threading.Thread(target=self._listen, daemon=True)
        self._reading.start()

    def _listen(self) -> None:
        assert self._running.stderr is not None
        for line in self._running.stderr:
            self._said.append(line.strip())
            if ": the board " in line:  # what it can do, which is said before the outputs are turned on
                self._plays = True
                self._begun.set()
        self._begun.set()

    def wait(self) -> None:
        self._begun.wait()

    def ask_to_stop(self) -> None:
        if not self._asked:
            self._asked = True
            self._running.send_signal(signal.SIGINT)

    def stop(self) -> None:
        """Outputs off. Raises HaptogramError when playing had failed."""
        self.ask_to_stop()
        code = self._running.wait()
        self._reading.join()
        if code == -signal.SIGINT and not self._plays:  # it still waited for its source
            return
        # Who answers at once stops it before it plays, of which it says so.
        if code and not any("because a signal asked to" in line for line in self._said):
            raise device_error("live", f"'haptogram {' '.join(self._command[1:])}' ended with code {code}: {'; '.join(self._said[-2:])}")


class Live(Presenter):
    """Plays for a tracked hand: `haptogram live`, from start() to stop(), on each array. One whose algorithm is `none` plays nothing."""

    def __init__(self, protocol: Protocol, program: str, ports: Sequence[str], baud: int | None, sources: Sequence[str]) -> None:
        super().__init__(protocol)
        arrays = len(protocol.stimulus.live)
        if not sources:
            raise bad_input("--from", f"is missing; {protocol.name} is for a tracked hand: say what sees it, such as leap-pipe:FIFO or depth-pipe:FIFO")
        if len(ports) != arrays or (arrays > 1 and len(sources) != arrays):
            raise bad_input("--port", f"found {len(ports)} and {len(sources)} --from; {protocol.name} has {arrays} arrays, which want a --port each"
                            + (" and a --from each, in the same order" if arrays > 1 else ""))  # fmt: skip
        self.program = program
        rate = ["--baud", str(baud)] if baud else []
        self._more_words = [[*(word for source in ([sources[i]] if arrays > 1 else sources) for word in ("--from", source)), "--port", port, *rate]
                            for i, port in enumerate(ports)]  # fmt: skip
        self._commands: list[list[str]] = []
        self._running: list[_Session] = []

    def prepare(self, values: Mapping[str, object]) -> dict[str, object]:
        self._commands = []
        for arguments, more in zip(self.protocol.stimulus.live, self._more_words):
            words = [fill(word, values) for word in arguments]
            if "--algorithm" not in words or words[words.index("--algorithm") + 1 :][:1] != ["none"]:
                self._commands.append([self.program, "live", *words, *more])
        return super().prepare(values) | {"played": bool(self._commands)}

    def start(self) -> None:
        """Returns when each board is about to play, or its program has failed to, of which stop() tells."""
        for command in self._commands:
            self._running.append(_Session(command))
        for session in self._running:
            session.wait()
        super().start()

    def stop(self) -> None:
        """Outputs off, of all boards. Raises HaptogramError when playing had failed."""
        for session in self._running:
            session.ask_to_stop()
        running, self._running = self._running, []
        failed: HaptogramError | None = None
        for session in running:
            try:
                session.stop()
            except HaptogramError as error:
                failed = failed or error
        if failed:
            raise failed
        super().stop()

    def close(self) -> None:
        if self._running:
            self.stop()
