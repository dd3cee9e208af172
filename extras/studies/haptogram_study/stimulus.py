# SPDX-License-Identifier: Apache-2.0
"""What a trial presents: its description and hash, its image by `haptogram compile`, and playing it on a board while a person answers."""
import ctypes
import datetime
import hashlib
import math
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from haptogram.client import Client
from haptogram.driving import play
from haptogram.errors import ErrorCode, HaptogramError, bad_input, device_error
from haptogram.image import Image
from haptogram.interface import Event
from haptogram.trigger import ClockSample, fit_clocks
from . import program as programs
from .protocol import PathPlan, Protocol, Stimulus, Value, canonical, fill, names_in

MOST_ROWS = 100_000
MOST_CLOCKS = 200
IMAGES_ARE_OF = ("compile", "path", "movement", "array", "board")  # what of a description decides an image


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
    step_mm = _number(plan.step_mm, values, where) or (0.0 if square_hz else 0.5)
    if step_mm < 0.0:
        raise bad_input(where, f"step_mm is {step_mm:g}, expected a length, or 0")
    lengths = [math.dist(begin, end) for begin, end in zip(corners, corners[1:])]
    travel_s = sum(lengths) / plan.speed_mm_s if lengths else 0.0
    rows = (travel_s + plan.hold_s) * 2.0 * square_hz if square_hz else sum(lengths) / step_mm
    if not rows < MOST_ROWS:
        raise bad_input(where, f"needs {rows:.3g} points, expected at most {MOST_ROWS}; make step_mm larger, or the path shorter")
    if square_hz:
        halves = math.ceil(rows - 1e-9)
        # The place is that of the period's beginning, or of that of the last whole step.
        step_s = step_mm / plan.speed_mm_s if lengths and step_mm else 0.0
        periods = [k // 2 / square_hz for k in range(halves)]
        times = [(k / (2.0 * square_hz), math.floor(at / step_s + 1e-9) * step_s if step_s and at < travel_s else at, 0.0 if k % 2 else intensity)
                 for k, at in enumerate(periods)]  # fmt: skip
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
    if stimulus.movement:
        found["movement"] = [fill(word, values) for word in stimulus.movement]
    if stimulus.path:
        found["path"] = path_rows(stimulus.path, values, where)
    if stimulus.array:
        found["array"] = stimulus.array
    return found


def used_places(stimulus: Stimulus, known: Container[str]) -> set[str]:
    """Names of the placeholders that a stimulus depends on."""
    path = stimulus.path
    numbers = [v for point in path.waypoints_mm for v in point] + [path.intensity, path.square_hz] if path else []
    texts = (stimulus.text, *stimulus.compile, *stimulus.movement, *(word for words in stimulus.live for word in words), *(v for v in numbers if isinstance(v, str)))
    return {name for text in texts for name in names_in(text, known)}


@dataclass(frozen=True)
class MadeFor:
    """What stimuli are made for, where it is not left to the array that the protocol names: names that the program knows."""

    board: str = ""
    array: str = ""


class Presenter:
    """Plays nothing: what there is without a port. A trial that is asked without a stimulus says so in its results."""

    def __init__(self, protocol: Protocol, made_for: MadeFor = MadeFor()) -> None:
        self.protocol, self._board, self._array = protocol, made_for.board, made_for.array
        self.fitted = protocol.fits()[0]
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

    @property
    def made_for(self) -> dict[str, object] | None:
        """What the stimuli were made for, as the results have it; None where the protocol alone says it."""
        found: dict[str, object] = {"board": self._board, "array": self._array, "fitted": self.fitted}
        return {name: value for name, value in found.items() if value} or None

    def fit(self, stimuli: Sequence[Mapping[str, object]]) -> None:
        """Before the first trial: finds the fitted numbers, and raises HaptogramError when one of the stimuli cannot be presented."""

    def prepare(self, values: Mapping[str, object]) -> dict[str, object]:
        """What the results say of the stimulus: `sha256` of its description, and `played`."""
        values = {**values, **self.fitted}
        key = tuple(str(values[name]) for name in sorted(used_places(self.protocol.stimulus, values)))
        if key not in self._hashes:
            found = describe(self.protocol.stimulus, values, f"{self.protocol.path}: stimulus")
            found |= {name: given for name, given in (("board", self._board), ("array", self._array)) if given}
            self._hashes[key] = {"sha256": hashlib.sha256(canonical(found)).hexdigest(), **self._more(found)}
        return self._hashes[key] | {"played": False}

    def _more(self, description: dict[str, object]) -> dict[str, object]:
        return {}

    def start(self) -> None:
        self.began_s = time.monotonic()

    def stop(self) -> None:
        self.ended_s = time.monotonic()

    def close(self) -> None: ...


def _unplayable(protocol: Protocol, board: str, error: HaptogramError) -> HaptogramError:
    """What is said before the first trial."""
    return HaptogramError(error.code, protocol.name, f"cannot be played{f' on {board}' if board else ''}: {error}"
                          + ("" if board else "; if it is made for another board than yours, give --board ('haptogram board list' has their names)"))  # fmt: skip


def _array_of(program: str, board: str) -> str:
    """The array of a shipped board, "" of what is none."""
    listed = json.loads(programs.ask(program, ["board", "list", "--json"], "--board"))
    return next((str(one["array"]) for one in listed if one["board"] == board), "")


class Compiler(Presenter):
    """Makes the images of the stimuli in a folder, and plays none."""

    def __init__(self, protocol: Protocol, made_for: MadeFor, folder: Path, program: str) -> None:
        super().__init__(protocol, made_for)
        self._folder, self.program = folder, program
        self._made: dict[str, dict[str, object]] = {}
        if not protocol.stimulus.compile:
            raise bad_input(str(protocol.path), "its stimuli have no images: they are live, or presented by another apparatus; run it without --images, "
                            "and a live one with --port and --from")  # fmt: skip
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise bad_input(str(folder), f"cannot be made: {error.strerror}; choose another folder") from error

    def fit(self, stimuli: Sequence[Mapping[str, object]]) -> None:
        """Makes the image of each."""
        for self.fitted in self.protocol.fits():
            try:
                for values in stimuli:
                    Presenter.prepare(self, values)
                return
            except HaptogramError as error:
                failed = error
        raise _unplayable(self.protocol, self._board, failed)

    def _more(self, description: dict[str, object]) -> dict[str, object]:
        of_image = {key: description[key] for key in IMAGES_ARE_OF if key in description}
        name = hashlib.sha256(canonical(of_image)).hexdigest()[:16]
        if name not in self._made:
            self._made[name] = self._make(name, of_image)
        return self._made[name]

    def _make(self, name: str, description: dict[str, object]) -> dict[str, object]:
        image, words = self._folder / f"{name}.hex", [str(w) for w in description["compile"]]  # type: ignore[attr-defined]
        made_for = [word for option in ("array", "board") if option in description for word in (f"--{option}", str(description[option]))]
        rows = description.get("path")
        if isinstance(rows, list):
            path = self._folder / f"{name}.csv"
            path.write_text("time_ms,x_mm,y_mm,z_mm,intensity\n" + "".join(",".join(map(repr, row)) + "\n" for row in rows), encoding="utf-8")
            words += ["--path", str(path)]
        if "movement" in description:
            path = self._folder / f"{name}.path.json"
            moves = [str(w) for w in description["movement"]]  # type: ignore[attr-defined]
            programs.ask(self.program, ["movement", *moves, *made_for, "-o", str(path)], f"{self.protocol.path}: stimulus")
            words += ["--path", str(path)]
        words += made_for
        before = image.read_bytes() if image.exists() else None  # files that a stimulus names may have been others then
        programs.ask(self.program, ["compile", *words, "-o", str(image)], f"{self.protocol.path}: stimulus")
        if before not in (None, image.read_bytes()):
            print(f"haptogram-study: {image}: 'haptogram compile {' '.join(words)}' makes another image than it did before; image_sha256 tells which was played",
                  file=sys.stderr, flush=True)
        return {"image_sha256": hashlib.sha256(image.read_bytes()).hexdigest(), "image": image.name}


class Board(Compiler):
    """Plays the images on a board: from start(), or the trigger input after it, to stop(), or to the image's end. When the board's trigger output tells each start, a
    stimulus began when the board says so, and otherwise when this computer knew that it plays."""

    def __init__(self, protocol: Protocol, made_for: MadeFor, folder: Path, program: str, port: str, baud: int | None, on_trigger: bool = False) -> None:
        super().__init__(protocol, made_for, folder, program)
        self._client, self._on_trigger = Client.open(port, baud), on_trigger
        if on_trigger:
            self._client.trigger()  # says so of a board that has no trigger input
        self._thread: threading.Thread | None = None
        self._asked, self._begun = threading.Event(), threading.Event()
        self._failed: BaseException | None = None
        self._clocks: deque[ClockSample] | None = None
        if self._client.trigger_event() == Event.START:
            self._clocks, self.began_by = deque(maxlen=MOST_CLOCKS), "board"

    def _make(self, name: str, description: dict[str, object]) -> dict[str, object]:
        found = super()._make(name, description)
        image = str(self._folder / str(found["image"]))
        Image.load(image).require_fits(self._client.identity, image)
        return found

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
            play(self._client, on_trigger=self._on_trigger, stopped=self._asked.is_set, started=self._begin, pause=self._asked.wait)
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

    def __init__(self, protocol: Protocol, made_for: MadeFor, program: str, ports: Sequence[str], baud: int | None, sources: Sequence[str]) -> None:
        super().__init__(protocol, made_for if made_for.array or not made_for.board else replace(made_for, array=_array_of(program, made_for.board)))
        arrays = len(protocol.stimulus.live)
        if not sources:
            raise bad_input("--from", f"is missing; {protocol.name} is for a tracked hand: say what sees it, such as leap-pipe:FIFO or depth-pipe:FIFO")
        if len(ports) != arrays or (arrays > 1 and len(sources) != arrays):
            raise bad_input("--port", f"found {len(ports)} and {len(sources)} --from; {protocol.name} has {arrays} arrays, which want a --port each"
                            + (" and a --from each, in the same order" if arrays > 1 else ""))  # fmt: skip
        self.program = program
        self._sources = [[word for source in ([sources[i]] if arrays > 1 else sources) for word in ("--from", source)] for i in range(arrays)]
        array, rate = ["--array", self._array] if self._array else [], ["--baud", str(baud)] if baud else []
        self._boards = [["--port", port, *rate, *array] for port in ports]
        self._commands: list[list[str]] = []
        self._running: list[_Session] = []

    def _words(self, values: Mapping[str, object], sources: Sequence[Sequence[str]]) -> list[list[str]]:
        """The commands that play a stimulus."""
        filled = ([fill(word, values) for word in arguments] for arguments in self.protocol.stimulus.live)
        return [["live", *words, *source, *board] for words, source, board in zip(filled, sources, self._boards)
                if "--algorithm" not in words or words[words.index("--algorithm") + 1 :][:1] != ["none"]]  # fmt: skip

    def fit(self, stimuli: Sequence[Mapping[str, object]]) -> None:
        """Asks each board whether it could play, with a tracker that ends before its first hand, so the outputs stay off."""
        for values in {tuple(values[f.name] for f in self.protocol.factors): values for values in stimuli}.values():
            for words in self._words(values, len(self._boards) * [["--from", "leap-pipe:/dev/null"]]):
                try:
                    programs.ask(self.program, words, "live", ErrorCode.DEVICE)
                except HaptogramError as error:
                    raise _unplayable(self.protocol, self._board, error) from error

    def prepare(self, values: Mapping[str, object]) -> dict[str, object]:
        self._commands = [[self.program, *words] for words in self._words(values, self._sources)]
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
