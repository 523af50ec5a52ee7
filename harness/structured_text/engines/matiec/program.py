"""The reference engine: ST translated by matiec's iec2c, compiled to C, scanned in process.

A block is a C structure. Its elementary members, enumerations, arrays and structures are each
wrapped with a byte of flags. Nested blocks are not wrapped. External and located variables are
pointers.
"""

from __future__ import annotations

import struct

from structured_text.engines.base import Value
from structured_text.engines.matiec.build import (
    Matiec,
    RefusedCodeError,
    TranslationError,
    Wanted,
    compile_program,
)
from structured_text.engines.matiec.source import (
    HIDDEN_INSTANCE,
    explain,
    explain_code,
    hidden_instance,
    join_sources,
)
from structured_text.engines.native.c_layout import FORMATS, Codec, converted, packed
from structured_text.engines.native.program import NativeProgram, layout_of
from structured_text.errors import InputError
from structured_text.language.project import Project
from structured_text.language.types import BlockType, ElementaryType, EnumType, StructType, Variable
from structured_text.language.values import scalar_to_python

__all__ = ["MatiecProgram"]


class _Dialect:
    """matiec's names in C; see `engines.native.c_layout.Dialect`."""

    def type_name(self, kind: StructType | BlockType) -> str:
        """Return the name of a structure or block in C."""
        return kind.name.upper()

    def member_name(self, kind: StructType | BlockType, variable: Variable) -> str:
        """Return the C expression of a member's value."""
        wrapped = isinstance(kind, BlockType) and not isinstance(variable.type, BlockType)
        return variable.name.upper() + (".value" if wrapped else "")

    def is_pointer(self, variable: Variable) -> bool:
        """Return whether the variable is located: matiec stores a pointer for it."""
        return variable.address is not None

    def scalar(self, kind: ElementaryType | EnumType, size: int) -> Codec:
        """Return the codec of an elementary type or enumeration."""
        if isinstance(kind, EnumType):
            return converted(kind, packed({1: "b", 2: "h", 4: "i"}[size], size))
        if kind.name == "STRING":
            return _string_codec(size)
        return packed(FORMATS[kind.name], size) if kind.name in FORMATS else _moment_codec(kind)


class MatiecProgram(NativeProgram):
    """One running instance of a program that matiec compiled; see `engines.base.Program`."""

    engine = "matiec"
    dialect = _Dialect()

    @classmethod
    def build(cls, project: Project, matiec: Matiec, compiler: str) -> MatiecProgram:
        """Compile a project.

        Raises:
            InputError: iec2c (with file and line) or the C compiler reports an error, or the
                priorities of the tasks require an order that matiec does not support.
        """
        _check_order(project)
        source = join_sources(project)
        instances: tuple[str, ...] = (HIDDEN_INSTANCE,)
        if project.configured:
            instances = tuple(hidden_instance(name, project) for name in project.instances)
        wanted = Wanted(
            instances=tuple(name.upper() for name in instances),
            globals=tuple(project.globals),
            layout=layout_of(project, cls.dialect),
        )
        try:
            image = compile_program(source.text, wanted, matiec, compiler)
        except TranslationError as error:
            raise explain(error, source, project, matiec) from None
        except RefusedCodeError as error:
            raise explain_code(error, project) from None
        return cls(project, image)


def _check_order(project: Project) -> None:
    """Raise InputError if priorities change the order of programs; matiec ignores priorities."""
    declared = list(project.instances)
    if [run.instance for run in project.schedule] == declared:
        return
    place = next(unit for unit in project.units if unit.kind == "CONFIGURATION")
    wanted = ", ".join(run.instance for run in project.schedule)
    raise InputError(
        f"matiec runs programs as they are declared ({', '.join(declared)}), not by priority",
        file=place.file,
        line=place.line,
        hint=f"declare them in the order {wanted}",
    )


def _moment_codec(kind: ElementaryType) -> Codec:
    """Return the codec of TIME, DATE, TOD and DT: seconds and nanoseconds, each a C long.

    Values are rounded to whole microseconds, because matiec computes literals such as T#1300ms
    in floating point and may be wrong by one nanosecond.
    """
    packer = struct.Struct("@ll")

    def get(memory: memoryview, at: int) -> Value:
        seconds, nanoseconds = packer.unpack_from(memory, at)
        microseconds = seconds * 1_000_000 + (nanoseconds + 500) // 1000
        return scalar_to_python(kind, microseconds * 1000)

    def put(memory: memoryview, at: int, value: Value) -> None:
        seconds, nanoseconds = divmod(abs(value), 1_000_000_000)
        sign = -1 if value < 0 else 1
        packer.pack_into(memory, at, sign * seconds, sign * nanoseconds)

    return Codec(packer.size, get, put)


def _string_codec(size: int) -> Codec:
    """Return the codec of a STRING: a byte with the length, then the characters."""

    def get(memory: memoryview, at: int) -> Value:
        return bytes(memory[at + 1 : at + 1 + memory[at]]).decode("latin-1")

    def put(memory: memoryview, at: int, value: Value) -> None:
        text = value.encode("latin-1")
        memory[at] = len(text)
        memory[at + 1 : at + size] = text.ljust(size - 1, b"\0")

    return Codec(size, get, put)
