"""Comparison of two versions of a program in a cell, and replays of their difference."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rcx_harness.cell.cell import Cell
from rcx_harness.cell.compiled import Compiled
from rcx_harness.cell.sources import blame_lib, source_files
from rcx_harness.cell.stimulus import Entry, Stimulus, stimulus_text
from rcx_harness.robot import RobotConfig
from rcx_harness.verify.prove.surroundings import CellSurroundings
from rcx_harness.verify.prove.user import LIBRARY, AloneBench, CellBench
from structured_text.bench import Bench
from structured_text.bench.stimulus import Entry as PlcEntry
from structured_text.bench.stimulus import Stimulus as PlcStimulus
from structured_text.errors import InputError
from structured_text.language.project import Project
from structured_text.language.types import ArrayType, BlockType, EnumType, StructType
from structured_text.output.files import replace_files
from structured_text.output.replays import MARK, check
from structured_text.projects.sources import SourceFiles
from structured_text.prove import values
from structured_text.prove.against import compare as pairs
from structured_text.prove.against.compare import Comparison, Ran, Wishes
from structured_text.prove.against.search import Run
from structured_text.prove.properties import Library
from structured_text.prove.search import Counterexample
from structured_text.prove.surroundings import Surroundings

__all__ = ["Versions", "compare"]


@dataclass(frozen=True)
class Versions:
    """The files of both versions, and how they are read.

    Attributes:
        old: The files of the old version.
        new: The files of the new version.
        lib: The folder of the library; None: the library of this package.
        robot: Whether there is a controller.
        replace: Files with Structured Text that replace POUs of a project, by name.
        device: The device to read if a project has several devices.
    """

    old: Sequence[Path]
    new: Sequence[Path]
    lib: Path | None = None
    robot: bool = True
    replace: Mapping[str, Path] = field(default_factory=dict)
    device: str = ""


def compare(versions: Versions, wishes: Wishes) -> Comparison:
    """Compare two versions of a program."""
    old, new = (
        source_files(list(files), versions.lib, given, device=versions.device)
        for files, given in ((versions.old, {}), (versions.new, versions.replace))
    )
    return pairs.compare((old, new), wishes, _Bench(versions, (old, new)))


class _Bench:
    """The bench that runs both versions in cells with the same inputs."""

    name = "rcx prove"

    def __init__(self, versions: Versions, sources: tuple[SourceFiles, SourceFiles]) -> None:
        kind = CellBench if versions.robot else AloneBench
        self._benches = (
            kind(versions.old, versions.lib, {}, versions.device),
            kind(versions.new, versions.lib, versions.replace, versions.device),
        )
        self._lib, self._sources = versions.lib, sources

    @property
    def library(self) -> Library:
        """Return the requirements of the library."""
        return LIBRARY

    def surroundings(self, project: Project) -> Surroundings:
        """Return the controllers of a program."""
        return self._benches[0].surroundings(project)

    def blame(self, error: InputError) -> InputError:
        """Return the error, with a hint if the library from `--lib` is incomplete."""
        return blame_lib(error, self._lib)

    def images(self, around: Surroundings) -> list[str]:
        """Return the names of the output areas."""
        if not isinstance(around, CellSurroundings):
            return []
        return [
            f"{instance}.{variable.name}"
            for instance, block in around.project.instances.items()
            for variable in block.variables
            if re.fullmatch(r"OUTPUTAREA\d*", variable.name.upper())
        ]

    def run(self, run: Run, side: int, around: Surroundings, names: Sequence[str]) -> Ran:
        """Run a version on the built-in engine, and read its outputs after each scan."""
        found: list[dict[str, Any]] = []
        with _made(self._sources[side], around, run.scan_us) as cell:
            in_cell = isinstance(around, CellSurroundings)
            entries = list(_entries(run, around, Entry if in_cell else PlcEntry))
            kind = Stimulus if in_cell else PlcStimulus
            kind(Path("stimulus"), entries).schedule(cell)
            parts = [
                path
                for path, type_ in cell.program.walk()
                if not isinstance(type_, (ArrayType, BlockType, StructType))
                and any(path == name or path.startswith((f"{name}.", f"{name}[")) for name in names)
            ]
            for _ in run.steps:
                try:
                    cell.scan()
                except InputError as error:
                    return Ran(tuple(found), error)
                found.append({path: cell.program.read(path) for path in parts})
        return Ran(tuple(found))

    def write(
        self, run: Run, around: Sequence[Surroundings], out: Path, about: str, watched: str
    ) -> tuple[str, tuple[str, str]]:
        """Write the stimulus file; a second one if the versions have different inputs."""
        name = re.sub(r"\W+", "-", about.partition(" ")[0]).strip("-")
        given = [
            stimulus_text(_entries(run, one), MARK.removeprefix("# ") + about) for one in around
        ]
        files = [out / f"differs-{name}{end}.toml" for end in ("-old", "")]
        if given[0] == given[1]:
            files[0] = files[1]
        for file in files:
            check(file)
        replace_files(dict(zip(files, given, strict=True)))
        again = Counterexample(run.scan_us, run.steps, ())
        commands = [
            bench.command(again, one, file) + f' --watch "{watched}"'
            for bench, one, file in zip(self._benches, around, files, strict=True)
        ]
        return str(files[1]), (commands[0], commands[1])


def _made(sources: SourceFiles, around: Surroundings, scan_us: int) -> Bench:
    if not isinstance(around, CellSurroundings):
        inputs = [one.name for one in around.inputs if one.searched]
        return Bench.build(sources, watch=inputs, engine="builtin", scan=scan_us)
    robots = [RobotConfig(size=area.size) for area in around.areas]
    m, n = [area.m for area in around.areas], [area.n for area in around.areas]
    return Cell.build(Compiled(sources, "builtin"), robot=robots, m=m, n=n, scan=scan_us)


def _entries(run: Run, around: Surroundings, kind: type[Any] = Entry) -> Iterator[Any]:
    """Yield the stimulus of a run for one version: each change of an input at its time."""
    kinds = dict(_variables(around))
    controllers = (
        {area.controller: area.size for area in around.areas}
        if isinstance(around, CellSurroundings)
        else {}
    )
    before: dict[int, tuple[bytes, bool]] = {}
    for step in run.steps:
        told = {
            name: _told(value, kinds[name.upper()])
            for name, value in step.inputs.items()
            if name.upper() in kinds
        }
        areas = {
            one: (content[: controllers[one]], connected)
            for one, (content, connected) in step.areas.items()
            if one in controllers
        }
        given = {one: area for one, area in areas.items() if before.get(one) != area}
        before |= given
        if told and 1 not in given:
            yield kind(step.t_us, values=told)
        for one, (content, connected) in sorted(given.items()):
            set_here = told if one == 1 else {}
            yield Entry(
                step.t_us, values=set_here, area=content, connected=connected, controller=one
            )


def _variables(around: Surroundings) -> Iterator[tuple[str, Any]]:
    """Yield the variables of the programs that a stimulus can set, in upper case."""
    for instance, block in around.project.instances.items():
        pou = around.project.pous[block.name.upper()]
        for symbol in pou.symbols.values():
            if not symbol.constant:
                yield f"{instance}.{symbol.name}".upper(), symbol.type
    for symbol in around.project.global_symbols.values():
        if not symbol.constant:
            yield symbol.name.upper(), symbol.type


def _told(value: Any, kind: Any) -> Any:
    if values.is_duration(kind):
        return f"{value // 1000}us"
    return kind.members[value] if isinstance(kind, EnumType) else value
