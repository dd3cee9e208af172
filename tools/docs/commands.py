# SPDX-License-Identifier: Apache-2.0
"""The page of all commands and options, from the manual page that the program prints."""
import html
import re
import subprocess

HEAD = """# Commands

Every command and option, as the program prints them (`haptogram completion man`).

"""
PLAIN = {r"\fB": "", r"\fI": "", r"\fR": "", r"\-": "-", r"\&": "", r"\e": "\\"}


def plain(line: str) -> str:
    return re.sub(r"\\(f[BIR]|[-&e])", lambda found: PLAIN[found[0]], line)


def shown(text: str) -> str:
    """As text of a page, in which nothing is markup."""
    return re.sub(r"([\\`*_\[\]|])", r"\\\1", html.escape(text, quote=False))


def row(names: str, about: str) -> str:
    return f"| `{plain(names)}` | {shown(plain(about))} |\n" if "help" not in names else ""


def commands_page(manual: str) -> str:
    """Markdown: a heading a command, a row of a table an option; all have --help, which says itself."""
    lines, page, inside = iter(manual.partition(".SH COMMANDS\n")[2].splitlines()), HEAD, False
    for line in lines:
        if line == ".TP":
            text = row(next(lines), next(lines))
            page += "| option | what it does |\n|---|---|\n" * (bool(text) and not inside) + text
            inside = inside or bool(text)
            continue
        page, inside = page + "\n" * inside, False
        if line.startswith(".SS "):
            page += f"## {plain(line[4:]).partition(' [')[0]}\n\n`{plain(line[4:])}`\n\n{shown(plain(next(lines)))}.\n\n"
        elif line.startswith(".SH "):
            page += f"## {line[4:].capitalize()}\n\n"
        else:
            page += f"{shown(plain(line))}\n\n"
    return page


def write(program: str) -> str:
    return commands_page(subprocess.run([program, "completion", "man"], check=True, capture_output=True, text=True).stdout)
