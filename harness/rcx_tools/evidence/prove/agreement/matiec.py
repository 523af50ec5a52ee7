"""The blocks and functions of the compared sources on matiec, for `comparing`.

The comparison sets and reads each variable that a program can access. The internal state of a
standard block cannot be set. The translation therefore begins with the initial state of the
standard block.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from datetime import timedelta
from typing import Any

from rcx_tools.evidence.prove.agreement.bench import Subject
from rcx_tools.evidence.prove.evaluate import REST
from structured_text.language import tree as t
from structured_text.language.types import (
    ArrayType,
    BlockType,
    ElementaryType,
    EnumType,
    StructType,
    Type,
)
from structured_text.language.values import nest
from structured_text.prove import values
from structured_text.prove.symbolic_memory import Path

__all__ = ["MatiecEngine"]

_US = timedelta(microseconds=1)
#: Largest number of microseconds in a TIME, which has 64 bits of nanoseconds.
_LONGEST = (1 << 63) // 1000 - 1


#: Shift counts are taken modulo 32, because shifts by 32 and more are undefined in C.
_SHIFTS = {"FC_RCXBITMASK": "DIGIT", "FC_RCXBYTEWITHBIT": "DIGIT"}


class MatiecEngine:
    """A block, or a function with its arguments and result, on matiec.

    Attributes:
        step: Resolution of the engine's clock [ns].
        checks: Whether the engine stops the program at a fault.
    """

    step = 1000
    checks = False

    def __init__(self, subject: Subject, pou: t.Pou, leaves: Sequence[tuple[Path, Type]]) -> None:
        assert subject.compiled is not None
        self._bench = subject.compiled
        self._number = subject.numbers[pou.name.upper()]
        self._kinds = [kind for _, kind in leaves]
        shifts = _SHIFTS.get(pou.name.upper())
        self._shifts = [path[-1] == shifts for path, _ in leaves]
        roots = {"B": (f"Main.B{self._number}", pou.block)}
        for symbol in pou.section("VAR_IN_OUT"):
            holder = subject.holders[symbol.type.name.upper()]
            roots[symbol.name.upper()] = (f"Main.{holder}", symbol.type)  # type: ignore[assignment]
        self._paths: list[str] = []
        for path, _ in leaves:
            if pou.kind == "FUNCTION":
                result = path[1] == pou.name.upper()
                at = f"R{self._number}" if result else f"A{self._number}_{path[1]}"
                self._paths.append(f"Main.{at}")
            elif str(path[-1]).islower():
                self._paths.append("")
            else:
                root, kind = roots[str(path[0])]
                assert kind is not None
                self._paths.append(_place(root, kind, path[1:]))
        self._open = [place for place, path in enumerate(self._paths) if path]
        self._reader = self._bench.program.reader([self._paths[place] for place in self._open])
        self._shows = [_shown(self._kinds[place]) for place in self._open]
        self._begin = [False if getattr(kind, "name", "") == "BOOL" else 0 for kind in self._kinds]
        self._held = list(self._begin)

    def read(self) -> list[Any]:
        """Return the values of scalars and arrays in the representation of `evaluate`."""
        found = list(self._held)
        for place, show, value in zip(self._open, self._shows, self._reader(), strict=True):
            found[place] = show(value)
        return found

    def write(self, place: int, value: Any) -> None:
        """Set a scalar or an array. If it cannot be set, do nothing."""
        if self._shifts[place]:
            value %= 32
        if self._paths[place]:
            self._bench.program.write(self._paths[place], _given(self._kinds[place], value))

    def reset(self) -> None:
        """Restore the initial state of the POU."""
        self._bench.program.restore(self._bench.start)
        self._bench.program.write("Main.Which", self._number)
        self._held = list(self._begin)

    def call(self, now: int) -> bool:
        """Call the POU. Always return True, because matiec does not stop at faults."""
        self._bench.program.scan(now // self.step)
        return True

    def follow(self, after: Sequence[Any]) -> None:
        """If a variable cannot be read from matiec, take its value from the translation."""
        self._held = list(after)


def _place(text: str, kind: Type, steps: Path) -> str:
    """Return the path of a scalar or an array in the syntax of `Program`."""
    for step in steps:
        if isinstance(kind, ArrayType):
            index, rest = [], int(step)
            for low, high in reversed(kind.bounds):
                rest, here = divmod(rest, high - low + 1)
                index.append(str(low + here))
            text, kind = f"{text}[{','.join(reversed(index))}]", kind.element
        else:
            assert isinstance(kind, (StructType, BlockType))
            parts = (
                dict(kind.fields)
                if isinstance(kind, StructType)
                else {one.name: one.type for one in kind.variables}
            )
            name = next(name for name in parts if name.upper() == step)
            text, kind = f"{text}.{name}", parts[name]
    return text


def _shown(kind: Type) -> Callable[[Any], Any]:
    """Return a function that converts a value of `Program` to the representation of `evaluate`."""
    if isinstance(kind, ArrayType):
        mask, flat = (1 << values.bits(kind.element)) - 1, len(kind.bounds) == 1
        assert flat, "an array of one dimension"
        return lambda found: {**{i: x & mask for i, x in enumerate(found)}, REST: 0}
    mask = (1 << values.bits(kind)) - 1
    if isinstance(kind, EnumType):
        return lambda found: (kind.members.index(found) if isinstance(found, str) else found) & mask
    name = kind.name if isinstance(kind, ElementaryType) else ""
    if name == "TIME":
        return lambda found: found // _US * 1000 & mask
    if name in ("REAL", "LREAL"):
        form, nan = ("<f", 0x7FC0_0000) if name == "REAL" else ("<d", 0x7FF8 << 48)
        return lambda found: (
            int.from_bytes(struct.pack(form, found), "little") if found == found else nan
        )
    if name in ("BOOL", "STRING"):
        return lambda found: found
    return lambda found: found & mask


def _given(kind: Type, value: Any) -> Any:
    """Convert a value to the type that `Program.write` takes.

    A TIME is truncated to microseconds.
    """
    if isinstance(kind, EnumType):
        return kind.members[value]
    if isinstance(kind, ArrayType):
        return nest(kind, value)
    if isinstance(kind, ElementaryType) and kind.name == "TIME":
        return min(max(value // 1000, -_LONGEST), _LONGEST) * _US
    return value
