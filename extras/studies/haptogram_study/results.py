# SPDX-License-Identifier: Apache-2.0
"""Results are JSON lines, one a trial. A line is on the disk before the next trial begins. Nothing that was written is ever overwritten: an
unfinished line, which a kill can leave, is moved to a file beside, and said."""
import contextlib
import fcntl
import json
import os
import stat
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from haptogram.errors import bad_input
from .session import FORMAT, Record

LONGEST_LINE = 1_000_000  # bytes
LARGEST_FILE = 500_000_000


def _no_constants(text: str) -> float:
    raise ValueError(f"{text} is no JSON")


def parse(content: bytes, where: str) -> list[tuple[str, Record]]:
    """The records of complete lines, each with `where` it stands."""
    found = []
    for number, line in enumerate(content.split(b"\n")[:-1], 1):
        place = f"{where}:{number}"
        if len(line) > LONGEST_LINE:
            raise bad_input(place, f"has {len(line)} bytes, expected at most {LONGEST_LINE}; is this a file of results?")
        try:
            record: Any = json.loads(line, parse_constant=_no_constants)
        except (ValueError, RecursionError) as error:
            raise bad_input(place, f"found {line[:40]!r}, expected a line of JSON ({str(error)[:60]}); the file is garbled") from error
        if not isinstance(record, dict) or record.get("format") != FORMAT:
            found_format = record.get("format") if isinstance(record, dict) else record
            raise bad_input(place, f"found {str(found_format)[:40]!r}, expected a record of format {FORMAT!r}; is this a file of results?")
        found.append((place, record))
    return found


def _content(file: int, path: Path) -> bytes:
    about = os.fstat(file)
    if not stat.S_ISREG(about.st_mode):
        raise bad_input(str(path), "is no ordinary file; results need one; choose another name")
    if about.st_size > LARGEST_FILE:
        raise bad_input(str(path), f"has {about.st_size} bytes, expected at most {LARGEST_FILE}; is this a file of results?")
    os.lseek(file, 0, os.SEEK_SET)
    parts = []
    while block := os.read(file, 1 << 20):
        parts.append(block)
    return b"".join(parts)


def read(path: Path) -> list[tuple[str, Record]]:
    """The records of a file; one that ends in the middle of a line is refused."""
    try:
        content = path.read_bytes() if path.is_file() else None
    except OSError as error:
        raise bad_input(str(path), f"cannot be read: {error.strerror}; check the path") from error
    if content is None:
        raise bad_input(str(path), "there is no such file; check the path")
    if not content:
        raise bad_input(str(path), "is empty; run the protocol into it first")
    if not content.endswith(b"\n"):
        raise bad_input(str(path), "its last line is not complete; let `run` go on with it")
    return parse(content, str(path))


class ResultsFile:
    """Appends records to a file, one program at a time. `before` are those that it had."""

    def __init__(self, path: Path) -> None:
        self.path, self.moved = path, ""
        try:
            self._file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC | os.O_NONBLOCK, 0o644)
        except OSError as error:
            raise bad_input(str(path), f"cannot be opened: {error.strerror}; choose another name or place") from error
        try:
            try:
                fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError as error:
                raise bad_input(str(path), "another program is writing to it; wait for its end, or name another file") from error
            content = _content(self._file, path)
            whole = content[: content.rfind(b"\n") + 1]
            self.before = parse(whole, str(path))
            if rest := content[len(whole) :]:
                self._move(rest, len(whole))
            self._sync_folder()
        except BaseException:
            os.close(self._file)
            raise

    def _move(self, rest: bytes, end: int) -> None:
        """Keeps an unfinished line in a file beside, before it is cut off here."""
        for number in range(1, 1000):
            beside = self.path.with_name(f"{self.path.name}.unfinished-{number}")
            with contextlib.suppress(FileExistsError), beside.open("xb") as file:
                file.write(rest)
                file.flush()
                os.fsync(file.fileno())
                os.ftruncate(self._file, end)
                os.fsync(self._file)
                self.moved = str(beside)
                return
        raise bad_input(str(self.path), "there are 999 files of unfinished lines beside it; look at them and remove them")

    def _sync_folder(self) -> None:
        folder = os.open(self.path.resolve().parent, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)

    def append(self, record: Record) -> None:
        """On the disk when it returns."""
        line = json.dumps(record, ensure_ascii=False, allow_nan=False).encode() + b"\n"
        try:
            while line:
                line = line[os.write(self._file, line) :]
            os.fsync(self._file)
        except OSError as error:
            raise bad_input(str(self.path), f"cannot be written: {error.strerror}; make room and run again, it goes on from here") from error

    def require_same(self, **expected: object) -> None:
        """Raises HaptogramError when a record is not of this session."""
        for where, record in self.before:
            for key, value in expected.items():
                if record.get(key) != value:
                    raise bad_input(where, f"its {key} is {str(record.get(key))[:80]!r}, not {str(value)[:80]!r}; name another file for this session")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        os.close(self._file)
