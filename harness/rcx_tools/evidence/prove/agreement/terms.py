"""A call of a block or function as terms of the solver, evaluated for given values.

Functions with long loops (`SUMMARIES`) are uninterpreted symbols in the terms of a block. The
function on the engine gives their values.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import z3

from rcx_tools.evidence.prove.agreement.bench import Subject
from rcx_tools.evidence.prove.agreement.builtin import double, shown, single
from rcx_tools.evidence.prove.evaluate import REST, program
from rcx_tools.evidence.prove.summaries import SUMMARIES
from structured_text.language.types import ArrayType, ElementaryType, Type
from structured_text.language.values import array_length
from structured_text.prove import reals, texts, values
from structured_text.prove.machine import Machine
from structured_text.prove.symbolic_memory import Path

__all__ = ["LREAL", "Translation", "bodies", "held", "long", "symbols"]

#: Kinds of faults that stop the program on an engine. Other faults give different results on the
#: engines: a conversion out of range, or a TIME of more than 64 bits.
_OPEN = ("conversion", "time")


class Translation:
    """The terms of a POU after one call, compiled to Python.

    Args:
        machine: The machine with its memory after the call.
        leaves: The scalars and arrays that are compared.
        start: Memory before the call if it was arbitrary. None if the state was known.
        functions: Python functions that evaluate the functions with long loops.
    """

    def __init__(
        self,
        machine: Machine,
        leaves: Sequence[tuple[Path, Type]],
        start: Mapping[Path, Any] | None,
        functions: Mapping[str, Callable[[int], int]],
    ) -> None:
        terms: list[Any] = []
        self._slots: list[tuple[int, int, int, Type]] = []
        for place, (path, kind) in enumerate(leaves):
            value = machine[path]
            if start is not None and value is start.get(path):
                continue
            parts = _parts(kind, value)
            self._slots.append((place, len(terms), len(parts), kind))
            terms += parts
        self._end = len(terms)
        strict = [one.when for one in machine.obligations if one.kind not in _OPEN]
        loose = [one.when for one in machine.obligations if one.kind in _OPEN]
        self._strict = len(strict)
        self._program = program([*terms, *strict, *loose], functions)
        self._given = _given(self._program.inputs, leaves, start) if start is not None else None

    def run(self, before: list[Any], now: int) -> tuple[list[Any], bool, bool]:
        """Evaluate a call.

        Return the variables, and whether it stops the program or has an open result.
        """
        given = self._given(before, now) if self._given is not None else ()
        found = self._program.run(given)
        after = list(before)
        for place, at, count, kind in self._slots:
            after[place] = _joined(kind, found[at : at + count])
        bad = self._end + self._strict
        return after, any(found[self._end : bad]), any(found[bad:])


def _parts(kind: Type, value: Any) -> list[Any]:
    if isinstance(value, texts.Text):
        return [value.size, *(value.char(place) for place in range(value.most))]
    if isinstance(value, reals.Real):
        if value.known:
            return [double(value.value) if kind == LREAL else single(value.value)]
        return [z3.fpToIEEEBV(value.value) if kind == LREAL else value.value]
    if isinstance(value, int) and not isinstance(value, bool):
        return [value & (1 << values.bits(kind)) - 1]
    return [value]


_REAL, LREAL = ElementaryType("REAL"), ElementaryType("LREAL")


def _joined(kind: Type, parts: Sequence[Any]) -> Any:
    name = kind.name if isinstance(kind, ElementaryType) else ""
    if name == "STRING":
        return "".join(chr(code) for code in parts[1 : 1 + parts[0]])
    (value,) = parts
    if isinstance(kind, ArrayType) and len(value) <= array_length(kind):
        places = range(array_length(kind))
        return {place: value.get(place, value[REST]) for place in places} | {REST: 0}
    if name == "REAL" and value & 0x7FFF_FFFF > 0x7F80_0000:
        return 0x7FC0_0000
    return value


def _given(
    inputs: Sequence[str], leaves: Sequence[tuple[Path, Type]], start: Mapping[Path, Any]
) -> Callable[[list[Any], int], tuple[Any, ...]]:
    """Return a function that computes the solver's variables from those of the POU."""
    codes = {"now": "now"}
    for place, (path, kind) in enumerate(leaves):
        value = start.get(path)
        if isinstance(value, texts.Text):
            codes[str(value.size)] = f"len(b[{place}])"
            for at in range(value.most):
                letter = f"b[{place}][{at}:{at + 1}]"
                codes[str(value.char(at))] = f"ord({letter} or chr(0))"
        elif isinstance(value, reals.Real):
            code = f"b[{place}]"
            codes[str(value.value)] = f"double_of({code})" if kind == LREAL else code
        elif value is not None:
            codes[str(value)] = f"b[{place}]"
    wanted = "".join(f"{codes[name]}, " for name in inputs)
    scope = {"double_of": lambda raw: struct.unpack("<d", raw.to_bytes(8, "little"))[0]}
    found: Callable[[list[Any], int], tuple[Any, ...]] = eval(f"lambda b, now: ({wanted})", scope)
    return found


# --- functions with long loops: uninterpreted symbols, whose values come from the engine ---


def long(subject: Subject) -> list[str]:
    """Return the functions of the project that have a summary, without the blocks."""
    pous = subject.project.pous
    return [name for name in SUMMARIES if name in pous and pous[name].kind == "FUNCTION"]


def _argument(subject: Subject, name: str) -> tuple[Type, Type]:
    """Return the type of a function's only argument, and the type of its result."""
    pou = subject.project.pous[name]
    (symbol,) = pou.section("VAR_INPUT")
    assert pou.result is not None
    return symbol.type, pou.result.type


def symbols(subject: Subject) -> dict[str, Callable[[Machine, list[Any]], Any]]:
    """Return for each function with long loops a summary that returns a symbol of the solver."""
    return {name: _symbol(subject, name) for name in long(subject)}


def _symbol(subject: Subject, name: str) -> Callable[[Machine, list[Any]], Any]:
    source, target = _argument(subject, name)
    sort = z3.BitVecSort(_width(source))

    def summary(machine: Machine, arguments: list[Any]) -> Any:
        function = z3.Function(name, sort, z3.BitVecSort(_width(target)))
        (raw,) = _parts(source, arguments[0])
        term = function(z3.BitVecVal(raw, sort) if isinstance(raw, int) else raw)
        return reals.Real(term) if target == _REAL else term

    return summary


def bodies(subject: Subject) -> dict[str, Callable[[int], int]]:
    """Return by name the functions of the engine that compute the values of the symbols."""
    return {name: _body(subject, name) for name in long(subject)}


def _body(subject: Subject, name: str) -> Callable[[int], int]:
    source, target = _argument(subject, name)
    body = subject.module.names[f"f_{name}"]
    show: Callable[[Any], int] = eval(f"lambda value: {shown('value', target)}", dict(_SHOWN))
    return lambda raw: show(body(held(source, raw)))


_SHOWN = {"single": single, "double": double, "REST": REST}


def _width(kind: Type) -> int:
    return 32 if kind == _REAL else values.bits(kind)


def held(kind: Type, raw: int) -> Any:
    """Convert a bit pattern of the solver to a value of the engine."""
    if kind == _REAL:
        return struct.unpack("<f", raw.to_bytes(4, "little"))[0]
    width = values.bits(kind)
    signed = getattr(kind, "name", "") in ("TIME", "LTIME", "SINT", "INT", "DINT", "LINT")
    return raw - (1 << width) if signed and raw >> width - 1 else raw
