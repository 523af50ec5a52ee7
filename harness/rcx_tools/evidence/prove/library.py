"""The library for the proofs: its checked sources, and machines that call one of its blocks."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path as File
from typing import Any

import z3

from rcx_tools.evidence.prove.outline import OUTLINED, Outline
from rcx_tools.evidence.prove.summaries import SUMMARIES
from structured_text.errors import InputError
from structured_text.language import tree as t
from structured_text.language.load import checked
from structured_text.language.parser import parse
from structured_text.language.project import Project
from structured_text.language.syntax import Source
from structured_text.output.results import digest
from structured_text.prove.machine import Machine
from structured_text.prove.symbolic_memory import Path
from structured_text.prove.values import TIME_BITS, Value

__all__ = ["BLOCK", "IMAGE", "ROBOT", "Library", "Step", "milliseconds"]

#: Paths of the block instance and of the connected variables in a `Step`.
BLOCK: Path = ("B",)
ROBOT: Path = ("ROBOT",)
IMAGE: Path = ("IMAGE",)


def milliseconds(count: int) -> Any:
    """Return a TIME of `number` milliseconds as a term."""
    return z3.BitVecVal(count * 1_000_000, TIME_BITS)


@dataclass
class Step:
    """One call of a block from an arbitrary state.

    Attributes:
        machine: The machine with its memory after the call. `machine.assumptions` restricts the
            values.
        before: Memory before the call.
        called: Path of the instance of the block.
    """

    machine: Machine
    before: dict[Path, Value]
    called: Path

    def was(self, path: Path) -> Any:
        """Return the value of a scalar before the call, as a term."""
        return self.machine.term(path, self.before)

    def now(self, path: Path) -> Any:
        """Return the value of a scalar after the call, as a term."""
        return self.machine.term(path)


@dataclass(frozen=True)
class Library:
    """A copy of plc/lib.

    Attributes:
        folder: Folder of the copy.
        like: Another copy. Files that are equal in both copies are not parsed again.
    """

    folder: File
    like: File | None = None

    @cached_property
    def project(self) -> Project:
        """Return the checked sources of the library.

        Raises:
            InputError: the folder does not exist, or a source has an error.
        """
        sources = sorted(self.folder.rglob("*.st"))
        if not sources:
            there = "contains no .st file" if self.folder.is_dir() else "is not a folder"
            raise InputError(f"{self.folder} {there}", hint="name a copy of plc/lib")
        return checked(sources, self._parsed)

    def _parsed(self, file: File) -> Source:
        if self.like is not None:
            twin = self.like / file.relative_to(self.folder)
            if twin.is_file() and twin.read_bytes() == file.read_bytes():
                return replace(parse(twin), file=file)
        return parse(file)

    def complete(self, original: File) -> None:
        """Check that this copy has all blocks and functions of another copy.

        Raises:
            InputError: a block or function is missing; the message contains the first missing name.
        """
        names = sorted(file.stem for file in original.rglob("F[BC]_*.st"))
        lacking = [name for name in names if name.upper() not in self.project.pous]
        if lacking:
            more = f" and {len(lacking) - 1} more" if len(lacking) > 1 else ""
            raise InputError(
                f"{self.folder} has no {lacking[0]}{more}",
                hint="a copy of plc/lib must contain all its blocks",
            )

    @property
    def blocks(self) -> list[str]:
        """Return the names of all function blocks except those in core/, in upper case."""
        return [
            name
            for name, pou in self.project.pous.items()
            if pou.kind == "FUNCTION_BLOCK" and not name.startswith("FB_RCX")
        ]

    @property
    def pous(self) -> list[str]:
        """Return the names of all blocks and functions, in upper case."""
        return list(self.project.pous)

    def state(self, names: Iterable[str]) -> str:
        """Return a hash of the sources of these POUs.

        The hash includes all POUs that these use, and the types.
        """
        files = {self.project.pous[name].file for name in self.used(names)}
        wanted = [
            file for file in self.project.files if str(file) in files or file.parent.name == "types"
        ]
        return digest(self.folder, wanted)

    def used(self, names: Iterable[str]) -> set[str]:
        """Return these POUs and all POUs that they use, in upper case."""
        found: set[str] = set()
        waiting = list(names)
        while waiting:
            name = waiting.pop()
            if name not in found:
                found.add(name)
                waiting += self._uses[name]
        return found

    @cached_property
    def _uses(self) -> dict[str, list[str]]:
        """Map each POU to the POUs that its source names."""
        return {
            name: self.named(File(pou.file).read_text(encoding="utf-8"))
            for name, pou in self.project.pous.items()
        }

    def named(self, text: str) -> list[str]:
        """Return the POUs that a text names, in upper case."""
        words = {word.upper() for word in re.findall(r"\bF[BC]_\w+", text)}
        return sorted(words & set(self.project.pous))

    def in_file(self, file: str) -> set[str]:
        """Return the POUs in a file of the library.

        The path of the file is relative to the folder. For a file with a type the result is empty.
        """
        where = str(self.folder / file)
        return {name for name, pou in self.project.pous.items() if pou.file == where}

    def pou(self, name: str) -> t.Pou:
        """Return a block or function by its name in upper case."""
        return self.project.pous[name]

    def machine(self, *, summaries: bool = True) -> Machine:
        """Return a machine at an arbitrary time of operation. `now` is a variable of the solver."""
        return self._timed(Machine(self.project, SUMMARIES if summaries else None))

    def outline(self, name: str) -> Machine:
        """Return a machine in which a block can be called.

        For some blocks (`OUTLINED`), inner blocks are not executed but replaced by their
        guarantees.
        """
        return self._timed(Outline(self.project, SUMMARIES)) if name in OUTLINED else self.machine()

    def _timed(self, machine: Machine) -> Machine:
        machine.now = z3.BitVec("now", TIME_BITS)
        machine.assume(z3.And(machine.now >= 0, machine.now < 1 << 62))
        return machine

    def step(self, name: str, machine: Machine | None = None) -> Step:
        """Call a block once, from any state, with any pins and any connected variables.

        The instance is at `BLOCK`, each VAR_IN_OUT at its name in upper case (`ROBOT`, `IMAGE`).
        """
        machine = machine or self.machine()
        pou = self.pou(name)
        assert pou.block is not None
        machine.havoc(BLOCK, pou.block)
        in_outs = {}
        for symbol in pou.section("VAR_IN_OUT"):
            in_outs[symbol.name.upper()] = (symbol.name.upper(),)
            if (symbol.name.upper(),) not in {path[:1] for path in machine.snapshot()}:
                machine.havoc((symbol.name.upper(),), symbol.type)
        before = machine.snapshot()
        machine.call_block(BLOCK, pou.block.name, in_outs)
        return Step(machine, before, BLOCK)
