"""The inputs of a proof: the modules that a property uses, found by following imports."""

from __future__ import annotations

import ast
import hashlib
import sys
from collections.abc import Iterable, Iterator
from functools import lru_cache
from pathlib import Path

import z3

from rcx_tools.evidence.checks import digest
from rcx_tools.evidence.results import ROOT

__all__ = ["module_of", "prover_state"]

_HARNESS = ROOT / "harness"
#: Tables, the grammar, and files that tests read. These files are listed because imports do not
#: lead to them.
_DATA = (
    "spec",
    "harness/structured_text/language",
    "tests/spec/second_reading",
    "tests/tools/evidence/wraps.toml",
)


@lru_cache(maxsize=64)
def prover_state(*modules: str) -> str:
    """Return a hash of these modules, their imports, the tables, and the version of z3."""
    state = hashlib.sha256(f"{z3.get_version_string()} {digest(_DATA)}".encode())
    for file in sorted(_closure(modules)):
        state.update(file.relative_to(_HARNESS).as_posix().encode() + b"\0")
        state.update(hashlib.sha256(file.read_bytes()).digest())
    return state.hexdigest()[:16]


def _closure(modules: Iterable[str]) -> set[Path]:
    found: set[Path] = set()
    waiting = [file for name in modules for file in _file(name)]
    while waiting:
        file = waiting.pop()
        if file not in found:
            found.add(file)
            waiting += _imports(file)
    return found


def _file(module: str) -> Iterator[Path]:
    """Yield the file of a module of the harness. For another name, yield nothing."""
    start = _HARNESS.joinpath(*module.split("."))
    yield from (
        file for file in (start.with_suffix(".py"), start / "__init__.py") if file.is_file()
    )


@lru_cache(maxsize=1024)
def _imports(file: Path) -> tuple[Path, ...]:
    names: list[str] = []
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            names += [node.module, *(f"{node.module}.{one.name}" for one in node.names)]
        elif isinstance(node, ast.Import):
            names += [one.name for one in node.names]
    return tuple(found for name in names for found in _file(name))


def module_of(item: object) -> str:
    """Return the name of the module whose PROPERTIES contain a property."""
    package = __package__ or ""
    return next(
        name
        for name, module in sorted(sys.modules.items())
        if name.startswith(package)
        and not name.endswith(".jobs")
        and any(one is item for one in getattr(module, "PROPERTIES", ()))
    )
