"""Replay of a counterexample: it becomes a stimulus file, and is run on the built-in engine."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from rcx_harness.cell.cell import Cell
from rcx_harness.cell.compiled import Compiled
from rcx_harness.cell.sources import source_files
from rcx_harness.cell.stimulus import Entry, Stimulus
from rcx_harness.robot import RobotConfig
from rcx_harness.verify.prove.surroundings import CellSurroundings
from rcx_harness.verify.replay import replayed
from structured_text.bench import Bench
from structured_text.bench.stimulus import Stimulus as PlcStimulus
from structured_text.errors import InputError
from structured_text.language.types import ArrayType, BlockType, EnumType, StructType
from structured_text.language.values import scalar_to_python
from structured_text.projects.sources import SourceFiles
from structured_text.prove import values
from structured_text.prove.search import Counterexample
from structured_text.prove.surroundings import Surroundings, path_of
from structured_text.prove.symbolic_memory import Path as Place
from structured_text.prove.user import Replayed

__all__ = ["entries", "replay"]


def entries(run: Counterexample, around: Surroundings) -> Iterator[Entry]:
    """Yield the stimulus of a counterexample: each change of an input at its time."""
    before: dict[int, tuple[bytes, bool]] = {}
    values = {one.name: one.initial for one in around.inputs}
    kinds = {one.name: one.type for one in around.inputs}
    for step in run.steps:
        changed = {name: value for name, value in step.inputs.items() if values[name] != value}
        values |= changed
        given = {one: area for one, area in step.areas.items() if before.get(one) != area}
        before |= given
        told = {name: _told(value, kinds[name]) for name, value in changed.items()}
        if told and 1 not in given:
            yield Entry(step.t_us, values=told)
        for one, (content, connected) in sorted(given.items()):
            set_here = told if one == 1 else {}
            yield Entry(
                step.t_us, values=set_here, area=content, connected=connected, controller=one
            )


def _told(value: Any, kind: Any) -> Any:
    if values.is_duration(kind):
        return f"{value // 1000}us"
    return kind.members[value] if isinstance(kind, EnumType) else value


def replay(
    run: Counterexample,
    around: Surroundings,
    files: Sequence[Path],
    stimulus: Path,
    *,
    about: str = "",
    lib: Path | None = None,
    chart: Path | None = None,
) -> Replayed:
    """Write the stimulus file of a counterexample, and run it on the built-in engine.

    `about` is the comment at the beginning of the stimulus file.
    """
    differences: list[str] = []
    error = None
    in_cell = isinstance(around, CellSurroundings)

    def made() -> Bench:
        given: dict[str, Any] = {"engine": "builtin", "scan": run.scan_us}
        if not isinstance(around, CellSurroundings):
            inputs = [one.name for one in around.inputs if one.searched]
            return Bench.build(_sources(files, lib), watch=inputs, **given)
        robots = [RobotConfig(size=area.size) for area in around.areas]
        m, n = [area.m for area in around.areas], [area.n for area in around.areas]
        compiled = Compiled(_sources(files, lib), given.pop("engine"))
        return Cell.build(compiled, robot=robots, m=m, n=n, **given)

    kind = Stimulus if in_cell else PlcStimulus
    with replayed(made, entries(run, around), about, stimulus, chart, kind=kind) as cell:
        compared = _compared(cell, around)
        for number, state in enumerate(run.states):
            try:
                cell.scan()
            except InputError as found:
                error = found
                break
            differences += _differences(cell, number, state, compared)
        return Replayed(
            cell.scans, error, tuple(differences), tuple(one.text for one in cell.violations)
        )


def _sources(files: Sequence[Path], lib: Path | None) -> SourceFiles:
    """Return the sources of a program; extracts of projects keep their lines and their dialect."""
    found = source_files(list(files), lib)
    given = {str(one): one for one in files}
    return replace(found, own=tuple(given.get(str(one), one) for one in found.own))


def _compared(cell: Bench, around: Surroundings) -> dict[str, Place]:
    """Return all scalars of the program with their positions in the memory of a machine."""
    return {
        name: path_of(around.project, name)[0]
        for name, kind in cell.program.walk()
        if not isinstance(kind, (ArrayType, BlockType, StructType))
    }


def _differences(
    cell: Bench, number: int, state: Mapping[Place, Any], compared: Mapping[str, Place]
) -> list[str]:
    found = []
    for name, place in compared.items():
        if place not in state:
            continue
        has, says = cell.program.read(name), state[place]
        if has != (wanted := scalar_to_python(cell.program.type_of(name), says)):
            found.append(f"scan {number}: {name} is {has}, not {wanted}")
    return found
