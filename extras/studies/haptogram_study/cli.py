# SPDX-License-Identifier: Apache-2.0
"""The commands of `python3 -m haptogram_study`. Messages are `haptogram-study: where: message` on stderr."""
import argparse
import atexit
import contextlib
import json
import platform
import signal
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from haptogram import __version__
from haptogram.cli import Parser, whole
from haptogram.errors import ErrorCode, HaptogramError, bad_input
from haptogram.markers import Markers, no_mark
from haptogram.program import exit_code_of, find_program
from . import design, program, results, touching
from . import protocol as protocols
from .asking import Keyboard, Observer, Page, Stopped
from .observers import read_protocol, simulated
from .protocol import Protocol
from .session import Session
from .stimulus import Board, Compiler, Live, MadeFor, Presenter

NOT_FINISHED = 1


def say(text: str) -> None:
    print(f"haptogram-study: {text}", file=sys.stderr, flush=True)


def list_command(options: argparse.Namespace) -> int:
    found = {name: read_protocol(path) for name, path in protocols.shipped().items()}
    bad: dict[str, str] = {}
    for name, path in protocols.in_folder(Path(options.folder)).items() if options.folder else ():
        try:
            found[name] = read_protocol(path)
        except HaptogramError as error:
            bad[name] = str(error)
    if options.json:
        good = {name: {"title": p.title, "source": p.source, "trials": p.trials, "participants": p.participants, "playable": bool(p.stimulus.compile)}
                for name, p in found.items()}  # fmt: skip
        print(json.dumps(good | {name: {"error": error} for name, error in bad.items()}, indent=1))
    else:
        for name, p in found.items():
            print(f"{name:22} {p.participants:3} people × {p.trials:3} {'runs  ' if p.staircase else 'trials'}  {p.title} ({p.source})")
        for error in bad.values():
            say(error)
    return 0


def _made_for(options: argparse.Namespace) -> MadeFor:
    return MadeFor(options.board or "", options.array or "")


def _plays(protocol: Protocol, made_for: MadeFor, given: str | None) -> str:
    """What a board that has been named plays of it. Raises HaptogramError when it cannot."""
    if made_for == MadeFor():
        return ""
    if protocol.stimulus.live:
        return "; a hand is followed as fast as the board's line allows: run says so at its port"
    if not protocol.stimulus.compile:
        return "; needs no board"
    with tempfile.TemporaryDirectory() as folder:
        made = Compiler(protocol, made_for, Path(folder), find_program(given))
        made.fit(design.stimuli(protocol, 1, 1))
    return f"; its stimuli fit {' '.join(filter(None, (made_for.board, made_for.array)))}" + "".join(f", with {name} = {value}" for name, value in made.fitted.items())


def check_command(options: argparse.Namespace) -> int:
    bad = 0
    for name in options.protocols or protocols.shipped():
        try:
            found = read_protocol(protocols.find(name))
            plays = _plays(found, _made_for(options), options.program)
            print(f"{name}: good: {found.trials} {'runs' if found.staircase else 'trials'} a participant, {len(found.questions)} questions, {len(found.analyses)} analyses{plays}")
        except HaptogramError as error:
            say(str(error))
            bad += 1
    return ErrorCode.BAD_INPUT if bad else 0


def _presenter(options: argparse.Namespace, protocol: Protocol) -> Presenter:
    if options.on_trigger and (protocol.stimulus.live or not options.ports):
        raise bad_input("--on-trigger", f"a board begins an image when its trigger input says so; {protocol.name} has live stimuli, or no --port was given")
    made_for = _made_for(options)
    if protocol.stimulus.live and options.ports:
        return Live(protocol, made_for, find_program(options.program), options.ports, options.baud, options.sources)
    if options.sources:
        raise bad_input("--from", f"{protocol.name} has no live stimuli, or no --port was given to play them on")
    if len(options.ports) > 1:
        raise bad_input("--port", f"is given {len(options.ports)} times; the stimuli of {protocol.name} are for one board")
    if options.ports:
        return Board(protocol, made_for, Path(options.images or "study-images"), find_program(options.program), options.ports[0], options.baud, options.on_trigger)
    if options.images:
        return Compiler(protocol, made_for, Path(options.images), find_program(options.program))
    if made_for != MadeFor():
        raise bad_input("--board" if made_for.board else "--array", "is what stimuli are made for, and none is made; give --port, or --images")
    return Presenter(protocol)


def _versions(presenter: Presenter) -> dict[str, str]:
    found = {"haptogram-py": __version__, "python": platform.python_version()}
    if isinstance(presenter, Compiler | Live):
        found["haptogram"] = program.ask(presenter.program, ["--version"], presenter.program).strip().removeprefix("haptogram ")
    return found


def _observer(options: argparse.Namespace, protocol: Protocol) -> Observer:
    if options.observer == "keyboard":
        return Keyboard()
    if options.observer == "page":
        return Page(protocol.trials)
    if options.observer == touching.NAME:
        return touching.Hand(protocol, find_program(options.program))
    return simulated(protocol, options.observer)


def _marking(options: argparse.Namespace, protocol: Protocol) -> Callable[..., None]:
    if not options.lsl:
        return no_mark
    markers = Markers(f"haptogram {protocol.name} {options.participant}")
    say("waits until somebody records the stream haptogram, of the type Markers")
    markers.wait()
    atexit.register(markers.close)
    return markers.mark


def _end(number: int, frame: object) -> None:
    """The program that shows the page ends a session as Ctrl-C does: outputs off, and results that can be gone on with."""
    signal.signal(number, signal.SIG_IGN)  # once is enough
    raise KeyboardInterrupt


def run_command(options: argparse.Namespace) -> int:
    protocol = read_protocol(protocols.find(options.protocol))
    observer = _observer(options, protocol)
    with results.ResultsFile(Path(options.output)) as file:
        if file.moved:
            say(f"{options.output}: its last line was not complete; it is now in {file.moved}, and its trial is asked again")
        file.require_same(protocol=protocol.name, protocol_sha256=protocol.sha256, participant=options.participant, seed=options.seed, observer=observer.name)
        with contextlib.closing(_presenter(options, protocol)) as presenter:
            session = None
            try:
                signal.signal(signal.SIGTERM, _end)
                presenter.fit(design.stimuli(protocol, options.participant, options.seed))
                file.require_same(made_for=presenter.made_for)
                mark = _marking(options, protocol)
                if not options.ports:
                    say("no --port was given: no stimulus is played")
                if file.before:
                    say(f"{options.output}: goes on after {len(file.before)} records")
                elif observer.waits:
                    for text in (protocol.title, *protocol.instructions):
                        observer.tell(text)
                session = Session(protocol, options.participant, options.seed, observer, presenter, file.append, before=file.before,
                                  versions=_versions(presenter), mark=mark)  # fmt: skip
                session.run()
            except (Stopped, KeyboardInterrupt):
                say(f"{options.output}: stopped after {session.asked if session else 0} more answers; the same command goes on with it")
                return NOT_FINISHED
    say(f"{options.output}: complete, {session.asked} new answers")
    return 0


def analyse_command(options: argparse.Namespace) -> int:
    from . import analysis

    protocol = read_protocol(protocols.find(options.protocol))
    records = [pair for name in options.results for pair in results.read(Path(name))]
    study = analysis.study(protocol, records, mixed=options.mixed, unfinished=options.unfinished)
    print(json.dumps(study.as_json(), indent=1, allow_nan=False) if options.json else study.report())
    return 0


def power_command(options: argparse.Namespace) -> int:
    from . import analysis

    protocol = read_protocol(protocols.find(options.protocol))
    participants = options.participants or protocol.participants
    found = analysis.power(protocol, options.observer, participants, options.runs, options.seed, options.alpha)
    if options.json:
        print(json.dumps({"simulated": True, "observer": options.observer, "participants": participants, "runs": options.runs, "power": found}, indent=1))
    else:
        print(f"SIMULATED: {options.runs} studies with {participants} × {options.observer}; no person was asked, this is no result")
        for name, (share, low, high) in found.items():
            print(f"{name:50} {share:6.3f}  [{low:.3f}, {high:.3f}]")
    return 0


def printed_command(options: argparse.Namespace) -> int:
    from . import printed

    lines = printed.recompute()
    if options.json:
        print(json.dumps([line.as_json() for line in lines], indent=1, ensure_ascii=False))
    else:
        print(printed.text(lines, options.differing))
    return 0


def share(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value < 1.0:
        raise argparse.ArgumentTypeError(f"must be a number between 0 and 1, found {text!r}")
    return value


def parser() -> Parser:
    top = Parser(prog="haptogram-study", description="Studies with people: protocols, a runner, simulated observers, statistics, printed numbers.",
                 epilog="Exit codes: 0 ok, 1 a session is not finished or a page is stale, 2 usage, 3 bad input, 4 device or link.")  # fmt: skip
    top.add_argument("--version", action="version", version=f"haptogram-study {__version__}")
    sub = top.add_subparsers(required=True, metavar="COMMAND")

    def add(name: str, run: Callable[[argparse.Namespace], int], about: str) -> Parser:
        command: Parser = sub.add_parser(name, help=about, description=about)
        command.set_defaults(run=run)
        return command

    def json_option(command: Parser) -> None:
        command.add_argument("--json", action="store_true", help="print as JSON")

    def made_for_options(command: Parser, board: str) -> None:
        command.add_argument("--board", help=board)
        command.add_argument("--array", help="the array, instead of the protocol's or the board's; the results of run say so")
        command.add_argument("--program", help="the C++ program (HAPTOGRAM_PROGRAM, or haptogram)")

    listing = add("list", list_command, "print the shipped protocols, and those of a folder")
    listing.add_argument("--folder", help="also the protocols of this folder")
    json_option(listing)
    check = add("check", check_command, "say whether protocols make sense")
    check.add_argument("protocols", nargs="*", metavar="PROTOCOL", help="file, or name of a shipped protocol (default: all of those)")
    made_for_options(check, "also whether its stimuli fit this board, as haptogram compile has it")
    run = add("run", run_command, "run a participant's session, or go on with it")
    run.add_argument("protocol", help="file, or name of a shipped protocol")
    run.add_argument("--participant", type=whole(1, 100_000), required=True, help="number of the participant, from 1; it decides the orders")
    run.add_argument("--seed", type=whole(0, 2**63), default=1, help="of all random numbers (1)")
    run.add_argument("-o", "--output", required=True, help="results, JSON lines; an unfinished session in it goes on")
    run.add_argument("--observer", default="keyboard", help="keyboard, page (lines of JSON, for a program that shows them), simulated:protocol, simulated:chance, simulated:FILE.toml or simulated:hand, which touches")
    run.add_argument("--port", action="append", default=[], dest="ports", metavar="PORT", help="serial port of the board that plays the stimuli; without one nothing is played; one for each array that stands side by side with others")
    made_for_options(run, "make the stimuli for this board, as haptogram compile has it (default: the one of the protocol's array); the results say so")
    run.add_argument("--baud", type=whole(300, 12_000_000), help="its rate (default: the one at which it answers)")
    run.add_argument("--from", action="append", default=[], dest="sources", metavar="SOURCE", help="of live stimuli, with --port: what sees the hand, as haptogram live has it; may be given again")
    run.add_argument("--images", help="folder of the stimuli's images (with --port: study-images); without a port they are compiled only")
    run.add_argument("--on-trigger", action="store_true", help="each stimulus begins when the board's trigger input says so (haptogram device trigger); until then the outputs are on, and silent")
    run.add_argument("--lsl", action="store_true", help="mark starts, answers and stops on a stream of the Lab Streaming Layer (pip install 'haptogram[lsl]')")
    analyse = add("analyse", analyse_command, "the statistics that a protocol asks for, of results")
    analyse.add_argument("protocol")
    analyse.add_argument("results", nargs="+", help="files of results, usually one a participant")
    analyse.add_argument("--mixed", action="store_true", help="also people with simulated observers, or different simulated ones; the output is labelled")
    analyse.add_argument("--unfinished", action="store_true", help="also sessions that are not finished; the output is labelled")
    json_option(analyse)
    power = add("power", power_command, "how often each analysis of a protocol finds its effect (p < alpha) with simulated people")
    power.add_argument("protocol")
    power.add_argument("--participants", type=whole(2, 1000), help="as the protocol says")
    power.add_argument("--runs", type=whole(1, 100_000), default=200, help="simulated studies (200)")
    power.add_argument("--seed", type=whole(0, 2**63), default=1)
    power.add_argument("--alpha", type=share, default=0.05)
    power.add_argument("--observer", default="simulated:protocol", help="simulated:protocol, simulated:chance or simulated:FILE.toml")
    json_option(power)
    printed = add("printed", printed_command, "the numbers that the papers print, beside what follows from their own data and formulas")
    printed.add_argument("--differing", action="store_true", help="only those that do not agree")
    json_option(printed)
    return top


def work() -> int:
    try:
        options = parser().parse_args()
        code: int = options.run(options)
    except ModuleNotFoundError as error:
        extra = "lsl" if error.name == "pylsl" else "study"
        say(f"Python's {error.name} is missing; install the package with its extra: pip install 'haptogram[{extra}]'")
        return ErrorCode.USAGE
    return code


def main() -> int:
    return exit_code_of("haptogram-study", work)
