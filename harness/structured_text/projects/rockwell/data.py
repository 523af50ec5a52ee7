"""The types of Logix tags, and their equivalents in the standard's language.

Elementary types keep their names. Arrays of SINT and INT become arrays of BYTE and WORD, which is
the form of process images; their elements are still read as signed numbers. A string type becomes
a STRING of its length.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

__all__ = ["INTEGERS", "NUMBERS", "STORED", "Data", "First", "Instruction", "Subroutine", "Types"]

#: Integer types by rank. The result of an operation has the type of higher rank, at least DINT.
INTEGERS = ("SINT", "USINT", "INT", "UINT", "DINT", "UDINT", "LINT", "ULINT")
NUMBERS = (*INTEGERS, "REAL", "LREAL")
STORED = {"SINT": "BYTE", "INT": "WORD"}


@dataclass(frozen=True)
class Data:
    """The type of a tag: its name, and its dimensions.

    `stored` is true for an element that is stored as a BYTE or WORD.
    """

    type: str
    sizes: tuple[int, ...] = ()
    stored: bool = False

    @property
    def element(self) -> Data:
        """Return the type of an element of the array."""
        return Data(self.type, stored=self.type in STORED)


@dataclass(frozen=True)
class Instruction:
    """An Add-On Instruction.

    Attributes:
        parameters: Its required parameters, in the order of a call, and the usage of each.
        false_routine: Whether it executes its routine EnableInFalse if EnableIn is FALSE.
        enable_out: Whether its logic mentions EnableOut.
        usages: The usage of each parameter, by its name in upper case; without EnableIn and
            EnableOut.
    """

    parameters: tuple[tuple[str, str], ...]
    false_routine: bool = False
    enable_out: bool = False
    usages: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class First:
    """A part of the prescan: the statements of an instruction, or a routine that JSR calls.

    `routine` is its name in upper case.
    """

    lines: tuple[str, ...] = ()
    routine: str = ""


@dataclass(frozen=True)
class Subroutine:
    """The parameters of a routine that JSR calls: the types of SBR's tags and of RET's values."""

    name: str
    inputs: tuple[Data, ...] = ()
    returns: tuple[Data, ...] = ()


@dataclass
class Types:
    """The types of a project, with names in upper case.

    Attributes:
        members: The members of each structure, and the parameters of each instruction.
        strings: The length of each string type.
        instructions: Add-On Instructions that are read.
        protected: Add-On Instructions with protected source, which the file does not contain.
        arrays: Named types for arrays, collected by `written`.
        read_members: The names of all members that the routines mention, such as ACC.
        used: The members of each tag that the routines mention directly, both in upper case.
    """

    members: dict[str, Mapping[str, Data]] = field(default_factory=dict)
    strings: dict[str, int] = field(default_factory=lambda: {"STRING": 82})
    instructions: dict[str, Instruction] = field(default_factory=dict)
    protected: set[str] = field(default_factory=set)
    arrays: dict[str, Data] = field(default_factory=dict)
    read_members: set[str] = field(default_factory=set)
    used: dict[str, set[str]] = field(default_factory=dict)

    def is_string(self, data: Data) -> bool:
        """Return whether the type is a single STRING."""
        return not data.sizes and data.type.upper() in self.strings

    def is_simple(self, data: Data) -> bool:
        """Return whether the type is a single number or BOOL."""
        return not data.sizes and (data.type == "BOOL" or data.type in NUMBERS)

    def written(self, data: Data) -> str:
        """Return the type as it is written in a declaration; an array gets a named type."""
        if data.sizes:
            name = "_".join(["L5X", data.type, *map(str, data.sizes)])
            self.arrays[name] = data
            return name
        return data.type

    def array(self, data: Data) -> str:
        """Return the text of an array type, `ARRAY [...] OF ...`."""
        bounds = ", ".join(f"0..{size - 1}" for size in data.sizes)
        return f"ARRAY [{bounds}] OF {STORED.get(data.type, data.type)}"
