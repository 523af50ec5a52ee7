"""The counterparts of the library's elements in a Logix controller.

Tags are BOOL, DINT, REAL, STRING, structures and arrays that begin at 0. A whole number or a bit
pattern narrower than 32 bits is stored in a DINT by its value (a WORD as 0 to 65535), because Logix
computes in DINT. Only the process images are arrays of SINT and INT, as in the controller's
scanner.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from structured_text.errors import BLOCKS
from structured_text.export.initial import literal
from structured_text.language import tree as t
from structured_text.language.scalars import DIGITS
from structured_text.language.syntax import Position
from structured_text.language.types import (
    ArrayType,
    BlockType,
    ElementaryType,
    EnumType,
    StructType,
    Type,
    Variable,
)

__all__ = [
    "FIRST_SCAN",
    "RESULT",
    "STANDARD_BLOCKS",
    "UNWRITTEN",
    "Aoi",
    "Data",
    "Images",
    "NotCarriedError",
    "Tag",
    "check_name",
    "companion",
    "data_of",
    "image_element",
    "is_whole",
    "is_zero",
    "passed",
    "value_text",
]

#: Types of process images with the type of their elements, SINT or INT. The scanner fills and sends
#: them, so the elements keep their width.
Images: TypeAlias = Mapping[str, str]

#: Name of the parameter with the result of a function.
RESULT = "FcResult"

#: Standard blocks, and the instructions that replace them (`blocks`).
STANDARD_BLOCKS = {name: f"{BLOCKS}{name}" for name in ("TON", "R_TRIG")}

#: Name of the instruction by which a program detects its first scan.
FIRST_SCAN = f"{BLOCKS}FirstScan"

#: The comment of a tag that is always 0; other tags are cleared by copying it.
UNWRITTEN = "all 0: nothing may write it"

_NUMBERS = ("SINT", "INT", "DINT", "USINT", "UINT", "UDINT", "BYTE", "WORD", "DWORD", "TIME")
_NANOSECONDS_PER_MS = 1_000_000
_LONGEST_NAME = 40
_LONGEST_STRING = 82


class NotCarriedError(Exception):
    """The error for an element without a counterpart in a Logix controller; the message names it.

    Attributes:
        at: Position of the element; None if the whole declaration has no counterpart.
    """

    at: Position | None = None


@dataclass(frozen=True)
class Data:
    """The type of a tag: an array of `size` elements of `type`, or one value if `size` is 0."""

    type: str
    size: int = 0

    @property
    def is_aggregate(self) -> bool:
        """Return whether a tag of this type is passed by reference only, and copied by COP."""
        return bool(self.size) or self.type not in ("BOOL", "DINT", "REAL", "SINT", "INT")


@dataclass(frozen=True)
class Tag:
    """A parameter or tag.

    It belongs to an Add-On Instruction or a program. `usage` is Input, Output, InOut or Local.
    `initial` is the first value as Structured Text; None if the controller's default, zero, is
    sufficient.
    """

    name: str
    data: Data
    usage: str
    initial: str | None = None
    note: str = ""
    is_block: bool = False


@dataclass
class Aoi:
    """An Add-On Instruction, or a program's tags and routine.

    Attributes:
        name: The name of the block or function.
        header: The comment in front of the source.
        parameters: The parameters in order. Parameters with the usage InOut are the arguments of a
            call.
        locals: The other tags.
        logic: Lines of the routine.
        prescan: Lines that set the tags to their initial values.
        types: Names of the structures that the instruction uses.
        blocks: Names of the instructions that the instruction uses.
    """

    name: str
    header: str
    parameters: list[Tag] = field(default_factory=list)
    locals: list[Tag] = field(default_factory=list)
    logic: list[str] = field(default_factory=list)
    prescan: list[str] = field(default_factory=list)
    types: dict[str, None] = field(default_factory=dict)
    blocks: dict[str, None] = field(default_factory=dict)


def data_of(kind: Type, images: Images) -> Data:
    """Return the tag type for a variable type; raise NotCarriedError if there is none."""
    if isinstance(kind, EnumType):
        return Data("DINT")
    if isinstance(kind, StructType):
        return Data(kind.name)
    if isinstance(kind, BlockType):
        return Data(_block(kind))
    if isinstance(kind, ArrayType):
        return _array(kind, images)
    if kind.name in _NUMBERS:
        return Data("DINT")
    if kind.name in ("BOOL", "REAL", "STRING"):
        return Data(kind.name)
    raise NotCarriedError(f"the type {kind.name} has no counterpart here")


def _block(kind: BlockType) -> str:
    if kind.name in STANDARD_BLOCKS:
        return STANDARD_BLOCKS[kind.name]
    if all(variable.name.isupper() for variable in kind.variables) and "FB" not in kind.name:
        raise NotCarriedError(f"the standard block {kind.name} has no counterpart here")
    return kind.name


def _array(kind: ArrayType, images: Images) -> Data:
    if len(kind.bounds) != 1 or kind.bounds[0][0] < 0:
        raise NotCarriedError(f"{kind.name} has several dimensions, or begins below 0")
    size = kind.bounds[0][1] + 1
    if image := image_element(kind.name, images):
        return Data(image, size)
    element = data_of(kind.element, images)
    if element.size or element.type == "BOOL" or isinstance(kind.element, BlockType):
        raise NotCarriedError(f"{kind.name} is an array of arrays, BOOL or blocks")
    return Data(element.type, size)


def image_element(name: str, images: Images) -> str:
    """Return the type of the elements of a process image, or "" for another type.

    The name of the type may have a prefix of the option `--prefix`.
    """
    return next((one for image, one in images.items() if name.upper().endswith(image)), "")


def is_whole(kind: Type) -> bool:
    """Return whether a type can only be copied with COP: a structure, an array or a STRING."""
    return isinstance(kind, StructType | ArrayType) or kind == ElementaryType("STRING")


def passed(variables: tuple[Variable, ...] | list[t.Symbol]) -> Iterator[Variable | t.Symbol]:
    """Yield the pins that are arguments of a call, in order.

    These are the VAR_IN_OUT, and inputs and outputs that are structures, arrays or texts.
    """
    for one in variables:
        outside = one.section in ("VAR_INPUT", "VAR_OUTPUT") and is_whole(one.type)
        if outside or one.section == "VAR_IN_OUT":
            yield one


def companion(instance: str, pin: str) -> str:
    """Return the caller's tag for a structure, array or STRING at a block's input or output.

    Raise NotCarriedError if a Logix controller refuses the name.
    """
    return check_name(f"{instance}_{pin}")


def check_name(name: str) -> str:
    """Return the name if a Logix controller accepts it.

    Raise NotCarriedError if the name is too long, or has underscores where they are not allowed.
    """
    if len(name) > _LONGEST_NAME:
        raise NotCarriedError(f"the name {name} is longer than {_LONGEST_NAME} characters")
    if name.endswith("_") or "__" in name:
        raise NotCarriedError(f"the name {name} has two underscores in a row or one at its end")
    return name


def is_zero(value: Any) -> bool:
    """Return whether an initial value consists only of 0, FALSE and empty texts."""
    if isinstance(value, dict):
        return all(map(is_zero, value.values()))
    if isinstance(value, list | tuple):
        return all(map(is_zero, value))
    return not value


def value_text(value: Any, kind: Type) -> str:
    """Return a value of a scalar or STRING as Structured Text of Logix.

    Raise NotCarriedError if the value has no counterpart.
    """
    if isinstance(kind, EnumType):
        return f"{value}(*{kind.members[value]}*)"
    name = getattr(kind, "name", "")
    if name == "STRING":
        return _string(str(value))
    if name == "BOOL":
        return "1" if value else "0"
    if name == "REAL":
        return literal(value, ElementaryType(name))
    number = int(value)
    if name == "TIME":
        number, rest = divmod(number, _NANOSECONDS_PER_MS)
        if rest:
            raise NotCarriedError("a TIME has a fraction of a millisecond")
    if name in ("BYTE", "WORD", "DWORD"):
        return f"16#{number:0{DIGITS[name]}X}"
    if not -(1 << 31) < number < 1 << 31:
        raise NotCarriedError(f"the number {number} does not fit a DINT")
    return str(number)


def _string(text: str) -> str:
    if len(text) > _LONGEST_STRING:
        raise NotCarriedError(f"a text has more than {_LONGEST_STRING} characters")
    return "'" + "".join(_character(one) for one in text) + "'"


def _character(one: str) -> str:
    if one in "$'":
        return f"${one}"
    return one if " " <= one <= "~" else f"${ord(one):02X}"
