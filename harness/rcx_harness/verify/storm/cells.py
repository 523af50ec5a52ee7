"""The cells of a campaign: a program, compiled once in each worker, for one run after another."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rcx_harness.cell import Cell
from rcx_harness.cell.build import make_robot, several
from rcx_harness.cell.compiled import Compiled
from rcx_harness.cell.sources import blame_lib, library_folder, source_files
from rcx_harness.verify.storm.demands import Demands
from structured_text.errors import InputError
from structured_text.farm import Parcel
from structured_text.projects.needed import declared_names
from structured_text.projects.sources import named_files, st_files

__all__ = ["Cells", "CellsOf"]

#: Of a cell's options those that are files.
_FILES = ("lib", "replace", "robot")


@dataclass(frozen=True)
class CellsOf:
    """What cells are made of; it can travel to a worker.

    Attributes:
        parcel: All files that are read.
        parts: How many of them are, in this order: the program's, the library's, replacements,
            robots', demands, a stimulus.
        options: Arguments of `Cell.build`, without files.
        replaced: The names of the POUs that files replace.
        depth: How deep the library's first file lies in its folder.
    """

    parcel: Parcel
    parts: tuple[int, ...]
    options: Mapping[str, Any]
    replaced: tuple[str, ...] = ()
    depth: int = 0

    @classmethod
    def of(
        cls,
        program: Sequence[Path],
        options: Mapping[str, Any],
        demands: Sequence[Path] = (),
        stimulus: Path | None = None,
    ) -> CellsOf:
        """Read all files.

        Args:
            program: Files and folders of the program.
            options: Arguments of `Cell.build`.
            demands: As `Demands.load` takes them.
            stimulus: The same.

        Raises:
            InputError: one cannot be read.
        """
        lib = options.get("lib")
        lib_files = st_files(library_folder(lib)) if lib is not None else []
        if lib is not None and not lib_files:
            raise InputError(
                f"--lib {lib} has no ST file",
                hint="name the folder of the library; without --lib that of this package is taken",
            )
        replaced = {name: Path(file) for name, file in (options.get("replace") or {}).items()}
        robots = [
            Path(one) for one in several(options.get("robot")) if isinstance(one, (str, Path))
        ]
        groups: list[list[Path]] = [
            list(_with_projects(named_files(list(program)))),
            lib_files,
            list(replaced.values()),
            robots,
            list(demands),
            [] if stimulus is None else [stimulus],
        ]
        depth = len(lib_files[0].relative_to(Path(lib)).parts) if lib and lib_files else 0
        kept = {name: value for name, value in options.items() if name not in _FILES}
        parcel = Parcel.of(file for group in groups for file in group)
        return cls(parcel, tuple(map(len, groups)), kept, tuple(replaced), depth)

    def make(self) -> Cells:
        """Compile the program, in this process.

        Raises:
            InputError: anything wrong with sources or options.
        """
        with self.parcel.unpacked() as here:
            files = iter(here)
            program, lib, replaced, robots, demands, stimulus = (
                [next(files) for _ in range(number)] for number in self.parts
            )
            folder = lib[0].parents[self.depth - 1] if lib else None
            named = [one for one in program if not _is_beside(one, program)]
            try:
                bodies = dict(zip(self.replaced, replaced, strict=True))
                compiled = Compiled(
                    source_files(named, folder, bodies), self.options.get("engine", "auto")
                )
            except InputError as error:
                raise blame_lib(error, folder) from None
            size = self.options.get("size")
            configs = [make_robot(one, size=size, seed=0).config for one in robots]
            options = {name: value for name, value in self.options.items() if name != "engine"}
            if configs:
                options["robot"] = configs
            made = Demands.load(demands, stimulus[0] if stimulus else None)
            # The copies are gone when demands are asked: their errors name the user's files.
            homes = {
                str(file): home for file, (home, _, _) in zip(here, self.parcel.files, strict=True)
            }
            return Cells(compiled, options, made.at_home(homes))


def _with_projects(named: Sequence[Path]) -> Iterator[Path]:
    """The files, and what lies beside a project that consists of several."""
    yield from named
    for file in named:
        if file.suffix.lower() == ".plcproj":
            yield from (
                one for one in sorted(file.parent.rglob("*")) if one.is_file() and one != file
            )


def _is_beside(file: Path, every: Sequence[Path]) -> bool:
    projects = [one.parent for one in every if one.suffix.lower() == ".plcproj"]
    return file.suffix.lower() != ".plcproj" and any(one in file.parents for one in projects)


class Cells:
    """A compiled program with what its cells have in common.

    A cell is thousands of objects that refer to each other. Python's collector would let several
    of them wait, so it is asked for each; as long as this lives, it looks at nothing older.

    Args:
        compiled: The program.
        options: Arguments of `Cell.build` but the seed.
        demands: What is demanded of them.
    """

    def __init__(self, compiled: Compiled, options: Mapping[str, Any], demands: Demands) -> None:
        self.demands = demands
        self._compiled, self._options = compiled, dict(options)
        gc.freeze()
        weakref.finalize(self, gc.unfreeze)

    def cell(self, seed: int, **changes: Any) -> Cell:
        """A cell at its beginning; it ends the one before, whose memory is used again."""
        gc.collect()
        return Cell.build(self._compiled, **{**self._options, **changes}, seed=seed)

    @property
    def library(self) -> frozenset[str]:
        """What the library's files declare, in upper case."""
        _, files = self._compiled.files.users
        return frozenset().union(*map(declared_names, files))

    @property
    def notice(self) -> str:
        """A line about the engine."""
        return self._compiled.notice
