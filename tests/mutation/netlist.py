#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes mutants_MODEL.v for each model of mutation.toml, the whole core with every chosen mutant in it, and mutants.json, which
says what each is.

Modules without mutants are included as they are. Mutant 0 is none; the number of the active one comes from the function
haptogram_mutant, which the simulation provides (select.cpp).
Exit code 0, or 2 when the table, a source or yosys is not as expected.
"""
import argparse
import collections
import functools
import hashlib
import itertools
import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
sys.path.insert(0, str(ROOT / "tools"))
import configurations  # noqa: E402


class Wrong(Exception):
    """The table, a source or a tool is not as expected."""


def table():
    return tomllib.loads((HERE / "mutation.toml").read_text())


def found(pattern, file):
    match = re.search(pattern, file.read_text(), re.DOTALL)
    if not match:
        raise Wrong(f"{file}: nothing matches {pattern}")
    return match[1]


def yosys(script, folder, name):
    (folder / f"{name}.ys").write_text("\n".join(script) + "\n")
    done = subprocess.run(["yosys", "-q", "-l", f"{name}.log", f"{name}.ys"], cwd=folder, capture_output=True, text=True)
    if done.returncode != 0:
        raise Wrong(f"yosys failed, see {folder / name}.log\n{done.stdout[-2000:]}{done.stderr[-2000:]}")


def port_of(t, model):
    """What mutation.toml says of a model that is not a configuration of the core; None of one that is."""
    return next((port for port in t.get("port", []) if port["model"] == model), None)


def sources_of(port):
    """The Verilog of the core, or of such a port, which takes one module from beside it."""
    core = [path for folder in ("rtl", "rtl/amplitudes", "rtl/time", "rtl/sdram") for path in sorted((ROOT / folder).glob("*.v"))]
    return core if port is None else [*sorted((ROOT / "rtl/net").glob("*.v")), ROOT / "rtl/synchronizer.v"]


def elaborate(modules, model, whole, folder, port):
    """Leaves the netlist of the core, or of a port, in all.il. Returns what yosys calls each module, and the module. `whole` says that all that is below
    the modules becomes a part of them."""
    chparam = " ".join(f"-chparam {k} {v}" for k, v in (port["parameters"] if port else configurations.configuration(model)).items())
    small = "*serial_product* *record_header*" if port is None else "*_crossing* *synchronizer* *answer_header*"
    yosys([f"read_verilog -defer -I{ROOT}/rtl -I{ROOT}/rtl/net {' '.join(map(str, sources_of(port)))}",
           f"hierarchy -check -top {model if port else 'haptogram_core'} {chparam}",
           "prep",
           # What is below a module that is mutated becomes a part of it.
           *([f"flatten {' '.join(f'*{m}' for m in modules)}"] if whole else
             ["setattr -mod -set keep_hierarchy 1 *", f"setattr -mod -unset keep_hierarchy {small}", "flatten"]),
           # Registers with enable and reset as the source has them, and nothing that no mutant could change anything in.
           "opt_dff", "opt_expr -fine t:$lt t:$le t:$gt t:$ge t:$and t:$or", "opt_clean -purge", "wreduce", "opt_clean -purge",
           "write_json all.json",
           "write_rtlil all.il"], folder, "elaborate")
    everything = json.loads((folder / "all.json").read_text())["modules"]
    named = {}
    for module in modules:
        # Yosys names a module with parameters anew, and remembers.
        same = [n for n, m in everything.items() if m["attributes"].get("hdlname") == "\\" + module]
        if len(same) != 1:
            raise Wrong(f"{module}: {len(same)} sets of parameters are instantiated, expected one")
        named[module] = same[0], everything[same[0]]
    return named


class Module:
    """A module's netlist, to tell a cell's place in the source without line numbers or generated names."""

    def __init__(self, name, netlist, whole=False):
        self.name, self.cells, self.whole = name, netlist["cells"], whole
        self.wires, self.loads, self.drives = {}, collections.defaultdict(list), {}
        self.driven_by = {}  # the cell whose output Y a bit is, and its place there
        self.ports = {bit for port in netlist["ports"].values() for bit in port["bits"]}
        for wire, net in sorted(netlist["netnames"].items()):
            for index, bit in enumerate(net["bits"] if not net["hide_name"] else []):
                self.wires.setdefault(bit, (wire, index if len(net["bits"]) > 1 else None))
        for name, cell in self.cells.items():
            bits = lambda way: [b for p, connected in cell["connections"].items() if cell["port_directions"][p] == way for b in connected]
            self.drives[name] = bits("output")
            self.driven_by |= {bit: (name, place) for place, bit in enumerate(cell["connections"].get("Y", []))}
            for bit in dict.fromkeys(bits("input")):
                self.loads[bit].append(name)

    @functools.cache
    def target(self, cell):
        """The nearest wire with a name of its own that the cell drives."""
        front = seen = {cell: None}
        while front:
            driven = [bit for name in front for bit in self.drives[name]]
            named = {self.wires[bit] for bit in driven if bit in self.wires}
            if named:
                wire, index = min(named)
                return f"{wire}[{index}]" if len(driven) == 1 and index is not None else wire
            front = {name: None for bit in driven for name in self.loads[bit] if name not in seen}
            seen = seen | front
        return "nothing"

    @functools.cache
    def value(self, bit):
        """The constant that a bit always is, or None: one of the netlist, or what a multiplexer has at all of its inputs."""
        if isinstance(bit, str):
            return bit
        cell, place = self.driven_by.get(bit, (None, 0))
        if cell is None or self.cells[cell]["type"] not in ("$mux", "$pmux"):
            return None
        a, b = (self.cells[cell]["connections"][port] for port in "AB")
        values = {self.value(one) for one in (a[place], *b[place::len(a)])}
        return values.pop() if len(values) == 1 else None

    def matters(self, cell, port, bit, mode):
        """False for what Yosys made by itself, for outputs that nothing reads, for constants that stay what they are, and for
        a memory's constant ports, which Yosys wants to be so."""
        unread = cell["port_directions"][port] == "output" and not self.loads[bit] and bit not in self.ports
        fixed = cell["type"].startswith("$mem") and isinstance(bit, str)
        return "src" in cell["attributes"] and not unread and not fixed and bit != "x" and mode != f"const{self.value(bit)}"

    def sources(self, cell):
        """Where it stands in the source; the innermost place first, of what was flattened."""
        places = self.cells[cell]["attributes"].get("src", "").split("|")
        return places[::-1] if self.whole else places

    def home(self, cell):
        """The module that it was written in."""
        return Path(self.sources(cell)[0].split(":")[0]).stem if self.whole else self.name

    @functools.cache
    def text(self, cell):
        """What the cell was made from, as it stands in the source, in one line."""
        for place in self.sources(cell):
            match = re.fullmatch(r"(.*):(\d+)\.(\d+)-(\d+)\.(\d+)", place)
            line, column, last, end = (int(n) for n in match.groups()[1:]) if match else (0, 0, 0, 0)
            if line:
                lines = Path(match[1]).read_text().splitlines()[line - 1:last]
                lines[-1] = lines[-1][:end - 1]
                lines[0] = lines[0][column - 1:]
                text = " ".join(" ".join(l.split("//")[0] for l in lines).split())
                return text if len(text) <= 70 else text[:67] + "..."
        return "?"


def candidates(module, lines, homes, modes, never):
    """Every mutant that `mutate` knows in a module, of what was written in one of `homes`, as what it is and its command, by the
    expression it is in."""
    places, twins = collections.defaultdict(list), collections.Counter()
    for line in lines:
        what = dict(re.findall(r"-(mode|cell|port|portbit) (\S+)", line))
        cell = module.cells[what["cell"]]
        bits = cell["connections"][what["port"]]
        bit = bits[int(what["portbit"])]
        home = module.home(what["cell"])
        if what["mode"] not in modes or what["port"] in never or home not in homes or not module.matters(cell, what["port"], bit, what["mode"]):
            continue
        kind = re.sub(r"^\$(s?dff).*|^\$(.*?)(_v2)?$", lambda m: "dff" if m[1] else m[2], cell["type"])
        target = cell["parameters"]["MEMID"].lstrip("\\") if kind == "mem" else module.target(what["cell"])
        # A register and a memory have names, and the text of their always block says nothing.
        text = "" if kind in ("dff", "mem") else f" | {module.text(what['cell'])}"
        port = what["port"] + (f"[{what['portbit']}]" if len(bits) > 1 else "")
        name = f"{home}.{target}{text} | {kind} {port} {what['mode']}"
        twins[name] += 1
        name += f" #{twins[name]}" if twins[name] > 1 else ""
        place = f"{home} {text or re.sub('[0-9]+', '', target)} {kind}"
        places[place].append((name, re.sub(r" -(src|wire|wirebit) \S+", "", line)))
    return places


def choose(places, number, seed):
    """One of each expression, then a second one of each, and so on. Ranked by what they are called, so that a change
    to the RTL changes only the choice where the RTL has changed."""
    rank = lambda text: hashlib.sha256(f"{seed} {text}".encode()).digest()
    columns = [sorted(places[place], key=lambda c: rank(c[0])) for place in sorted(places, key=rank)]
    rounds = itertools.chain.from_iterable(itertools.zip_longest(*columns))
    chosen = list(itertools.islice((c for c in rounds if c), number))
    if len(chosen) < number:
        raise Wrong(f"only {len(chosen)} mutants exist, {number} are wanted")
    return chosen


def stand_in(module, width):
    """The module with its own header, and the mutants' netlist within."""
    source = next(f for folder in ("rtl", "rtl/amplitudes", "rtl/time", "rtl/net", "rtl/sdram") if (f := ROOT / folder / f"{module}.v").exists())
    header = found(rf"(\bmodule\s+{module}\b.*?\);)", source)
    return f"{header}\n    bit [{width - 1}:0] mutant = {width}'(mutation::haptogram_mutant());\n    {module}_mutants mutants (.*);\nendmodule\n"


def models(t):
    return list(dict.fromkeys(group["model"] for group in t["group"]))


def write_model(t, model, first, top):
    """Writes one model's files; its mutants, which it returns, are numbered from `first` on."""
    folder = top / model
    folder.mkdir(parents=True, exist_ok=True)
    groups = [g for g in t["group"] if g["model"] == model]
    whole = [g["within"] for g in groups if "within" in g]
    modules = list(dict.fromkeys(m for g in groups for m in ([g["within"]] if "within" in g else g["modules"])))
    port = port_of(t, model)
    named = elaborate(modules, model, bool(whole), folder, port)
    script = ["read_rtlil all.il"]
    for module, (name, _) in named.items():
        script.append(f"rename {name} {module}")
    script += [f"mutate -list 1000000 -o {m}.list -module {m}" for m in modules]
    yosys(script, folder, "list")

    width = sum(g["mutants"] for g in t["group"]).bit_length()
    mutants, commands = [], []
    for group in groups:
        places = {}
        for m in [group["within"]] if "within" in group else group["modules"]:
            lines = (folder / f"{m}.list").read_text().splitlines()
            places.update(candidates(Module(m, named[m][1], "within" in group), lines, group["modules"], t["modes"], t["never"]))
        for name, command in choose(places, group["mutants"], t["seed"]):
            mutants.append({"number": first + len(mutants), "group": group["name"], "name": name})
            commands.append(f"{command} -ctrl mutant {width} {mutants[-1]['number']}")
    script = ["read_rtlil all.il"]
    for module, (name, _) in named.items():
        script.append(f"rename {name} {module}")
    script += commands
    script += [f"rename {m} {m}_mutants" for m in modules]
    script += [f"select {' '.join(m + '_mutants' for m in modules)}", "splitnets -driver", "write_verilog -noattr -selected netlist.v"]
    yosys(script, folder, "mutate")

    text = ["// SPDX-License-Identifier: Apache-2.0", "// Written by tests/mutation/netlist.py.", 
            '`include "interface.vh"', *(['`include "answers.vh"'] if port else []), 'package mutation; import "DPI-C" function int haptogram_mutant(); endpackage',
            *[stand_in(m, width) for m in modules], (folder / "netlist.v").read_text(),
            *[f'`include "{f.name}"' for f in sources_of(port) if f.stem not in modules], ""]
    (top / f"mutants_{model}.v").write_text("\n".join(text))
    return mutants


def write(folder):
    t, mutants = table(), []
    for model in models(t):
        mutants += write_model(t, model, len(mutants) + 1, folder)
    (folder / "mutants.json").write_text(json.dumps(mutants, indent=1) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--build", metavar="DIR", type=Path, default=ROOT / "build" / "mutation", help="where to write")
    folder = parser.parse_args().build.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    try:
        write(folder)
    except (Wrong, configurations.Wrong, OSError, KeyError) as error:
        print(f"netlist.py: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
