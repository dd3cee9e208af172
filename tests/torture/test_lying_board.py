# SPDX-License-Identifier: Apache-2.0
"""The program, and haptogram-py on the same library, before a board that lies. Whatever it says, a command ends soon, with a documented exit code and one sentence that
names the port; outputs that it turned on were turned off; after a signal it turns nothing on. The cases wait more than they compute,
so many of those that are asked for run at the same time, each board in a process of its own. How soon all this is, is asked of a machine
that does nothing else: those cases are marked real_time."""
import concurrent.futures
import multiprocessing
import os
import re
import signal
import struct
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest
from lying_board import (
    CHANNELS,
    DISABLE,
    ENABLE,
    IDENTIFY,
    IDENTITIES,
    LIES,
    PRIMARY,
    RECORD_BYTES,
    REFUSALS,
    SEQUENCE,
    STOP,
    WATCHDOG,
    Frame,
    LyingBoard,
)

pytestmark = pytest.mark.xdist_group("lies")  # one worker, which has them all at a time

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = Path(os.environ.get("HAPTOGRAM_PROGRAM", ROOT / "build/release/host/cli/haptogram")).resolve()
SLOWER = int(os.environ.get("HAPTOGRAM_SLOWER", "1"))  # of a build with sanitizers
PROGRAMS = {"python": [sys.executable, "-m", "haptogram.cli"], "program": [str(PROGRAM)]}
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT / "python"), "PYTHONDONTWRITEBYTECODE": "1"}
AT_ONCE, AT_ONCE_IN_TIME = 24, 3
MOST_S = 300 * SLOWER  # of a command that hangs
TARGET_S = 12 * SLOWER  # of a command that is not told to play longer: 32 rounds without an answer take ten
MOST_CPU_S = 5 * SLOWER
MOST_MEMORY_KB = 400_000 * SLOWER
MOST_FRAMES = 3000  # in any second
MOST_LINES = 3  # of the program's messages: what is wrong, that a port is waited for, what became of the outputs
OF_A_BUSY_MACHINE = re.compile(r": shot \d+: \d+ shots before number \d+ were lost|only \d+ of \d+ frames that made something to feel were played")  # further lines of `live`
SOON_S = 2 * SLOWER  # after a signal nothing is turned on, whatever the machine does; at once is asked of an idle one
INTERRUPTED = 1  # before the outputs were on
LINK = 4
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)

VERBS = {
    "info": ["device", "info"],
    "status": ["device", "status"],
    "disable": ["device", "disable"],
    "upload": ["upload", "image.hex"],
    "upload-verify": ["upload", "image.hex", "--verify", "--json"],
    "list": ["device", "list"],
    "self-test": ["device", "self-test", "--json"],
    "download": ["download", "-o", "out.hex"],
    "play": ["play", "--seconds", "0.6"],
    "play-long": ["play", "--seconds", "8"],
    "play-on": ["play", "--loops", "0"],
    "play-unwatched": ["play", "--seconds", "0.6", "--watchdog", "0"],
    "stream": ["stream", "lines.txt"],
    "stream-on": ["stream", "endless.txt"],
    "enable": ["device", "enable", "--watchdog", "0"],
    "tile-2": ["device", "status"],  # of a chain
    "live": ["live", "--from", "fingers:press", "--seconds", "0.6", "--watchdog", str(5000 * SLOWER)],  # its cameras may take all of a busy machine
    "live-on": ["live", "--from", "fingers:press", "--seconds", "30", "--watchdog", str(5000 * SLOWER)],
    "stream-path": ["stream", "--path", "path.csv", "--array", "tile-10x10", "--loops", "0"],
}
ASKING = ("info", "status", "upload", "download", "play", "stream")  # for an identity
DRIVING = ("play", "stream")


class Case(NamedTuple):
    """A command before a lie, and what its exit code may be. With a signal: when it is sent, so long after the first frame of
    the command `after` has arrived; with `twice`, a second one so long behind it."""

    program: str
    lie: str
    verb: str
    codes: tuple[int, ...]
    signal: int = 0
    after: int = 0
    delay_s: float = 0.0
    twice_s: float = 0.0
    in_time: bool = False

    def __str__(self) -> str:
        words = [self.program, self.lie, self.verb]
        return " ".join(words + ([signal.Signals(self.signal).name, f"after-{self.after}"] if self.signal else []) + (["twice"] if self.twice_s else []))


class Outcome(NamedTuple):
    code: int
    stdout: str
    stderr: str
    seconds: float
    cpu_s: float
    memory_kb: int
    port: str
    frames: list[Frame]
    enabled: bool  # in the end
    trips: int
    signals: list[float]  # when they were sent
    ended_at: float
    killed: bool
    paused_s: float  # the longest time for which this machine let nothing of the test run


def fill(board: LyingBoard) -> None:
    """Eight records and a sequence that plays each for 200 cycles, for ever."""
    record = struct.pack("<4H", 250, 125 << 8, 5, 0) + struct.pack(f"<{CHANNELS}H", *range(CHANNELS))
    memory = board.instrument.memory
    memory[PRIMARY][: 8 * RECORD_BYTES] = 8 * record
    memory[SEQUENCE][:36] = struct.pack("<HH", 8, 0) + b"".join(struct.pack("<HH", index, 200) for index in range(1, 9))


def perform(case: Case, image: str) -> Outcome:
    """In a process of the pool. When this machine paused the board, which is in this process, what came of that is no answer of the command's."""
    for _ in range(5):
        found = perform_once(case, image)
        if found.code in case.codes or found.paused_s < 0.3 or case.in_time:
            break
    return found


def perform_once(case: Case, image: str) -> Outcome:
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        (place / "image.hex").write_text(image)
        (place / "lines.txt").write_text("".join(f"{1 + n % 8} 40\n" for n in range(200)))
        (place / "path.csv").write_text("time_ms,x_mm,y_mm,z_mm,intensity\n" + "".join(f"{10 * n},{n % 40 - 20},0,150,1\n" for n in range(1000)))
        (place / "endless.txt").write_text("".join(f"{1 + n % 8} 60000\n" for n in range(2000)))
        sent: list[float] = []
        first: list[float] = []
        board = LyingBoard(LIES[case.lie](), case.verb.startswith("live"), lambda frame: first.append(frame.at) if frame.command == case.after and not first else None)
        fill(board)
        with board, (place / "out").open("w+") as out, (place / "err").open("w+") as err:
            command = [*PROGRAMS[case.program], *VERBS[case.verb], "--port", board.port + ("#2" if case.verb == "tile-2" else "")]
            command += ["--baud", "1000000"]  # what is told lies is what comes after its rate was found
            if case.verb.startswith(DRIVING) and "--watchdog" not in command and not case.in_time:
                command += ["--watchdog", str(5000 * SLOWER)]  # it speaks as often
            if case.program == "program" and case.verb == "upload":
                command += ["--wait", "1"]
            begun = time.monotonic()
            process = subprocess.Popen(command, cwd=place, env=ENVIRONMENT, stdin=subprocess.DEVNULL, stdout=out, stderr=err, start_new_session=True,
                                       preexec_fn=_default_signals)  # fmt: skip
            killed, paused_s, now = False, 0.0, begun
            while True:
                ended, status, usage = os.wait4(process.pid, os.WNOHANG)
                paused_s = max(paused_s, time.monotonic() - now)
                now = time.monotonic()
                if ended:
                    break
                if now - begun > MOST_S:
                    process.kill()
                    killed = True
                due = [first[0] + case.delay_s, first[0] + case.delay_s + case.twice_s][: 2 if case.twice_s else 1] if first and case.signal else []
                if len(sent) < len(due) and now >= due[len(sent)]:
                    os.kill(process.pid, case.signal)
                    sent.append(time.monotonic())
                time.sleep(0.005)
            process.returncode = os.waitstatus_to_exitcode(status)
            enabled, ended_at = board.instrument.enabled, time.monotonic()
            time.sleep(0.05)
            out.seek(0)
            err.seek(0)
            return Outcome(process.returncode, out.read(), err.read(), ended_at - begun, usage.ru_utime + usage.ru_stime, usage.ru_maxrss, board.port, board.frames, enabled,
                           board.instrument.trips, sent, ended_at, killed, paused_s)  # fmt: skip


def _default_signals() -> None:
    for number in SIGNALS:
        signal.signal(number, signal.SIG_DFL)


def _cases(program: str) -> list[Case]:
    """Each lie before the commands that it concerns."""
    cases: list[Case] = []

    def add(lie: str, verbs: tuple[str, ...], *codes: int) -> None:
        cases.extend(Case(program, lie, verb, codes) for verb in verbs)

    # Those that take longest come first.
    add("silent-from-enable", (*DRIVING, "play-unwatched", "enable"), LINK)
    add("silent-from-start", ("play",), LINK)
    add("loses-read", ("download", "play"), LINK)
    add("loses-status", ("status", *DRIVING), LINK)
    add("loses-digest", ("upload",), LINK)
    add("loses-write", ("upload",), 0, LINK)
    add("loses-start", ("play",), 0, LINK)
    add("loses-enable", (*DRIVING, "enable"), 0, LINK)
    for lie in ("silent", "babbles", "babbles-zeros", "babbles-answers"):
        add(lie, (*ASKING, "disable"), LINK)
    for seed in range(2, 6):
        add(f"late-{seed}", ("play-long",), 0)
    add("late", (*ASKING, "disable"), 0)
    add("loses-identify", ASKING, LINK)
    add("loses-identify", ("disable",), 0)
    add("loses-disable", (*DRIVING, "disable"), LINK)
    add("loses-disable-and-stop", (*DRIVING, "disable", "play-unwatched"), LINK)
    add("loses-stop", (*DRIVING, "disable"), 0, LINK)
    for lie in ("honest", "twice", "babbles-beside"):
        add(lie, (*ASKING, "disable"), 0)
    add("backwards", (*ASKING, "disable"), 0, LINK)  # no line does that
    add("forgets", ("upload", "upload-verify"), LINK)
    for lie in ("honest", "twice", "late", "babbles-beside"):
        add(lie, ("upload-verify",), 0)
    for length in (0, 1, 7, 400):
        add(f"read-of-{length}", ("upload-verify",), LINK)
    for length in (0, 1, 7, 400):
        add(f"read-of-{length}", ("download", "play"), LINK)
    for length in (0, 3, 8):
        add(f"digest-of-{length}", ("upload",), LINK)
    for length in (0, 33, 42, 300):
        add(f"status-of-{length}", ("status", *DRIVING), LINK)
    for length in (0, 17, 18, 51, 54, 600):
        add(f"identify-of-{length}", ("status", "play"), LINK)
    add("write-of-9", ("upload",), LINK)
    for name in IDENTITIES:
        dangerous = name.startswith(("live", "sequence", "channels", "name"))
        add(f"identity-{name}", ("info", "stream", "play", "download") if dangerous else ("play",), LINK)
    add("status-role-3", ("status", *DRIVING), LINK)
    add("status-level-65535", ("status", *DRIVING), LINK)
    add("status-stands-still", ("play",), 0)
    add("level-65535", ("upload", *DRIVING), 0, LINK)
    add("sequence-length-32767", ("play", "download"), LINK)
    add("sequence-length-0", ("play", "download"), LINK)
    add("sequence-of-record-65535", ("download",), 0, LINK)
    add("sequence-of-silence", ("download",), LINK)
    for lie in ("silent", "babbles", "babbles-zeros", "babbles-answers", "honest"):
        add(lie, ("tile-2",), LINK)
    add("hangs-up-at-identify", ("status", "play"), LINK)
    add("hangs-up-at-write", ("upload",), LINK)
    add("hangs-up-at-start", ("play",), LINK)
    for status in REFUSALS:
        add(f"refuses-{status:#04x}", ("play",), LINK)
    add("refuses-0x04", (*DRIVING, "upload", "download"), LINK)
    add("refuses-0x02", ("stream", "upload", "download", "status"), LINK)
    if program == "program":
        for lie in ("honest", "late", "twice", "backwards"):
            add(lie, ("live",), 0)
        for lie in ("silent-from-enable", "silent", "babbles", "loses-status", "loses-disable-and-stop", "identity-live-depth-3", "identity-channels-0", "refuses-0x05"):
            add(lie, ("live",), LINK)
        for lie in ("honest", "silent", "babbles", "babbles-zeros", "backwards", "identity-channels-0", "identity-name-escapes", "identify-of-17"):
            add(lie, ("list",), 0, LINK)
        for lie in ("honest", "silent", "babbles", "silent-from-enable", "loses-disable-and-stop", "loses-status", "read-of-7", "status-stands-still", "refuses-0x05"):
            add(lie, ("self-test",), 0, 1, LINK)
    add("refuses-0x0a", ("disable",), 0)  # whatever the board says of it, it acted
    add("refuses-0x04", ("disable",), 0)
    return cases


def _signalled(program: str) -> list[Case]:
    """Commands that get a signal before the outputs are on, and while they are."""
    before = [Case(program, "late-identity", verb, (0, LINK, INTERRUPTED), number, IDENTIFY, 0.3)
              for verb in ("play-on", "stream-on") for number in SIGNALS]  # fmt: skip
    before += [Case(program, lie, "play-on", (0, LINK, INTERRUPTED), signal.SIGINT, IDENTIFY, 0.5) for lie in ("silent", "babbles", "babbles-answers")]
    before += [Case(program, "silent-from-watchdog", verb, (0, LINK, INTERRUPTED), signal.SIGTERM, WATCHDOG, 0.5) for verb in ("play-on", "stream-on")]
    on = [Case(program, "honest", verb, (0, INTERRUPTED), number, ENABLE, 0.5) for verb in ("play-on", "stream-on") for number in SIGNALS]
    on += [Case(program, "silent-from-enable", verb, (LINK,), number, ENABLE, 0.7) for verb in ("play-on", "stream-on") for number in SIGNALS[:3]]
    on += [Case(program, "silent-from-enable", "enable", (LINK,), signal.SIGINT, ENABLE, 0.7)]
    on += [Case(program, "loses-disable-and-stop", "play-on", (LINK,), signal.SIGINT, ENABLE, 0.7)]
    on += [Case(program, "status-stands-still", "stream", (0, INTERRUPTED), signal.SIGINT, ENABLE, 1.5)]
    on += [Case(program, "silent-from-enable", "play-on", (0, LINK, INTERRUPTED, -signal.SIGINT), signal.SIGINT, ENABLE, 0.7, 0.7)]
    if program == "program":
        before += [Case(program, "late-identity", verb, (0, LINK, INTERRUPTED), number, IDENTIFY, 0.3) for verb in ("live-on", "stream-path") for number in SIGNALS[:2]]
        on += [Case(program, "honest", verb, (0, INTERRUPTED), number, ENABLE, 0.5) for verb in ("live-on", "stream-path") for number in SIGNALS]
        on += [Case(program, "silent-from-enable", verb, (LINK,), signal.SIGINT, ENABLE, 0.7) for verb in ("live-on", "stream-path")]
    return before + on


@pytest.fixture(scope="session")
def image(tmp_path_factory: pytest.TempPathFactory) -> str:
    assert PROGRAM.is_file(), f"{PROGRAM} is missing: build it, or name it in HAPTOGRAM_PROGRAM"
    folder = tmp_path_factory.mktemp("image")
    subprocess.run([str(PROGRAM), "compile", "--shape", "circle", "--points", "8", "--rate", "500", "-o", "image.hex"], cwd=folder, check=True,
                   stdout=subprocess.DEVNULL)  # fmt: skip
    return (folder / "image.hex").read_text()


@pytest.fixture(scope="session")
def outcomes(request: pytest.FixtureRequest, image: str):
    """All that this run asks for, begun at once."""
    cases = [item.callspec.params["case"] for item in request.session.items if item.path == Path(__file__) and hasattr(item, "callspec")]
    at_once = AT_ONCE_IN_TIME if any(case.in_time for case in cases) else AT_ONCE
    with concurrent.futures.ProcessPoolExecutor(at_once, multiprocessing.get_context("forkserver")) as pool:
        yield {case: pool.submit(perform, case, image) for case in dict.fromkeys(cases)}


def require_order(case: Case, found: Outcome) -> None:
    """What holds whatever the board says."""
    story = f"{case}: exit code {found.code} after {found.seconds:.1f} s\n{found.stdout[-500:]}\n{found.stderr[-2000:]}\n" + " ".join(f.name for f in found.frames[-30:])
    assert not found.killed, f"had not ended; {story}"
    assert found.code in case.codes, f"expected {case.codes}; {story}"
    assert "Traceback" not in found.stderr and "Sanitizer" not in found.stderr, story
    assert (found.stdout + found.stderr).replace("\n", "").isprintable(), f"what the board said went to the terminal raw; {story}"
    if found.code == LINK:
        lines = [line for line in found.stderr.splitlines() if not OF_A_BUSY_MACHINE.search(line)]
        most = 1 if case.program == "python" else MOST_LINES
        assert 1 <= len(lines) <= most and all(line.startswith(("haptogram: ", "haptogram-py: ")) for line in lines), f"expected one message; {story}"
    assert found.cpu_s < MOST_CPU_S, f"computed for {found.cpu_s:.1f} s; {story}"
    assert found.memory_kb < MOST_MEMORY_KB, f"{found.memory_kb} KiB; {story}"
    times = [frame.at for frame in found.frames]
    assert all(later - first > 1 for first, later in zip(times, times[MOST_FRAMES:], strict=False)), f"more than {MOST_FRAMES} frames in a second; {story}"
    commands = [frame.command for frame in found.frames]
    if ENABLE in commands and not case.lie.startswith("hangs-up"):
        last = len(commands) - commands[::-1].index(ENABLE)
        assert DISABLE in commands[last:] and STOP in commands[last:], f"outputs were turned on and not off; {story}"
        assert not found.enabled, f"outputs are on; {story}"


NAMED = [Case(program, lie, verb, (LINK,)) for program in ("python",)  # the program says "board", and was given one port
         for lie, verb in (("silent", "info"), ("babbles", "status"), ("refuses-0x02", "play"), ("identity-channels-0", "play"), ("read-of-7", "download"),
                           ("loses-digest", "upload"), ("loses-disable", "disable"))]  # fmt: skip


BEARABLE = ("late", "honest", "twice", "backwards", "babbles-beside")  # lines


def judge(case: Case, outcomes) -> None:
    found = outcomes[case].result(timeout=600)
    require_order(case, found)
    if case.lie.startswith(BEARABLE):
        assert found.trips == 0, f"{case}: the watchdog tripped"


def judge_signalled(case: Case, outcomes) -> Outcome:
    found = outcomes[case].result(timeout=600)
    assert found.signals, f"{case}: ended before the signal with {found.code}: {found.stderr}"
    require_order(case, found)
    at = found.signals[0]
    late = [frame for frame in found.frames if frame.command == ENABLE and frame.at > at + (0.02 if case.in_time else SOON_S)]
    assert not late, f"{case}: outputs were turned on {late[0].at - at:.2f} s after the signal"
    if case.after == ENABLE:
        assert any(frame.command == DISABLE and frame.at >= at for frame in found.frames), f"{case}: outputs were not turned off after the signal"
    return found


# haptogram-py has the program's link, so it is asked for one case of each command and kind of error.
OF_PYTHON = {f"python {words}" for words in (
    "honest info", "honest status", "honest upload", "honest upload-verify", "honest disable", "late play", "twice stream", "babbles-beside download",
    "late-2 play-long", "babbles info", "silent disable", "babbles-answers tile-2", "loses-write upload", "forgets upload-verify", "read-of-7 download",
    "status-of-33 status", "identify-of-17 play", "identity-name-escapes play", "level-65535 stream", "sequence-length-0 play", "refuses-0x04 play",
    "hangs-up-at-write upload", "hangs-up-at-start play", "silent-from-enable stream", "silent-from-enable enable", "loses-disable-and-stop play-unwatched",
    "late-identity play-on SIGINT after-1", "silent play-on SIGINT after-1", "silent-from-watchdog stream-on SIGTERM after-10",
    "honest play-on SIGINT after-4", "honest stream-on SIGTERM after-4", "honest play-on SIGHUP after-4", "honest stream-on SIGQUIT after-4",
    "silent-from-enable play-on SIGINT after-4", "silent-from-enable enable SIGINT after-4", "silent-from-enable play-on SIGINT after-4 twice")}  # fmt: skip


def of(program: str, cases: Callable[[str], list[Case]]) -> list[Case]:
    return [case for case in cases(program) if program != "python" or str(case) in OF_PYTHON]


@pytest.mark.parametrize("case", of("python", _cases), ids=str)
def test_the_python_client_before_a_lie(case, outcomes):
    judge(case, outcomes)


@pytest.mark.parametrize("case", of("python", _signalled), ids=str)
def test_the_python_client_gets_a_signal(case, outcomes):
    judge_signalled(case, outcomes)


def test_each_case_of_python_is_one():
    assert OF_PYTHON == {str(case) for cases in (_cases, _signalled) for case in of("python", cases)}


@pytest.mark.parametrize("case", _cases("program"), ids=str)
def test_the_program_before_a_lie(case, outcomes):
    judge(case, outcomes)


@pytest.mark.parametrize("case", _signalled("program"), ids=str)
def test_the_program_gets_a_signal(case, outcomes):
    judge_signalled(case, outcomes)


def _in_time(cases: list[Case]) -> list[Case]:
    return [case._replace(in_time=True) for case in cases]


@pytest.mark.real_time
@pytest.mark.parametrize("case", _in_time([case for program in PROGRAMS for case in of(program, _signalled) if case.signal == signal.SIGINT or case.program == "program"]), ids=str)
def test_a_signal_acts_at_once(case, outcomes, figure):
    found = judge_signalled(case, outcomes)
    at = found.signals[0]
    if case.after == ENABLE:
        figure(f"{case}: DISABLE after", min(frame.at - at for frame in found.frames if frame.command == DISABLE and frame.at >= at), 0.2 * SLOWER)
    if case.lie == "honest" and case.verb != "live-on":  # whose simulated cameras take much of a machine
        on = [frame.at for frame in found.frames if frame.at <= at and frame.at >= next(f.at for f in found.frames if f.command == ENABLE)]
        figure(f"{case}: nothing said, outputs on, for", max(b - a for a, b in zip(on, [*on[1:], at], strict=True)), 0.12 * SLOWER)
    figure(f"{case}: ended after", found.ended_at - found.signals[-1], (0.5 if case.twice_s else 2.3) * SLOWER)  # a silent board is given 2 s


@pytest.mark.real_time
@pytest.mark.parametrize("case", _in_time([case for program in PROGRAMS for case in of(program, _cases)
                                           if case.lie.startswith(BEARABLE) and case.lie != "late-identity" and case.verb.startswith((*DRIVING, "live"))]), ids=str)  # fmt: skip
def test_a_bad_line_trips_no_watchdog(case, outcomes):
    """That of 500 ms, which a command has if nothing else is said."""
    judge(case, outcomes)


@pytest.mark.real_time
@pytest.mark.parametrize("case", _in_time([case for case in _cases("program") if case.lie in ("silent", "babbles", "loses-status", "silent-from-enable")]), ids=str)
def test_a_board_that_does_not_answer_is_soon_given_up(case, outcomes, figure):
    judge(case, outcomes)
    figure(f"{case}: given up after", outcomes[case].result().seconds, TARGET_S)


@pytest.mark.parametrize("case", NAMED, ids=str)
def test_messages_name_the_port(case, outcomes):
    found = outcomes[case].result(timeout=600)
    assert found.code == LINK and found.port in found.stderr, f"expected {found.port} in: {found.stderr}"


def test_a_lying_board_without_a_lie_is_a_board(outcomes):
    """What the assertions above rest on: its frames are recorded, and its outputs are on in between."""
    found = next((future.result(timeout=600) for case, future in outcomes.items() if (case.program, case.lie, case.verb) == ("python", "late", "play")), None)
    if found is None:
        pytest.skip("the case that it looks at was not asked for")
    commands = [frame.name for frame in found.frames]
    assert commands.index("watchdog") < commands.index("enable") < commands.index("start") < commands.index("disable")
    assert "status" in commands[commands.index("start"):commands.index("disable")]
