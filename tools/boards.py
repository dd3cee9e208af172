# SPDX-License-Identifier: Apache-2.0
"""The board files of constraints/, for scripts."""
import tomllib
from pathlib import Path

BOARDS = Path(__file__).resolve().parent.parent / "constraints"


class Unknown(Exception):
    """There is no board of this name, or it is like itself."""


def names():
    return sorted(p.stem for p in BOARDS.glob("*.toml"))


def own(name):
    """A board's file, without what it has from the board that it is like."""
    path = BOARDS / f"{name}.toml"
    if not path.exists():
        raise Unknown(f"no board {name}; there are {', '.join(names())}")
    return tomllib.loads(path.read_text(encoding="utf-8"))


def load(name):
    """A board's file, with what it has from the board that it is like, and that one from its own. `haptogram board list` checks files; this
    does not, but for boards that are like themselves."""
    chain, said = [name], own(name)
    while (like := said.pop("like", None)) is not None:
        if like in chain:
            raise Unknown(f"board {name} is like itself: {', like '.join([*chain, like])}")
        chain.append(like)
        said = own(like) | said
    return said
