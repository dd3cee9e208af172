#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The core's parameters and its named configurations, from tools/interface.toml and the board files of constraints/.

As a program it prints one configuration, for scripts: `tools/configurations.py tile-100 --as verilator`; without a name, all names.
"""
import argparse
import tomllib
from pathlib import Path

import boards

TABLE = Path(__file__).resolve().parent / "interface.toml"
FORMATS = {"verilator": "-G{}={}", "iverilog": "-P haptogram_core.{}={}", "yosys": "-set {} {}", "text": "{} = {}\n"}


class Wrong(Exception):
    """The table contradicts itself, or somebody asks for a name that it does not have."""


def load():
    return tomllib.loads(TABLE.read_text(encoding="utf-8"))


def bounds(parameter, values):
    """The lowest and the highest value that a parameter may have beside the others."""

    def other(text):
        name, _, divisor = text.partition(" / ")
        return values[name] // int(divisor or 1)

    low, high = parameter["low"], parameter["high"]
    if "at_least" in parameter:
        low = max(low, other(parameter["at_least"]))
    if "at_most" in parameter:
        high = min(high, other(parameter["at_most"]))
    return low, high


def check(name, values, parameters):
    """Raises Wrong unless `values` has every parameter, and each within its bounds."""
    if set(values) != {p["name"] for p in parameters}:
        wrong = sorted(set(values) ^ {p["name"] for p in parameters})
        raise Wrong(f"configuration {name}: unknown or missing: {', '.join(wrong)}")
    for parameter in parameters:
        value, (low, high) = values[parameter["name"]], bounds(parameter, values)
        if parameter.get("optional") and value == 0:
            continue
        if not low <= value <= high:
            raise Wrong(f"configuration {name}: {parameter['name']} is {value}, expected {low} to {high}")
        if parameter.get("power_of_two") and value & (value - 1):
            raise Wrong(f"configuration {name}: {parameter['name']} is {value}, expected a power of two")


def configurations(table=None):
    """Every configuration: its name and a dict of all parameters, in the order of the table; then the boards that have parameters of
    their own."""
    table = table or load()
    rows = [(row["name"], row["parameters"]) for row in table["configuration"]]
    rows += [(name, own) for name in boards.names() if (own := boards.own(name).get("parameters")) and "configuration" not in own]
    result = {}
    for name, differing in rows:
        values = {p["name"]: p["default"] for p in table["parameter"]} | differing
        check(name, values, table["parameter"])
        if name in result:
            raise Wrong(f"there are two configurations {name}")
        result[name] = values
    return result


def configuration(name):
    known = configurations()
    if name not in known:
        raise Wrong(f"no configuration {name}; there are {', '.join(known)}")
    return known[name]


def parameters_of(board):
    """The parameters of a board file: what it says, and for the rest those of the configuration that it names, or the defaults."""
    table = dict(board["parameters"])
    name = table.pop("configuration", None)
    parameters = load()["parameter"]
    values = ({p["name"]: p["default"] for p in parameters} if name is None else configuration(name)) | table
    check(name or board.get("description", "of the board"), values, parameters)
    return values


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("name", nargs="?", help="of a configuration")
    parser.add_argument("--as", dest="format", choices=FORMATS, default="text", help="whose options to print")
    options = parser.parse_args()
    try:
        if options.name is None:
            print("\n".join(configurations()))
            return
        form = FORMATS[options.format]
        text = [form.format(key, value) for key, value in configuration(options.name).items()]
        print("".join(text).rstrip() if options.format == "text" else " ".join(text))
    except Wrong as error:
        parser.exit(2, f"configurations.py: {error}\n")


if __name__ == "__main__":
    main()
