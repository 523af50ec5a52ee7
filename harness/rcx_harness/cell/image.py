"""The process image of a program, which consists of two arrays or of located variables."""

from __future__ import annotations

import re
import struct
from typing import Any, NamedTuple

from rcx_harness.spec.wire import check_size
from structured_text.engines.base import Program
from structured_text.errors import InputError
from structured_text.language.types import ArrayType, BlockType, ElementaryType, Located, Type

__all__ = ["ArrayImage", "Image", "LocatedImage", "Slot", "find_image", "owner_of_areas", "store"]

_INPUT, _OUTPUT = "InputArea", "OutputArea"
_ADDRESS = re.compile(r"%([IQM])([XBWDL]?)(\d+)(?:\.(\d+))?", re.IGNORECASE)
_BYTES = {"X": 0, "": 0, "B": 1, "W": 2, "D": 4, "L": 8}


class Slot(NamedTuple):
    """A variable in an area: its path and type, and the position of its first byte in the area."""

    path: str
    kind: str
    start: int
    bit: int
    width: int
    """Bytes; 0 for a single bit."""


def find_image(program: Program, *, size: int, m: int, n: int, located: bool = False) -> Image:
    """Find the process image of a program and check that the areas fit.

    If the program fills `InputArea` itself, its process image consists of the variables from which
    it copies.

    The areas begin at byte `m` (from the robot) and `n` (to the robot). With `located` the process
    image are located variables, even if the program has an `InputArea`.
    """
    check_size(size)
    for name, offset in (("m", m), ("n", n)):
        if offset < 0:
            raise InputError(f"the offset {name} = {offset} is negative")
    found = None if located else _arrays(program)
    if found is not None:
        return ArrayImage(program, found[0], found[1], size=size, m=m, n=n)
    if items := program.located():
        return LocatedImage(program, items, size=size, m=m, n=n)
    instance = next(iter(program.instances()), "Main")
    raise InputError(
        f"the program has no process image: neither {instance}.{_INPUT} and "
        f"{instance}.{_OUTPUT} nor located variables",
        hint=f"declare {_INPUT} and {_OUTPUT} : RCX_IMAGE in the PROGRAM or in a list of global "
        "variables; a program without a robot: --no-robot, in Python structured_text.Bench",
    )


def _arrays(program: Program) -> tuple[str, str] | None:
    for name, kind in program.instances().items():
        assert isinstance(kind, BlockType)
        declared = {variable.name.lower(): variable for variable in kind.variables}
        present = [area for area in (_INPUT, _OUTPUT) if area.lower() in declared]
        if len(present) == 1:
            raise InputError(
                f"the program has {name}.{present[0]}, but needs both {_INPUT} and {_OUTPUT}",
                hint="declare both, of type RCX_IMAGE",
            )
        if present:
            for area in present:
                _bytes_of_array(f"{name}.{area}", declared[area.lower()].type)
            return f"{name}.{_INPUT}", f"{name}.{_OUTPUT}"
    return _elsewhere(program)


def owner_of_areas(program: Program) -> str:
    """Return the path of the block, structure or list with both areas; empty if there is none.

    The path is also empty if a PROGRAM declares the areas.
    """
    found = _elsewhere(program)
    return found[0].rpartition(".")[0] if found is not None else ""


def _elsewhere(program: Program) -> tuple[str, str] | None:
    """Find both areas in one block, structure or variable list; the outermost has priority.

    A PROGRAM in TIA Portal has no permanent variables, and users of other tools often declare wired
    variables in a global list.
    """
    areas: dict[str, dict[str, str]] = {}
    for path, kind in program.walk():
        owner, _, name = path.rpartition(".")
        for area in (_INPUT, _OUTPUT):
            if name.lower() == area.lower() and isinstance(kind, ArrayType):
                areas.setdefault(owner, {})[area] = path
    pairs = [found for found in areas.values() if len(found) == 2]
    if not pairs:
        return None
    first = min(pairs, key=lambda found: found[_INPUT].count("."))
    return first[_INPUT], first[_OUTPUT]


def _bytes_of_array(path: str, kind: Type) -> int:
    if isinstance(kind, ArrayType) and len(kind.bounds) == 1:
        width = {"BYTE": 1, "WORD": 2}.get(getattr(kind.element, "name", ""))
        if width is not None and isinstance(kind.element, ElementaryType):
            low, high = kind.bounds[0]
            return (high - low + 1) * width
    raise InputError(
        f"{path} is not an array of BYTE or WORD", hint="declare it with the type RCX_IMAGE"
    )


def _check_end(name: str, offset: int, size: int, have: int, where: str) -> None:
    if offset + size > have:
        raise InputError(
            f"the area at {name} = {offset} needs {size} bytes, but {where} has {have}",
            hint=f"{name} can be 0 to {have - size}" if have >= size else "enlarge the image",
        )


class ArrayImage:
    """The process image of a program with the arrays `InputArea` and `OutputArea`; see `Image`."""

    bridged, life_path = False, ""

    def __init__(
        self, program: Program, source: str, target: str, *, size: int, m: int, n: int
    ) -> None:
        self._program, self._source, self._target = program, source, target
        self._m, self._n, self._size = m, n, size
        for name, offset, path in (("m", m, source), ("n", n, target)):
            kind = program.type_of(path)
            have = _bytes_of_array(path, kind)
            _check_end(name, offset, size, have, path)
            if offset % 2 and _is_words(kind):
                raise InputError(f"{name} = {offset} is odd, but {path} is an array of WORD")

    @property
    def slots(self) -> list[Slot]:
        """Return the elements of the array `InputArea` as slots."""
        kind = self._program.type_of(self._source)
        assert isinstance(kind, ArrayType)
        width, low = 2 if _is_words(kind) else 1, kind.bounds[0][0]
        first = low + self._m // width
        name = getattr(kind.element, "name", "")
        return [
            Slot(f"{self._source}[{first + k}]", name, k * width, 0, width)
            for k in range(self._size // width)
        ]

    def put(self, area: bytes, connected: bool = True) -> None:
        """Write the area from the robot into the array; bytes outside of the area do not change."""
        self._program.write_bytes(self._source, area, self._m)

    def get(self) -> bytes:
        """Read the area that goes to the robot."""
        return self._program.read_bytes(self._target, self._n, self._size)


def _is_words(kind: Type) -> bool:
    return isinstance(kind, ArrayType) and getattr(kind.element, "name", "") == "WORD"


class LocatedImage:
    """A process image of located variables: `%I` and `%Q`, `%M` for both areas, or `%M` and `%Q`.

    A program behind `rcx bridge` has `%M` and `%Q`.

    An index counts elements of its own width, as on OpenPLC: `%IW3` is bytes 6 and 7, `%ID1` bytes
    4 to 7, `%IX5.2` bit 2 of byte 5. Bytes without a variable read as zero. With `%M` and `%Q` the
    word behind the inputs is the bridge's life word. The life word changes in each scan. Without a
    connection the life word and the whole area are 0.

    A row is a group of variables with consecutive addresses. If an area has offset 0 but no row
    begins at address 0, the only row that is long enough is used, because tools assign addresses
    such as `%IB100`.
    """

    def __init__(
        self, program: Program, located: list[Located], *, size: int, m: int, n: int
    ) -> None:
        slots = [_slot(item) for item in located]
        memory = {area: [s for a, s in slots if a == area] for area in "IQM"}
        shared = not memory["I"] and not memory["Q"]
        bridged = not memory["I"] and not shared and bool(memory["M"])
        if shared and abs(m - n) < size:
            raise InputError(
                f"the areas at m = {m} and n = {n} overlap in %M",
                hint=f"leave {size} bytes between them",
            )
        m = _begin(memory["M" if shared or bridged else "I"], m, size)
        n = n if shared else _begin(memory["Q"], n, size)
        self._program, self._size = program, size
        self.slots = _within(memory["M" if shared or bridged else "I"], "m", m, size)
        self._outputs = _within(memory["M" if shared else "Q"], "n", n, size)
        _check_overlap(self._outputs)
        self.bridged = bridged
        behind = [slot.path for slot in memory["M"] if (slot.start, slot.width) == (m + size, 2)]
        self.life_path = behind[0] if bridged and behind else ""

    def put(self, area: bytes, connected: bool = True) -> None:
        """Write the area that came from the robot to the inputs."""
        if self.bridged and not connected:
            area = bytes(self._size)
        if self.life_path:
            life = int(self._program.read(self.life_path)) % 0xFFFF + 1
            self._program.write(self.life_path, life if connected else 0)
        for slot in self.slots:
            self._program.write(slot.path, _value(slot, area))

    def get(self) -> bytes:
        """Collect the area that goes to the robot from the outputs."""
        area = bytearray(self._size)
        for slot in self._outputs:
            store(area, slot, self._program.read(slot.path))
        return bytes(area)


def _slot(item: Located) -> tuple[str, Slot]:
    match = _ADDRESS.fullmatch(item.address)
    if match is None:
        raise InputError(
            f"{item.path} is at {item.address}, which is not a plain address",
            hint="use %IX0.0, %IB0, %IW0 or %ID0",
        )
    kind = getattr(item.type, "name", "")
    width = _BYTES[match[2].upper()]
    index, bit = int(match[3]), int(match[4] or 0)
    if width == 0 and bit > 7:
        raise InputError(f"{item.path} is at {item.address}; a byte has bits 0 to 7")
    start = index * max(width, 1) if item.start is None else item.start
    return match[1].upper(), Slot(item.path, kind, start, bit, width)


def _begin(slots: list[Slot], offset: int, size: int) -> int:
    """Return the address of an area: its offset, or the start of the only long enough row."""
    rows: list[list[int]] = []
    for slot in sorted(slots, key=lambda one: one.start):
        if not slot.width:
            continue
        if not rows or slot.start > rows[-1][1]:
            rows.append([slot.start, slot.start])
        rows[-1][1] = max(rows[-1][1], slot.start + slot.width)
    long = [begin for begin, end in rows if end - begin >= size]
    return long[0] if not offset and 0 not in long and len(long) == 1 else offset


def _within(slots: list[Slot], name: str, offset: int, size: int) -> list[Slot]:
    """Return the variables inside an area, with addresses relative to its first byte."""
    inside = [
        slot._replace(start=slot.start - offset)
        for slot in slots
        if offset <= slot.start and slot.start + max(slot.width, 1) <= offset + size
    ]
    if not inside:
        have = max((slot.start + max(slot.width, 1) for slot in slots), default=0)
        first = min((slot.start for slot in slots), default=0)
        raise InputError(
            f"no located variable lies in the area at {name} = {offset}",
            hint=f"the program's variables begin at byte {first} and end at byte {have}: "
            f"--{name} {first}"
            if slots
            else "declare the areas of the scanner: In AT %IB0 and Out AT %QB0, 48 bytes each",
        )
    return inside


def _check_overlap(slots: list[Slot]) -> None:
    taken: dict[tuple[int, int], str] = {}
    for slot in slots:
        bits = [(slot.start, slot.bit)] if slot.width == 0 else _bits(slot)
        for place in bits:
            other = taken.setdefault(place, slot.path)
            if other != slot.path:
                raise InputError(f"{slot.path} and {other} overlap in the area to the robot")


def _bits(slot: Slot) -> list[tuple[int, int]]:
    return [(slot.start + k, bit) for k in range(slot.width) for bit in range(8)]


def _value(slot: Slot, area: bytes) -> object:
    if slot.width == 0:
        return bool(area[slot.start] >> slot.bit & 1)
    raw = area[slot.start : slot.start + slot.width]
    if slot.kind in _FLOATS:
        return float(struct.unpack(_FLOATS[slot.kind], raw)[0])
    return int.from_bytes(raw, "little", signed=slot.kind in _SIGNED)


def store(area: bytearray, slot: Slot, value: Any) -> None:
    """Write the value of a variable into an area, in which its bits must be 0 before the call."""
    end = slot.start + slot.width
    if slot.width == 0:
        area[slot.start] |= int(value) << slot.bit
    elif slot.kind in _FLOATS:
        area[slot.start : end] = struct.pack(_FLOATS[slot.kind], value)
    else:
        mask = (1 << (8 * slot.width)) - 1
        area[slot.start : end] = (int(value) & mask).to_bytes(slot.width, "little")


_FLOATS = {"REAL": "<f", "LREAL": "<d"}
_SIGNED = ("SINT", "INT", "DINT", "LINT")

#: The robot's two areas in the program's process image. `slots` are the variables that receive the
#: area from the robot. With `bridged`, `rcx bridge` writes the image, and the area is 0 without a
#: connection. `life_path` is the path of the bridge's life word; it is empty without such a
#: variable.
Image = ArrayImage | LocatedImage
