"""A whole program on terms: where it starts, what its surroundings may do to it, and its scans."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import z3

from rcx_harness.cell.image import Image, Slot, find_image
from rcx_harness.spec.wire import SIZE
from rcx_harness.watch.image_source import reads_located
from structured_text.engines.builtin import BuiltinProgram
from structured_text.engines.builtin.storage import address_slot, is_scalar, stored
from structured_text.language import tree as t
from structured_text.language.paths import resolve
from structured_text.language.project import Project
from structured_text.language.scalars import ANY_DURATION, WIDTH
from structured_text.language.types import BlockType, ElementaryType, EnumType, Type
from structured_text.prove import reals, values
from structured_text.prove.logic import UnsupportedError
from structured_text.prove.machine import Machine, Path
from structured_text.prove.program import ProgramMachine
from structured_text.prove.tree import calls_of, written

__all__ = ["Area", "Given", "Input", "Surroundings", "path_of"]


@dataclass(frozen=True)
class Area:
    """One controller's area in the inputs, and the variable with its scanner's status, if any."""

    controller: int
    size: int
    m: int
    n: int
    image: Image
    status: Path | None


@dataclass(frozen=True)
class Input:
    """A variable that the surroundings may set before each scan: its name is its path in a cell."""

    name: str
    path: Path
    type: Type
    initial: Any = None

    @property
    def searched(self) -> bool:
        """A stimulus can set it to any value that the solver chooses."""
        if isinstance(self.type, EnumType):
            return True
        name = self.type.name if isinstance(self.type, ElementaryType) else ""
        return name == "BOOL" or name in ANY_DURATION or name in WIDTH


@dataclass(frozen=True)
class Given:
    """What the surroundings do before a scan, as terms: bytes and status of each area, inputs."""

    areas: dict[int, tuple[list[Any], Any]]
    inputs: dict[str, Any]


class Surroundings:
    """The program of a project with all that may happen to it from outside.

    Args:
        project: The sources, with the programs that run.

    Attributes:
        areas: The input area of each controller.
        inputs: Variables that no program writes: those of the panel, of the scanner, of others.

    Raises:
        InputError: the program has no process image.
    """

    def __init__(self, project: Project) -> None:
        self.project = project
        self.writes = {
            name: written(pou)
            for name, pou in project.pous.items()
            if pou.kind in ("PROGRAM", "FUNCTION_BLOCK")
        }
        program, located = BuiltinProgram.build(project), reads_located(project)
        self.areas = [
            Area(
                number,
                size,
                m,
                n,
                find_image(program, size=size, m=m, n=n, located=located),
                self._status(number),
            )
            for number, (size, m, n) in enumerate(_places(project), 1)
        ]
        held = {path for area in self.areas for path in self._held(area)}
        self.inputs = [one for one in self._inputs() if one.path not in held]

    def _held(self, area: Area) -> Iterator[Path]:
        """What is the scanner's own."""
        for slot in area.image.slots:
            path, _ = path_of(self.project, slot.path.partition("[")[0])
            yield path
        if area.image.life_path:
            yield path_of(self.project, area.image.life_path)[0]
        if area.status is not None:
            yield area.status

    def _status(self, number: int) -> Path | None:
        """As a cell finds it: `Main.Connected`, `Main.Connected2` of the second controller."""
        wanted = "CONNECTED" if number == 1 else f"CONNECTED{number}"
        for name, block in self.project.instances.items():
            for variable in block.variables:
                if variable.name.upper() == wanted and variable.type == ElementaryType("BOOL"):
                    return path_of(self.project, f"{name}.{variable.name}")[0]
        return None

    def _inputs(self) -> Iterator[Input]:
        everywhere = set().union(*self.writes.values())
        for instance, block in self.project.instances.items():
            pou = self.project.pous[block.name.upper()]
            for symbol in pou.symbols.values():
                own = symbol.section in ("VAR", "VAR_INPUT") and not symbol.constant
                key = symbol.name.upper()
                if not own or key == "OUTPUTAREA" or key in self.writes[pou.name.upper()]:
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
        """Everything with its initial value."""
        for path, symbol in self.roots():
            machine.create(path, symbol.type, symbol.initial)

    def anything(self, machine: Machine) -> None:
        """Any state: all that can change may be anything."""
        for path, symbol in self.roots():
            if symbol.constant:
                machine.create(path, symbol.type, symbol.initial)
            else:
                machine.havoc(path, symbol.type)

    def roots(self) -> Iterator[tuple[Path, t.Symbol]]:
        """Yield the variables of the programs, global and located ones, each with its place."""
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
        """Let the surroundings do what they may before a scan.

        Inputs that no stimulus can set to what the solver chooses (REAL, STRING, arrays) stay as
        they are, or are anything where `everything` is to be thought of.
        """
        areas = {}
        for area in self.areas:
            name = f"{area.controller}.{number}"
            content = [z3.BitVec(f"area.{name}.{k}", 8) for k in range(area.size)]
            connected = z3.Bool(f"connected.{name}")
            self._put(machine, area, content, connected)
            areas[area.controller] = (content, connected)
        inputs: dict[str, Any] = {}
        for one in self.inputs:
            if one.searched:
                value = values.anything(one.type, f"{one.name}.{number}")
                if values.is_duration(one.type) and not everything:  # as a file writes it
                    whole = z3.BitVec(f"{one.name}.{number}", 32)
                    value = z3.ZeroExt(values.TIME_BITS - 32, whole) * 1_000_000
                inputs[one.name] = value
                legal = values.legal(one.type, inputs[one.name])
                machine.assume(legal)
                machine[one.path] = inputs[one.name]
            elif everything:
                machine.havoc(one.path, one.type)
        return Given(areas, inputs)

    def _put(self, machine: Machine, area: Area, content: list[Any], connected: Any) -> None:
        image = area.image
        if area.status is not None:
            machine[area.status] = connected
        if image.bridged:
            content = [z3.If(connected, byte, z3.BitVecVal(0, 8)) for byte in content]
        if image.life_path:
            path, kind = path_of(self.project, image.life_path)
            life = z3.ZeroExt(16, machine.term(path))
            following = z3.Extract(15, 0, z3.URem(life, z3.BitVecVal(0xFFFF, 32)) + 1)
            machine[path] = z3.If(connected, following, z3.BitVecVal(0, values.bits(kind)))
        for slot in image.slots:
            self._write(machine, slot, content)

    def _write(self, machine: Machine, slot: Slot, content: list[Any]) -> None:
        if slot.width == 0:
            machine[path_of(self.project, slot.path)[0]] = (
                z3.Extract(slot.bit, slot.bit, content[slot.start]) == 1
            )
            return
        parts = content[slot.start : slot.start + slot.width]
        value = parts[0] if len(parts) == 1 else z3.Concat(*reversed(parts))
        path, kind = path_of(self.project, slot.path)
        if path not in machine:  # an element of a long array
            machine[path[:-1]] = z3.Store(machine[path[:-1]], path[-1], value)
        elif slot.kind == "REAL":
            machine[path] = reals.Real(value)
        elif values.bits(kind) == value.size():
            machine[path] = value
        else:
            raise UnsupportedError(f"{slot.path}: a {slot.kind} in the process image")

    def scan(self, machine: ProgramMachine, number: int) -> None:
        """Run the scan with this number; what a machine has noted is then of this scan."""
        machine.calls.clear()
        machine.own.clear()
        machine.obligations.clear()
        machine.operations.clear()
        for run in self.project.schedule:
            if number % run.every == 0:
                kind = self.project.instances[run.instance]
                machine.call_block((run.instance.upper(),), kind.name, {})


def _places(project: Project) -> list[tuple[int, int, int]]:
    """Size, m and n of each controller, as the calls of FB_ReadArea and FB_WriteArea say."""
    found: dict[str, list[tuple[int, int]]] = {"READ": [], "WRITE": []}
    for pou in project.pous.values():
        for call in calls_of(pou.body):
            for kind, pin in (("READ", "M"), ("WRITE", "N")):
                if call.block.name.upper() in (f"FB_{kind}AREA", f"FB_{kind}AREAWORDS"):
                    found[kind].append((_pin(call, "SIZE", SIZE), _pin(call, pin, 0)))
    pairs = list(zip(found["READ"], found["WRITE"], strict=False))
    # A second call for the same area is no second controller.
    places = {m: (size, m, n) for (size, m), (_, n) in reversed(pairs)}
    return list(reversed(places.values())) or [(SIZE, 0, 0)]


def _pin(call: t.CallBlock, name: str, default: int) -> int:
    for pin, value in call.inputs:
        if pin.upper() == name:
            return int(value.value) if isinstance(value, t.Constant) else default
    return default


def path_of(project: Project, name: str) -> tuple[Path, Type]:
    """Where a machine has what a cell calls `Main.Stage`."""
    found = resolve(project, name)
    if found.address is not None:
        inside = (step.upper() if isinstance(step, str) else step for step in found.inside)
        return ("", address_slot(found.address), *inside), found.type
    steps = tuple(step.upper() if isinstance(step, str) else step for step in found.steps)
    root = ("", found.root.upper()) if found.is_global else (found.root.upper(),)
    return (*root, *steps), found.type
