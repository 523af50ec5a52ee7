"""The sources that are compared, and the PROGRAM that calls each of them, on either engine."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path as File
from typing import Any, Protocol

from structured_text.engines.base import Program
from structured_text.engines.builtin.module import Module
from structured_text.engines.load import MISSING, find_c_compiler, find_matiec
from structured_text.engines.matiec.program import MatiecProgram
from structured_text.language import tree as t
from structured_text.language.load import checked
from structured_text.language.project import Project
from structured_text.language.types import ArrayType, Type
from structured_text.prove.machine import Path

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
    """Why there is no matiec to compare with; empty where there is one.

    Raises:
        InputError: `RCX_MATIEC` or an `iec2c` on `PATH` leads to no complete matiec.
    """
    if find_matiec() is None:
        return MISSING
    return "" if find_c_compiler() else "matiec found, but no C compiler: set CC or PATH"


class Engine(Protocol):
    """A POU on an engine: what is compared with the translation.

    Attributes:
        step: Nanoseconds of its clock.
        checks: Whether it stops at a fault by itself.
    """

    step: int
    checks: bool

    def __init__(
        self, subject: Subject, pou: t.Pou, leaves: Sequence[tuple[Path, Type]]
    ) -> None: ...

    def read(self) -> list[Any]:
        """The leaves as `evaluate` has them."""

    def write(self, place: int, value: Any) -> None:
        """Set a leaf that can be set."""

    def reset(self) -> None:
        """Bring back the initial state."""

    def call(self, now: int) -> bool:
        """Call it; whether it was not stopped."""

    def follow(self, after: Sequence[Any]) -> None:
        """Take over what cannot be read, of the leaves as the translation has them."""


@dataclass(frozen=True)
class Compiled:
    """The PROGRAM, compiled by matiec, and its state at the start."""

    program: Program
    start: object


@dataclass(frozen=True)
class Subject:
    """Sources to compare, with a PROGRAM that calls one block or function in each scan.

    Attributes:
        project: What is translated.
        module: The same, compiled by the built-in engine.
        numbers: By name in upper case: for which `Which` the PROGRAM calls it, from 1.
        holders: The variable of that PROGRAM for each type of a VAR_IN_OUT, by its name.
        compiled: The same on matiec, where that was asked for.
    """

    project: Project
    module: Module
    numbers: Mapping[str, int]
    holders: Mapping[str, str]
    compiled: Compiled | None = None

    @classmethod
    def of(cls, files: Sequence[File], *, matiec: bool = False) -> Subject:
        """The sources of these files; for matiec only where `missing` gives nothing."""
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
    """An instance of a block; arguments and result of a function."""
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
