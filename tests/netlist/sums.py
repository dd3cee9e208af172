# SPDX-License-Identifier: Apache-2.0
"""Proves that what tools/ecp5_map.v makes of sums.v is equal to it, whatever comes in by carries that nothing drives; and that the proof notices faults
in the map. Exit code 1 when it does not."""
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
import bitstream  # noqa: E402

MAP = ROOT / "tools/ecp5_map.v"
FAULTS = [("16'h000b : 16'h0002", "16'h000e : 16'h0002"), ("16'h000a, ADDS", "16'h0008, ADDS"), ("ADDS = 16'h96aa", "ADDS = 16'h96cc"),
          ("ENDS = 16'h0000", "ENDS = 16'hff00"), ("UPPER = h + 1 < Y_WIDTH", "UPPER = h + 2 < Y_WIDTH"),
          ("same[2*n+1] && less[2*n]", "less[2*n]"), ('DENIED  = _TECHMAP_CELLTYPE_ == "$ge"', 'DENIED  = _TECHMAP_CELLTYPE_ == "$gt"')]  # fmt: skip
PROOF = """read_verilog {source}
{commands}
read_verilog -overwrite /usr/share/yosys/ecp5/cells_sim.v
hierarchy -top sums
proc
flatten
setundef -undriven -anyseq
setundef -anyseq
opt_clean
design -stash made
read_verilog {source}
prep -flatten -top sums
design -stash written
design -copy-from written -as written sums
design -copy-from made -as made sums
miter -equiv -flatten -make_assert written made both
sat -verify -prove-asserts both
"""


def proves(folder, text):
    """Whether Yosys proves it with this map; fails when Yosys fails otherwise."""
    (folder / "map.v").write_text(text)
    commands = bitstream.commands("ecp5", "sums").replace(str(MAP), str(folder / "map.v"))
    script = folder / "proof.ys"
    script.write_text(PROOF.format(source=Path(__file__).with_name("sums.v"), commands=commands))
    run = subprocess.run(["yosys", "-q", script], capture_output=True, text=True)
    if run.returncode != 0 and "proof did fail" not in run.stderr + run.stdout:
        sys.exit(f"sums: yosys failed:\n{(run.stderr + run.stdout)[-800:]}")
    return run.returncode == 0


def main():
    text = MAP.read_text()
    with tempfile.TemporaryDirectory() as folder:
        if not proves(Path(folder), text):
            return "sums: what tools/ecp5_map.v makes is not what sums.v says"
        for found, instead in FAULTS:
            if text.count(found) != 1:
                return f"sums: tools/ecp5_map.v has {text.count(found)} times '{found}', expected it once"
            if proves(Path(folder), text.replace(found, instead)):
                return f"sums: the proof does not notice '{instead}' instead of '{found}'"
    print(f"proved; {len(FAULTS)} of {len(FAULTS)} faults noticed")
    return 0


if __name__ == "__main__":
    sys.exit(main())
