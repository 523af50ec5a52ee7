"""The cells of a campaign. Each worker compiles the program once and builds cell after cell."""

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
from rcx_harness.robot.config.programs import named_by
from rcx_harness.verify.storm.demands import Demands
from structured_text.errors import InputError
from structured_text.farm import Parcel
from structured_text.language.dialects import chosen
from structured_text.projects.needed import declared_names
from structured_text.projects.sources import is_ax, named_files, st_files

__all__ = ["Cells", "CellsOf"]

#: The options of `Cell.build` whose values are files.
_FILES = ("lib", "replace", "robot")


@dataclass(frozen=True)
class CellsOf:
    """The arguments from which a worker builds cells; they can be sent to another process.

    Attributes:
        parcel: The contents of all files.
        parts: The number of files of each group, in the order program, library, replacements,
            robots, demands, stimulus, files that the robot files name.
        options: Arguments of `Cell.build`, without files.
        replaced: The names of the POUs that files replace.
        depth: The number of path components of the library's first file below its folder.
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
        """Read all files, and return the arguments for the workers.

        `demands` and `stimulus` are the files for `Demands.load`.
        """
        lib = options.get("lib")
        lib_files = st_files(library_folder(lib)) if lib is not None else []
        if lib is not None and not lib_files:
            raise InputError(
                f"--lib {lib} has no ST file",
                hint="name a folder, or leave out --lib to use the library in this package",
            )
        replaced = {name: Path(file) for name, file in (options.get("replace") or {}).items()}
        robots = [
            Path(one) for one in several(options.get("robot")) if isinstance(one, (str, Path))
        ]
        named = named_files(list(program))
        groups: list[list[Path]] = [
            list(_with_projects(named)),
            lib_files,
            list(replaced.values()),
            robots,
            list(demands),
            [] if stimulus is None else [stimulus],
            [named for robot in robots for named in named_by(robot)],
        ]
        depth = len(lib_files[0].relative_to(Path(lib)).parts) if lib and lib_files else 0
        kept = {name: value for name, value in options.items() if name not in _FILES}
        # The copies are in another folder, perhaps on another computer.
        kept["dialect"] = kept.get("dialect") or chosen() or ("ax" if is_ax(named) else None)
        parcel = Parcel.of(file for group in groups for file in group)
        return cls(parcel, tuple(map(len, groups)), kept, tuple(replaced), depth)

    def make(self) -> Cells:
        """Compile the program in this process, and return the cells."""
        with self.parcel.unpacked() as here:
            files = iter(here)
            program, lib, replaced, robots, demands, stimulus, _ = (
                [next(files) for _ in range(number)] for number in self.parts
            )
            folder = lib[0].parents[self.depth - 1] if lib else None
            named = [one for one in program if not _is_beside(one, program)]
            try:
                bodies = dict(zip(self.replaced, replaced, strict=True))
                dialect, device = self.options.get("dialect"), self.options.get("device") or ""
                sources = source_files(named, folder, bodies, dialect, device)
                compiled = Compiled(sources, self.options.get("engine", "auto"))
            except InputError as error:
                raise blame_lib(error, folder) from None
            size = self.options.get("size")
            configs = [make_robot(one, size=size, seed=0).config for one in robots]
            options = {name: value for name, value in self.options.items() if name != "engine"}
            if configs:
                options["robot"] = configs
            made = Demands.load(demands, stimulus[0] if stimulus else None)
            # The copies are deleted before the demands are evaluated, so errors name
            # the user's files.
            homes = {
                str(file): home for file, (home, _, _) in zip(here, self.parcel.files, strict=True)
            }
            return Cells(compiled, options, made.at_home(homes))


def _with_projects(named: Sequence[Path]) -> Iterator[Path]:
    """Yield all files of the program. For a project of several files, yield its whole folder."""
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
    """A compiled program with the common settings of its cells.

    A cell consists of thousands of objects that refer to each other. The garbage collector would
    free several cells together and late, so `cell` calls it each time. While this object exists,
    the collector skips all older objects (`gc.freeze`).

    Args:
        options: Arguments of `Cell.build` without the seed.
    """

    def __init__(self, compiled: Compiled, options: Mapping[str, Any], demands: Demands) -> None:
        self.demands = demands
        self._compiled, self._options = compiled, dict(options)
        gc.freeze()
        weakref.finalize(self, gc.unfreeze)

    def cell(self, seed: int, **changes: Any) -> Cell:
        """Return a new cell.

        The new cell uses the memory of the previous cell, so the previous cell is invalid.
        """
        gc.collect()
        return Cell.build(self._compiled, **{**self._options, **changes}, seed=seed)

    @property
    def library(self) -> frozenset[str]:
        """Return the names that the library's files declare, in upper case."""
        _, files = self._compiled.files.users
        return frozenset().union(*map(declared_names, files))

    @property
    def notice(self) -> str:
        """Return a line about the engine of the cells, and the warnings about the sources."""
        return "\n".join(filter(None, (self._compiled.notice, *self._compiled.warned())))
