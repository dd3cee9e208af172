#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Reads all Verilog of rtl/ and tests/ by slang, which holds it to Verilog-2005 where Yosys, Icarus and Verilator let things pass:
above all a net that is used before its declaration. Each way to build is read: the core in every named configuration, the network port, the records in an SDRAM, the top of every
board, every proof with its assertions, and the benches. Prints each error once; exit code 1 when there is any.
"""
import re
import sys
import tomllib

import bitstream
import boards
import configurations

try:
    from pyslang import DiagnosticEngine
    from pyslang.driver import Driver
except ImportError:
    sys.exit("portable_verilog.py: the Python module pyslang is not installed; tools/setup installs it into build/venv")

ROOT = bitstream.ROOT
RTL = [path for folder in ("rtl", "rtl/amplitudes", "rtl/time") for path in sorted((ROOT / folder).glob("*.v"))]
NET = sorted(ROOT.glob("rtl/net/*.v"))
SDRAM = sorted(ROOT.glob("rtl/sdram/*.v"))
BOARDS = sorted(ROOT.glob("rtl/boards/*.v"))
BENCHES = sorted(set(ROOT.glob("tests/**/*.v")) - set(ROOT.glob("tests/formal/*.v")))
ERROR = re.compile(r"(\S+:\d+:\d+: )?(fatal )?error: ")
# Assertions are SystemVerilog.
PLAIN, WITH_ASSERTIONS = ["--std", "1364-2005"], ["--std", "1800-2017", "-DFORMAL"]


def said_of(top, parameters, options, sources):
    """What slang says of a top with these parameters, a line an error."""
    values = [f"-G{name}={value}" for name, value in parameters.items()]
    command = ["slang", "--error-limit=0", "-I", ROOT / "rtl", "-I", ROOT / "rtl/net", "--top", top, *values, *options, *sources]
    driver = Driver()
    driver.addStandardArgs()
    # The driver splits its command line as a shell does.
    line = " ".join(f'"{word}"' for word in command)
    if not (driver.parseCommandLine(line) and driver.processOptions() and driver.parseAllSources()):
        sys.exit(f"portable_verilog.py: slang does not take its options or sources for {top}")
    text = DiagnosticEngine.reportAll(driver.sourceManager, driver.createCompilation().getAllDiagnostics())
    return [line for line in text.splitlines() if ERROR.match(line)]


def readings():
    """(top, parameters, options, sources) of all that is read."""
    for parameters in configurations.configurations().values():
        yield "haptogram_core", parameters, PLAIN, [*RTL, *SDRAM]
        yield "haptogram_core", parameters, WITH_ASSERTIONS, [*RTL, *SDRAM]
    yield "udp_link", {}, PLAIN, [*RTL, *NET]
    for mib in (4, 8):
        yield "sdram_memory", {"MIB": mib}, PLAIN, [*RTL, *SDRAM]
    for name in boards.names():
        board = bitstream.load(name)
        # The vendors' primitives are in no file of ours.
        yield board["fpga"]["top"], board["parameters"], [*PLAIN, *bitstream.defines(board), "--ignore-unknown-modules"], [*RTL, *NET, *SDRAM, *BOARDS]
    for proof in tomllib.loads((ROOT / "tests/formal/proofs.toml").read_text(encoding="utf-8"))["proof"]:
        sources = [ROOT / source for key in ("sources", "plain") for source in proof.get(key, [])]
        yield proof["top"], proof.get("parameters", {}), [*WITH_ASSERTIONS, *(f"-D{name}" for name in proof.get("defines", []))], sources
    for bench in BENCHES:
        if not bench.stem.isupper():  # the stand-in of a vendor's primitive, read below its bench
            yield bench.stem, {}, [*PLAIN, "--timescale", "1ns/1ps"], [*RTL, *NET, *SDRAM, *BOARDS, *BENCHES]


def main():
    said = {}
    for reading in readings():
        said |= dict.fromkeys(said_of(*reading))
    sys.exit("\n".join(said) or 0)


if __name__ == "__main__":
    main()
