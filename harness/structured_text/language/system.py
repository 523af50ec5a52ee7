"""The namespace `__SYSTEM` of CODESYS and TwinCAT: ANY, its classes and IQueryInterface.

The declarations are Structured Text. If a program uses one of them, it is added to the program's
declarations.
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

__all__ = [
    "ANY_TYPE",
    "EXCEPTION_CODES",
    "GROUPS",
    "QUERY",
    "SPACE",
    "class_of",
    "system_declaration",
]

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
#: The members of ExceptionCode with their numbers, the prefix RTSEXCPT_ left out: Beckhoff InfoSys,
#: TwinCAT 3 PLC, data type __SYSTEM.ExceptionCode (6753940235). CODESYS has the same members.
EXCEPTION_CODES = {
    "UNKNOWN": 0xFFFFFFFF,
    "NOEXCEPTION": 0,
    "WATCHDOG": 0x10,
    "HARDWAREWATCHDOG": 0x11,
    "IO_CONFIG_ERROR": 0x12,
    "PROGRAMCHECKSUM": 0x13,
    "FIELDBUS_ERROR": 0x14,
    "IOUPDATE_ERROR": 0x15,
    "CYCLE_TIME_EXCEED": 0x16,
    "ONLCHANGE_PROGRAM_EXCEEDED": 0x17,
    "UNRESOLVED_EXTREFS": 0x18,
    "DOWNLOAD_REJECTED": 0x19,
    "BOOTPROJECT_REJECTED_DUE_RETAIN_ERROR": 0x1A,
    "LOADBOOTPROJECT_FAILED": 0x1B,
    "OUT_OF_MEMORY": 0x1C,
    "RETAIN_MEMORY_ERROR": 0x1D,
    "BOOTPROJECT_CRASH": 0x1E,
    "BOOTPROJECTTARGETMISMATCH": 0x21,
    "SCHEDULEERROR": 0x22,
    "FILE_CHECKSUM_ERR": 0x23,
    "RETAIN_IDENTITY_MISMATCH": 0x24,
    "IEC_TASK_CONFIG_ERROR": 0x25,
    "APP_TARGET_MISMATCH": 0x26,
    "ILLEGAL_INSTRUCTION": 0x50,
    "ACCESS_VIOLATION": 0x51,
    "PRIV_INSTRUCTION": 0x52,
    "IN_PAGE_ERROR": 0x53,
    "STACK_OVERFLOW": 0x54,
    "INVALID_DISPOSITION": 0x55,
    "INVALID_HANDLE": 0x56,
    "GUARD_PAGE": 0x57,
    "DOUBLE_FAULT": 0x58,
    "INVALID_OPCODE": 0x59,
    "MISALIGNMENT": 0x100,
    "ARRAYBOUNDS": 0x101,
    "DIVIDEBYZERO": 0x102,
    "OVERFLOW": 0x103,
    "NONCONTINUABLE": 0x104,
    "PROCESSORLOAD_WATCHDOG": 0x105,
    "FPU_ERROR": 0x150,
    "FPU_DENORMAL_OPERAND": 0x151,
    "FPU_DIVIDEBYZERO": 0x152,
    "FPU_INEXACT_RESULT": 0x153,
    "FPU_INVALID_OPERATION": 0x154,
    "FPU_OVERFLOW": 0x155,
    "FPU_STACK_CHECK": 0x156,
    "FPU_UNDERFLOW": 0x157,
    "VENDOR_EXCEPTION_BASE": 0x2000,
    "USER_EXCEPTION_BASE": 0x10000,
}
_EXCEPTIONS = ", ".join(f"RTSEXCPT_{name} := {n}" for name, n in EXCEPTION_CODES.items())
_TEXT = f"""
TYPE ExceptionCode : ({_EXCEPTIONS}) UDINT; END_TYPE
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
    """Return the number that TYPE_CLASS gives to the class of a type."""
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


_NAMED = ("TYPE_CLASS", ANY_TYPE, "PVOID", "EXCEPTIONCODE")


@lru_cache(maxsize=1)
def _declared() -> dict[str, Declared]:
    from structured_text.language.parser import read_text  # imported late: it loads the grammar

    source = read_text(_TEXT, Path(SPACE))
    found: dict[str, Declared] = {}
    for node in source.declarations:
        assert isinstance(node, (s.TypeDecl, s.Interface))
        found[node.name.key] = Declared(node, source)
    return found


def system_declaration(key: str) -> Declared | None:
    """Return a declaration of `__SYSTEM` by its upper-case name; None for other names."""
    return _declared().get(key) if key in (*_NAMED, QUERY) else None
