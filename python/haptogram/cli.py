# SPDX-License-Identifier: Apache-2.0
"""The program haptogram-py: its arguments and its messages, `haptogram-py: where: message` on stderr."""
import argparse
import math
import sys
from collections.abc import Callable
from typing import NoReturn

from . import __version__, commands
from .errors import ErrorCode, HaptogramError
from .interface import KNOWN_RATES
from .program import exit_code_of


class Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        raise HaptogramError(ErrorCode.USAGE, self.prog.removeprefix("haptogram-py").strip() or "arguments", f"{message}; see {self.prog} --help")


def whole(low: int, high: int) -> Callable[[str], int]:
    def parse(text: str) -> int:
        if not (text.isascii() and text.isdigit() and low <= int(text) <= high):
            raise argparse.ArgumentTypeError(f"must be a whole number from {low} to {high}, found {text!r}")
        return int(text)

    return parse


def positive(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"must be a positive number, found {text!r}")
    return value


def parser() -> Parser:
    top = Parser(prog="haptogram-py", description="Drives a Haptogram board over its serial line.",
                 epilog="Exit codes: 0 ok, 1 run failed, 2 usage, 3 bad input, 4 device or link.")  # fmt: skip
    top.add_argument("--version", action="version", version=f"haptogram-py {__version__}")
    json = Parser(add_help=False)
    json.add_argument("--json", action="store_true", help="print the outcome as JSON")
    port = Parser(add_help=False, parents=[json])
    port.add_argument("--port", required=True, help="serial port of the board, or of 'haptogram board run'")
    port.add_argument("--baud", type=whole(300, 12_000_000),
                      help=f"its rate, which the board's build fixes (default: that of {', '.join(map(str, KNOWN_RATES))} at which it answers, which is remembered)")  # fmt: skip
    watchdog = Parser(add_help=False)
    watchdog.add_argument("--watchdog", type=whole(0, 65535), default=500, metavar="MS",
                          help="outputs go off when this program is silent for so long (500); 0: never, they may stay on when it dies")  # fmt: skip
    sub = top.add_subparsers(required=True, metavar="COMMAND")

    def add(to: "argparse._SubParsersAction[Parser]", name: str, run: Callable[[argparse.Namespace], None], about: str,
            *parents: Parser) -> Parser:  # fmt: skip
        command = to.add_parser(name, help=about, description=about, parents=list(parents))
        command.set_defaults(run=run)
        return command

    device = sub.add_parser("device", help="what a board is and does, and its outputs").add_subparsers(required=True, metavar="COMMAND")
    add(device, "list", commands.device_list, "print the serial ports", json)
    add(device, "info", commands.device_info, "print what the board is", port)
    add(device, "status", commands.device_status, "print what it is doing, and its counters", port)
    enable = add(device, "enable", commands.device_enable, "turn the outputs on, until no host speaks within the watchdog's time", port)
    enable.add_argument("--watchdog", type=whole(0, 65535), metavar="MS", help="that time; 0 leaves them on with no host (default: as it is)")
    add(device, "disable", commands.device_disable, "turn the outputs off, at once", port)
    add(device, "stop", commands.device_stop, "silence after the present cycle; outputs stay as they are", port)

    modulate = add(device, "modulate", commands.device_modulate, "multiply all amplitudes by the samples in the board's modulation memory", port)
    modulate.add_argument("--divider", type=whole(1, 65535), default=1, help="carrier periods that a sample lasts (1)")
    modulate.add_argument("--samples", type=whole(0, 65535), default=0, help="so many samples; 0: all that the board holds")
    how = modulate.add_mutually_exclusive_group()
    how.add_argument("--once", action="store_true", help="not over and over; the last sample stays")
    how.add_argument("--off", action="store_true", help="end the modulation")

    sync = add(device, "sync", commands.device_sync, "reset the board, and then keep its carrier cycles in step with other boards over the wire SYNC", port)
    sync.add_argument("role", choices=("alone", "master", "slave"))

    upload = add(sub, "upload", commands.upload, "write into a board's memories what differs from an image, and check it by digests", port)
    upload.add_argument("image", help="Intel HEX image")
    upload.add_argument("--verify", action="store_true", help="also read it back and compare every byte")
    download = add(sub, "download", commands.download, "read the sequence and the records that it plays back into an image", port)
    download.add_argument("-o", "--output", required=True, help="Intel HEX image; - is standard output")

    play = add(sub, "play", commands.play_command, "outputs on, play what is in the board's memories until its end or Ctrl-C, off", port, watchdog)
    what = play.add_mutually_exclusive_group()
    what.add_argument("--index", type=whole(1, 65535), default=0, help="one record, until Ctrl-C")
    what.add_argument("--loops", type=whole(0, 65535), help="passes over the sequence; 0: until Ctrl-C (default: as the image says)")
    play.add_argument("--seconds", type=positive, default=0.0, help="not longer than this")
    stream = add(sub, "stream", commands.stream_command, "outputs on, play indices as they come, off", port, watchdog)
    stream.add_argument("file", nargs="?", default="-", help="lines 'index' or 'index dwell'; - is standard input")
    stream.add_argument("--dwell", type=whole(0, 65535), default=1, help="cycles that an index lasts if its line does not say; 0: until the next")
    return top


def work() -> None:
    options = parser().parse_args()
    options.run(options)


def main() -> int:
    return exit_code_of("haptogram-py", work)


if __name__ == "__main__":
    sys.exit(main())
