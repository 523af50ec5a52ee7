"""Dialects: the rules of computation in which PLC tools differ, from the table `dialects.toml`.

The paths of the sources contain the dialect (`source.in_dialect`), because all commands pass a
program, its copies and its library as paths. For a path without a dialect the environment variable
decides; `--dialect` sets it.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

from structured_text.errors import InputError, near
from structured_text.output.toml_files import load_toml

__all__ = [
    "IEC",
    "MATIEC",
    "Dialect",
    "Row",
    "chosen",
    "dialect_of",
    "dialects",
    "rows",
    "rules_of",
    "using",
]

#: Name of the dialect of plain Structured Text.
IEC = "iec"
#: Name of the dialect of the tools that compile with matiec.
MATIEC = "openplc"
#: The file with the table of all differences.
TABLE = Path(__file__).with_name("dialects.toml")
#: The environment variable with the dialect of sources whose paths do not name a dialect.
VARIABLE = "RCX_DIALECT"


@dataclass(frozen=True)
class Row:
    """A row of the table of differences: the answer of some tools to a question.

    Attributes:
        rule: The name of the question.
        title: The question.
        tools: Names of dialects.
        value: The answer, as the code reads it.
        meaning: The answer in words.
        source: The document of the tool's maker that states it.
        also: Further facts about the question, which are true for all tools.
    """

    rule: str
    title: str
    tools: tuple[str, ...]
    value: str | int
    meaning: str
    source: str
    also: str


@dataclass(frozen=True)
class Dialect:
    """The rules of a tool. Each field is a rule of `dialects.toml`, which explains the values.

    Attributes:
        name: The dialect's name, as `--dialect` takes it.
        title: The tools that compute in this dialect.
        time_unit: The unit of a TIME or TOD as a number, `s` or `ms`.
        counters: What limits CV in CTU, CTD and CTUD: `preset`, `unsigned` or `type`.
        operands: Whether the right operand of AND and OR is evaluated if `needed`, or always
            (`both`).
        integers: The type of integer calculations: the operands' `own` type, or `dint`.
        text: Number of characters of a plain STRING.
        notation: `digits` or `short`, the form of a number that is converted to STRING.
        real_by_zero: Whether a REAL divided by 0 makes the program `stop`, or is `infinite`.
        root: The result of SQRT of a negative number: `stop`, `nan` or `absolute`.
        pace: When a program without a task runs beside tasks; `scan` is in every scan.
        start: The order of initialisation; `declared` is the order of declaration.
    """

    name: str
    title: str
    time_unit: str
    counters: str
    operands: str
    integers: str
    text: int
    notation: str
    real_by_zero: str
    root: str
    pace: str
    start: str

    def unit_ns(self, moment: str) -> int:
        """Return the unit [ns] in which a duration or date of this type is a number."""
        if moment.startswith("L"):
            return 1
        return 1_000_000 if self.time_unit == "ms" and moment in ("TIME", "TOD") else 1_000_000_000

    @property
    def is_standard(self) -> bool:
        """Return whether this dialect computes as the dialect of plain Structured Text does."""
        return self._is_like(IEC, "name", "title")

    @property
    def is_matiec(self) -> bool:
        """Return whether matiec follows this dialect, apart from matiec's known faults.

        The rule for counters is one of these faults (`engines/matiec/faults.toml`).
        """
        return self._is_like(MATIEC, "name", "title", "counters")

    def _is_like(self, other: str, *without: str) -> bool:
        mine, theirs = vars(self), vars(rules_of(other))
        return all(mine[field] == theirs[field] for field in mine if field not in without)


@lru_cache(maxsize=1)
def _table() -> dict[str, Any]:
    return load_toml(TABLE)


@lru_cache(maxsize=1)
def rows() -> tuple[Row, ...]:
    """Return all rows of the table, in its order."""
    rules = _table()["rules"]
    return tuple(
        Row(
            row["rule"],
            rules[row["rule"]]["title"],
            tuple(row["tools"]),
            row["value"],
            rules[row["rule"]][str(row["value"])],
            row["source"],
            rules[row["rule"]].get("also", ""),
        )
        for row in _table()["row"]
    )


def dialects() -> dict[str, str]:
    """Return the names of all dialects, each with its tools."""
    return dict(_table()["tools"])


@cache
def rules_of(name: str) -> Dialect:
    """Return the rules of a dialect, or raise InputError for an unknown name."""
    known = dialects()
    if name not in known:
        hint = near(name, list(known), "use")
        raise InputError(f"there is no dialect {name!r}", hint=hint)
    values: dict[str, Any] = {row.rule: row.value for row in rows() if name in row.tools}
    return Dialect(name, known[name], **values)


def chosen() -> str:
    """Return the dialect that the user has named for this process; empty if none.

    Raises:
        InputError: There is no such dialect.
    """
    name = os.environ.get(VARIABLE, "")
    return rules_of(name).name if name else ""


@contextmanager
def using(name: str | None) -> Iterator[None]:
    """Read all sources in this dialect, also in the processes that are started meanwhile.

    If the argument is None, nothing changes.

    Raises:
        InputError: There is no such dialect.
    """
    if name is None:
        yield
        return
    before = os.environ.get(VARIABLE)
    os.environ[VARIABLE] = rules_of(name).name
    try:
        yield
    finally:
        if before is None:
            del os.environ[VARIABLE]
        else:
            os.environ[VARIABLE] = before


def dialect_of(paths: Iterable[Path]) -> str:
    """Return the dialect of a program.

    It is the dialect of the first source with a dialect, else the chosen dialect, else the dialect
    of plain Structured Text.
    """
    said = (getattr(path, "dialect", "") for path in paths)
    return next(filter(None, said), "") or chosen() or IEC
