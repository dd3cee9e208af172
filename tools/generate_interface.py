#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Write every side's constants from tools/interface.toml; with --check, fail when a written file is stale."""

import argparse
import binascii
import pathlib
import sys
import textwrap

if sys.version_info < (3, 11):
    sys.exit("generate_interface.py needs Python 3.11 or newer (tomllib)")

from configurations import Wrong, configurations, load

ROOT = pathlib.Path(__file__).resolve().parent.parent
NOTE = "Generated from tools/interface.toml by tools/generate_interface.py; edit the table, not this file."


def blocks(table):
    return {block["region"]: block["words"] for block in table["block"]}


def fields(part, words, word_bits):
    """Name, first bit counted from the part's beginning, width and meaning of its fields. A word without fields is one itself."""
    result, covered = [], set()
    for field in part.get("fields", []):
        word = field["word"] if isinstance(field["word"], int) else words.index(field["word"])
        first, end = word * word_bits + field["low"], word * word_bits + field["low"] + field["width"]
        if end > len(words) * word_bits or field["width"] > 32:
            raise Wrong(f"field {field['name']} reaches beyond its block, or is wider than 32 bits")
        result.append((field["name"], first, field["width"], field["about"]))
        covered |= set(range(first // word_bits, (end - 1) // word_bits + 1))
    for position, word in enumerate(words):
        if position not in covered:
            result.append((word, position * word_bits, word_bits, part.get("about", {}).get(word, "")))
    bits = [bit for _, first, width, _ in result for bit in range(first, first + width)]
    if len(bits) != len(set(bits)):
        raise Wrong("two fields of a block share a bit")
    return sorted(result, key=lambda field: field[1])


def layouts(table):
    """Everything that has fields: by name, its words (numbers where they have no name) and the bits of a word."""
    widths = {region["name"]: region["word_bits"] for region in table["region"]}
    yield "record", fields(table["record"], range(table["record"]["header_words"]), widths["primary"]), widths["primary"]
    for name in ("sequence_header", "sequence_entry"):
        yield name, fields(table[name], range(1), widths["sequence"]), widths["sequence"]
    for block in table["block"]:
        named = dict(block, fields=block.get("fields", []))
        words = block["words"]
        yield block["region"], [f for f in fields(named, words, widths[block["region"]]) if not f[0].startswith("name_")], widths[block["region"]]


def name_words(table):
    raw = table["protocol"]["name"].encode("ascii").ljust(16, b"\0")
    return [raw[i] | raw[i + 1] << 8 for i in range(0, 16, 2)]


def status_ends(table):
    """Lengths of the status block on boards without SCHEDULE, and on those with it that have no STREAM."""
    status = next(block for block in table["block"] if block["region"] == "status")
    return {"untimed": (status["words"].index(status["timed_from"]), "schedule"), "unstreamed": (status["words"].index(status["streamed_from"]), "stream")}


def trigger_settings(table):
    """How many words of the trigger block a host may write."""
    block = next(block for block in table["block"] if block["region"] == "trigger")
    return block["words"].index(block["first_read"])


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
    # The memory controller takes a record's fields apart as they arrive, word by word; this one bit it is told by name.
    autostart = next(f for f in table["sequence_header"]["fields"] if f["name"] == "autostart")
    define("AUTOSTART_BIT", autostart["low"])
    define("MARK_BIT", next(f for f in table["sequence_entry"]["fields"] if f["name"] == "mark")["low"])
    for name, words in blocks(table).items():
        if name == "description":  # the board never sees it
            continue
        define(f"{name}_WORDS", len(words))
        if name == "status":
            for end, (length, _) in status_ends(table).items():
                define(f"STATUS_{end}_WORDS", length)
        for position, word in enumerate(words):
            define(f"{name}_{word}", f"5'd{position}")
    define("TRIGGER_SETTINGS", trigger_settings(table))
    define("FLASH_FIRST", f"24'h{table['flash_image']['first']:06x}")
    # What every core has, and what it has when one of its parameters is not 0.
    define("FEATURES", f"16'h{sum(1 << row['bit'] for row in table['feature'] if 'parameter' not in row):04x}")
    for row in table["feature"]:
        if "parameter" in row:
            define(f"FEATURE_{row['name']}", f"16'h{1 << row['bit']:04x}")
    for kind, bits in (("kind", 8), ("mode", 2), ("role", 2), ("flash", 2), ("event", 3), ("test", 2)):
        for row in table[kind]:
            define(f"{kind}_{row['name']}", f"{bits}'d{row['value']}")
    for command in table["command"]:
        define(f"COMMAND_{command['name']}", f"8'h{command['code']:02x}")
    for status in table["status"]:
        define(f"REPLY_{status['name']}", f"8'h{status['code']:02x}")
    chain = table["chain"]
    define("CHAIN_ALL", f"8'd{chain['all']}")
    define("CHAIN_NEAR", "8'd3")  # the nearest tile's number is 1
    define("CHAIN_COMPLEMENT", "8'hfd")  # of both
    return "\n".join(out) + "\n"


def verilog_parameters(table):
    """For the header of the core and of each top around it. Others follow there, hence the last comma."""
    out = [f"// {NOTE}", "// SPDX-License-Identifier: Apache-2.0"]
    out += [f"parameter {p['name']} = {p['default']}," for p in table["parameter"]]
    return "\n".join(out) + "\n"


def verilog_connections(table):
    """What such a top hands on to the core."""
    out = [f"// {NOTE}", "// SPDX-License-Identifier: Apache-2.0"]
    out += [f".{p['name']}({p['name']})," for p in table["parameter"]]
    return "\n".join(out) + "\n"


def verilog_check(table):
    """A value out of range does not elaborate, because a module of that name does not exist; the tool says its name."""
    out = [f"// {NOTE}", "// SPDX-License-Identifier: Apache-2.0"]
    for p in table["parameter"]:
        name = p["name"]
        wrong = [f"{name} < {p['low']}", f"{name} > {p['high']}"]
        wrong += [f"{name} {sign} {p[key]}" for key, sign in (("at_least", "<"), ("at_most", ">")) if key in p]
        wrong += [f"({name} & ({name} - 1)) != 0"] if p.get("power_of_two") else []
        wrong += [f"{p[key]} == 0" for key in ("needs", "needs_too") if key in p]
        wrong = " || ".join(wrong)
        if p.get("optional"):
            wrong = f"{name} != 0 && ({wrong})"
        elif "needs" in p:
            wrong = wrong.replace(f" || {p['needs']} == 0", f" || ({name} != 0 && {p['needs']} == 0)")
        out.append(f"generate if ({wrong}) {name.lower()}_out_of_range error(); endgenerate")
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


CPP_TYPES = """/// Some bits of a block of little-endian words of any width: `width` bits from bit `offset` on, counted from the block's
/// beginning. A field may reach over several words.
struct BitField {
    std::string_view name;
    unsigned offset, width;

    [[nodiscard]] constexpr std::uint32_t most() const { return static_cast<std::uint32_t>((std::uint64_t{1} << width) - 1U); }

    /// @param words  the block: a vector, an array, a span or a pointer, of 8, 16 or 32 bits each
    template <class Words>
    [[nodiscard]] constexpr std::uint32_t get(const Words& words) const {
        constexpr unsigned digits = std::numeric_limits<std::remove_cvref_t<decltype(words[0])>>::digits;
        std::uint64_t value = 0;
        for (unsigned done = 0; done < width;) {
            const unsigned low = (offset + done) % digits;
            value |= std::uint64_t{words[(offset + done) / digits]} >> low << done;
            done += digits - low;
        }
        return static_cast<std::uint32_t>(value & most());
    }

    /// @throws std::out_of_range when the value is wider than the field
    template <class Words>
    constexpr void set(Words&& words, std::uint64_t value) const {
        using Word = std::remove_cvref_t<decltype(words[0])>;
        constexpr unsigned digits = std::numeric_limits<Word>::digits;
        if (value > most())
            throw std::out_of_range(std::string(name) + " is " + std::to_string(value) + ", but its field has " +
                                    std::to_string(width) + " bits, at most " + std::to_string(most()));
        for (unsigned done = 0; done < width;) {
            const unsigned low = (offset + done) % digits;
            const std::uint64_t mask = std::uint64_t{most()} >> done << low;
            auto& word = words[(offset + done) / digits];
            word = static_cast<Word>((word & ~mask) | (value >> done << low & mask));
            done += digits - low;
        }
    }
};
"""

CPP_PARAMETERS = """/// A parameter may be bounded by another one, or by another one divided by a number.
struct ParameterBound {
    std::uint32_t CoreParameters::* member = nullptr;  ///< none when null
    std::uint32_t divisor = 1;
};

/// One parameter of the core, as rtl/haptogram_core.v takes it.
struct ParameterDescription {
    std::string_view name;  ///< in Verilog and in board files
    std::uint32_t CoreParameters::* member;
    std::uint32_t low, high;
    ParameterBound at_least, at_most;
    bool power_of_two, optional;  ///< optional: 0 is allowed beside low to high

    /// The lowest and highest value beside the others of `core`.
    [[nodiscard]] constexpr std::uint32_t lowest(const CoreParameters& core) const {
        return at_least.member == nullptr ? low : std::max(low, core.*at_least.member / at_least.divisor);
    }
    [[nodiscard]] constexpr std::uint32_t highest(const CoreParameters& core) const {
        return at_most.member == nullptr ? high : std::min(high, core.*at_most.member / at_most.divisor);
    }
    [[nodiscard]] constexpr bool allows(const CoreParameters& core) const {
        const std::uint32_t value = core.*member;
        if (optional && value == 0) return true;
        return value >= lowest(core) && value <= highest(core) && (!power_of_two || std::has_single_bit(value));
    }
};
"""


def quoted(text):
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def cpp(table):
    headers = ["algorithm", "array", "bit", "cstdint", "limits", "stdexcept", "string", "string_view", "type_traits"]
    out = [f"// {NOTE}", "// SPDX-License-Identifier: Apache-2.0", "#pragma once"] + [f"#include <{h}>" for h in headers] + [""]
    out += ["namespace haptogram::interface {", ""]
    protocol, record = table["protocol"], table["record"]
    out.append(f'inline constexpr std::string_view name = "{protocol["name"]}";')
    out.append(f"inline constexpr unsigned version_major = {protocol['version_major']};")
    out.append(f"inline constexpr unsigned version_minor = {protocol['version_minor']};")
    for region in table["region"]:
        out.append(f"inline constexpr std::uint32_t {region['name']}_base = 0x{region['base']:08x};")
        out.append(f"inline constexpr unsigned {region['name']}_word_bits = {region['word_bits']};")
    out.append(f"inline constexpr unsigned record_header_words = {record['header_words']};")
    out.append(f"inline constexpr std::uint16_t silent_timing = 0x{record['silent_timing']:04x};  // a channel that never fires")
    description = next(b for b in table["block"] if b["region"] == "description")
    out.append(f"inline constexpr std::uint16_t description_magic = 0x{description['magic']:04x};")
    out.append(f"inline constexpr std::uint16_t description_format = {description['format']};")
    out.append(f"inline constexpr std::uint16_t description_long_format = {description['long_format']};")
    out.append(f"inline constexpr double longest_cycle_s = {table['image']['longest_cycle_s']};")
    out += ["", CPP_TYPES.rstrip("\n")]
    for name, rows, word_bits in layouts(table):
        out += ["", f"namespace {name}_field {{  // words of {word_bits} bits"]
        out += [f'inline constexpr BitField {field} = {{"{field}", {first}, {width}}};' + (f"  // {about}" if about else "") for field, first, width, about in rows]
        out += [f"}}  // namespace {name}_field"]
    out += ["", "/// How a host deals with a line that loses bytes; rtl/INTERFACE.md says what each number means.", "namespace link_policy {"]
    out += [f"inline constexpr unsigned {row['name']} = {row['value']};" for row in table["link"]] + ["}  // namespace link_policy"]
    out += ["", "/// What stands before each frame in a chain of tiles; rtl/INTERFACE.md says how it is used.", "namespace chain {"]
    out += [f"inline constexpr unsigned {name} = {value};" for name, value in table["chain"].items()] + ["}  // namespace chain"]
    out += ["", "/// Where an image lies in the flash, in bytes; rtl/sdram/flash_image.v reads it.", "namespace flash_image {"]
    out += [f"inline constexpr unsigned {name} = {value:#x};" for name, value in table["flash_image"].items()] + ["}  // namespace flash_image"]
    out += ["", "/// Boards with a network port; rtl/INTERFACE.md says how they are spoken to.", "namespace network {"]
    out += [f"inline constexpr unsigned {name} = {value};" for name, value in table["network"].items()] + ["}  // namespace network"]
    for name, words in blocks(table).items():
        out += ["", f"enum class {name.capitalize()}Word : unsigned {{"]
        out += [f"    {word} = {position}," for position, word in enumerate(words)]
        out += ["};", f"inline constexpr unsigned {name}_words = {len(words)};"]
        if name == "status":
            out += [f"inline constexpr unsigned status_{end}_words = {length};  // of boards without {lacks}" for end, (length, lacks) in status_ends(table).items()]
        if name == "trigger":
            out += [f"inline constexpr unsigned trigger_settings = {trigger_settings(table)};  // the first of them, which a host may write"]
    out += ["", "/// Bits of the identity block's features.", "enum class Feature : unsigned {"]
    out += [f"    {row['name']} = {row['bit']},  // {row['about']}" for row in table["feature"]] + ["};"]
    out += ["[[nodiscard]] constexpr bool has(std::uint32_t features, Feature feature) {"]
    out += ["    return (features >> static_cast<unsigned>(feature) & 1U) != 0;", "}"]
    for kind, about in (("kind", "What the words of a record are"), ("mode", "Where the next record comes from"),
                        ("role", "How its carrier cycles are kept in step with other boards"), ("flash", "What became of the image in the flash"),
                        ("event", "What makes a pulse at the trigger output"), ("test", "What is at the test output")):  # fmt: skip
        out += ["", f"/// {about}.", f"enum class {kind.capitalize()} : unsigned {{"]
        out += [f"    {row['name']} = {row['value']},  // {row['about']}" for row in table[kind]] + ["};"]
    out += ["", "enum class Command : std::uint8_t {"] + [f"    {c['name']} = 0x{c['code']:02x}," for c in table["command"]] + ["};"]
    out += ["", "enum class Status : std::uint8_t {"] + [f"    {s['name']} = 0x{s['code']:02x}," for s in table["status"]] + ["};", ""]
    replying = " || ".join(f"command == Command::{c['name']}" for c in table["command"] if "reply" in c)
    out += ["/// Whether its reply carries data.", "constexpr bool replies(Command command) {", f"    return {replying};", "}", ""]
    for variable in ("mode", "role", "flash", "event", "test", "command"):
        title = variable.capitalize()
        out += [f"constexpr std::string_view to_string({title} {variable}) {{", f"    switch ({variable}) {{"]
        out += [f'        case {title}::{row["name"]}: return "{row["name"]}";' for row in table[variable]]
        out += ["    }", '    return "unknown";', "}", ""]
    out += ["constexpr std::string_view to_string(Status status) {", "    switch (status) {"]
    out += [f'        case Status::{s["name"]}: return "{s["name"]}: {s["about"]}";' for s in table["status"]]
    out += ["    }", '    return "unknown status";', "}", ""]

    def bound(text):
        if text is None:
            return "{}"
        name, _, divisor = text.partition(" / ")
        return f"{{&CoreParameters::{name.lower()}, {divisor or 1}}}"

    names = [p["name"].lower() for p in table["parameter"]]
    out += ["/// The parameters of rtl/haptogram_core.v; rtl/INTERFACE.md says what each is.", "struct CoreParameters {"]
    out += [f"    std::uint32_t {p['name'].lower()} = {p['default']};" for p in table["parameter"]]
    out += ["    friend bool operator==(const CoreParameters&, const CoreParameters&) = default;", "};", "", CPP_PARAMETERS]
    out += [f"inline constexpr std::array<ParameterDescription, {len(names)}> core_parameters = {{{{"]
    for p in table["parameter"]:
        out.append(f"    {{{quoted(p['name'])}, &CoreParameters::{p['name'].lower()}, {p['low']}, {p['high']}, {bound(p.get('at_least'))}, "
                   f"{bound(p.get('at_most'))}, {str(p.get('power_of_two', False)).lower()}, {str(p.get('optional', False)).lower()}}},")  # fmt: skip
    out += ["}};", "", "/// A named set of parameters.", "struct CoreConfiguration {", "    std::string_view name;", "    CoreParameters parameters;", "};", ""]
    rows = configurations(table)
    out += [f"inline constexpr std::array<CoreConfiguration, {len(rows)}> core_configurations = {{{{"]
    for name, values in rows.items():
        out.append(f"    {{{quoted(name)},")
        out.append("     {" + ", ".join(f".{key.lower()} = {value}" for key, value in values.items()) + "}},")
    out += ["}};", "", "/// The configuration of this name; null when there is none.",
            "[[nodiscard]] constexpr const CoreConfiguration* find_configuration(std::string_view wanted) {",
            "    for (const CoreConfiguration& configuration : core_configurations)",
            "        if (configuration.name == wanted) return &configuration;", "    return nullptr;", "}",
            "", "}  // namespace haptogram::interface"]  # fmt: skip
    return "\n".join(out) + "\n"


PYTHON_TYPES = '''class BitField(NamedTuple):
    """Some bits of little-endian memory: `width` bits from bit `offset` on, counted from the beginning of its block."""

    offset: int
    width: int

    def get(self, data: bytes) -> int:
        end = self.offset + self.width
        return int.from_bytes(data[: (end + 7) // 8], "little") >> self.offset & (1 << self.width) - 1


def pack(fields: dict[str, BitField], size: int, **values: int) -> bytes:
    """A block of `size` bytes with these fields; all other bits are zero."""
    block = 0
    for name, value in values.items():
        field = fields[name]
        if not 0 <= value < 1 << field.width:
            raise ValueError(f"{name} is {value}, but its field has {field.width} bits, at most {(1 << field.width) - 1}")
        block |= value << field.offset
    return block.to_bytes(size, "little")


def unpack(fields: dict[str, BitField], data: bytes) -> dict[str, int]:
    """The value of every field."""
    return {name: field.get(data) for name, field in fields.items()}
'''


def python(table):
    out = [f'"""{NOTE}"""', "# SPDX-License-Identifier: Apache-2.0", "import enum", "from typing import NamedTuple", ""]
    protocol = table["protocol"]
    out += [f"NAME = {protocol['name']!r}", f"VERSION = ({protocol['version_major']}, {protocol['version_minor']})"]
    for region in table["region"]:
        out.append(f"{region['name'].upper()}_BASE = 0x{region['base']:08x}")
    out.append(f"RECORD_HEADER_WORDS = {table['record']['header_words']}")
    out.append(f"SILENT_TIMING = 0x{table['record']['silent_timing']:04x}")
    description = next(b for b in table["block"] if b["region"] == "description")
    out += [f"DESCRIPTION_MAGIC = 0x{description['magic']:04x}", f"DESCRIPTION_FORMAT = {description['format']}",
            f"DESCRIPTION_LONG_FORMAT = {description['long_format']}"]  # fmt: skip
    out.append(f"LONGEST_CYCLE_S = {table['image']['longest_cycle_s']}")
    out += [f"LINK_{row['name'].upper()} = {row['value']}" for row in table["link"] if row["name"].startswith("keep_alive")]
    out += [f"KNOWN_RATES = {tuple(known_rates(table))}", ""]
    for name, words in blocks(table).items():
        out.append(f"{name.upper()}_WORDS = {words!r}".replace("'", '"'))
    out += [""] + [f"STATUS_{end.upper()}_WORDS = {length}  # of boards without {lacks}" for end, (length, lacks) in status_ends(table).items()]
    out.append(f"TRIGGER_SETTINGS = {trigger_settings(table)}  # words of the trigger block which a host may write")
    out += ["", "", PYTHON_TYPES, ""]
    for name, rows, _ in layouts(table):
        out += [f"{name.upper()}_FIELDS = {{"] + [f'    "{field}": BitField({first}, {width}),' for field, first, width, _ in rows] + ["}"]
    for kind in ("kind", "feature", "mode", "role", "flash", "event", "test"):
        out += ["", "", f"class {kind.capitalize()}(enum.IntEnum):"]
        out += [f"    {row['name'].upper()} = {row['bit' if kind == 'feature' else 'value']}" for row in table[kind]]
    for title, rows in (("Command", table["command"]), ("Status", table["status"])):
        out += ["", "", f"class {title}(enum.IntEnum):"]
        out += [f"    {row['name'].upper()} = 0x{row['code']:02x}" for row in rows]
    return "\n".join(out) + "\n"


def example_frame(table):
    """IDENTIFY with sequence number 42: the decoded frame without its CRC, and the bytes on the line. None of them is zero, so COBS adds one byte."""
    body = bytes([42, next(row["code"] for row in table["command"] if row["name"] == "identify")])
    body += binascii.crc_hqx(body, 0xFFFF).to_bytes(2, "big")
    return body[:2].hex(" ").upper(), (bytes([len(body) + 1]) + body + b"\0").hex(" ").upper()


def rows_of(head, rows):
    """A table of the page; Markdown needs no bars at the ends of its rows."""
    return [" | ".join(head), "|".join(["---"] * len(head))] + [" | ".join(str(cell) for cell in row).rstrip() for row in rows]


def prose(text):
    """Paragraphs and lists of the page, as lines: a list's next lines are indented."""
    lines = []
    for paragraph in text.split("\n"):
        indent = "  " if paragraph.startswith("- ") else ""
        lines += textwrap.wrap(paragraph, 150, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False) or [""]
    return lines + [""]


def values_table(kind, rows, about):
    return rows_of((kind, "value", about), [(row["name"], row["value"], row["about"]) for row in rows]) + [""]


def page(table):
    out = [f"<!-- {NOTE} -->", "<!-- SPDX-License-Identifier: Apache-2.0 -->", "# What a host sends and reads, and what a core can be", ""]
    out += prose("For a host in any language, and for FPGA engineers. [page_client.py](../tests/client_from_the_page/page_client.py) is a host of at most 150 lines, "
                 "written from this page.")
    plain, coded = example_frame(table)
    out += ["## Frames", "", *prose(f"""\
A host sends requests, and the board answers each. The serial line has 8 data bits, lowest first, no parity, one stop bit and no flow control; it idles high. A *break* \
is a low of 20 bits or longer; send 25. A request is

`sequence number, command, arguments…, data…, CRC high, CRC low`

and its reply

`sequence number, command | 0x80, status, next expected sequence number, live level low, high, data…, CRC high, CRC low`

Arguments and data are 16-bit words, low byte first. The live level is how many indices wait in the live FIFO. The CRC is CRC-16/IBM-3740 (polynomial 0x1021, start \
0xFFFF, no reflection) of all bytes before it. On the line a frame is COBS-encoded and ends with a zero byte. For example, IDENTIFY with number 42 is `{plain}` and its \
CRC, on the line `{coded}`. A repeated reply, too, tells the present state.

A frame of frame_bytes bytes, decoded and without its CRC, always fits: a WRITE of one record (6 bytes before its data), a PUSH of frame_bytes / 2 − 2 indices, \
if the live FIFO has room, or a PUSH_FOCI of (frame_bytes − 4) / 8 foci.""")]
    out += rows_of(("command", "code", "arguments, data…", "what"), [
        (c["name"], f"0x{c['code']:02X}", ", ".join([*c["args"], *(["data…"] if c.get("tail") else [])]), c["about"]) for c in table["command"]])  # fmt: skip
    out += ["", *prose("""\
Boards without modulation, schedule, foci, stream or SYNC answer MODULATE, GATE, PUSH_FOCI, STREAM or SYNC with unknown_command, or with bad_length if the length is \
wrong, too.""")]
    out += rows_of(("status", "code", "what"), [(s["name"], f"0x{s['code']:02X}", s["about"]) for s in table["status"]])
    out += ["", "## A line that loses bytes", "", *prose("""\
Sequence numbers count modulo 256. The board applies each once and in order, answers every good frame, and drops damaged ones silently. A host sends again from the \
first unanswered frame on. The board judges a frame by its command and length first, then by its number, then by its arguments. A refused frame does not use up its number: the \
next frame has the same one. Damage to the zero behind a frame can add a zero to the frame \
and leave its CRC right; the board answers bad_length, and the host sends the frame again. The numbers of all hosts of this project:""")]
    out += rows_of(("number", "value", "what"), [(row["name"], row["value"], row["about"]) for row in table["link"]])
    rates = ", ".join(f"{rate:,}" for rate in known_rates(table))
    out += ["", *prose(f"""\
A host that does not know the rate sends IDENTIFY at {rates} baud, in this order, and waits {table['probe']['patience_ms']} ms each. To a faster board, slower bytes can \
be a break; so the rate that answered last comes first.

## Switching off

Outputs go off by DISABLE, a break, the stop input, the watchdog, the guard, loss of SYNC, RESET, or a reset of the FPGA. **A frame whose first edge was at the pin \
before that cannot switch outputs on.** Frames that wait or arrive when outputs go off are carried out and answered, but an ENABLE among them is answered ok and does \
nothing. In the same way, a SELECT, START or PUSH from before a STOP is answered and not carried out.

DISABLE and STOP act within 20 clocks of the last bit of their frame (over Ethernet, of their datagram) if its CRC is right. They overtake waiting frames, act with any \
sequence number, without a session or in any host's session, and without room for them. So any answer to a DISABLE or STOP shows that it has acted. A late copy acts \
again and ends what has begun since. Therefore **a host sends nothing after a DISABLE or STOP until the answer comes**; then no copy is under way. Frames behind a \
DISABLE or STOP in the same datagram count as sent before it.

A break also ends a frame, as a zero does. To silence a board whatever came before, send a zero (not needed over Ethernet), DISABLE and STOP with any numbers, and, \
without an answer, a break.

## Address map

Addresses count bytes. Words are little-endian, of 32 bits in sequence, of 16 elsewhere. A field without bits takes whole words, the lowest bits in the first. A field \
without a description is the parameter of that name. "Needs foci" means: on boards with that feature.""")]
    out += rows_of(("region", "base", "access", "what"), [(r["name"], f"`0x{r['base']:08X}`", r["access"], r["about"]) for r in table["region"]])

    def bit_table(rows, word_bits):
        """A parameter of the core needs no words, and the upper bits of a number that has three words no row of their own."""
        high = {name.removesuffix("_high"): first + width - 1 for name, first, width, _ in rows if name.endswith("_high")}
        cells = []
        for field, first, width, about in rows:
            if field.removesuffix("_high") in high and field.endswith("_high"):
                continue
            word, low = divmod(first, word_bits)
            last, end = divmod(high.get(field, first + width - 1), word_bits)
            place = f"{word}" if last == word else f"{word}…{last}"
            if (low, end) != (0, word_bits - 1):
                bits = f"bits {end}…{low}" if end != low else f"bit {low}"
                place = f"{word}, {bits}" if last == word else f"{place}, to bit {end}"
                assert last == word or low == 0
            cells.append((place, field, "" if about == field.upper() else about))
        return rows_of(("word", "field", "what"), cells)

    parts = {name: bit_table(rows, word_bits) for name, rows, word_bits in layouts(table)}
    out += ["", "## Record", "", "A record has a header and a word for each channel.", ""] + parts["record"]
    out += [f"{table['record']['header_words']}… | word[CHANNELS] | of channel 0, 1, …", "", *values_table("kind", table["kind"], "a channel's word")]
    out += [*prose("""\
A record of timings has a pulse of 0 (silence), or of min_pulse_clocks to max_pulse_clocks clocks and at most max_duty_256 / 256 of its cycle. On boards with amplitude \
its cycle has at least 8 clocks, and not 2^TIMING_BITS + 1 to 2^TIMING_BITS + 2^WIDTH_BITS − 1 ticks. A record of amplitudes has pulse_length 0, prescaler 1, and a \
cycle of 2 · (CHANNELS + 44) to 2 · min(2^WIDTH_BITS − 1, max_pulse_clocks) clocks. Modulation multiplies its amplitudes by sample / 255 before widths are computed. \
Silence replaces a record that breaks a limit.

A focus record has no header. The n-th one has index RECORDS + n and begins at word 4 · (`foci_base` + (n − 1) · (`foci_last` + 1)) of primary memory. It has \
`foci_last` + 1 foci of four words: the lower 16 bits of x, y and z (signed, 18 bits, 1/128 mm), then amplitude in bits 15…8, 0 in 7…6, and the upper bits of z in \
5…4, of y in 3…2, of x in 1…0.

Silence replaces a focus record with an index above RECORDS + `foci_count`, a word beyond primary memory, bits 7…6 that are not 0, or a `foci_cycle` that a record of \
amplitudes may not have (on a master or a slave: other than 40 kHz). A focus 1.024 m or more from a channel in x, y or z does not count for that channel; `far_foci` \
counts such records.

R is a channel's distance from a focus in 1/128 mm. Phases are in turns and say where in the carrier period a pulse's middle lies."""),
            "    phase of a focus = offset − R · wave_number / 2^27           a nearer channel plays later",
            "    sum              = Σ amplitude / 255 · e^(2πj · phase)       over the record's foci",
            "    phase            = the sum's angle",
            "    amplitude        = |sum| · gain / 39953, at most 1; with foci_whole 1, or 0 if the sum is 0",
            "    of the channel   = amplitude · (255 − lack) / 255            other records ignore offset and lack", "",
            *prose("""\
wave_number is 2^27 / (128 · wavelength in mm): 122,212 for 8.58 mm. A single focus's phase is right to 0.0001 turn and its amplitude to 0.1 % of full; a sum's to \
0.0006 turn, if it is at least a quarter of full, and to 0.5 %."""),
            "## Sequence", "", "The header, word 0 of sequence memory:", "", *parts["sequence_header"], "", "An entry:", "", *parts["sequence_entry"], ""]  # fmt: skip
    for block in table["block"]:
        region = block["region"]
        out += [f"## The {region} block", ""]
        if region == "identity":
            out += [f"Words 0 to 7 are the name {table['protocol']['name']}, in ASCII, padded with zeros.", ""]
        out += parts[region] + [""]
        if region == "identity":
            bits = [f"{row['bit']} {row['name']}" + (f" ({row['parameter']})" if row.get("parameter", row["name"].upper()) != row["name"].upper() else "") for row in table["feature"]]
            out += prose(f"Bits of features: {', '.join(bits)}. All cores have the first four; the others need the parameter in brackets, or that of their name.")
        if region == "parameters":
            out += prose("""\
A write applies from the next carrier period or focus record whose words are begun. The slew limiter starts from what the pins do. After a reset, with outputs off, and \
after records of timings, which it does not limit, it starts from amplitude 0 at the target's phase. A phase goes the shorter way round; from exactly half a turn, backwards.""")
        if region == "ring":
            out += prose("""\
`base` is `foci_base` + (`first` − RECORDS − 1) · (`foci_last` + 1). The ring ends within primary memory and at index RECORDS + `foci_count` at the latest. A PUSH_FOCI \
carries whole records. Their indices count up; after the ring's last comes its first.""")
        if region == "trigger":
            out += values_table("event", table["event"], "a pulse when")
            out += prose(f"""\
A host can write the first {trigger_settings(table)} words. A reset changes none. An event during a pulse lengthens it, and both count. The trigger input never switches \
outputs on. Whether in_gates holds pulses back at the moment cannot be read.""")
        if region == "description":
            flash = table["flash_image"]
            out += prose(f"""\
A bitstream holds only records and a sequence; an image of format 2 is uploaded. In the flash of a board with SDRAM an image begins at {flash['first']:#x} and has at \
most {flash['bytes']:,} bytes: a zero, frames as on the line, each with its zero, and two more zeros. The first frame is IDENTIFY, all others are WRITE with \
consecutive numbers. None is answered. A frame that is damaged, refused or out of order ends the reading. So does a byte from a host, which begins the host's frame.""")
    chain = table["chain"]
    out += ["## A chain of tiles", "", *prose(f"""\
From the second serial port of a board with chain one wire goes to the next board's first port, and one comes back. In a chain, two bytes stand before each frame, \
outside of its COBS. The first is 2 · n + 1 for tile n (1 to {chain['most_tiles']}), or {chain['all']} for all. The second is the complement of the first byte's upper \
seven bits above a 1: 3, 253 for the first tile, 5, 251 for the second, 2, 253 for all. A frame whose two bytes do not match reaches no tile. Each tile counts n down as it \
passes a frame on, and takes 3, 253 as its own. An answer carries its tile's number in the same two bytes. A zero is always passed on as a zero.

Each tile has its own session and judges a frame for all by it. All tiles carry out and answer such a frame. So begin all sessions by one IDENTIFY for all before you send \
all tiles more than DISABLE, STOP and IDENTIFY.

After power-up a board passes nothing on. The bytes {chain['all']}, 253, 0 make it one of a chain; the next such bytes go to the next tile. So a host sends a zero and \
the three bytes and asks tile 1, sends the three bytes and asks tile 2, and so on until a tile does not answer in 0.3 s. A board without chain takes the bytes for a damaged frame. A \
break, half a bit longer for each tile, ends the chain and switches all outputs off."""),
            *network_page(table["network"], table),
            *STREAM_PAGE,
            "## Boards in step", "", *prose("""\
SYNC makes one board the master, whose every second cycle is a clock longer, and the others slaves. A slave is in step 13 to 20 ms after the master has begun (512 carrier periods in a row), and numbered within \
128 periods more, as its status tells. Until it is in step it refuses ENABLE.""")]
    out += ["## Parameters of the core", "", "A range of 0…1 means: 1 if the core has it.", ""]
    cells = []
    for p in table["parameter"]:
        unit = "" if p["unit"] in ("", "0 or 1") else f" {p['unit']}"
        bounds = [f"{p['low']}…{p['high']}{unit}" if p["low"] != p["high"] else f"{p['low']}{unit}"]
        bounds += [f"{sign} {p[key]}" for key, sign in (("at_least", "≥"), ("at_most", "≤")) if key in p]
        bounds += ["a power of two"] if p.get("power_of_two") else []
        bounds += ["or 0"] if p.get("optional") else []
        bounds += [f"0 without {p[key]}" for key in ("needs", "needs_too") if key in p]
        cells.append((p["name"], ", ".join(bounds), p["default"], f"{p['about'][0].upper()}{p['about'][1:]}. {p['why']}"))
    out += rows_of(("parameter", "range", "default", "what, and why"), cells)
    rows = configurations(table)
    default = {p["name"]: p["default"] for p in table["parameter"]}
    out += ["", "## Named configurations", "", *prose("""\
Other parameters have their defaults. `tools/interface.toml` has more, for tests. Each board of `constraints/` is a configuration, too: `haptogram board pinout BOARD \
--json` tells its parameters.""")]
    other = {name: ", ".join(f"{key} {value}" for key, value in values.items() if value != default[key]) for name, values in rows.items()}
    out += rows_of(("configuration", "parameters", "what"), [(row["name"], other[row["name"]] or "the defaults", row["about"]) for row in table["configuration"] if "about" in row])
    return "\n".join(out) + "\n"


STREAM_PAGE = [
    "## A stream of patterns", "", *prose("""\
On boards with stream a host can send a new pattern for every carrier period. A STREAM frame is neither answered nor sent again. In place of its own sequence number it \
carries the number of the IDENTIFY that began the session, and only that session takes it. So each IDENTIFY needs another number than the one before. STREAM restarts the watchdog's time.

The stream block names 2^slot_bits records as slots. The host writes their headers, with a cycle of one carrier period. A pattern is the CHANNELS words of a record \
behind its header, or a whole focus record. The first of a frame is for the period that the frame names, the others for the periods after it. The pattern for period p \
goes into slot p mod 2^slot_bits and plays in period p only. What plays in p is decided 1.4 periods before p begins, or up to half a period earlier where cycles are \
shorter than at 40 kHz.

- A pattern is **late** if its period was already decided, **early** if its period is 2^slot_bits or more behind the last decided one, **repeated** if its slot already \
has that period's pattern. Such a pattern only raises its counter. An incomplete pattern at a frame's end is refused; those before it hold.
- A stream begins when the first pattern's time comes, and ends what else plays. A period without a pattern is **lost**: the last pattern plays on. After `hold` lost \
periods the stream ends: amplitudes fall by `fade` a period, and the mode is idle. A later pattern begins a new stream.
- SELECT, START, PUSH, STOP, IDENTIFY, a switch-off, a write to the stream block or to the first three words of the parameters block, and a jump of the period number (a \
slave takes the master's) end a stream and empty all slots. Patterns from before a DISABLE or STOP, or while the stop input or missing SYNC keeps outputs off, are \
dropped without a count."""),
]


def link_number(table, name):
    return next(row["value"] for row in table["link"] if row["name"] == name)


def network_page(net, table):
    codes = {row["name"]: f"0x{row['code']:02x}" for row in table["command"]}
    tries, first = (link_number(table, name) * link_number(table, "patience_ms") // net["patience_ms"] for name in ("tries", "first_tries"))
    return [
        "## Over Ethernet", "", *prose(f"""\
A board with net has an IPv4 address, answers ARP and ping, and takes frames in UDP datagrams at port {net['port']}, at 1 Gbit/s only. A datagram has at most \
{net['datagram_bytes']} bytes and holds whole frames; the zero at its end may be missing. The window is {net['window']} and patience_ms {net['patience_ms']}, with as \
many tries as fill the same time: {tries}, and {first} of IDENTIFY. Answers gather for 50 µs.

- **Room.** The board has room for {2 ** 12:,} bytes of datagrams and takes out a byte a clock. A host keeps its unanswered bytes below that, or sends again what was dropped.
- **Dropped datagrams.** A wrong FCS, a wrong IP or UDP sum to port {net['port']} (a UDP sum of 0 is none) or no room drops a datagram whole and counts as damaged; a \
DISABLE or STOP acts even without room. Dropped without a count: contradictory lengths, fragments, IP options, VLAN tags, other addresses, broadcast, multicast.
- **Peer.** The first sender of a good datagram, by MAC, IP and port, is the peer until it has been silent for {net['silence_ms']} ms. Any good datagram makes and keeps \
a peer, even an empty one. Datagrams of others are refused and counted.
- **A session ends** when the link is lost, when anybody sends DISABLE to the open port, and when the peer is another than the last one. A peer that was silent and \
comes back keeps its session. STOP ends no session. After the end no frame is carried out, not even one on its way; each is answered session_ended, even an IDENTIFY \
on its way.
- **After the end** a host does not take session_ended for the answer to an earlier frame, sends nothing of that session again, and reports that outputs are off. Only then, \
if asked, it sends IDENTIFY with another number.
- **Break.** A host has no line to break. It sends DISABLE to the open port, which ends the session, whoever's it is. Loss of the link (by the PHY's status or clock) is \
a break, and loses a datagram in which it happens. Only a board that plays by autostart, and to which no host has sent more than questions, plays on.
- There is **no authentication**: use a private wire or switch.

The *open port*, {net['open_port']}, takes four bytes from anybody: `H`, `G`, a command, 0. The command is IDENTIFY ({codes['identify']}), which only asks and may be \
broadcast, DISABLE ({codes['disable']}), which switches off and ends the session, or STOP ({codes['stop']}). The answer is `H`, `G`, the command | 0x80, a byte of \
flags, the identity block, and three 16-bit counts of datagrams: taken, refused, damaged. Flag bit 0: there is a peer. Bit 1: outputs were on when the question came, \
even if a DISABLE has then switched them off."""),
    ]


def cmake(table):
    out = [f"# {NOTE}", "# SPDX-License-Identifier: Apache-2.0"]
    out.append(f"set(HAPTOGRAM_PARAMETERS {' '.join(p['name'] for p in table['parameter'])})")
    rows = configurations(table)
    out.append(f"set(HAPTOGRAM_CONFIGURATIONS {' '.join(rows)})")
    out += ["# The values of each, in the order of HAPTOGRAM_PARAMETERS."]
    out += [f"set(HAPTOGRAM_CONFIGURATION_{name} {' '.join(str(v) for v in values.values())})" for name, values in rows.items()]
    return "\n".join(out) + "\n"


def known_rates(table):
    """The rates of all configurations, from the fastest on: a board then answers before it hears a slower byte, which could be a break."""
    return sorted({values["BAUD"] for values in configurations(table).values()}, reverse=True)


def cpp_rates(table):
    rates, probe = known_rates(table), table["probe"]
    return "\n".join([f"// {NOTE}", "// SPDX-License-Identifier: Apache-2.0", "#pragma once", "#include <array>", "#include <chrono>", "#include <cstdint>", "",
                      "namespace haptogram::link {", "", "/// Those of all configurations, in the order in which a board's rate is looked for.",
                      f"inline constexpr std::array<std::uint32_t, {len(rates)}> known_rates = {{{', '.join(map(str, rates))}}};",
                      f"inline constexpr std::chrono::milliseconds probe_patience{{{probe['patience_ms']}}};",
                      f"inline constexpr unsigned probe_rounds = {probe['rounds']};", "", "}  // namespace haptogram::link"]) + "\n"  # fmt: skip


NUMBERED = {"region": "base", "kind": "value", "command": "code", "status": "code", "feature": "bit", "mode": "value", "role": "value", "flash": "value",
            "event": "value", "test": "value"}  # fmt: skip


def numbers(table):
    """What boards and hosts of one major version agree on, a line each: codes, bits, and of a field its first bit / its width."""
    lines = [f"version_major {table['protocol']['version_major']}"]
    lines += [f"{part}.{entry['name']} {entry[key]:#x}" for part, key in NUMBERED.items() for entry in table[part]]
    lines += [f"{block}.{name} {first}/{width}" for block, found, _ in layouts(table) for name, first, width, _ in found]
    return "\n".join(["# " + NOTE, "# Published: a number stays while version_major does.", *lines]) + "\n"


def stays(old, new):
    """A field may grow into bits that were free."""
    if new is None or "/" not in old:
        return old == new
    return old.split("/")[0] == new.split("/")[0] and int(old.split("/")[1]) <= int(new.split("/")[1])


def renumbered(published, now):
    """Lines of two such texts that contradict each other: what a board of the old text and a host of the new one would misread."""
    old, new = (dict(line.split() for line in text.splitlines() if not line.startswith("#")) for text in (published, now))
    if old.get("version_major") != new["version_major"]:
        return []
    return [f"{name} was published as {number}, and {'is ' + new[name] if name in new else 'has gone'}" for name, number in old.items() if not stays(number, new.get(name))]


NUMBERS = "tools/interface_numbers.txt"
FILES = {
    NUMBERS: numbers,
    "rtl/interface.vh": verilog,
    "rtl/parameters.vh": verilog_parameters,
    "rtl/parameter_connections.vh": verilog_connections,
    "rtl/parameter_check.vh": verilog_check,
    "rtl/command_table.v": verilog_commands,
    "host/haptogram/format/interface.hpp": cpp,
    "host/haptogram/link/known_rates.hpp": cpp_rates,
    "python/haptogram/interface.py": python,
    "rtl/INTERFACE.md": page,
    "sim/configurations.cmake": cmake,
}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="change nothing; exit 1 when a file is stale")
    check = parser.parse_args().check
    table = load()
    stale = []
    try:
        texts = {name: make(table) for name, make in FILES.items()}
    except Wrong as error:
        sys.exit(f"tools/interface.toml: {error}")
    published = ROOT / NUMBERS
    if published.exists() and (wrong := renumbered(published.read_text(encoding="utf-8"), texts[NUMBERS])):
        sys.exit("tools/interface.toml: " + "\n  ".join(wrong) + "\nAdd new words, bits and codes behind the published ones, or raise version_major: then old hosts refuse the board.")
    for name, text in texts.items():
        path = ROOT / name
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
