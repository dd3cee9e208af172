#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Synthesises haptogram_core in a named configuration and writes the netlist as Verilog."""
import argparse
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tools"))
import bitstream  # noqa: E402
import configurations  # noqa: E402


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--family", choices=["ice40", "ecp5"], required=True)
    parser.add_argument("--configuration", required=True, help="name in tools/interface.toml")
    parser.add_argument("--output", type=Path, required=True)
    options = parser.parse_args()
    try:
        parameters = configurations.configuration(options.configuration)
    except configurations.Wrong as error:
        parser.error(str(error))
    sets = " ".join(f"-set {name} {value}" for name, value in parameters.items())
    options.output.parent.mkdir(parents=True, exist_ok=True)
    script = f"""read_verilog -I{ROOT}/rtl {' '.join(str(p) for p in [*sorted(ROOT.glob('rtl/*.v')), *sorted(ROOT.glob('rtl/amplitudes/*.v')), *sorted(ROOT.glob('rtl/time/*.v'))])}
chparam {sets} haptogram_core
{bitstream.commands(options.family, "haptogram_core", dsp=False)}
chtype -set dp16kd t:DP16KD
splitnets
write_verilog -noattr {options.output}
"""
    return subprocess.run(["yosys", "-q", "-l", f"{options.output}.log", "-p", script]).returncode


if __name__ == "__main__":
    sys.exit(main())
