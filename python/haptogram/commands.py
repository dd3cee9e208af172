# SPDX-License-Identifier: Apache-2.0
"""What each command of haptogram-py does."""
import argparse
import contextlib
import ctypes
import dataclasses
import json
import signal
import sys
import time
from collections.abc import Mapping
from io import FileIO

from .client import Board
from .driving import play, stream
from .errors import ErrorCode, HaptogramError, bad_input, device_error
from .image import Image
from .interface import Feature, Role
from .library import library
from .lines import batches
from .link import Link, never

TOGETHER_S = 0.3  # signals within it are one: a terminal that closes sends several


class Interrupt:
    """Ctrl-C, SIGTERM and SIGQUIT, and the terminal that closes, end a command in good order: nothing is turned on any more, and
    outputs that are on go off. A second signal, unless it comes along with the first, ends the program at once."""

    def __init__(self) -> None:
        self._asked_at: float | None = None
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGQUIT, signal.SIGHUP):
            if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN:  # of nohup
                signal.signal(number, self._ask)

    def _ask(self, number: int, _: object) -> None:
        if self._asked_at is None:
            self._asked_at = time.monotonic()
        elif time.monotonic() - self._asked_at > TOGETHER_S:
            signal.signal(number, signal.SIG_DFL)
            signal.raise_signal(number)

    def __call__(self) -> bool:
        return self._asked_at is not None


def show(values: Mapping[str, object], as_json: bool, sentence: str = "") -> None:
    """As JSON, as a sentence, or as "name  value" lines."""
    if as_json:
        print(json.dumps(values, indent=1))
    elif sentence:
        print(sentence)
    else:
        for name, value in values.items():
            print(f"{name:16} {value}")


def connect(options: argparse.Namespace, interrupt: Interrupt | None = None) -> Board:
    return Board.open(options.port, options.baud, interrupt or Interrupt(), lambda baud: tell_rate(options.port, baud))


def tell_rate(port: str, baud: int) -> None:
    if baud:
        print(f"haptogram-py: {port}: it answers at {baud} baud, which is remembered", file=sys.stderr)


def device_list(options: argparse.Namespace) -> None:
    text = ctypes.create_string_buffer(library().haptogram_ports(None, 0))
    library().haptogram_ports(text, len(text))
    ports = [dict(zip(("port", "name"), line.split("\t"))) for line in text.raw.decode("utf-8", "backslashreplace").splitlines()]
    if options.json:
        print(json.dumps(ports, indent=1))
    else:
        for port in ports:
            print(port["port"], port["name"])


def device_info(options: argparse.Namespace) -> None:
    with connect(options) as board:
        major, minor = board.identity.version
        show({**dataclasses.asdict(board.identity), "version": f"{major}.{minor}"}, options.json)


def device_status(options: argparse.Namespace) -> None:
    with connect(options) as board:
        values = dataclasses.asdict(board.status())
    first = {"outputs": "on" if values.pop("enabled") else "off", "stop_input": "active" if values.pop("stopped") else "released",
             "mode": values.pop("mode"), "index": values.pop("present_index")}  # fmt: skip
    show(first | values, options.json)


def device_enable(options: argparse.Namespace) -> None:
    with connect(options) as board:
        if options.watchdog is not None:
            board.set_watchdog(options.watchdog)
        board.enable()


def device_disable(options: argparse.Namespace) -> None:
    """Asks for no session, which a bad line or another state of the board may not allow."""
    Interrupt()
    with contextlib.closing(Link(options.port, options.baud, never)) as link:
        try:
            link.shut_off()
        finally:
            tell_rate(options.port, link.state().found_baud)


def device_stop(options: argparse.Namespace) -> None:
    with connect(options) as board:
        board.stop()


def device_modulate(options: argparse.Namespace) -> None:
    with connect(options) as board:
        most = 2 * board.identity.modulation_words
        if most == 0:
            raise device_error("board", "this board has no modulation")
        if options.samples > most:
            raise HaptogramError(ErrorCode.USAGE, "--samples", f"the board holds {most} samples, not {options.samples}")
        board.modulate(0 if options.off else options.divider, options.samples, not options.once)


def device_sync(options: argparse.Namespace) -> None:
    with connect(options) as board:
        if not board.identity.features >> Feature.SYNC & 1:
            raise device_error("board", "this board has no SYNC")
        board.set_role(Role[options.role.upper()])


def upload(options: argparse.Namespace) -> None:
    image = Image.load(options.image)
    with connect(options) as board:
        begun = time.monotonic()
        written = board.upload(image, options.image)
        seconds = time.monotonic() - begun
        if options.verify:
            board.compare(image, options.image)
        again = board.retransmissions
    records = len(image.records) + (image.foci.count if image.foci else 0)
    frames = len(image.pieces()) + len(image.unread_pieces())
    values = {"records": records, "sequence_entries": len(image.entries), "frames": frames, "frames_written": written,
              "seconds": seconds, "retransmissions": again, "verified": options.verify}  # fmt: skip
    show(values, options.json, f"{records} records and {len(image.entries)} sequence entries in {seconds:.2f} s, {written} of "
         f"{values['frames']} frames differed{', read back and equal' if options.verify else ''}, {again} frames sent again")  # fmt: skip


def download(options: argparse.Namespace) -> None:
    with connect(options) as board:
        image = board.download()
    image.save(options.output)
    values = {"records": len(image.records), "sequence_entries": len(image.entries)}
    if options.output != "-":
        show(values, options.json, f"{values['records']} records and {values['sequence_entries']} sequence entries")


def play_command(options: argparse.Namespace) -> None:
    interrupt = Interrupt()
    with connect(options, interrupt) as board:
        outcome = play(board, index=options.index, loops=options.loops, seconds=options.seconds, watchdog_ms=options.watchdog, stopped=interrupt)
    show(outcome._asdict(), options.json, f"{outcome.underruns} underruns, {outcome.refused_records} refused records")


def stream_command(options: argparse.Namespace) -> None:
    interrupt = Interrupt()
    where = "standard input" if options.file == "-" else options.file
    with connect(options, interrupt) as board:
        try:
            source = FileIO(0 if options.file == "-" else options.file, closefd=options.file != "-")
        except OSError as error:
            raise bad_input(where, f"cannot be opened: {error.strerror}; check the path") from error
        with source:
            entries = batches(source, where, dwell=options.dwell, records=board.highest_index(), pause=board.until_next)
            sent, outcome = stream(board, entries, watchdog_ms=options.watchdog, stopped=interrupt)
    values = {"sent": sent, "underruns": outcome.underruns, "refused_records": outcome.refused_records, "interrupted": outcome.interrupted}
    show(values, options.json, f"{sent} indices, {outcome.underruns} underruns, {outcome.refused_records} refused records")
