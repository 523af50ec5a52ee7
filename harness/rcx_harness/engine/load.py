"""Which engine runs a program: the one place that chooses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from rcx_harness.engine import cache
from rcx_harness.engine.base import Program
from rcx_harness.engine.builtin import BuiltinProgram
from rcx_harness.engine.compiling import uncollected
from rcx_harness.engine.frontend import Project
from rcx_harness.engine.frontend import load as load_anew
from rcx_harness.engine.matiec.build import MISSING, Matiec, find_c_compiler, find_matiec
from rcx_harness.engine.matiec.program import MatiecProgram
from rcx_harness.errors import InputError

__all__ = [
    "ENGINES",
    "MISSING",
    "Built",
    "Matiec",
    "build",
    "find_c_compiler",
    "find_matiec",
    "load",
]

#: What `--engine` takes.
ENGINES = ("auto", "matiec", "builtin")


@dataclass(frozen=True)
class Built:
    """A compiled program, and what a user should know about the choice of its engine.

    Attributes:
        program: Ready for its first scan.
        notice: One line where `auto` had to do without matiec, else empty.
    """

    program: Program
    notice: str


@uncollected()
def build(paths: Sequence[Path | str], engine: str = "auto") -> Built:
    """Check ST sources and compile them.

    Args:
        paths: The ST files, in any order.
        engine: `matiec`, `builtin`, or `auto`: matiec where it and a C compiler are found, else
            the built-in engine.

    Raises:
        InputError: an error in the sources (with file and line), an unknown engine, or matiec
            is asked for and missing.
    """
    if engine not in ENGINES:
        raise InputError(f"there is no engine {engine!r}", hint=f"use {', '.join(ENGINES)}")
    project = load([Path(path) for path in paths])
    if engine == "builtin":
        return Built(BuiltinProgram.build(project), "")
    matiec, compiler = find_matiec(), find_c_compiler()
    if matiec is not None and compiler is not None:
        return Built(MatiecProgram.build(project, matiec, compiler), "")
    if engine == "matiec":
        missing = MISSING if matiec is None else "matiec found, but no C compiler: set CC or PATH"
        raise InputError(f"{missing}, or use the built-in engine")
    missing = "matiec not found (RCX_MATIEC, PATH)"
    if matiec is not None:
        missing = "matiec found, but no C compiler (CC, cc, gcc, clang)"
    notice = f"{missing}: running on the built-in engine"
    return Built(BuiltinProgram.build(project), notice)


def load(paths: Sequence[Path]) -> Project:
    """A checked project; from the cache where the same files were loaded before."""
    key = cache.sources_key(paths)

    def made() -> Project:
        return replace(load_anew(paths), key=key if cache.is_lasting(paths) else "")

    def found() -> Project:
        return cache.kept("project", key if cache.is_lasting(paths) else "", made)

    return cache.remembered("project", key, found)
