# SPDX-License-Identifier: Apache-2.0
"""Intel HEX text and the regions of memory in it; and files, written beside and renamed, so that none is ever half there."""
import io
import os
import sys
from pathlib import Path

from intelhex import IntelHex, IntelHexError

from .errors import bad_input

END = b":00000001FF"


def parse(content: bytes, where: str) -> dict[int, bytes]:
    """Contiguous data by their first address. Stricter than intelhex about what else is in the file."""
    lines = content.upper().split()
    if END not in lines:
        raise bad_input(where, f"no end record ({END.decode()}) found; the file is cut short, or no Intel HEX file")
    if lines.index(END) != len(lines) - 1:
        raise bad_input(where, "there is text after the end record; two files may have been joined")
    file = IntelHex()
    try:
        file.loadhex(io.StringIO(content.decode("ascii")))
    except IntelHexError as error:
        line = getattr(error, "line", None)
        raise bad_input(f"{where}:{line}" if line else where, f"{error}; the file is garbled") from error
    except UnicodeDecodeError as error:
        raise bad_input(where, f"byte {error.start} is no ASCII; is this an Intel HEX file?") from error
    if file.start_addr:
        raise bad_input(where, "a start address has no meaning for an image; was this file made for a processor?")
    return {start: bytes(file.tobinstr(start=start, end=end - 1)) for start, end in file.segments()}


def format(regions: dict[int, bytes]) -> str:
    file, text = IntelHex(), io.StringIO()
    for address, data in regions.items():
        file.puts(address, data)
    file.write_hex_file(text)
    return text.getvalue()


def read_file(path: str) -> bytes:
    """`-` is standard input."""
    try:
        return sys.stdin.buffer.read() if path == "-" else Path(path).read_bytes()
    except OSError as error:
        raise bad_input(path, f"cannot be read: {error.strerror}; check the path") from error


def write_file(path: str, text: str) -> None:
    """`-` is standard output; so is what is there and no regular file written as it is."""
    if path == "-":
        sys.stdout.write(text)
        return
    target = Path(path).resolve()  # keeps a symbolic link
    beside = target.with_name(f"{target.name}.{os.getpid()}")
    try:
        if target.exists() and not target.is_file():
            target.write_text(text)
            return
        try:
            with beside.open("x") as file:
                file.write(text)
                file.flush()
                os.fsync(file.fileno())
            if target.exists():
                beside.chmod(target.stat().st_mode & 0o7777)
            beside.rename(target)
        finally:
            beside.unlink(missing_ok=True)
    except OSError as error:
        raise bad_input(path, f"cannot be written: {error.strerror}; choose another place or make room, nothing was left behind") from error
