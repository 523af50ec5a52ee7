"""The surroundings of a program in a cell for proofs: controller areas and their scanner."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import z3

from rcx_harness.cell.image import Image, Slot, find_image
from rcx_harness.spec.wire import SIZE
from rcx_harness.watch.image_source import reads_located
from structured_text.engines.builtin import BuiltinProgram
from structured_text.language import tree as t
from structured_text.language.project import Project
from structured_text.language.types import ElementaryType
from structured_text.language.walk import calls_of
from structured_text.prove import reals, values
from structured_text.prove.logic import UnsupportedError
from structured_text.prove.machine import Machine
from structured_text.prove.surroundings import Surroundings, path_of
from structured_text.prove.symbolic_memory import Path

__all__ = ["Area", "CellSurroundings"]


@dataclass(frozen=True)
class Area:
    """The input area of one controller, and the variable with the link status if there is one."""

    controller: int
    size: int
    m: int
    n: int
    image: Image
    status: Path | None


class CellSurroundings(Surroundings):
    """The controllers around a program in a proof. Their areas and link states are free."""

    def __init__(self, project: Project) -> None:
        program, located = BuiltinProgram.build(project), reads_located(project)
        self.areas = [
            Area(
                number,
                size,
                m,
                n,
                find_image(program, size=size, m=m, n=n, located=located),
                _status(project, number),
            )
            for number, (size, m, n) in enumerate(_places(project), 1)
        ]
        super().__init__(project)
        self.linked = {one.controller: one.status for one in self.areas if one.status}

    def held(self) -> Iterator[Path]:
        """Yield the variables that the scanner writes, and the output area."""
        for area in self.areas:
            yield from self._held(area)
        for instance in self.project.instances:
            yield (instance.upper(), "OUTPUTAREA")

    def give_areas(self, machine: Machine, number: int) -> dict[int, tuple[list[Any], Any]]:
        """Write arbitrary content of each controller's area into the process image."""
        areas = {}
        # Each byte of an area and each link state is a new free variable of the solver. A
        # proof then holds for every behaviour of the controllers.
        for area in self.areas:
            name = f"{area.controller}.{number}"
            content = [z3.BitVec(f"area.{name}.{k}", 8) for k in range(area.size)]
            connected = z3.Bool(f"connected.{name}")
            self._put(machine, area, content, connected)
            areas[area.controller] = (content, connected)
        return areas

    def byte_name(self, number: str) -> str:
        """Return the manual's name of a byte of an area."""
        return f"byte m+{number}"

    def _held(self, area: Area) -> Iterator[Path]:
        """Yield the variables of one controller that the scanner writes."""
        for slot in area.image.slots:
            path, _ = path_of(self.project, slot.path.partition("[")[0])
            yield path
        if area.image.life_path:
            yield path_of(self.project, area.image.life_path)[0]
        if area.status is not None:
            yield area.status

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
        if path not in machine:  # elements of a long array are not in `machine`
            machine[path[:-1]] = z3.Store(machine[path[:-1]], path[-1], value)
        elif slot.kind == "REAL":
            machine[path] = reals.Real(value)
        elif values.bits(kind) == value.size():
            machine[path] = value
        else:
            raise UnsupportedError(
                f"{slot.path}: {slot.kind} in the process image is not supported"
            )


def _status(project: Project, number: int) -> Path | None:
    """Return the variable with the link status, such as `Main.Connected`."""
    wanted = "CONNECTED" if number == 1 else f"CONNECTED{number}"
    for name, block in project.instances.items():
        for variable in block.variables:
            if variable.name.upper() == wanted and variable.type == ElementaryType("BOOL"):
                return path_of(project, f"{name}.{variable.name}")[0]
    return None


def _places(project: Project) -> list[tuple[int, int, int]]:
    """Return size, m and n of each controller from the calls of FB_ReadArea and FB_WriteArea."""
    found: dict[str, list[tuple[int, int]]] = {"READ": [], "WRITE": []}
    for pou in project.pous.values():
        for call in calls_of(pou.body):
            for kind, pin in (("READ", "M"), ("WRITE", "N")):
                if call.block.name.upper() in (f"FB_{kind}AREA", f"FB_{kind}AREAWORDS"):
                    found[kind].append((_pin(call, "SIZE", SIZE), _pin(call, pin, 0)))
    pairs = list(zip(found["READ"], found["WRITE"], strict=False))
    # A second call for the same area is not a second controller.
    places = {m: (size, m, n) for (size, m), (_, n) in reversed(pairs)}
    return list(reversed(places.values())) or [(SIZE, 0, 0)]


def _pin(call: t.CallBlock, name: str, default: int) -> int:
    for pin, value in call.inputs:
        if pin.upper() == name:
            return int(value.value) if isinstance(value, t.Constant) else default
    return default
