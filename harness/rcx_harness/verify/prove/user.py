"""Proofs of the properties of a program in a cell, and replays of counterexamples."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from rcx_harness.cell.sources import blame_lib, source_files
from rcx_harness.spec.wire import SIZE
from rcx_harness.verify.prove.replay import replay
from rcx_harness.verify.prove.surroundings import CellSurroundings
from rcx_harness.watch.calls_source import AREAS
from structured_text.errors import InputError
from structured_text.language.project import Project
from structured_text.output.console import quoted
from structured_text.prove import user
from structured_text.prove.properties import Library
from structured_text.prove.search import Counterexample
from structured_text.prove.surroundings import Surroundings
from structured_text.prove.user import Replayed, Result

__all__ = ["LIBRARY", "CellBench", "Settings", "prove"]

#: Assumptions of the proofs about the library that the programs call.
LIBRARY = Library(
    areas=AREAS,
    reference="RCX_REF",
    milliseconds="FC_RcxMilliseconds",
    counts="FC_RcxMilliseconds gives 0 to 480 h, in ms (make prove).",
    calls="A call of the library's blocks may do anything to its instance, its Robot and its "
    "Image.",
)
#: Assumptions for a program without a robot, which does not use the library.
_ALONE = replace(LIBRARY, areas={}, reference="")


@dataclass(frozen=True)
class Settings(user.Settings):
    """The settings of a proof.

    Attributes:
        lib: The folder of the library; None: the library of this package.
        robot: Whether there is a controller. Without a controller the program has no areas.
        replace: Files with Structured Text that replace POUs of a project, by name.
        device: The device to read if a project has several devices.
    """

    lib: Path | None = None
    robot: bool = True
    replace: Mapping[str, Path] = field(default_factory=dict)
    device: str = ""


def prove(files: list[Path], settings: Settings) -> tuple[list[Result], list[str]]:
    """Prove a program's properties; return the results and the names of the program's inputs."""
    sources = source_files(list(files), settings.lib, settings.replace, device=settings.device)
    bench = CellBench if settings.robot else AloneBench
    return user.prove(
        sources, settings, bench(files, settings.lib, settings.replace, settings.device)
    )


@dataclass(frozen=True)
class CellBench:
    """The bench that replays counterexamples in a cell."""

    files: Sequence[Path]
    lib: Path | None
    replace: Mapping[str, Path] = field(default_factory=dict)
    device: str = ""
    name: str = "rcx prove"
    library: Library = LIBRARY

    def surroundings(self, project: Project) -> Surroundings:
        """Return the controllers of a program."""
        return CellSurroundings(project)

    def blame(self, error: InputError) -> InputError:
        """Return the error, with a hint if the library from `--lib` is incomplete."""
        return blame_lib(error, self.lib)

    def replay(
        self,
        run: Counterexample,
        around: Surroundings,
        files: Sequence[Path],
        stimulus: Path,
        *,
        about: str,
        chart: Path,
    ) -> Replayed:
        """Write the stimulus file of a counterexample, and run it."""
        return replay(run, around, files, stimulus, about=about, lib=self.lib, chart=chart)

    def command(self, run: Counterexample, around: Surroundings, stimulus: Path) -> str:
        """Return the command line that replays a counterexample."""
        words = ["rcx run", *map(quoted, self.files)]
        words += [f"--lib {quoted(self.lib)}"] if self.lib else []
        words += [f"--replace {name}={quoted(file)}" for name, file in self.replace.items()]
        words += [f"--device {quoted(self.device)}"] if self.device else []
        words += [
            f"--scan {run.scan_us / 1000:g}ms --for {len(run.steps) * run.scan_us / 1000:g}ms"
        ]
        words += ["--engine builtin", f"--stimulus {quoted(stimulus)}"]
        if not isinstance(around, CellSurroundings):
            return " ".join([*words, "--no-robot"])
        areas = around.areas
        if len(areas) > 1 or areas[0].m or areas[0].n:
            words += [f"--m {area.m} --n {area.n}" for area in areas]
        if len(areas) > 1:
            words += [f"--robot robot{area.controller}.toml" for area in areas]
        words += [f"--size {areas[0].size}"] if areas[0].size != SIZE else []
        return " ".join(words)


@dataclass(frozen=True)
class AloneBench(CellBench):
    """The bench of a program without a robot."""

    library: Library = _ALONE

    def surroundings(self, project: Project) -> Surroundings:
        """Return surroundings in which only the inputs of the program change."""
        return Surroundings(project)
