"""What a cell is made of: source files, library, robot and link, found and checked."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

from rcx_harness.cell.clock import Agenda, Timing
from rcx_harness.cell.link import DirectLink, Link
from rcx_harness.cell.node import Member
from rcx_harness.engine.needed import declared_names, needed
from rcx_harness.engine.projects import in_folder, is_project, project_sources
from rcx_harness.errors import InputError
from rcx_harness.output.exported import RECORD, own_output
from rcx_harness.robot import Controller, RobotConfig
from rcx_harness.spec import load_toml
from rcx_harness.spec.wire import check_size
from rcx_harness.trace import FORMAT
from rcx_harness.trace.view import BEGINNING

if TYPE_CHECKING:
    from rcx_harness.cell.elsewhere import Elsewhere

__all__ = [
    "INSTEAD",
    "Areas",
    "Files",
    "Robots",
    "SourceFiles",
    "blame_lib",
    "check_outputs",
    "default_lib",
    "make_agenda",
    "make_link",
    "make_members",
    "make_robot",
    "named_files",
    "not_declared",
    "several",
    "source_files",
    "st_files",
]

#: One file or folder, or several.
Files = str | Path | Sequence[str | Path]
#: Properties of a robot, or a file of them; or several.
Robots = RobotConfig | str | Path | None | Sequence[RobotConfig | str | Path]
#: Where the area of the robot begins, in bytes; or of several robots.
Areas = int | Sequence[int]

#: Files that are read instead of others, which are resolved: copies with a mistake in them
#: (`rcx mutants`).
INSTEAD: dict[Path, Path] = {}

_PACKAGE = Path(__file__).resolve().parents[1]
#: Folders of other tools, besides hidden ones: the ST files in them are not the user's.
_FOREIGN = ("__pycache__", "site-packages")
#: What a run writes: its name, and how every file of that kind begins.
_WRITTEN = {
    "trace": ("trace", f'{{"format":"{FORMAT.partition("/")[0]}/'),
    "chart": ("timing chart (SVG)", "<svg "),
    "vcd": ("wave file (VCD)", "$timescale"),
    "view": ("page of rcx view", BEGINNING),
}


@dataclass(frozen=True)
class SourceFiles:
    """The sources of a program: the user's own and those of the library.

    Attributes:
        own: ST files, and what was taken out of project files.
        lib: Those files of the library that they need.
        folder: Of the library.
        notes: What of a project is not read, a line each.
        declared: Names that projects declare, in upper case: not taken from the library.
    """

    own: tuple[Path, ...]
    lib: tuple[Path, ...]
    folder: Path
    notes: tuple[str, ...] = ()
    declared: frozenset[str] = frozenset()

    @property
    def all(self) -> list[Path]:
        """The user's first, so that of several errors one of theirs is told."""
        return [*self.own, *self.lib]

    @property
    def users(self) -> tuple[list[Path], list[Path]]:
        """The user's files, and those of the library, also where they are named one by one."""
        folder = self.folder.resolve()
        named = {file for file in self.own if folder in file.resolve().parents}
        return [file for file in self.own if file not in named], [*named, *self.lib]


def source_files(
    program: Files,
    lib: str | Path | None = None,
    replace: Mapping[str, str | Path] | None = None,
) -> SourceFiles:
    """Find the files of a program, and those of the library that it needs.

    Args:
        program: Files, also of projects (`engine.projects`), or folders whose `.st` files are
            taken, see `st_files`, or where there are none, whose TwinCAT project.
        lib: Folder of the library, searched with its subfolders; None for the one of this
            package. What a project declares itself is not taken from it.
        replace: Files with Structured Text for POUs of a project, by name.

    Raises:
        InputError: a file or folder that is missing, a folder without sources, or a project that
            cannot be read.
    """
    named = named_files(program)
    projects = [file for file in named if is_project(file)]
    if replace and not projects:
        raise InputError(
            "--replace is for projects of PLC tools, and none is given",
            hint="change the .st file itself",
        )
    made = project_sources(projects, {name: Path(file) for name, file in (replace or {}).items()})
    own = [*(file for file in named if file not in projects), *made.paths]
    folder = default_lib() if lib is None else Path(lib)
    if not folder.is_dir():
        raise InputError(
            f"--lib {folder} is no folder",
            hint="it is the folder of the library; without --lib that of this package is taken",
        )
    taken = {file.resolve() for file in own}
    found = [file for file in st_files(folder) if file.resolve() not in taken]
    found = not_declared(found, made.declared)
    own = list(dict.fromkeys(own))
    if INSTEAD:
        own = [INSTEAD.get(file.resolve(), file) for file in own]
    return SourceFiles(tuple(own), tuple(needed(own, found)), folder, made.notes, made.declared)


def named_files(program: Files) -> list[Path]:
    """The files that are named, and those of the folders that are.

    Raises:
        InputError: a file or folder that is missing, or a folder without sources.
    """
    given = [program] if isinstance(program, (str, Path)) else list(program)
    if not given:
        raise InputError("no program is given")
    return list(dict.fromkeys(file for entry in given for file in _expand(Path(entry))))


def not_declared(library: Sequence[Path], declared: frozenset[str]) -> list[Path]:
    """Files of the library without those whose names a project declares itself."""
    if not declared:
        return list(library)
    return [file for file in library if not declared_names(file) & declared]


def blame_lib(error: InputError, lib: str | Path | None) -> InputError:
    """An error in a program; where `--lib` lacks what this package's library has, it says so."""
    missing = re.match(r"there is no (?:type|function) (\w+)", error.message)
    if lib is None or missing is None or not any(default_lib().rglob(f"{missing[1]}.st")):
        return error
    return InputError(
        error.message,
        file=error.file,
        line=error.line,
        column=error.column,
        hint=f"--lib {lib} does not declare it; without --lib the library of this package is taken",
    )


def st_files(folder: Path) -> list[Path]:
    """The ST files of a folder and of those below it, sorted.

    Hidden files and folders (`.venv`, `.git`), `site-packages` and `__pycache__` below it are
    left out; the folder itself may be in one. So is what `rcx export` has written.
    """
    every = (file for file in folder.rglob("*.st") if _is_users(file, folder))
    found = sorted(every, key=lambda file: file.parts)  # as on Linux also where case is nothing
    written = own_output(found)
    return [file for file in found if file not in written]


def _is_users(file: Path, folder: Path) -> bool:
    """Is this file below the folder one of the user's, and not of another tool?"""
    parts = file.relative_to(folder).parts
    return not any(part.startswith(".") or part in _FOREIGN for part in parts)


def check_outputs(
    outputs: Mapping[str, str | Path | None], files: SourceFiles | None, *inputs: object
) -> None:
    """Refuse to write over what is read, twice to the same file, or over what is not a run's.

    Args:
        outputs: Where to write, by kind: `trace`, `chart`, `vcd`, `view`; None for nothing.
        files: The ST files that are read, if there are any.
        inputs: What else is read; entries that are no paths do not count.

    Raises:
        InputError: an output that is an input, two outputs that are one file, or a file that no
            run has written.
    """
    read = {file.resolve() for file in files.all} if files else set()
    read |= {Path(entry).resolve() for entry in inputs if isinstance(entry, (str, Path))}
    written: set[Path] = set()
    for kind, output in outputs.items():
        if output is None:
            continue
        place = Path(output).resolve()
        if place in read:
            raise InputError("would be overwritten, but it is an input", file=output)
        if place in written:
            raise InputError("is named for two outputs", file=output)
        if place.is_dir():
            raise InputError("is a folder, not a file", file=output)
        _check_earlier(kind, output)
        written.add(place)


def _check_earlier(kind: str, output: str | Path) -> None:
    """A file that is there must be empty, or what an earlier run has written there."""
    if not os.path.isfile(output):  # not there, or a device
        return
    name, beginning = _WRITTEN[kind]
    try:
        with open(output, "rb") as file:
            found = file.read(len(beginning))
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", file=output) from None
    if found and found != beginning.encode("ascii"):
        raise InputError(
            f"is there already, and is no {name}; nothing was written",
            file=output,
            hint="name another file, or remove this one",
        )


def make_robot(
    robot: RobotConfig | str | Path | None, *, size: int | None, seed: int
) -> Controller:
    """A controller from its properties, or from a file of them.

    A size that is not said of the robot is that of the PLC's areas.

    Raises:
        InputError: the file cannot be read or is wrong, or no area has this size.
    """
    if size is not None:
        check_size(size)
    if isinstance(robot, RobotConfig):
        config = robot
    elif robot is None:
        config = RobotConfig() if size is None else RobotConfig(size=size)
    else:
        config = RobotConfig.load(robot)
        if size is not None and "size" not in load_toml(Path(robot)):
            config = replace(config, size=size)
    return Controller(config, seed=seed)


def several(robots: Robots) -> Sequence[RobotConfig | str | Path | None]:
    """The robots one by one, also where there is but one."""
    if robots is None or isinstance(robots, (RobotConfig, str, Path)):
        return [robots]
    return robots


def make_members(
    robots: Robots,
    link: str,
    *,
    size: int | None,
    m: Areas,
    n: Areas,
    timing: Timing,
    seed: int,
    connect: Elsewhere | None = None,
) -> list[Member]:
    """The controllers of a cell, each with its link and its areas.

    Raises:
        InputError: as `make_robot` and `make_link`; areas that overlap, or more than robots;
            properties of a controller that runs elsewhere.
    """
    if connect is not None:
        from rcx_harness.cell.elsewhere import FarLink

        if robots is not None:
            hint = "leave its properties out"
            raise InputError("a controller elsewhere is what it is", hint=hint)
        stand_in = make_robot(None, size=size, seed=seed)
        area = stand_in.config.size
        (begin_m,), (begin_n,) = _begins("m", m, [area]), _begins("n", n, [area])
        return [Member(stand_in, FarLink(area, timing, connect), begin_m, begin_n, far=True)]
    given = several(robots)
    if not given:
        raise InputError("no robot is given")
    if len(given) > 1 and link == "enip-realtime":
        raise InputError("in real time a cell has one robot", hint="run it without --realtime")
    made = [make_robot(one, size=size, seed=seed + k) for k, one in enumerate(given)]
    sizes = [one.config.size if size is None else size for one in made]
    places = zip(made, sizes, _begins("m", m, sizes), _begins("n", n, sizes), strict=True)
    members: list[Member] = []
    try:
        for one, area, begin_m, begin_n in places:
            members.append(Member(one, make_link(link, area, timing), begin_m, begin_n))
    except BaseException:
        for member in members:
            member.link.close()
        raise
    return members


def _begins(name: str, given: Areas, sizes: Sequence[int]) -> list[int]:
    """Where each robot's area begins: as given, the others behind the one before."""
    begins = [given] if isinstance(given, int) else list(given) or [0]
    if len(begins) > len(sizes):
        raise InputError(f"{len(begins)} offsets {name}, but {len(sizes)} robot(s)")
    while len(begins) < len(sizes):
        begins.append(begins[-1] + sizes[len(begins) - 1])
    for (one, size), (other, _) in pairwise(sorted(zip(begins, sizes, strict=True))):
        if one + size > other:
            raise InputError(
                f"the areas at {name} = {one} and {name} = {other} overlap",
                hint=f"the first of them has {size} bytes",
            )
    return begins


def make_agenda(link: str, connect: Elsewhere | None = None) -> Agenda:
    """The agenda of a cell with this link: at the pace of the clock where its packets are."""
    if link != "enip-realtime" and connect is None:
        return Agenda()
    from rcx_harness.cell.live import RealTimeAgenda

    return RealTimeAgenda()


def make_link(name: str, size: int, timing: Timing) -> Link:
    """The link called `"direct"`, `"enip"` or `"enip-realtime"`.

    Raises:
        InputError: no such link.
    """
    if name == "direct":
        return DirectLink(size)
    if name == "enip":
        from rcx_harness.enip import LockstepLink  # the network only when it is asked for

        return LockstepLink(size)
    if name == "enip-realtime":
        from rcx_harness.cell.live import RealTimeLink

        return RealTimeLink(size, timing)
    raise InputError(f"unknown link {name!r}", hint="use direct or enip")


def _expand(path: Path) -> list[Path]:
    if path.is_dir():
        found = st_files(path) or _project_in(path)
        if not found:
            written = any(path.rglob("*.st"))
            hint = (
                "one that `rcx export` has written is taken if you name the file" if written else ""
            )
            raise InputError("no .st files in this folder", file=path, hint=hint)
        return found
    if not path.is_file():
        raise InputError("no such file", file=path)
    return [path]


def _project_in(folder: Path) -> list[Path]:
    """A TwinCAT project in a folder; one that `rcx export` has written only in its own folder."""
    found = in_folder(file for file in folder.rglob("*") if _is_users(file, folder))
    written = own_output(found) if found else set()
    whole = (folder / RECORD).is_file()
    return [file for file in found if whole or file not in written]


def default_lib() -> Path:
    """The repository's `plc/lib`, or the copy in an installed package."""
    repository = _PACKAGE.parents[1] / "plc" / "lib"
    return repository if repository.is_dir() else _PACKAGE / "_data" / "plc" / "lib"
