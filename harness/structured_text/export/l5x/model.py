"""What of the library has a counterpart in a Logix controller, and which.

Tags are BOOL, DINT, REAL, STRING, structures and arrays that begin at 0. A whole number or a bit
pattern narrower than 32 bits is held in a DINT by its value (a WORD as 0 to 65535), because Logix
computes in DINT; only the process images are arrays of SINT and INT, as its scanner has them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from structured_text.errors import BLOCKS
from structured_text.language import tree as t
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

#: Array types whose elements keep their width, what the scanner fills and sends: SINT or INT.
Images: TypeAlias = Mapping[str, str]

#: The parameter that holds what a function returns.
RESULT = "FcResult"

#: Standard blocks, and the instructions that stand for them (`l5x_blocks`).
STANDARD_BLOCKS = {name: f"{BLOCKS}{name}" for name in ("TON", "R_TRIG")}

#: The instruction that tells a program its first scan.
FIRST_SCAN = f"{BLOCKS}FirstScan"

#: What is said of a tag that all others are cleared from.
UNWRITTEN = "all 0: nothing may write it"

_NUMBERS = ("SINT", "INT", "DINT", "USINT", "UINT", "UDINT", "BYTE", "WORD", "DWORD", "TIME")
_NANOSECONDS_PER_MS = 1_000_000
_LONGEST_NAME = 40
_LONGEST_STRING = 82


class NotCarriedError(Exception):
    """Something that a Logix controller has no counterpart for; the message says what.

    Attributes:
        at: Where it is; None for the whole declaration.
    """

    at: Position | None = None


@dataclass(frozen=True)
class Data:
    """Type of a tag: `size` elements of `type`, or one where it is 0."""

    type: str
    size: int = 0

    @property
    def is_aggregate(self) -> bool:
        """It can be passed by reference only, and is copied by COP."""
        return bool(self.size) or self.type not in ("BOOL", "DINT", "REAL", "SINT", "INT")


@dataclass(frozen=True)
class Tag:
    """A parameter or tag.

    `usage` is Input, Output, InOut or Local; `initial` its first value as Structured Text has it,
    or None where the controller's own zero will do.
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
        name: As the block or function is called.
        header: What its source says about it.
        parameters: In their order; those of usage InOut are the arguments of a call.
        locals: Its other tags.
        logic: Lines of its routine.
        prescan: Lines that bring its tags to their initial values.
        types: Names of the structures it uses.
        blocks: Names of the instructions it uses.
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
    """The type of the tag that holds a variable of this type.

    Raises:
        NotCarriedError: there is none.
    """
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
    """The elements of a type that is an image, also with a prefix; empty for another type."""
    return next((one for image, one in images.items() if name.upper().endswith(image)), "")


def is_whole(kind: Type) -> bool:
    """It can be copied with COP only: a structure, an array or a STRING."""
    return isinstance(kind, StructType | ArrayType) or kind == ElementaryType("STRING")


def passed(variables: tuple[Variable, ...] | list[t.Symbol]) -> Iterator[Variable | t.Symbol]:
    """The pins that are arguments of a call, in their order: passed by reference."""
    for one in variables:
        outside = one.section in ("VAR_INPUT", "VAR_OUTPUT") and is_whole(one.type)
        if outside or one.section == "VAR_IN_OUT":
            yield one


def companion(instance: str, pin: str) -> str:
    """The caller's tag for a structure, array or STRING at a block's input or output."""
    return check_name(f"{instance}_{pin}")


def check_name(name: str) -> str:
    """The name, if a Logix controller takes it."""
    if len(name) > _LONGEST_NAME:
        raise NotCarriedError(f"the name {name} is longer than {_LONGEST_NAME} characters")
    if name.endswith("_") or "__" in name:
        raise NotCarriedError(f"the name {name} has underscores where none may be")
    return name


def is_zero(value: Any) -> bool:
    """Nothing in this initial value is anything but 0, FALSE or an empty text."""
    if isinstance(value, dict):
        return all(map(is_zero, value.values()))
    if isinstance(value, list | tuple):
        return all(map(is_zero, value))
    return not value


def value_text(value: Any, kind: Type) -> str:
    """A value of a scalar or STRING as Structured Text of Logix has it."""
    if isinstance(kind, EnumType):
        return f"{value}(*{kind.members[value]}*)"
    name = getattr(kind, "name", "")
    if name == "STRING":
        return _string(str(value))
    if name == "BOOL":
        return "1" if value else "0"
    if name == "REAL":
        text = f"{float(value):.9g}".upper()
        return text if "." in text else _pointed(text)
    number = int(value)
    if name == "TIME":
        number, rest = divmod(number, _NANOSECONDS_PER_MS)
        if rest:
            raise NotCarriedError("a time with parts of a millisecond")
    if name in ("BYTE", "WORD", "DWORD"):
        return f"16#{number:0{ {'BYTE': 2, 'WORD': 4, 'DWORD': 8}[name] }X}"
    if not -(1 << 31) < number < 1 << 31:
        raise NotCarriedError(f"the number {number} does not fit a DINT")
    return str(number)


def _pointed(text: str) -> str:
    digits, e, exponent = text.partition("E")
    return f"{digits}.0{e}{exponent}"


def _string(text: str) -> str:
    if len(text) > _LONGEST_STRING:
        raise NotCarriedError(f"a text longer than {_LONGEST_STRING} characters")
    return "'" + "".join(_character(one) for one in text) + "'"


def _character(one: str) -> str:
    if one in "$'":
        return f"${one}"
    return one if " " <= one <= "~" else f"${ord(one):02X}"
