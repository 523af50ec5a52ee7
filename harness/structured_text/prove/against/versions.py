"""The two versions of a program: what they have in common, and what counts as their outputs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase

from structured_text.errors import InputError
from structured_text.language import tree as t
from structured_text.language.project import Project
from structured_text.language.source import source_text
from structured_text.language.types import ArrayType, BlockType, StructType, Type
from structured_text.prove.surroundings import Input, Surroundings, path_of
from structured_text.prove.symbolic_memory import Path

__all__ = ["Pair", "SharedInput", "Version", "alike", "outputs_of", "unchanged"]


@dataclass(frozen=True)
class Version:
    """A version of the program: its title for messages, its sources and its surroundings.

    `own` holds the names of the user's own files.
    """

    title: str
    project: Project
    around: Surroundings
    own: frozenset[str]

    @property
    def library(self) -> frozenset[str]:
        """Return the files of the library."""
        pous = self.project.pous.values()
        return frozenset(pou.file for pou in pous if pou.file not in self.own)


@dataclass(frozen=True)
class SharedInput:
    """An input of the pair.

    Attributes:
        name: Its path in the program.
        inputs: The input in the old and in the new version; None if a version does not have the
            variable.
        steady: Whether a value may be given in each scan. Otherwise the variable keeps its value
            in scans in which it is not set, because its first values differ, or because a version
            writes it.
    """

    name: str
    inputs: tuple[Input | None, Input | None]
    steady: bool

    @property
    def any(self) -> Input:
        """Return the input in a version that has it."""
        found = self.inputs[0] or self.inputs[1]
        assert found is not None
        return found


@dataclass(frozen=True)
class Pair:
    """Two versions of a program, the old one first.

    Attributes:
        versions: The old and the new version.
        outputs: The names of the outputs that count, each with its path in both versions.
        related: Variables of the new version that the user relates to a variable of the old
            version, as paths.
    """

    versions: tuple[Version, Version]
    outputs: dict[str, Path]
    related: dict[Path, Path] = field(default_factory=dict)

    def inputs(self) -> list[SharedInput]:
        """Return the inputs of both versions, by name.

        A variable that only one version writes is an input of both, since it may be set from
        outside for the other one.
        """
        old, new = ({one.name.upper(): one for one in v.around.inputs} for v in self.versions)
        found = []
        for key in dict.fromkeys([*old, *new]):
            known = old.get(key) or new[key]
            sides = tuple(
                of.get(key) or _declared(version, known)
                for of, version in zip((old, new), self.versions, strict=True)
            )
            first, second = sides
            if first and second and not alike(first.type, second.type):
                raise InputError(
                    f"{known.name} is an input with another type in the old version",
                    hint="give it the same type in both versions",
                )
            steady = (
                (first is None or key in old)
                and (second is None or key in new)
                and (first is None or second is None or first.initial == second.initial)
            )
            found.append(SharedInput(known.name, (first, second), steady))
        return found

    def old_path(self, path: Path) -> Path:
        """Return the path in the old version that a path of the new version is related to."""
        for length in range(len(path), 1, -1):
            if path[:length] in self.related:
                return (*self.related[path[:length]], *path[length:])
        return path


def _declared(version: Version, known: Input) -> Input | None:
    """Return a variable of a version that is an input of the other version."""
    try:
        path, kind = path_of(version.project, known.name)
    except InputError:
        return None
    for root, symbol in version.around.roots():
        if root == path:
            return None if symbol.constant else Input(known.name, path, kind, symbol.initial)
    return None


def alike(one: Type, other: Type) -> bool:
    """Return whether two types of different projects are the same; blocks are, if the name is."""
    if isinstance(one, ArrayType) and isinstance(other, ArrayType):
        return one.bounds == other.bounds and alike(one.element, other.element)
    if isinstance(one, StructType) and isinstance(other, StructType):
        fields, others = dict(one.fields), dict(other.fields)
        return list(fields) == list(others) and all(
            alike(kind, others[name]) for name, kind in fields.items()
        )
    if isinstance(one, BlockType) and isinstance(other, BlockType):
        return one.name.upper() == other.name.upper()
    return one == other


def unchanged(old: Version, new: Version) -> frozenset[str]:
    """Return the blocks and functions of the library that are the same in both versions.

    They do not use global variables, and neither do the blocks and functions that they call.
    """
    texts: dict[str, str] = {}

    def text(file: str) -> str:
        if file not in texts:
            paths = [one for v in (old, new) for one in v.project.files if str(one) == file]
            texts[file] = source_text(paths[0]) if paths else file
        return texts[file]

    good: set[str] = set()
    for name, pou in new.project.pous.items():
        before = old.project.pous.get(name)
        if before is None or pou.file not in new.library or before.file not in old.library:
            continue
        if before.file != pou.file and text(before.file) != text(pou.file):
            continue
        if any(s.section == "VAR_EXTERNAL" or s.address is not None for s in pou.symbols.values()):
            continue
        if list(before.symbols) != list(pou.symbols) or not all(
            alike(before.symbols[key].type, symbol.type) for key, symbol in pou.symbols.items()
        ):
            continue
        known = new.project.pous
        # POUs come after those that they call, so these are decided already.
        if all(called in good for called in {*pou.calls, *_blocks(pou)} if called in known):
            good.add(name)
    return frozenset(good)


def _blocks(pou: t.Pou) -> Iterator[str]:
    """Yield the names of the blocks that a POU declares, in upper case."""
    for symbol in pou.symbols.values():
        kind = symbol.type
        while isinstance(kind, ArrayType):
            kind = kind.element
        if isinstance(kind, BlockType):
            yield kind.name.upper()


def outputs_of(
    old: Version,
    new: Version,
    images: Sequence[str],
    wanted: Sequence[str],
    without: Sequence[str],
) -> dict[str, Path]:
    """Return the outputs that count, with their paths.

    Args:
        old: The old version.
        new: The new version.
        images: The variables of the process image that the programs write.
        wanted: Names that the user wants, with `*`; empty: the outputs of the programs.
        without: Names that do not count, with `*`.

    Raises:
        InputError: A name does not exist, or an output is missing in a version.
    """
    known = [dict(_variables(one)) for one in (old, new)]
    every = {**known[0], **known[1]}
    for pattern in [*wanted, *without]:
        if not any(_matches(name, pattern) for name in every):
            option = "--output" if pattern in wanted else "--except"
            raise InputError(
                f"{option} {pattern}: no variable of the programs has this name",
                hint="write a path such as Main.Lamp, or a pattern such as Main.*",
            )
    if wanted:
        names = [name for name in every if any(_matches(name, one) for one in wanted)]
    else:
        named = {name.upper() for name in images}
        names = [name for name, output in every.items() if output or name.upper() in named]
    names = [name for name in names if not any(_matches(name, one) for one in without)]
    if not names:
        raise InputError(
            "the programs have no output to compare: no VAR_OUTPUT, no %Q, no process image",
            hint='name the variables that count, such as --output "Main.*"',
        )
    for version, of in zip((old, new), known, strict=True):
        upper = {name.upper() for name in of}
        missing = [name for name in names if name.upper() not in upper]
        if missing:
            raise InputError(
                f"{missing[0]} counts as an output, but the {version.title} version does not "
                "have it",
                hint=f"leave it out with --except {missing[0]}",
            )
    found: dict[str, Path] = {}
    for name in names:
        (path, kind), (other, second) = (path_of(one.project, name) for one in (new, old))
        if not alike(kind, second) or path != other:
            raise InputError(
                f"{name} counts as an output, but the versions declare it with different types",
                hint=f"leave it out with --except {name}",
            )
        found[name] = path
    return found


def _matches(name: str, pattern: str) -> bool:
    return fnmatchcase(name.upper(), pattern.upper())


def _variables(version: Version) -> Iterator[tuple[str, bool]]:
    """Yield the variables of the programs and the globals, and whether each is an output."""
    project = version.project
    for instance, block in project.instances.items():
        for symbol in project.pous[block.name.upper()].symbols.values():
            own = symbol.section in ("VAR", "VAR_INPUT", "VAR_OUTPUT")
            if own and not symbol.constant and not isinstance(symbol.type, BlockType):
                located = (symbol.address or "").upper().startswith("%Q")
                yield f"{instance}.{symbol.name}", symbol.section == "VAR_OUTPUT" or located
    for symbol in project.global_symbols.values():
        if not symbol.constant and not isinstance(symbol.type, BlockType):
            yield symbol.name, (symbol.address or "").upper().startswith("%Q")
