"""Declarations as they are written: types, variables, POUs, configurations."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from structured_text.errors import InputError
from structured_text.language.syntax.code import (
    Argument,
    Expression,
    Name,
    Position,
    Range,
    Statement,
)

__all__ = [
    "ArrayInit",
    "ArraySpec",
    "Configuration",
    "Declaration",
    "EnumSpec",
    "GlobalList",
    "Init",
    "Interface",
    "Method",
    "NamedSpec",
    "Namespace",
    "PointerSpec",
    "Pou",
    "ProgramInstance",
    "Property",
    "Section",
    "Sequence",
    "Source",
    "StructInit",
    "StructSpec",
    "SubrangeSpec",
    "Task",
    "TypeDecl",
    "TypeSpec",
    "VarDecl",
]


@dataclass(frozen=True)
class NamedSpec:
    """A type given by its name; `length` is that of a STRING.

    `arguments` are those behind the name of a block: `Front : Drive(Axis := 1);`.
    """

    name: Name
    at: Position
    length: Expression | None = None
    arguments: tuple[Argument, ...] = ()


@dataclass(frozen=True)
class SubrangeSpec:
    """INT (low..high)."""

    base: NamedSpec
    low: Expression
    high: Expression
    at: Position


@dataclass(frozen=True)
class ArraySpec:
    """ARRAY [dimensions] OF element."""

    dimensions: tuple[Range, ...]
    element: TypeSpec
    at: Position


@dataclass(frozen=True)
class EnumSpec:
    """(MEMBER, MEMBER := 5, …); `values` has one entry for each member, `base` is its type."""

    members: tuple[Name, ...]
    at: Position
    values: tuple[Expression | None, ...] = ()
    base: NamedSpec | None = None

    @property
    def explicit(self) -> bool:
        """Is a member given a value?"""
        return any(value is not None for value in self.values)


@dataclass(frozen=True)
class StructSpec:
    """STRUCT … END_STRUCT, or UNION … END_UNION."""

    fields: tuple[VarDecl, ...]
    at: Position
    union: bool = False


@dataclass(frozen=True)
class PointerSpec:
    """POINTER TO, REFERENCE TO or REF_TO a type; `kind` is the first word in upper case."""

    kind: str
    target: TypeSpec
    at: Position


TypeSpec = NamedSpec | ArraySpec | EnumSpec | StructSpec | SubrangeSpec | PointerSpec


@dataclass(frozen=True)
class ArrayInit:
    """`[1, 2, 3(0)]`: pairs of (how often, value); how often is None for once."""

    items: tuple[tuple[Expression | None, Init], ...]
    at: Position


@dataclass(frozen=True)
class Sequence:
    """What `3(1, 2)` repeats where that is not one value; nothing in `3()`."""

    items: tuple[tuple[Expression | None, Init], ...]
    at: Position


@dataclass(frozen=True)
class StructInit:
    """`(field := value, …)`."""

    fields: tuple[tuple[Name, Init], ...]
    at: Position


Init = ArrayInit | Sequence | StructInit | Expression


@dataclass(frozen=True)
class VarDecl:
    """One or more variables of one type; `address` is the `%QW3` of an AT.

    `bound` where the initial value stands behind REF=.
    """

    names: tuple[Name, ...]
    spec: TypeSpec
    initial: Init | None
    address: Name | None
    at: Position
    bound: bool = False


@dataclass(frozen=True)
class Section:
    """A VAR … END_VAR section; `kind` is its upper-case opening word.

    `qualifier` is CONSTANT where that is one of them, else the first one, or empty.
    """

    kind: str
    qualifier: str
    variables: tuple[VarDecl, ...]
    at: Position


@dataclass(frozen=True)
class TypeDecl:
    """One type of a TYPE … END_TYPE."""

    name: Name
    spec: TypeSpec
    initial: Init | None
    at: Position
    extends: Name | None = None


@dataclass(frozen=True)
class Method:
    """A METHOD, or an ACTION, which takes nothing; `words` are its access words in upper case."""

    name: Name
    words: tuple[str, ...]
    result: TypeSpec | None
    sections: tuple[Section, ...]
    body: tuple[Statement, ...]
    at: Position
    action: bool = False


@dataclass(frozen=True)
class Property:
    """A PROPERTY; its GET and SET are methods of its name, None where it has none."""

    name: Name
    words: tuple[str, ...]
    result: TypeSpec
    getter: Method | None
    setter: Method | None
    at: Position


@dataclass(frozen=True)
class Interface:
    """An INTERFACE; its methods have no statements."""

    name: Name
    extends: tuple[Name, ...]
    members: tuple[Method | Property, ...]
    at: Position


@dataclass(frozen=True)
class GlobalList:
    """A list of global variables outside of a CONFIGURATION; its name is that of the file.

    `qualified` where a variable can only be named with it (the attribute `qualified_only`).
    """

    name: Name
    section: Section
    at: Position
    qualified: bool = False


@dataclass(frozen=True)
class Pou:
    """A function, function block or program; `kind` is its upper-case opening word.

    `words` are the access words of a block in upper case, `members` its methods and properties.
    """

    kind: str
    name: Name
    result: TypeSpec | None
    sections: tuple[Section, ...]
    body: tuple[Statement, ...]
    at: Position
    words: tuple[str, ...] = ()
    extends: Name | None = None
    implements: tuple[Name, ...] = ()
    members: tuple[Method | Property, ...] = ()


@dataclass(frozen=True)
class Task:
    """TASK name (INTERVAL := …, PRIORITY := …)."""

    name: Name
    settings: tuple[tuple[Name, Expression], ...]
    at: Position


@dataclass(frozen=True)
class ProgramInstance:
    """PROGRAM name WITH task : program; `connected` where variables are connected in ()."""

    name: Name
    task: Name | None
    program: Name
    connected: bool
    at: Position


@dataclass(frozen=True)
class Configuration:
    """CONFIGURATION with at most one RESOURCE."""

    name: Name
    globals: tuple[Section, ...]
    tasks: tuple[Task, ...]
    programs: tuple[ProgramInstance, ...]
    resources: int
    at: Position


Declaration = TypeDecl | Pou | Interface | Configuration | GlobalList


@dataclass(frozen=True)
class Namespace:
    """The dotted name of a NAMESPACE, or of a USING where `used` is true."""

    name: Name
    used: bool
    at: Position


@dataclass(frozen=True)
class Source:
    """Everything one file declares, in its order.

    Attributes:
        file: Where it comes from.
        declarations: What it declares, as far as it could be read.
        uses: Constructs beyond the portable subset (`constructs.Use`).
        pragmas: What is in { }.
        errors: What could not be read.
        namespaces: Those it declares and uses.
        characters: How long its text is.
        tokens: How many words, numbers and signs it has.
    """

    file: Path
    declarations: tuple[Declaration, ...]
    uses: tuple[Any, ...] = ()
    pragmas: tuple[Name, ...] = ()
    errors: tuple[InputError, ...] = ()
    namespaces: tuple[Namespace, ...] = ()
    characters: int = 0
    tokens: int = 0
