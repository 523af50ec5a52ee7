"""The layout of the controller's areas in the process image, for the proofs (chapter 1, 4).

The layout is taken from the manual independently of plc/lib. An error in the layout of plc/lib is
therefore detected.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import z3

from rcx_tools.evidence.prove.library import BLOCK, IMAGE, Library, Step
from structured_text.language.types import ArrayType, Type
from structured_text.prove.machine import Machine
from structured_text.prove.symbolic_memory import Path
from structured_text.prove.values import Value

__all__ = [
    "AGAIN",
    "DEDICATED",
    "INPUTS",
    "STOPS",
    "accepted",
    "again",
    "at_the_start",
    "byte",
    "legal_image",
    "offset",
    "word",
]

#: The dedicated inputs in bytes n + 32 and n + 33 (chapter 5, 1): SI(00), SI(01), SI(06), SI(10),
#: SI(12), SI(14) to SI(17).
INPUTS = 0x0043 | 0xF500
#: The bits of SI(00) and SI(06). Switching these inputs OFF takes effect immediately.
STOPS = 0x0041
#: Offset of the first byte of the dedicated bits, from m or n (chapter 1, 4.1).
DEDICATED = 32
#: ErrorID of a second call in the same scan (docs/reference/errors.md).
AGAIN = 0x8037

Memory = Mapping[Path, Value]


def byte(machine: Machine, address: Any, memory: Memory | None = None) -> Any:
    """Return a byte of the process image.

    An image of words is little endian (guide chapter 1, 1.1).
    """
    image = machine.term(IMAGE, memory)
    if image.sort().range().size() == 8:
        return z3.Select(image, address)
    element = z3.Select(image, z3.UDiv(address, z3.BitVecVal(2, 32)))
    return z3.If(
        z3.Extract(0, 0, address) == 0, z3.Extract(7, 0, element), z3.Extract(15, 8, element)
    )


def word(machine: Machine, address: Any, memory: Memory | None = None) -> Any:
    """Return a word of the process image. Its offset in the area must be even."""
    image = machine.term(IMAGE, memory)
    if image.sort().range().size() == 8:
        return z3.Concat(z3.Select(image, address + 1), z3.Select(image, address))
    return z3.Select(image, z3.UDiv(address, z3.BitVecVal(2, 32)))


def offset(machine: Machine, pin: str = "N") -> Any:
    """Return the address of the first byte of an area, in 32 bits."""
    return z3.SignExt(16, machine.term((*BLOCK, pin)))


def legal_image(machine: Machine) -> Any:
    """Return the claim that ImageSize does not exceed the array of 512 bytes (chapter 1, 4).

    The manual allows images of any size, so the array is the only limit.
    """
    size = machine.term((*BLOCK, "IMAGESIZE"))
    return z3.And(size >= 0, size <= 512)


def accepted(step: Step) -> Any:
    """Return the claim that this FB_WriteArea call was the first of its scan, with a legal area."""
    return step.now((*BLOCK, "ERRORID")) == 0


def again(step: Step) -> Any:
    """Return the claim that FB_WriteArea was already called in this scan, with a legal area."""
    return step.now((*BLOCK, "ERRORID")) == AGAIN


def at_the_start(library: Library, block: str) -> Machine:
    """Return a machine with a new instance of a block and its VAR_IN_OUTs before any call."""
    machine = library.machine()
    pou = library.pou(block)
    assert pou.block is not None
    machine.create(BLOCK, pou.block)
    for symbol in pou.section("VAR_IN_OUT"):
        path = (symbol.name.upper(),)
        for leaf in machine.leaves(symbol.type):
            machine.create(path + leaf.suffix, leaf.type, _zero(leaf.type))
    return machine


def _zero(kind: Type) -> Any:
    if not isinstance(kind, ArrayType):
        return 0
    ((low, high),) = kind.bounds
    return [0] * (high - low + 1)
