"""The representation of variables in the C++ of STruC++.

Each scalar is wrapped: the value, a flag for a forced variable, and the forced value. Blocks,
structures and arrays are not wrapped.
"""

from __future__ import annotations

import struct

from structured_text.engines.base import Value
from structured_text.engines.native.c_layout import FORMATS, Codec, enumeration, packed
from structured_text.language.types import (
    ArrayType,
    BlockType,
    ElementaryType,
    EnumType,
    StructType,
    Variable,
)
from structured_text.language.values import scalar_to_python

__all__ = ["NAMESPACE", "StrucppDialect"]

NAMESPACE = "strucpp"
_LENGTH = struct.Struct("=H")


class StrucppDialect:
    """STruC++'s names in C++; see `engines.native.c_layout.Dialect`.

    Args:
        programs: Names of the programs, in upper case.
    """

    def __init__(self, programs: frozenset[str] = frozenset()) -> None:
        self._programs = programs

    def type_name(self, kind: StructType | BlockType) -> str:
        """Return the name of a structure or block in C++."""
        name = kind.name.upper()
        return f"{NAMESPACE}::{'Program_' if name in self._programs else ''}{name}"

    def member_name(self, kind: StructType | BlockType, variable: Variable) -> str:
        """Return the C++ name of a member; STruC++ appends `_` if it has the name of its type."""
        name = variable.name.upper()
        own = not isinstance(variable.type, (ElementaryType, ArrayType))
        return f"{name}_" if own and name == variable.type.name.upper() else name

    def is_pointer(self, variable: Variable) -> bool:
        """Return False: located variables are stored inside their program."""
        return False

    def scalar(self, kind: ElementaryType | EnumType, size: int) -> Codec:
        """Return the codec of an elementary type or enumeration."""
        if isinstance(kind, EnumType):
            return enumeration(kind, packed({1: "b", 2: "h", 4: "i", 8: "q"}[size // 3], size))
        if kind.name == "STRING":
            return _string_codec(size)
        if kind.name in FORMATS:
            return packed(FORMATS[kind.name], size)
        return _moment_codec(kind, packed("q", size))


def _moment_codec(kind: ElementaryType, number: Codec) -> Codec:
    """Return the codec of TIME, DATE, TOD and DT, in nanoseconds."""

    def get(memory: memoryview, at: int) -> Value:
        return scalar_to_python(kind, number.get(memory, at))

    return Codec(number.size, get, number.put)


def _string_codec(size: int) -> Codec:
    """Return the codec of a STRING.

    In memory it is: the characters, a zero, the length in two bytes, then flag and forced value.
    """
    length_at = (size - _LENGTH.size) // 2 - _LENGTH.size

    def get(memory: memoryview, at: int) -> Value:
        (length,) = _LENGTH.unpack_from(memory, at + length_at)
        return bytes(memory[at : at + length]).decode("latin-1")

    def put(memory: memoryview, at: int, value: Value) -> None:
        text = value.encode("latin-1")
        memory[at : at + len(text) + 1] = text + b"\0"
        _LENGTH.pack_into(memory, at + length_at, len(text))

    return Codec(size, get, put)
