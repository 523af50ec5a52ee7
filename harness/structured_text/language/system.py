"""The namespace `__SYSTEM` of CODESYS and TwinCAT: ANY, its classes and IQueryInterface.

The declarations are Structured Text. If a program names them, they are used like its own.
"""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

from structured_text.language import syntax as s
from structured_text.language.registry import Declared
from structured_text.language.scalars import (
    ANY_BIT,
    ANY_DATE,
    ANY_DURATION,
    ANY_INT,
    ANY_NUM,
    ANY_REAL,
    ANY_STRING,
    SIGNED,
    UNSIGNED,
)
from structured_text.language.types import (
    ArrayType,
    ElementaryType,
    EnumType,
    ReferenceType,
    StructType,
    Type,
)

__all__ = ["ANY_TYPE", "GROUPS", "QUERY", "SPACE", "class_of", "system_declaration"]

SPACE, QUERY, ANY_TYPE = "__SYSTEM", "IQUERYINTERFACE", "ANYTYPE"
#: The names of generic types, with the elementary types of each; None for any type.
GROUPS: dict[str, tuple[str, ...] | None] = {
    "ANY": None,
    "ANY_BIT": ANY_BIT,
    "ANY_DATE": ANY_DATE,
    "ANY_DURATION": ANY_DURATION,
    "ANY_INT": ANY_INT,
    "ANY_NUM": ANY_NUM,
    "ANY_REAL": ANY_REAL,
    "ANY_SIGNED": SIGNED,
    "ANY_STRING": ANY_STRING,
    "ANY_UNSIGNED": UNSIGNED,
}
#: The members of TYPE_CLASS with their numbers: CODESYS help, library Base Interfaces, TypeClass.
_CLASSES = (
    *("BOOL", "BIT", "BYTE", "WORD", "DWORD", "LWORD", "SINT", "INT", "DINT", "LINT", "USINT"),
    *("UINT", "UDINT", "ULINT", "REAL", "LREAL", "STRING", "WSTRING", "TIME", "DATE"),
    *("DATEANDTIME", "TIMEOFDAY", "POINTER", "REFERENCE", "SUBRANGE", "ENUM", "ARRAY", "PARAMS"),
    *("USERDEF", "NONE", "ANY", "ANYBIT", "ANYDATE", "ANYINT", "ANYNUM", "ANYREAL", "LAZY"),
    *("LTIME", "BITCONST", "UXINT", "XWORD", "XINT", "XSTRING", "VARLENARRAY", "ANYSTRING"),
    *("VECTOR", "LDATE", "LDATEANDTIME", "LTIMEOFDAY"),
)
_NAMES = {"DT": "DATEANDTIME", "TOD": "TIMEOFDAY", "LDT": "LDATEANDTIME", "LTOD": "LTIMEOFDAY"}
_TEXT = f"""
TYPE TYPE_CLASS : ({", ".join(f"TYPE_{name}" for name in _CLASSES)}) DWORD; END_TYPE
TYPE AnyType :
STRUCT
  TypeClass : TYPE_CLASS := TYPE_NONE;
  pValue : POINTER TO BYTE;
  diSize : DINT;
END_STRUCT
END_TYPE
TYPE PVOID : POINTER TO BYTE; END_TYPE
INTERFACE IQueryInterface
END_INTERFACE
"""


def class_of(kind: Type) -> int:
    """Return the number of a type's class in TYPE_CLASS."""
    name = "NONE"
    if isinstance(kind, ElementaryType):
        name = _NAMES.get(kind.name, kind.name)
    elif isinstance(kind, EnumType):
        name = "ENUM"
    elif isinstance(kind, ArrayType):
        name = "ARRAY"
    elif isinstance(kind, StructType):
        name = "USERDEF"
    elif isinstance(kind, ReferenceType):
        name = "POINTER"
    return _CLASSES.index(name if name in _CLASSES else "NONE")


@lru_cache(maxsize=1)
def _declared() -> dict[str, Declared]:
    from structured_text.language.parser import read_text  # imports the grammar

    source = read_text(_TEXT, Path(SPACE))
    found: dict[str, Declared] = {}
    for node in source.declarations:
        assert isinstance(node, (s.TypeDecl, s.Interface))
        found[node.name.key] = Declared(node, source)
    return found


def system_declaration(key: str) -> Declared | None:
    """Return a declaration of `__SYSTEM` by its upper-case name; None for other names."""
    return _declared().get(key) if key in ("TYPE_CLASS", ANY_TYPE, "PVOID", QUERY) else None
