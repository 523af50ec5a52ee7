"""A whole program in terms of the solver: its start, its external inputs, and its scans."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import z3

from structured_text.engines.builtin.storage import address_slot, is_scalar, stored
from structured_text.language import tree as t
from structured_text.language.paths import resolve
from structured_text.language.project import Project
from structured_text.language.scalars import ANY_DURATION, WIDTH
from structured_text.language.types import BlockType, ElementaryType, EnumType, Type
from structured_text.language.walk import written
from structured_text.prove import values
from structured_text.prove.machine import Machine
from structured_text.prove.program import ProgramMachine
from structured_text.prove.symbolic_memory import Path

__all__ = ["Given", "Input", "Surroundings", "path_of"]


@dataclass(frozen=True)
class Input:
    """A variable that may be set from outside before each scan; `name` is its path."""

    name: str
    path: Path
    type: Type
    initial: Any = None

    @property
    def searched(self) -> bool:
        """Return whether a stimulus can set the input to every value that the solver may choose."""
        if isinstance(self.type, EnumType):
            return True
        name = self.type.name if isinstance(self.type, ElementaryType) else ""
        return name == "BOOL" or name in ANY_DURATION or name in WIDTH


@dataclass(frozen=True)
class Given:
    """The input before a scan, as terms: bytes and status of each device, and input variables."""

    areas: dict[int, tuple[list[Any], Any]]
    inputs: dict[str, Any]


class Surroundings:
    """A project's programs with all inputs that may change from outside.

    This class is a program without a process image: only its inputs change. A derived class sets
    more in `give_areas`; its `held` returns the memory paths that `give_areas` sets.

    Attributes:
        inputs: Variables that no program writes, for example those of a panel or a scanner.
        linked: The connection status of each device, by the number of the device, as paths in the
            memory.
    """

    def __init__(self, project: Project) -> None:
        self.project = project
        self.linked: dict[int, Path] = {}
        self.writes = {
            name: written(pou)
            for name, pou in project.pous.items()
            if pou.kind in ("PROGRAM", "FUNCTION_BLOCK")
        }
        held = set(self.held())
        self.inputs = [one for one in self._inputs() if one.path not in held]

    def held(self) -> Iterator[Path]:
        """Yield the memory paths that `give_areas` sets; these are not inputs."""
        return iter(())

    def give_areas(self, machine: Machine, number: int) -> dict[int, tuple[list[Any], Any]]:
        """Write the data of each device into the process image before a scan.

        Returns:
            The bytes of each device and its connection status as terms, by the number of the
            device. The names of the terms begin with `area.` and `connected.`, followed by the
            device's number.
        """
        del machine, number
        return {}

    def byte_name(self, number: str) -> str:
        """Return the name of a byte of an area for reports."""
        return f"byte {number}"

    def _inputs(self) -> Iterator[Input]:
        everywhere = set().union(*self.writes.values())
        for instance, block in self.project.instances.items():
            pou = self.project.pous[block.name.upper()]
            for symbol in pou.symbols.values():
                own = symbol.section in ("VAR", "VAR_INPUT") and not symbol.constant
                key = symbol.name.upper()
                if not own or key in self.writes[pou.name.upper()]:
                    continue
                if symbol.address is not None and symbol.address.upper() in everywhere:
                    continue
                if not isinstance(symbol.type, BlockType):
                    name = f"{instance}.{symbol.name}"
                    yield Input(name, path_of(self.project, name)[0], symbol.type, symbol.initial)
        for symbol in self.project.global_symbols.values():
            key = symbol.address.upper() if symbol.address else symbol.name.upper()
            if not symbol.constant and key not in everywhere and is_scalar(symbol.type):
                place, _ = path_of(self.project, symbol.name)
                yield Input(symbol.name, place, symbol.type, symbol.initial)

    # --- memory ---

    def start(self, machine: Machine) -> None:
        """Create all variables with their initial values."""
        for path, symbol in self.roots():
            machine.create(path, symbol.type, symbol.initial)

    def anything(self, machine: Machine) -> None:
        """Create an arbitrary state: every variable that is not constant may have any value."""
        for path, symbol in self.roots():
            if symbol.constant:
                machine.create(path, symbol.type, symbol.initial)
            else:
                machine.havoc(path, symbol.type)

    def roots(self) -> Iterator[tuple[Path, t.Symbol]]:
        """Yield program variables, global variables and located variables with memory paths."""
        for symbol in self.project.global_symbols.values():
            slot = address_slot(symbol.address) if symbol.address else symbol.name.upper()
            yield ("", slot), symbol
        for pou in self.project.pous.values():
            for symbol in pou.symbols.values():
                if symbol.address is not None:
                    yield ("", address_slot(symbol.address)), symbol
        for instance, block in self.project.instances.items():
            for symbol in stored(self.project.pous[block.name.upper()].symbols.values()):
                yield (instance.upper(), symbol.name.upper()), symbol

    # --- scans ---

    def give(self, machine: Machine, number: int, *, everything: bool = False) -> Given:
        """Set the inputs to arbitrary values before a scan.

        A stimulus cannot set inputs of the types REAL, STRING and array to a value that the solver
        chooses. They stay unchanged, or are arbitrary if `everything` is True.
        """
        areas = self.give_areas(machine, number)
        inputs: dict[str, Any] = {}
        for one in self.inputs:
            if one.searched:
                value = values.anything(one.type, f"{one.name}.{number}")
                # Whole milliseconds, as in a stimulus file.
                if values.is_duration(one.type) and not everything:
                    whole = z3.BitVec(f"{one.name}.{number}", 32)
                    value = z3.ZeroExt(values.TIME_BITS - 32, whole) * 1_000_000
                inputs[one.name] = value
                legal = values.legal(one.type, inputs[one.name])
                machine.assume(legal)
                machine[one.path] = inputs[one.name]
            elif everything:
                machine.havoc(one.path, one.type)
        return Given(areas, inputs)

    def scan(self, machine: ProgramMachine, number: int) -> None:
        """Run the scan with this number; the records of the machine then belong to this scan."""
        machine.calls.clear()
        machine.own.clear()
        machine.obligations.clear()
        machine.operations.clear()
        for run in self.project.schedule:
            if number % run.every == 0:
                kind = self.project.instances[run.instance]
                machine.call_block((run.instance.upper(),), kind.name, {})


def path_of(project: Project, name: str) -> tuple[Path, Type]:
    """Return the memory path and the type of a variable such as `Main.Stage`."""
    found = resolve(project, name)
    if found.address is not None:
        inside = (step.upper() if isinstance(step, str) else step for step in found.inside)
        return ("", address_slot(found.address), *inside), found.type
    steps = tuple(step.upper() if isinstance(step, str) else step for step in found.steps)
    root = ("", found.root.upper()) if found.is_global else (found.root.upper(),)
    return (*root, *steps), found.type
