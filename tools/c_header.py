# SPDX-License-Identifier: Apache-2.0
"""Reads host/c/haptogram.h, which is plain enough for a few patterns, and writes from it what C# and Python need to call the library.

`tools/c_header.py` writes both files; with --check it only says whether they are fresh."""
import re
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
HEADER = ROOT / "host/c/haptogram.h"
CSHARP = ROOT / "extras/unity/Runtime/Native.cs"
PYTHON = ROOT / "python/haptogram/native.py"
NUMBERS = {"uint8_t": "byte", "int32_t": "int", "uint32_t": "uint", "uint16_t": "ushort", "uint64_t": "ulong", "double": "double", "size_t": "UIntPtr"}


KEYWORDS = {"event"}  # of C#
# The runtime keeps a SafeHandle's pointer alive during a call, and refuses one that was disposed of. What releases it has the bare pointer.
HANDLES = {"haptogram_board": "Board", "haptogram_image": "Image"}
RELEASES = {"haptogram_close", "haptogram_free_image"}


@dataclass
class Parameter:
    type: str  # without const
    stars: int
    name: str
    const: bool


@dataclass
class Header:
    abi: int
    codes: dict  # name: value, of all enums
    enums: dict  # name: [names of its values]
    structs: dict  # name: [Parameter]
    functions: dict  # name: (Parameter of what it returns, [Parameter])


def parameter(text):
    found = re.fullmatch(r"(const )?(\w+)\s*(\**)\s*(\w*)", text.strip())
    if not found:
        raise ValueError(f"{HEADER.name}: cannot read '{text}'")
    return Parameter(found[2], len(found[3]), found[4], bool(found[1]))


def fields(text):
    for line in filter(None, (part.strip() for part in text.split(";"))):
        first, *more = line.split(",")
        head = parameter(first)
        yield head
        yield from (Parameter(head.type, head.stars, name.strip(), head.const) for name in more)


def read(path=HEADER):
    text = re.sub(r"/\*.*?\*/", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
    codes = {name: int(value) for name, value in re.findall(r"(HAPTOGRAM_\w+) = (\d+)", text)}
    enums = {name: re.findall(r"HAPTOGRAM_\w+", body) for body, name in re.findall(r"typedef enum \w+ \{(.*?)\} (\w+);", text, re.DOTALL)}
    structs = {name: list(fields(body)) for body, name in re.findall(r"typedef struct \w+ \{(.*?)\} (\w+);", text, re.DOTALL)}
    functions = {}
    for returns, name, arguments in re.findall(r"HAPTOGRAM_API ([\w ]+\**)\s*(haptogram_\w+)\((.*?)\);", text, re.DOTALL):
        given = [] if arguments == "void" else [parameter(re.sub(r"\s+", " ", one)) for one in arguments.split(",")]
        functions[name] = (parameter(returns), given)
    return Header(int(re.search(r"#define HAPTOGRAM_ABI (\d+)", text)[1]), codes, enums, structs, functions)


def camel(name):
    return "".join(word.capitalize() for word in name.removeprefix("haptogram_").split("_"))


def csharp_type(p, structs, in_struct=False):
    if p.stars == 0:
        return NUMBERS.get(p.type) or ("Code" if p.type == "haptogram_code" else "Native" + camel(p.type))
    if p.stars == 2:
        return "out IntPtr"
    if not in_struct and p.type in structs and structs[p.type][0].name == "size":  # the others come in rows
        return f"ref Native{camel(p.type)}"
    if not in_struct and p.type in NUMBERS and (p.const or p.type != "double"):  # doubles that are written may be NULL
        return f"ref {NUMBERS[p.type]}"
    return "IntPtr"


def called_by_csharp(header):
    """The functions that the sources beside the written file call, and the structs that those take."""
    said = set(re.findall(r"\bhaptogram_\w+", "".join(file.read_text(encoding="utf-8") for file in CSHARP.parent.glob("*.cs") if file != CSHARP)))
    functions = {name: function for name, function in header.functions.items() if name in said}
    taken = {p.type for _, given in functions.values() for p in given}
    taken |= {p.type for name in taken & set(header.structs) for p in header.structs[name]}
    return functions, {name: members for name, members in header.structs.items() if name in taken}


def csharp(header):
    functions, structs = called_by_csharp(header)
    lines = ["// SPDX-License-Identifier: Apache-2.0", "// Written by tools/c_header.py from host/c/haptogram.h.", "using System;",
             "using System.Runtime.InteropServices;", "", "namespace Haptogram", "{"]
    for name, values in header.enums.items():
        first = "HAPTOGRAM_" if name == "haptogram_code" else name.upper() + "_"
        lines += [f"    public enum {camel(name)}", "    {"]
        lines += [f"        {camel(value.removeprefix(first).lower())} = {header.codes[value]}," for value in values]
        lines += ["    }", ""]
    for name, members in structs.items():
        lines += ["    [StructLayout(LayoutKind.Sequential)]", f"    internal struct Native{camel(name)}", "    {"]
        lines += [f"        public {csharp_type(p, header.structs, True)} {'@' * (p.name in KEYWORDS)}{p.name};" for p in members]
        lines += ["    }", ""]
    lines += ["    internal static class Native", "    {", f"        internal const int Abi = {header.abi};", '        private const string Library = "haptogram";']
    for name, (returns, given) in functions.items():
        def taken(p, releases=name in RELEASES):
            return HANDLES[p.type] if p.type in HANDLES and p.stars == 1 and not releases else csharp_type(p, header.structs)

        kind = "void" if returns.type == "void" and not returns.stars else csharp_type(returns, header.structs)
        lines += ["", "        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]",
                  f"        internal static extern {kind} {name}({', '.join(f'{taken(p)} {p.name}' for p in given)});"]
    return "\n".join([*lines, "    }", "}", ""])


def python_type(p, structs):
    number = p.type if p.type == "size_t" else p.type.removesuffix("_t")
    if p.stars == 0:
        return {"haptogram_code": "c_int", "void": "None"}.get(p.type) or f"c_{number}"
    if p.stars == 2:
        return "POINTER(c_void_p)"
    if p.type == "char" and p.const:
        return "c_char_p"
    if p.type in structs:
        return f"POINTER({camel(p.type)})"
    return f"POINTER(c_{number})" if p.type in NUMBERS else "c_void_p"


def python(header):
    lines = ["# SPDX-License-Identifier: Apache-2.0", "# fmt: off", '"""Written by tools/c_header.py from host/c/haptogram.h: its structs, and the types of its functions."""',
             "from ctypes import POINTER, Structure, c_char_p, c_double, c_int, c_int32, c_size_t, c_uint8, c_uint16, c_uint32, c_uint64, c_void_p",
             "from typing import Any", "", f"ABI = {header.abi}"]
    for name, members in header.structs.items():
        typed = (f'("{p.name}", {python_type(p, header.structs)})' for p in members)
        lines += ["", "", f"class {camel(name)}(Structure):", f"    _fields_ = [{', '.join(typed)}]"]
    lines += ["", "", "# What each returns, and what it is given.", "FUNCTIONS: dict[str, tuple[Any, list[Any]]] = {"]
    for name, (returns, given) in header.functions.items():
        lines.append(f'    "{name}": ({python_type(returns, header.structs)}, [{", ".join(python_type(p, header.structs) for p in given)}]),')
    return "\n".join([*lines, "}", ""])


def main():
    header, stale = read(), 0
    for path, fresh in ((CSHARP, csharp(header)), (PYTHON, python(header))):
        if "--check" not in sys.argv[1:]:
            path.write_text(fresh, encoding="utf-8")
        elif not path.is_file() or path.read_text(encoding="utf-8") != fresh:
            print(f"{path.relative_to(ROOT)} is not what tools/c_header.py writes; run it")
            stale = 1
    return stale


if __name__ == "__main__":
    sys.exit(main())
