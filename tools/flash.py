#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Loads a board's bitstream with openFPGALoader, with an image in it, or beside it in the flash, if one is given.

Exit code 0, 1 when a program fails, 2 on wrong usage.
"""
import argparse
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import boards
import configurations

ROOT = Path(__file__).resolve().parent.parent


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("board", help="of constraints/")
    parser.add_argument("--program", type=Path, required=True, help="haptogram")
    parser.add_argument("--image", type=Path, help="Intel HEX image to put into the bitstream, or beside it")
    parser.add_argument("--autostart", action="store_true", help="with --image: it plays at power-up, with no host and no watchdog")
    parser.add_argument("--write", action="store_true", help="to the board's flash, where it stays; else until power is cut")
    parser.add_argument("--dry-run", action="store_true", help="print the commands only")
    options = parser.parse_args()
    try:
        board = boards.load(options.board)
    except boards.Unknown as error:
        parser.error(str(error))
    if options.autostart and not options.image:
        parser.error("--autostart needs an --image to play")
    in_flash = "sdram" in board and options.image  # beside the bitstream, because an SDRAM is in none
    if in_flash and not options.write:
        parser.error(f"{options.board} takes an image out of its flash alone: give --write, or upload it")
    folder = ROOT / "build" / "boards" / options.board
    suffix = "bin" if board["fpga"]["family"] == "ice40" else "bit"
    bitstream, commands = folder / f"{options.board}.{suffix}", []
    if options.image:
        image = folder / ("flash.raw" if in_flash else f"flash.{suffix}")
        bitstream = bitstream if in_flash else image
        commands.append([options.program, "bitstream", "--board", options.board, "--placed", folder.parent, "--image", options.image,
                         "-o", image, *(["--autostart"] if options.autostart else [])])
    if bitstream.name != f"flash.{suffix}" and not options.dry_run and not bitstream.exists():
        print(f"flash: {bitstream} is not there; run 'make bitstream BOARD={options.board}', or put a release's there, gunzipped", file=sys.stderr)
        return 1
    commands.append(["openFPGALoader", *board["flash"]["write" if options.write else "load"], bitstream])
    if in_flash:
        offset = configurations.load()["flash_image"]["first"]
        commands.append(["openFPGALoader", *board["flash"]["write"], "--offset", str(offset), "--file-type", "raw", image])
    print(f"{board['description']}: {board['flash']['note']}", file=sys.stderr)
    if jumpers := board["flash"].get("write_jumpers" if options.write else "load_jumpers"):
        print(f"jumpers: {jumpers}", file=sys.stderr)
    missing = [command[0] for command in commands if not shutil.which(command[0])]
    if missing and not options.dry_run:
        print(f"flash: {missing[0]} is not there; {'make build makes it' if missing[0] == options.program else 'tools/setup board installs it'}", file=sys.stderr)
        return 1
    for command in commands:
        print(shlex.join(map(str, command)), flush=True)
        if not options.dry_run and subprocess.run(list(map(str, command))).returncode != 0:
            print("flash: the command above failed", file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
