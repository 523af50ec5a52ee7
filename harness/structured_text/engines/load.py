"""The choice of the engine that runs a program; no other module makes this choice."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from structured_text.engines.base import Program
from structured_text.engines.builtin import BuiltinProgram
from structured_text.engines.builtin.collector import collecting
from structured_text.engines.matiec.build import MISSING, Matiec, find_matiec
from structured_text.engines.native.toolchain import find_c_compiler, find_cxx_compiler
from structured_text.engines.strucpp.build import MISSING_STRUCPP, find_strucpp
from structured_text.errors import InputError
from structured_text.language.checked import load
from structured_text.language.compiling import uncollected
from structured_text.language.constructs import refuse
from structured_text.language.dialects import Dialect, rules_of
from structured_text.language.project import Project
from structured_text.language.types import BlockType, Type, has_address

__all__ = ["ENGINES", "Built", "build", "why_not"]

#: Values of the option `--engine`.
ENGINES = ("auto", "matiec", "builtin", "strucpp")


@dataclass(frozen=True)
class Built:
    """A compiled program, and a notice for the user about the choice of its engine.

    Attributes:
        program: The program, ready for its first scan.
        notice: One line with the reason if `auto` did not choose matiec. If matiec runs the
            program, one line for each warning about a known fault of matiec. Otherwise empty.
        retained: Paths of the variables that keep their values over a warm start.
    """

    program: Program
    notice: str
    retained: tuple[str, ...] = ()


#: Constructs that are outside the portable subset, but that matiec compiles.
_OF_MATIEC = (
    "a standard function of dates or BCD",
    "a VAR_IN_OUT read outside of its block",
)


@uncollected()
def build(paths: Sequence[Path | str], engine: str = "auto") -> Built:
    """Check ST sources and compile them.

    Raise InputError if the sources contain an error (with file and line), the engine is unknown or
    not installed, or matiec is named and cannot compile a construct of the program.

    Args:
        paths: The ST files, in any order.
        engine: `matiec`, `builtin`, `strucpp` or `auto`. `auto` takes matiec if it and a C compiler
            are found, the program is portable and in the plain dialect (`language.dialects`), no
            known fault of matiec concerns it, and coverage is not counted. Otherwise it takes the
            built-in engine. STruC++ runs only if it is named.
    """
    if engine not in ENGINES:
        raise InputError(f"there is no engine {engine!r}", hint=f"use {', '.join(ENGINES)}")
    project = load([path if isinstance(path, Path) else Path(path) for path in paths])
    program, notice = _compiled(project, engine)
    return Built(program, notice, _retained(project))


def _compiled(project: Project, engine: str) -> tuple[Program, str]:
    """Return the program on an engine, and a notice about the choice."""
    collector = collecting()
    if engine == "auto" and collector is not None:
        notice = "coverage is counted: running on the built-in engine"
        return BuiltinProgram.build(project), notice
    rules = rules_of(project.dialect)
    if engine == "auto" and (reason := _only_here(project, rules)) and find_matiec() is not None:
        return BuiltinProgram.build(project), f"{reason}: running on the built-in engine"
    if engine == "matiec":
        refuse(project.uses, "matiec", _OF_MATIEC)
    matiec = find_matiec() if engine in ("auto", "matiec") else None
    beyond = [use for use in project.uses if use.construct not in _OF_MATIEC]
    if beyond and matiec is not None:
        first = min(beyond, key=lambda use: (str(use.file), use.at))
        where = f"{first.file.name}, line {first.at.line}"
        notice = f"matiec does not know {first} ({where}): running on the built-in engine"
        return BuiltinProgram.build(project), notice
    strucpp = find_strucpp() if engine == "strucpp" else None
    compiler = find_cxx_compiler() if strucpp else find_c_compiler()
    compiled = compiler is not None and (matiec is not None or strucpp is not None)
    if collector is not None and compiled:
        collector.elsewhere.add(engine)
    if matiec is not None and compiler is not None:
        program, notice = _on_matiec(project, engine, matiec, compiler)
        return program, "\n".join(filter(None, (notice, _elsewhere(rules, engine))))
    if strucpp is not None and compiler is not None:
        from structured_text.engines.strucpp.program import StrucppProgram

        return StrucppProgram.build(project, strucpp, compiler), _elsewhere(rules, engine)
    if reason := why_not(engine):
        raise InputError(f"{reason}, or use the built-in engine")
    notice = ""
    if engine == "auto":
        missing = "matiec not found (RCX_MATIEC, PATH)"
        if matiec is not None:
            missing = "matiec found, but no C compiler (CC, cc, gcc, clang)"
        notice = f"{missing}: running on the built-in engine"
    return BuiltinProgram.build(project), notice


def _on_matiec(project: Project, engine: str, matiec: Matiec, compiler: str) -> tuple[Program, str]:
    """Return the program on matiec; with `auto`, on the built-in engine if matiec is unsuitable."""
    from structured_text.engines.matiec import faults
    from structured_text.engines.matiec.program import MatiecProgram

    found = faults.places(project, faults.is_new(matiec))
    if engine == "auto":
        if found:
            return BuiltinProgram.build(project), faults.why_builtin(found)
        try:
            return MatiecProgram.build(project, matiec, compiler), ""
        except InputError as error:
            where = f" ({Path(error.file).name}, line {error.line})" if error.file else ""
            reason = error.message.removeprefix("matiec: ")
            notice = f"matiec cannot compile the program{where}: {reason}"
            return BuiltinProgram.build(project), f"{notice}: running on the built-in engine"
    faults.refuse_faults(found)
    program = MatiecProgram.build(project, matiec, compiler)
    return program, "\n".join(f"warning: {one}" for one in faults.warnings(found))


def _elsewhere(rules: Dialect, engine: str) -> str:
    """Return a notice if the engine does not support the dialect of the program.

    The notice is empty if the engine supports the dialect.
    """
    return "" if rules.is_matiec else f"{engine} does not compute in the dialect {rules.name}"


def _only_here(project: Project, rules: Dialect) -> str:
    """Return the reason why matiec cannot run the program as its vendor tool does."""
    if not rules.is_matiec:
        return f"matiec does not compute in the dialect {rules.name}"
    if project.free:
        first = project.free[0]
        return f"matiec runs {first}, which has no task, only at the pace of the tasks"
    return ""


def why_not(engine: str) -> str:
    """Return the reason why an engine cannot run on this computer; empty if it can.

    Raises:
        InputError: `RCX_MATIEC` or `RCX_STRUCPP` is set, but the installation there is
            incomplete.
    """
    if engine == "matiec" and find_matiec() is None:
        return MISSING
    if engine == "strucpp" and find_strucpp() is None:
        return MISSING_STRUCPP
    if engine == "matiec" and find_c_compiler() is None:
        return "matiec found, but no C compiler: set CC or PATH"
    if engine == "strucpp" and find_cxx_compiler() is None:
        return "STruC++ found, but no C++ compiler: set CXX or PATH"
    return ""


def _retained(project: Project) -> tuple[str, ...]:
    """Return the paths of all retained variables.

    For a retained block, the paths of the variables inside the block are returned.

    Pointers and references are left out, because the start of the program sets them.
    """
    found = [
        path
        for name, block in project.instances.items()
        for path in _inside(name, block, whole=False)
    ]
    for variable in project.globals.values():
        if variable.retain or isinstance(variable.type, BlockType):
            found += _paths(variable.name, variable.type, whole=variable.retain)
    return tuple(found)


def _inside(path: str, block: BlockType, *, whole: bool) -> Iterator[str]:
    for variable in block.variables:
        if variable.section in ("VAR_IN_OUT", "VAR_EXTERNAL") or variable.address is not None:
            continue
        keeps = whole or variable.retain
        if keeps or isinstance(variable.type, BlockType):
            yield from _paths(f"{path}.{variable.name}", variable.type, whole=keeps)


def _paths(path: str, kind: Type, *, whole: bool) -> Iterator[str]:
    if isinstance(kind, BlockType):
        yield from _inside(path, kind, whole=whole)
    elif not has_address(kind):
        yield path
