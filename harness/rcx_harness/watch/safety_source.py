"""The variables that a program passes to EmergencyStopOk and StopOk, from its checked source."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from rcx_harness.watch.calls_source import AREAS
from structured_text.language import cache
from structured_text.language.checked import analysed
from structured_text.language.project import Project
from structured_text.language.tree import Use
from structured_text.language.walk import calls_of

__all__ = ["safety_inputs"]

_HERE = Path(__file__)
_PINS = ("EMERGENCYSTOPOK", "STOPOK")


def safety_inputs(files: Sequence[Path], library: Sequence[Path] = ()) -> list[str]:
    """Return the paths of the variables with the safety state of a cell, such as `Main.CellSafe`.

    Variables that reach the pins only through expressions or blocks are left out.
    """
    every = (*files, *library)
    key = cache.sources_key((*files, _HERE, *library))
    return list(cache.made_of("safety", key, every, lambda: _found(every)))


def _found(every: Sequence[Path]) -> list[str]:
    project, _ = analysed(every)
    return [] if project is None else list(dict.fromkeys(_variables(project)))


def _variables(project: Project) -> Iterator[str]:
    for instance, block in project.instances.items():
        for call in calls_of(project.pous[block.name.upper()].body):
            if AREAS.get(call.block.name.upper()) != "write":
                continue
            for pin, value in call.inputs:
                if pin.upper() in _PINS and isinstance(value, Use) and not value.symbol.constant:
                    outside = value.symbol.section in ("VAR_EXTERNAL", "VAR_GLOBAL")
                    yield value.symbol.name if outside else f"{instance}.{value.symbol.name}"
