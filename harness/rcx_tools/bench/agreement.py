"""Comparison of the built-in engine with matiec, by random calls of a library's POUs."""

from __future__ import annotations

import random
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date, datetime, time, timedelta
from pathlib import Path
from typing import Any

from structured_text.engines.builtin import BuiltinProgram
from structured_text.engines.matiec.build import Matiec
from structured_text.engines.matiec.program import MatiecProgram
from structured_text.errors import InputError
from structured_text.language.dialects import MATIEC
from structured_text.language.load import analyse, load
from structured_text.language.project import Project
from structured_text.language.scalars import INT_RANGE
from structured_text.language.source import in_dialect
from structured_text.language.tree import Pou
from structured_text.language.types import ElementaryType, EnumType, Type
from structured_text.projects.needed import declared_names, needed

__all__ = ["Compared", "candidates", "compared"]

#: Number of functions and blocks in one test program.
_TOGETHER = 24
#: Constructs outside of the portable subset that are tried, because matiec may accept them.
_TRIED = (
    "a written VAR_INPUT",
    "an empty branch",
    "an empty statement",
    "a section in another place",
    "a variable called as something else",
    "a function without VAR_INPUT",
    "a variable of a block that is not a pin",
    "inputs of a function left out",
    "a CASE of bit strings",
    "a function with VAR_OUTPUT or VAR_IN_OUT",
    "a function that never sets its result",
    "a comment inside a comment",
    "a name with __ or _ at its end",
    "a standard function of dates or BCD",
)
_INPUTS, _OUTPUTS = ("VAR_INPUT",), ("VAR_OUTPUT",)
_PLAIN = ("BOOL", "REAL", "LREAL", "TIME", "DATE", "TOD", "DT", "STRING", *INT_RANGE)
#: Special values of a REAL. All other values are drawn from a uniform distribution.
_REALS = (0.0, 1.0, -1.0, 0.5, 2.0, 100.0)


@dataclass
class Compared:
    """The result of a comparison: number of calls and POUs, and a line for each difference."""

    calls: int
    pous: int
    differences: list[str]


@dataclass(frozen=True)
class _Candidate:
    """A function or block that both engines accept, with the files that it needs."""

    pou: Pou
    files: tuple[Path, ...]

    def pins(self, sections: Sequence[str]) -> list[tuple[str, Type]]:
        """Return the variables of the POU in the given sections."""
        every = self.pou.symbols.values()
        return [(one.name, one.type) for one in every if one.section in sections]


def candidates(files: Sequence[Path]) -> list[_Candidate]:
    """Return the functions and blocks that matiec may accept, with the declarations that they use.

    Args:
        files: Sources without errors.
    """
    files = [in_dialect(file, MATIEC) for file in files]  # the library may target another tool
    project, errors = analyse(files)
    while project is None:  # a file may still use declarations of a file that was refused
        refused = {error.file for error in errors}
        left = [file for file in files if str(file) not in refused]
        if len(left) == len(files) or not left:
            return []
        files = left
        project, errors = analyse(files)
    beyond = {use.file for use in project.uses if use.construct not in _TRIED}
    naming = [file for file in files if declared_names(file)]
    found = []
    for unit in project.units:
        pou = project.pous.get(unit.name.upper())
        if pou is None or unit.kind not in ("FUNCTION", "FUNCTION_BLOCK") or unit.file in beyond:
            continue
        uses = needed([unit.file], naming)
        if not beyond.isdisjoint(uses) or not _is_callable(pou):
            continue
        found.append(_Candidate(pou, tuple(dict.fromkeys([unit.file, *uses]))))
    return found


def _is_callable(pou: Pou) -> bool:
    """Return whether a POU can be called with random values and has a result to compare."""
    pins = [one for one in pou.symbols.values() if one.section in (*_INPUTS, *_OUTPUTS)]
    plain = all(isinstance(one.type, EnumType) or _name(one.type) in _PLAIN for one in pins)
    given = all(one.section != "VAR_IN_OUT" for one in pou.symbols.values())
    shown = pou.result is None or _name(pou.result.type) in _PLAIN
    has = pou.result is not None or any(one.section in _OUTPUTS for one in pins)
    return plain and given and shown and has


def _name(kind: Type) -> str:
    return kind.name if isinstance(kind, ElementaryType) and kind.length is None else ""


def compared(
    libraries: Sequence[Sequence[Path]], matiec: Matiec, compiler: str, calls: int, seed: int = 1
) -> Compared:
    """Call POUs that both engines accept with random values. Compare the results.

    Args:
        libraries: Sources of each library, without errors.
        matiec: The engine to compare with.
        compiler: The C compiler for the code that matiec generates.
        calls: Total number of calls.
        seed: Seed of the random values.
    """
    draw = random.Random(seed)
    programs: list[tuple[list[_Candidate], Project, MatiecProgram]] = []
    with tempfile.TemporaryDirectory() as folder:
        for number, files in enumerate(libraries):
            waiting = candidates(files)
            parts = [waiting[k : k + _TOGETHER] for k in range(0, len(waiting), _TOGETHER)]
            while parts:
                part = parts.pop()
                file = Path(folder) / f"calls_{number}_{len(programs)}_{len(parts)}.st"
                built = _built(part, file, matiec, compiler)
                if built is not None:
                    programs.append((part, *built))
                elif len(part) > 1:
                    half = len(part) // 2
                    parts += [part[:half], part[half:]]
        pous = sum(len(part) for part, _, _ in programs)
        found = Compared(0, pous, [])
        for part, project, theirs in programs:
            ours = BuiltinProgram.build(project)
            _compare(part, ours, theirs, draw, calls // max(pous, 1) + 1, found)
            theirs.close()
    return found


def _built(
    part: Sequence[_Candidate], file: Path, matiec: Matiec, compiler: str
) -> tuple[Project, MatiecProgram] | None:
    """Return a program that calls each POU of the part. If matiec refuses a POU, return None."""
    file.write_text(_program(part), encoding="utf-8")
    files = dict.fromkeys(path for one in part for path in one.files)
    try:
        project = load([*files, file])
        return project, MatiecProgram.build(project, matiec, compiler)
    except InputError:
        return None


def _program(part: Sequence[_Candidate]) -> str:
    """Return a program in which one scan calls the function or block selected by `Which`."""
    variables, branches = ["  Which : INT;"], []
    for number, one in enumerate(part):
        given = one.pins(_INPUTS)
        variables += [f"  I{number}_{name} : {kind.name};" for name, kind in given]
        arguments = ", ".join(f"{name} := I{number}_{name}" for name, _ in given)
        if one.pou.result is not None:
            variables.append(f"  R{number} : {one.pou.result.type.name};")
            call = f"R{number} := {one.pou.name}({arguments});"
        else:
            variables.append(f"  B{number} : {one.pou.name};")
            call = f"B{number}({arguments});"
        branches.append(f"  {number}: {call}")
    lines = ["PROGRAM RandomCalls", "VAR", *variables, "END_VAR", "CASE Which OF", *branches]
    return "\n".join([*lines, "END_CASE;", "END_PROGRAM", ""])


def _compare(
    part: Sequence[_Candidate],
    ours: BuiltinProgram,
    theirs: MatiecProgram,
    draw: random.Random,
    times: int,
    found: Compared,
) -> None:
    now = 0
    for number, one in enumerate(part):
        given = one.pins(_INPUTS)
        block = one.pou.result is None
        paths = [f"Main.R{number}"]
        if block:
            paths = [f"Main.B{number}.{name}" for name, _ in one.pins(_OUTPUTS)]
        for engine in (ours, theirs):
            engine.write("Main.Which", number)
        for _ in range(times):
            now += 10_000
            values = {name: _drawn(kind, draw) for name, kind in given}
            for name, value in values.items():
                ours.write(f"Main.I{number}_{name}", value)
            try:
                ours.scan(now)
            except InputError:
                break  # The error ends the run; in C the result is undefined.
            for name, value in values.items():
                theirs.write(f"Main.I{number}_{name}", value)
            theirs.scan(now)
            found.calls += 1
            mine, other = [[repr(side.read(path)) for path in paths] for side in (ours, theirs)]
            if mine != other:
                found.differences.append(
                    f"{one.pou.name}: {', '.join(mine)} here, {', '.join(other)} on matiec,"
                    f" for {values}"
                )
                break


def _drawn(kind: Type, draw: random.Random) -> Any:
    """Return a random value of a type, often a small value or a limit."""
    if isinstance(kind, EnumType):
        return draw.choice(kind.members)
    assert isinstance(kind, ElementaryType)
    name = kind.name
    if name == "BOOL":
        return draw.random() < 0.5
    if name in INT_RANGE:
        low, high = INT_RANGE[name]
        small = max(low, min(high, draw.randint(-20, 200)))
        return draw.choice([small, small, draw.randint(low, high), low, high])
    if name in ("REAL", "LREAL"):
        return draw.choice([draw.choice(_REALS), draw.uniform(-50, 50) // 0.125 / 8])
    if name == "TIME":
        return timedelta(milliseconds=draw.choice([0, 10, 1000, draw.randrange(10**7)]))
    if name == "TOD":
        return time(draw.randrange(24), draw.randrange(60), draw.randrange(60))
    if name == "DATE":
        return date(1970, 1, 1) + timedelta(days=draw.randrange(20_000))
    if name == "DT":
        return datetime(1970, 1, 1) + timedelta(seconds=draw.randrange(10**9))
    return "".join(draw.choice("ab0 Z.-") for _ in range(draw.randrange(20)))
