"""The blocks and functions of the compared sources on the built-in engine, for `comparing`."""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from types import SimpleNamespace
from typing import Any

from rcx_tools.evidence.prove.agreement.bench import Subject
from rcx_tools.evidence.prove.evaluate import REST
from structured_text.engines.builtin.runtime import ProgramError
from structured_text.engines.builtin.storage import is_scalar
from structured_text.language import tree as t
from structured_text.language.types import ArrayType, ElementaryType, Type
from structured_text.prove import values
from structured_text.prove.symbolic_memory import Path

__all__ = ["BuiltinEngine", "double", "shown", "single"]


class BuiltinEngine:
    """A block, or a function with its arguments and result, on the built-in engine.

    Attributes:
        step: Resolution of the engine's clock [ns].
        checks: Whether the engine stops the program at a fault.
    """

    step = 1
    checks = True

    def __init__(self, subject: Subject, pou: t.Pou, leaves: Sequence[tuple[Path, Type]]) -> None:
        names = subject.module.names
        bench_globals = names["b_globals"]()
        self._globals = bench_globals
        self._body = names[f"f_{pou.name.upper()}"]
        self._leaves = leaves
        self._function = pou.kind == "FUNCTION"
        roots: dict[str, Any] = {}
        if self._function:
            roots["B"] = {}
            self._inputs = [symbol.name.upper() for symbol in pou.section("VAR_INPUT")]
            self._result = pou.name.upper()
        else:
            roots["B"] = names[f"b_{pou.name.upper()}"](bench_globals)
            bench = names["b_AGREEMENT_BENCH"](bench_globals)
            roots["SCALARS"] = SimpleNamespace()
            for symbol in pou.section("VAR_IN_OUT"):
                holder = subject.holders[symbol.type.name.upper()]
                home = roots["SCALARS"].__dict__ if is_scalar(symbol.type) else roots
                home[symbol.name.upper()] = getattr(bench, holder)
            self._in_outs = [symbol.name.upper() for symbol in pou.section("VAR_IN_OUT")]
        self._roots = roots
        codes = [self._place(path, kind) for path, kind in leaves]
        scope: dict[str, Any] = {
            **roots,
            "REST": REST,
            "single": single,
            "double": double,
        }
        values_of = [shown(code, kind) for code, (_, kind) in zip(codes, leaves, strict=True)]
        self.read: Callable[[], list[Any]] = eval(f"lambda: [{', '.join(values_of)}]", scope)
        self._write: list[Callable[[Any], None]] = []
        for code, (_, kind) in zip(codes, leaves, strict=True):
            slot = f"{code}[:]" if isinstance(kind, ArrayType) else code
            self._write.append(_setter(slot, scope))
        self._initial = [] if self._function else [eval(_kept(code), scope) for code in codes]

    def _place(self, path: Path, kind: Type) -> str:
        """Return the Python expression for a scalar or an array in the engine's memory."""
        if self._function:
            return f"B[{path[1]!r}]"
        if len(path) == 1 and is_scalar(kind):
            return f"SCALARS.{path[0]}"
        return str(path[0]) + "".join(
            f"[{step}]" if isinstance(step, int) else f".{step}" for step in path[1:]
        )

    def write(self, place: int, value: Any) -> None:
        """Set a scalar or an array."""
        self._write[place](value)

    def reset(self) -> None:
        """Restore the initial state of the POU."""
        for place, value in enumerate(self._initial):
            self._write[place](value)

    def call(self, now: int) -> bool:
        """Call the POU. Return False if a fault has stopped it."""
        self._globals.now = now
        try:
            if self._function:
                held = self._roots["B"]
                held[self._result] = self._body(*[held[name] for name in self._inputs])
            else:
                self._call_block()
        except (ArithmeticError, ValueError, ProgramError):
            return False
        return True

    def _call_block(self) -> None:
        """Call the block. Scalar VAR_IN_OUTs are passed by value and written back afterwards."""
        scalars = self._roots["SCALARS"].__dict__
        in_outs = [scalars.get(name, self._roots.get(name)) for name in self._in_outs]
        back = self._body(self._roots["B"], *in_outs)
        scalars.update(zip(scalars, back if len(scalars) > 1 else (back,), strict=False))

    def follow(self, after: Sequence[Any]) -> None:
        """Do nothing, because every variable can be read from this engine."""


def _setter(slot: str, scope: dict[str, Any]) -> Callable[[Any], None]:
    names = dict(scope)
    exec(f"def write(value): {slot} = value", names)
    found: Callable[[Any], None] = names["write"]
    return found


def _kept(code: str) -> str:
    return f"{code}[:] if isinstance({code}, list) else {code}"


def shown(code: str, kind: Type) -> str:
    """Return Python code that converts an expression of the engine to the form of `evaluate`."""
    if isinstance(kind, ArrayType):
        mask = (1 << values.bits(kind.element)) - 1
        return f"{{**{{i: x & {mask} for i, x in enumerate({code})}}, REST: 0}}"
    name = kind.name if isinstance(kind, ElementaryType) else ""
    if name == "REAL":
        return f"single({code})"
    if name == "LREAL":
        return f"double({code})"
    if name == "STRING":
        return code
    width = values.bits(kind)
    return f"{code} & {(1 << width) - 1}" if width else f"bool({code})"


def single(value: float) -> Any:
    """Return the bit pattern of a REAL, or the number itself if no REAL represents it."""
    if value != value:
        return 0x7FC0_0000
    try:
        raw = struct.pack("<f", value)
    except OverflowError:
        return value
    return int.from_bytes(raw, "little") if struct.unpack("<f", raw)[0] == value else value


def double(value: float) -> int:
    """Return the bit pattern of an LREAL."""
    return 0x7FF8 << 48 if value != value else int.from_bytes(struct.pack("<d", value), "little")
