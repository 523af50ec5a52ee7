"""The sources that are compared, and a PROGRAM that calls each of their POUs on an engine."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path as File
from typing import Any, Protocol

from structured_text.engines.base import Program
from structured_text.engines.builtin.module import Module
from structured_text.engines.matiec.build import MISSING, find_matiec
from structured_text.engines.matiec.program import MatiecProgram
from structured_text.engines.native.toolchain import find_c_compiler
from structured_text.language import tree as t
from structured_text.language.load import checked
from structured_text.language.project import Project
from structured_text.language.types import ArrayType, Type
from structured_text.prove.symbolic_memory import Path

__all__ = ["Compiled", "Engine", "Subject", "missing"]

_BENCH = """\
PROGRAM AGREEMENT_BENCH
VAR
{}
END_VAR
CASE Which OF
{}
END_CASE;
END_PROGRAM
"""


def missing() -> str:
    """Return the reason why matiec cannot be used. Empty if it can be used.

    Raises:
        InputError: `RCX_MATIEC` or an `iec2c` on `PATH` does not lead to a complete matiec.
    """
    if find_matiec() is None:
        return MISSING
    return "" if find_c_compiler() else "matiec found, but no C compiler: set CC or PATH"


class Engine(Protocol):
    """A POU on an engine, for comparison with the translation.

    Attributes:
        step: Resolution of the engine's clock [ns].
        checks: Whether the engine stops the program at a fault, such as a division by zero.
    """

    step: int
    checks: bool

    def __init__(
        self, subject: Subject, pou: t.Pou, leaves: Sequence[tuple[Path, Type]]
    ) -> None: ...

    def read(self) -> list[Any]:
        """Return the values of scalars and arrays in the representation of `evaluate`."""

    def write(self, place: int, value: Any) -> None:
        """Set a scalar or an array. If it cannot be set, do nothing."""

    def reset(self) -> None:
        """Restore the initial state of the POU."""

    def call(self, now: int) -> bool:
        """Call the POU. Return False if a fault has stopped it."""

    def follow(self, after: Sequence[Any]) -> None:
        """If a variable cannot be read from the engine, take its value from `after`.

        `after` has the values that the translation has computed.
        """


@dataclass(frozen=True)
class Compiled:
    """The PROGRAM compiled by matiec, and a snapshot of its initial state."""

    program: Program
    start: object


@dataclass(frozen=True)
class Subject:
    """Sources to compare, with a PROGRAM that calls one block or function in each scan.

    Attributes:
        project: The sources that are translated.
        module: The same sources, compiled by the built-in engine.
        numbers: Value of `Which` that selects a POU, by name of the POU in upper case. The values
            start at 1.
        holders: Variable of the PROGRAM that is passed to a VAR_IN_OUT, by name of the type.
        compiled: The same sources compiled by matiec, if this was requested.
    """

    project: Project
    module: Module
    numbers: Mapping[str, int]
    holders: Mapping[str, str]
    compiled: Compiled | None = None

    @classmethod
    def of(cls, files: Sequence[File], *, matiec: bool = False) -> Subject:
        """Build the subject from source files. With `matiec`, `missing` must have returned ""."""
        pous = list(checked(files).pous.values())
        numbers = {pou.name.upper(): number for number, pou in enumerate(pous, 1)}
        kinds = {s.type.name.upper() for pou in pous for s in pou.section("VAR_IN_OUT")}
        holders = {kind: f"V{number}" for number, kind in enumerate(sorted(kinds))}
        declared = ["Which : INT;", *(f"{name} : {kind};" for kind, name in holders.items())]
        calls = []
        for pou in pous:
            number = numbers[pou.name.upper()]
            declared += _declared(pou, number)
            calls.append(f"{number}: {_call(pou, number, holders)}")
        compiled = None
        with tempfile.TemporaryDirectory() as folder:
            bench = File(folder) / "bench.st"
            bench.write_text(_BENCH.format("\n".join(declared), "\n".join(calls)))
            project = checked([*files, bench])
            if matiec:
                compiler, c_compiler = find_matiec(), find_c_compiler()
                assert compiler is not None
                assert c_compiler is not None
                program = MatiecProgram.build(project, compiler, c_compiler)
                compiled = Compiled(program, program.snapshot())
        return cls(project, Module(project), numbers, holders, compiled)


def _declared(pou: t.Pou, number: int) -> Iterator[str]:
    """Yield the declarations for a POU: a block instance, or arguments and result of a function."""
    if pou.kind != "FUNCTION":
        yield f"B{number} : {pou.name};"
        return
    assert pou.result is not None
    for symbol in pou.section("VAR_INPUT"):
        yield f"A{number}_{symbol.name} : {_name(symbol.type)};"
    yield f"R{number} : {_name(pou.result.type)};"


def _call(pou: t.Pou, number: int, holders: Mapping[str, str]) -> str:
    if pou.kind == "FUNCTION":
        names = (f"A{number}_{symbol.name}" for symbol in pou.section("VAR_INPUT"))
        return f"R{number} := {pou.name}({', '.join(names)});"
    in_outs = pou.section("VAR_IN_OUT")
    given = (f"{symbol.name} := {holders[symbol.type.name.upper()]}" for symbol in in_outs)
    return f"B{number}({', '.join(given)});"


def _name(kind: Type) -> str:
    assert not isinstance(kind, ArrayType)
    return kind.name
