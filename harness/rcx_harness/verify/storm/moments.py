"""The times of changes in a good run; many failures occur at these times."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from rcx_harness.cell import Cell
from rcx_harness.cell.stimulus import Entry
from rcx_harness.verify.storm.course import Course
from rcx_harness.verify.storm.storms import Failure
from structured_text.engines.base import Program
from structured_text.language.types import BlockType, ElementaryType, EnumType, StructType, Type

__all__ = ["Moments", "moments", "own_variables"]

#: Times of changes [us], relative to the beginning of the first storm and of any later storm.
Moments = tuple[tuple[int, ...], tuple[int, ...]]

_DISCRETE = frozenset(("BOOL", "SINT", "INT", "DINT", "USINT", "UINT", "UDINT", "BYTE", "WORD"))
#: If a variable changes in a greater share of the scans, it is ignored.
_OFTEN = 0.1
#: Longest time for which a good run is observed [us].
_LONGEST_US = 20_000_000


def moments(
    course: Course, start: Collection[Entry], length_us: int, library: Collection[str]
) -> Moments:
    """Return the times at which states and flags of the user's blocks change without any fault.

    `library` has the names of ignored types, in upper case.
    """
    course.wanted = ""
    length_us = min(length_us, _LONGEST_US)
    changes = _Changes(course.cell, library)
    try:
        course.begin()
        for entry in start:
            course.plan(entry)
        first = changes.over(length_us)
        if start:
            return first, ()
        course.come_to_rest()
        course.recover()
        return first, changes.over(length_us)
    except Failure:
        return (), ()


class _Changes:
    """The scans of a cell in which discrete variables change."""

    def __init__(self, cell: Cell, library: Collection[str]) -> None:
        self._cell = cell
        self._read = cell.program.reader(list(own_variables(cell.program, library)))

    def over(self, length_us: int) -> tuple[int, ...]:
        """Run for some time, and return the times of changes, relative to the beginning [us]."""
        cell, begin_us = self._cell, self._cell.now_us
        before = self._read()
        times: dict[int, list[int]] = {}
        scans = 0
        while cell.now_us < begin_us + length_us:
            cell.scan()
            scans += 1
            now = self._read()
            for place, (old, new) in enumerate(zip(before, now, strict=True)):
                if old != new:
                    times.setdefault(place, []).append(cell.now_us - begin_us)
            before = now
        few = (those for those in times.values() if len(those) <= max(2, _OFTEN * scans))
        return tuple(sorted({t_us for those in few for t_us in those}))


def own_variables(program: Program, library: Collection[str]) -> Iterator[str]:
    """Yield the discrete variables of the user's own blocks."""
    inside: list[str] = []
    for path, kind in program.walk():
        if any(path.startswith(one) for one in inside[-1:]):
            continue
        if isinstance(kind, (BlockType, StructType)) and kind.name.upper() in library:
            inside.append(f"{path}.")
        elif _is_discrete(kind):
            yield path


def _is_discrete(kind: Type) -> bool:
    if isinstance(kind, EnumType):
        return True
    return isinstance(kind, ElementaryType) and kind.name in _DISCRETE
