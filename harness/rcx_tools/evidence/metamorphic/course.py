"""The course of a program: the records of a run, and its variables scan by scan."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from rcx_harness.cell import Cell
from rcx_harness.cell.stimulus import Stimulus
from rcx_harness.trace import Cycle, Record, Scan
from rcx_tools.evidence.metamorphic.programs import Subject
from structured_text.engines.base import Program
from structured_text.language.types import BlockType

__all__ = ["Course", "Options", "Seen", "follow", "slowed"]

#: Excluded variables: the records contain their values.
_IMAGES = ("InputArea", "OutputArea")


@dataclass(frozen=True)
class Options:
    """Options of a run.

    Attributes:
        engine: `auto`, `matiec` or `builtin`.
        link: `direct` or `enip`.
        slower: Factor on all times of the cell.
        lib: Folder of the library; None for plc/lib.
    """

    engine: str = "auto"
    link: str = "direct"
    slower: int = 1
    lib: Path | None = None


class Seen(NamedTuple):
    """A scan: the area read, the area written, the values of the watched variables."""

    so: bytes
    si: bytes
    values: tuple[Any, ...]


@dataclass
class Course:
    """The record of a run.

    Attributes:
        paths: The watched variables: outputs of the program's blocks, and its own but the images.
        times: Time of each scan [us].
        scans: The observed values of each scan.
        cycles: The controller's cycles: time, area read, area answered.
        outside: Number of bytes of the output image beside the area that are not 0 at the end.
        broken: Rules that were broken.
        engine: The name of the engine.
    """

    paths: tuple[str, ...] = ()
    times: list[int] = field(default_factory=list)
    scans: list[Seen] = field(default_factory=list)
    cycles: list[tuple[int, bytes, bytes]] = field(default_factory=list)
    outside: int = 0
    broken: tuple[str, ...] = ()
    engine: str = ""


def _unnumbered(values: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return the values without RCX_REF.Inner.Scan, which has an arbitrary start."""
    return tuple(
        {**one, "Inner": {**one["Inner"], "Scan": 0}}
        if isinstance(one, dict) and "Inner" in one
        else one
        for one in values
    )


def follow(subject: Subject, options: Options = Options()) -> Course:
    """Run a program in a cell.

    Raises:
        InputError: it cannot be compiled.
    """
    course = Course()
    slower = options.slower
    with TemporaryDirectory() as folder:
        files = []
        for name, text in subject.files.items():
            files.append(Path(folder) / name)
            files[-1].write_text(text, encoding="utf-8")
        with Cell.build(
            files,
            lib=options.lib,
            scan=10_000 * slower,
            engine=options.engine,
            link=options.link,
            size=subject.size,
            m=subject.m,
            n=subject.n,
            robot=subject.robot,
            rpi=10_000 * slower,
            timeout=100_000 * slower,
        ) as cell:
            course.engine = cell.program.engine
            course.paths = tuple(_watched(cell.program))
            look = cell.program.reader(course.paths)

            def take(record: Record) -> None:
                if isinstance(record, Scan):
                    course.times.append(record.t_us)
                    course.scans.append(Seen(record.so, record.si, _unnumbered(look())))
                elif isinstance(record, Cycle):
                    course.cycles.append((record.t_us, record.rcx_si, record.rcx_so))

            cell.trace.listen(take)
            if subject.stimulus is not None:
                subject.stimulus.schedule(cell)
            cell.run(subject.length_us * slower)
            course.outside = _outside(cell, subject)
            course.broken = tuple(one.text for one in cell.violations)
    return course


def slowed(stimulus: Stimulus | None, slower: int) -> Stimulus | None:
    """Return a stimulus with all times multiplied by a factor."""
    if stimulus is None:
        return None
    entries = [
        replace(
            entry,
            t_us=entry.t_us * slower,
            held_us=None if entry.held_us is None else entry.held_us * slower,
        )
        for entry in stimulus.entries
    ]
    return Stimulus(stimulus.file, entries)


def _outside(cell: Cell, subject: Subject) -> int:
    image = bytes(cell.program.read_bytes("Main.OutputArea"))
    beside: Sequence[int] = image[: subject.n] + image[subject.n + subject.size :]
    return sum(map(bool, beside))


def _watched(program: Program) -> list[str]:
    """Return the program's variables except its images, and the outputs of its blocks."""
    found = []
    for name, kind in program.instances().items():
        assert isinstance(kind, BlockType)
        for variable in kind.variables:
            path = f"{name}.{variable.name}"
            if isinstance(variable.type, BlockType):
                outputs = [pin for pin in variable.type.variables if pin.section == "VAR_OUTPUT"]
                found += [f"{path}.{pin.name}" for pin in outputs]
            elif variable.name not in _IMAGES:
                found.append(path)
    return found
