#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Write every side's constants from tools/interface.toml; with --check, fail when a written file is stale."""

import argparse
import pathlib
import sys

try:
    import tomllib
except ModuleNotFoundError:
    sys.exit("generate_interface.py needs Python 3.11 or newer (tomllib)")

ROOT = pathlib.Path(__file__).resolve().parent.parent
NOTE = "Generated from tools/interface.toml by tools/generate_interface.py; edit the table, not this file."


def load():
    return tomllib.loads((ROOT / "tools/interface.toml").read_text(encoding="utf-8"))


def blocks(table):
    return {block["region"]: block["words"] for block in table["block"]}


def name_words(table):
    raw = table["protocol"]["name"].encode("ascii").ljust(16, b"\0")
    return [raw[i] | raw[i + 1] << 8 for i in range(0, 16, 2)]


def verilog(table):
    out = [f"// {NOTE}", "// SPDX-License-Identifier: Apache-2.0", ""]

    def define(name, value):
        out.append(f"`define HG_{name.upper()} {value}")

    protocol = table["protocol"]
    define("VERSION", f"16'h{protocol['version_major']:02x}{protocol['version_minor']:02x}")
    define("NAME", "128'h" + "".join(f"{word:04x}" for word in reversed(name_words(table))))
    for region in table["region"]:
        if region["access"] == "image only":
            continue
        define(f"REGION_{region['name']}", f"4'h{region['base'] >> 28:x}")
    define("RECORD_HEADER_WORDS", table["record"]["header_words"])
    define("AUTOSTART_BIT", table["sequence_header"]["autostart_bit"])
    for name, words in blocks(table).items():
        if name == "description":  # the board never sees it
            continue
        define(f"{name}_WORDS", len(words))
        for position, word in enumerate(words):
            define(f"{name}_{word}", f"5'd{position}")
    features = table["features"]
    define("FEATURES", f"16'h{sum(1 << bit for bit in features.values()):04x}")
    for command in table["command"]:
        define(f"COMMAND_{command['name']}", f"8'h{command['code']:02x}")
    for status in table["status"]:
        define(f"REPLY_{status['name']}", f"8'h{status['code']:02x}")
    return "\n".join(out) + "\n"


def verilog_commands(table):
    """A module rather than a define, since Verilog-2005 has no table to look a command up in."""
    rows = []
    for command in table["command"]:
        reply = {"identity": "2'd1", "status": "2'd2", "memory": "2'd3", "digest": "2'd3"}.get(command.get("reply", ""), "2'd0")
        rows.append(
            f"            8'h{command['code']:02x}: o_shape = {{1'b1, 2'd{len(command['args'])}, "
            f"1'b{int(command.get('tail', False))}, {reply}}};  // {command['name']}"
        )
    body = "\n".join(rows)
    return f"""// {NOTE}
// SPDX-License-Identifier: Apache-2.0
//
// The shape of each command: how many argument words it has, whether data words follow, what its reply
// carries (0 nothing, 1 identity block, 2 status block, 3 memory or its digest). Combinational.
`default_nettype none
module command_table (
    input  wire [7:0] i_command,
    output reg  [5:0] o_shape  // {{known, arguments, tail, reply}}
);
    always @* begin
        case (i_command)
{body}
            default: o_shape = 6'd0;
        endcase
    end
endmodule
`default_nettype wire
"""


def cpp(table):
    out = [f"// {NOTE}", "// SPDX-License-Identifier: Apache-2.0", "#pragma once", "#include <cstdint>", "#include <string_view>", ""]
    out += ["namespace haptogram::interface {", ""]
    protocol = table["protocol"]
    out.append(f'inline constexpr std::string_view name = "{protocol["name"]}";')
    out.append(f"inline constexpr unsigned version_major = {protocol['version_major']};")
    out.append(f"inline constexpr unsigned version_minor = {protocol['version_minor']};")
    for region in table["region"]:
        out.append(f"inline constexpr std::uint32_t {region['name']}_base = 0x{region['base']:08x};  // {region['word_bits']}-bit words")
    out.append(f"inline constexpr unsigned record_header_words = {table['record']['header_words']};")
    out.append(f"inline constexpr std::uint16_t silent_timing = 0x{table['record']['silent_timing']:04x};")
    out.append(f"inline constexpr std::uint32_t autostart_bit = 1U << {table['sequence_header']['autostart_bit']};  // of the sequence header")
    for name, words in blocks(table).items():
        out += ["", f"enum class {name.capitalize()}Word : unsigned {{"]
        out += [f"    {word} = {position}," for position, word in enumerate(words)]
        out += ["};", f"inline constexpr unsigned {name}_words = {len(words)};"]
    out += ["", "enum class Feature : unsigned {"] + [f"    {k} = {v}," for k, v in table["features"].items()] + ["};"]
    out += ["", "enum class Command : std::uint8_t {"] + [f"    {c['name']} = 0x{c['code']:02x}," for c in table["command"]] + ["};"]
    out += ["", "enum class Status : std::uint8_t {"] + [f"    {s['name']} = 0x{s['code']:02x}," for s in table["status"]] + ["};", ""]
    replying = " || ".join(f"command == Command::{c['name']}" for c in table["command"] if "reply" in c)
    out += ["/// Whether its reply carries data.", f"constexpr bool replies(Command command) {{ return {replying}; }}", ""]
    out += ["constexpr std::string_view to_string(Command command) {", "    switch (command) {"]
    out += [f'        case Command::{c["name"]}: return "{c["name"]}";' for c in table["command"]]
    out += ["    }", '    return "unknown";', "}", ""]
    out += ["constexpr std::string_view to_string(Status status) {", "    switch (status) {"]
    out += [f'        case Status::{s["name"]}: return "{s["name"]}: {s["about"]}";' for s in table["status"]]
    out += ["    }", '    return "unknown status";', "}", "", "}  // namespace haptogram::interface"]
    return "\n".join(out) + "\n"


def python(table):
    out = [f'"""{NOTE}"""', "# SPDX-License-Identifier: Apache-2.0", "import enum", ""]
    protocol = table["protocol"]
    out += [f"NAME = {protocol['name']!r}", f"VERSION = ({protocol['version_major']}, {protocol['version_minor']})"]
    for region in table["region"]:
        out.append(f"{region['name'].upper()}_BASE = 0x{region['base']:08x}")
    out.append(f"RECORD_HEADER_WORDS = {table['record']['header_words']}")
    out.append(f"SILENT_TIMING = 0x{table['record']['silent_timing']:04x}")
    out.append(f"AUTOSTART_BIT = 1 << {table['sequence_header']['autostart_bit']}  # of the sequence header")
    for name, words in blocks(table).items():
        out.append(f"{name.upper()}_WORDS = {words!r}".replace("'", '"'))
    for title, rows in (("Command", table["command"]), ("Status", table["status"])):
        out += ["", "", f"class {title}(enum.IntEnum):"]
        out += [f"    {row['name'].upper()} = 0x{row['code']:02x}" for row in rows]
    return "\n".join(out) + "\n"


def page(table):
    out = [f"<!-- {NOTE} -->", "<!-- SPDX-License-Identifier: Apache-2.0 -->", "# Address map, records, commands and status codes", ""]
    out += ["## Address map", "", "One byte-addressed space; 16- and 32-bit words are little-endian.", ""]
    out += ["| region | base | word | access | what |", "|---|---|---|---|---|"]
    for r in table["region"]:
        out.append(f"| {r['name']} | `0x{r['base']:08X}` | {r['word_bits']} bits | {r['access']} | {r['about']} |")
    out += ["", "## Record", "", "| word | field | what |", "|---|---|---|"]
    out += [f"| {f['word']} | {f['name']} | {f['about']} |" for f in table["record"]["fields"]]
    out.append(f"| {table['record']['header_words']}… | timing[CHANNELS] | tick at which channel 0, 1, … starts its pulse; 0x{table['record']['silent_timing']:04X} never |")
    out += ["", "A sequence header is `length + (loops << 16)`; a sequence entry is `index + (dwell << 16)`, dwell in carrier cycles.",
            f"Bit {table['sequence_header']['autostart_bit']} of the header, in a bitstream, makes the board enable its outputs and play the sequence at power-up, once,",
            "with no host and no watchdog; a header that is written over the link cannot.", ""]
    for block in table["block"]:
        out += [f"## The {block['region']} block", "", "| word | field | what |", "|---|---|---|"]
        out += [f"| {i} | {w} | {block['about'].get(w, '')} |" for i, w in enumerate(block["words"])]
        out.append("")
    out += ["Feature bits: " + ", ".join(f"{bit} {name}" for name, bit in table["features"].items()) + ".", ""]
    out += ["## Frames", "", "On the line a frame is COBS-encoded and ends with a zero byte. Decoded, a request is", ""]
    out += ["`sequence number, command, arguments…, data…, CRC high, CRC low`", "", "and a reply is", ""]
    out += ["`sequence number, command | 0x80, status, next expected sequence number, live level low, high, data…, CRC high, CRC low`", ""]
    out += ["The CRC is CRC-16/IBM-3740 (polynomial 0x1021, start 0xFFFF, no reflection) over everything before it.", ""]
    out += ["| command | code | arguments (16 bits each) | data | reply data | what |", "|---|---|---|---|---|---|"]
    for c in table["command"]:
        out.append(f"| {c['name']} | 0x{c['code']:02X} | {', '.join(c['args']) or '–'} | {'yes' if c.get('tail') else '–'} | {c.get('reply', '–')} | {c['about']} |")
    out += ["", "| status | code | what |", "|---|---|---|"]
    out += [f"| {s['name']} | 0x{s['code']:02X} | {s['about']} |" for s in table["status"]]
    return "\n".join(out) + "\n"


FILES = {
    "rtl/interface.vh": verilog,
    "rtl/command_table.v": verilog_commands,
    "host/haptogram/boards/interface.hpp": cpp,
    "tools/python/haptogram/interface.py": python,
    "rtl/INTERFACE.md": page,
}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="change nothing; exit 1 when a file is stale")
    check = parser.parse_args().check
    table = load()
    stale = []
    for name, make in FILES.items():
        path, text = ROOT / name, make(table)
        if path.exists() and path.read_text(encoding="utf-8") == text:
            continue
        stale.append(name)
        if not check:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
    if check and stale:
        sys.exit("stale, run tools/generate_interface.py: " + ", ".join(stale))


if __name__ == "__main__":
    main()
