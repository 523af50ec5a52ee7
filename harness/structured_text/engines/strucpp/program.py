"""A second compiled engine: ST translated by STruC++, compiled to C++17, scanned in process.

Each scalar is wrapped: the value, a flag for a forced variable, and the forced value. Blocks,
structures and arrays are not wrapped. STruC++ omits some initial values, so they are checked.
"""

from __future__ import annotations

import ctypes
import struct
from collections.abc import Callable, Iterable
from typing import Any

from structured_text.engines.base import Value
from structured_text.engines.native.c_layout import FORMATS, Codec, converted, packed
from structured_text.engines.native.program import NativeProgram, layout_of
from structured_text.engines.strucpp.build import NAMESPACE, Strucpp, compile_project
from structured_text.errors import InputError
from structured_text.language.project import Project
from structured_text.language.tree import Symbol
from structured_text.language.types import (
    ArrayType,
    BlockType,
    ElementaryType,
    EnumType,
    StructType,
    Type,
    Variable,
)
from structured_text.language.values import nest, scalar_to_python

__all__ = ["StrucppProgram"]


class StrucppProgram(NativeProgram):
    """One running instance of a program that STruC++ compiled; see `engines.base.Program`."""

    engine = "strucpp"

    def __init__(self, project: Project, image: bytes) -> None:
        self.dialect = _dialect(project)
        super().__init__(project, image)

    @classmethod
    def build(cls, project: Project, strucpp: Strucpp, compiler: str) -> StrucppProgram:
        """Compile a project.

        Raises:
            InputError: STruC++ or the C++ compiler reports an error (with file and line), or the
                program does not start with the values of its sources.
        """
        layout = layout_of(project, _dialect(project))
        program = cls(project, compile_project(project, layout, strucpp, compiler))
        _check_start(project, program.read)
        return program

    def check(self, library: ctypes.PyDLL) -> None:
        """Raise InputError if the installed STruC++ represents values in an unknown way."""
        if not library.shim_is_as_expected():
            raise InputError(
                "this version of STruC++ stores its variables in an unknown way",
                hint="use --engine builtin or matiec, or another version of STruC++",
            )


def _dialect(project: Project) -> _Dialect:
    return _Dialect(frozenset(block.name.upper() for block in project.instances.values()))


_STORED = ("VAR", "VAR_INPUT", "VAR_OUTPUT", "VAR_GLOBAL")


def _check_start(project: Project, read: Callable[[str], Value]) -> None:
    """Compare the first state of a program with its sources.

    `read` is `Program.read` before the first scan.

    Raises:
        InputError: A variable does not have its initial value; the error has the line of its
            declaration.
    """
    seen: set[str] = set()

    def check(symbols: Iterable[Symbol], prefix: str, file: str | None) -> None:
        for symbol in symbols:
            path = prefix + symbol.name
            if symbol.section not in _STORED:
                continue
            if isinstance(symbol.type, BlockType):
                check_block(symbol.type, path)
            elif symbol.initial is not None and read(path) != _shown(symbol.type, symbol.initial):
                raise InputError(
                    f"STruC++ does not start {path} with its initial value",
                    file=file,
                    line=symbol.at.line,
                    hint="assign it in the first scan, or use --engine builtin",
                )

    def check_block(block: BlockType, path: str) -> None:
        """Check the first instance of each block; all instances start with the same values."""
        pou = project.pous.get(block.name.upper())
        if pou is not None and pou.name not in seen:
            seen.add(pou.name)
            check(pou.symbols.values(), f"{path}.", pou.file)

    check(project.global_symbols.values(), "", None)
    for name, block in project.instances.items():
        check_block(block, name)


def _shown(kind: Type, initial: Any) -> Value:
    """Return an initial value in the form of `Program.read`."""
    if isinstance(kind, StructType):
        return {name: _shown(field, initial[name]) for name, field in kind.fields}
    if isinstance(kind, ArrayType):
        return nest(kind, [_shown(kind.element, item) for item in initial])
    return scalar_to_python(kind, initial)


_LENGTH = struct.Struct("=H")


class _Dialect:
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
            return converted(kind, packed({1: "b", 2: "h", 4: "i", 8: "q"}[size // 3], size))
        if kind.name == "STRING":
            return _string_codec(size)
        if kind.name in FORMATS:
            return packed(FORMATS[kind.name], size)
        return converted(kind, packed("q", size))


def _string_codec(size: int) -> Codec:
    """Return the codec of a STRING.

    In memory, a STRING has the characters, a zero, the length in two bytes, the flag for a forced
    variable, and the forced value.
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
