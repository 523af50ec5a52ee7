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
    Variable,
)

__all__ = [
    "ArrayInit",
    "ArraySpec",
    "ConfigEntry",
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
    "TaskDeclaration",
    "TypeDecl",
    "TypeSpec",
    "VarDecl",
]


@dataclass(frozen=True)
class NamedSpec:
    """A type given by its name; `length` is the length of a STRING.

    `generics` are the values of the generic constants of a block: `Buffer<6>`.

    `arguments` are the arguments behind the name of a block: `Front : Drive(Axis := 1);`. `empty`
    is true for parentheses without arguments: `Start : R_TRIG();`.
    """

    name: Name
    at: Position
    length: Expression | None = None
    arguments: tuple[Argument, ...] = ()
    empty: bool = False
    generics: tuple[Expression, ...] = ()


@dataclass(frozen=True)
class SubrangeSpec:
    """A subrange: `INT (low..high)`."""

    base: NamedSpec
    low: Expression
    high: Expression
    at: Position


@dataclass(frozen=True)
class ArraySpec:
    """An array: `ARRAY [dimensions] OF element`."""

    dimensions: tuple[Range, ...]
    element: TypeSpec
    at: Position


@dataclass(frozen=True)
class EnumSpec:
    """An enumeration `(MEMBER, MEMBER := 5, …)`; `values` has one entry per member.

    `attributes` are the names in its pragmas `{attribute 'strict'}` and `{attribute 'to_string'}`.
    """

    members: tuple[Name, ...]
    at: Position
    values: tuple[Expression | None, ...] = ()
    base: NamedSpec | None = None
    attributes: frozenset[str] = frozenset()

    @property
    def explicit(self) -> bool:
        """Return whether a member has an explicit value."""
        return any(value is not None for value in self.values)


@dataclass(frozen=True)
class StructSpec:
    """A structure, `STRUCT … END_STRUCT`, or a union, `UNION … END_UNION`."""

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
    """`[1, 2, 3(0)]` as pairs of (repetitions, value); without a factor, repetitions is None."""

    items: tuple[tuple[Expression | None, Init], ...]
    at: Position


@dataclass(frozen=True)
class Sequence:
    """The repeated values of `3(1, 2)`. A single value is not a `Sequence`; `3()` is empty."""

    items: tuple[tuple[Expression | None, Init], ...]
    at: Position


@dataclass(frozen=True)
class StructInit:
    """The initial value of a structure, `(field := value, …)`."""

    fields: tuple[tuple[Name, Init], ...]
    at: Position


Init = ArrayInit | Sequence | StructInit | Expression


@dataclass(frozen=True)
class VarDecl:
    """A declaration of one or more variables of one type; `address` stands behind AT: `%QW3`.

    `bound` is true if the initial value stands behind REF=.
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

    `qualifier` is CONSTANT if the section has it, else the first qualifier, or empty.
    `access` is its access word in upper case, as in `VAR PRIVATE`, or empty.
    """

    kind: str
    qualifier: str
    variables: tuple[VarDecl, ...]
    at: Position
    access: str = ""


@dataclass(frozen=True)
class TypeDecl:
    """A single type of a TYPE … END_TYPE."""

    name: Name
    spec: TypeSpec
    initial: Init | None
    at: Position
    extends: Name | None = None


@dataclass(frozen=True)
class Method:
    """A METHOD, or an ACTION, which has no parameters.

    `words` are the access words in upper case.
    """

    name: Name
    words: tuple[str, ...]
    result: TypeSpec | None
    sections: tuple[Section, ...]
    body: tuple[Statement, ...]
    at: Position


@dataclass(frozen=True)
class Property:
    """A PROPERTY. GET and SET are methods of the same name, or None."""

    name: Name
    words: tuple[str, ...]
    result: TypeSpec
    getter: Method | None
    setter: Method | None
    at: Position


@dataclass(frozen=True)
class Interface:
    """An INTERFACE. Its methods have no statements."""

    name: Name
    extends: tuple[Name, ...]
    members: tuple[Method | Property, ...]
    at: Position


@dataclass(frozen=True)
class GlobalList:
    """A list of global variables outside of a CONFIGURATION, named after the file.

    `qualified` is true if its variables must be written with the name of the list (the attribute
    `qualified_only`).
    """

    name: Name
    section: Section
    at: Position
    qualified: bool = False


@dataclass(frozen=True)
class Pou:
    """A function, function block or program; `kind` is its upper-case opening word.

    `words` are the access words of a block in upper case. `members` are its methods and properties.
    `generics` are the values that it gives to the generic constants of its base block.
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
    generics: tuple[Expression, ...] = ()


@dataclass(frozen=True)
class TaskDeclaration:
    """A task: `TASK name (INTERVAL := …, PRIORITY := …)`."""

    name: Name
    settings: tuple[tuple[Name, Expression], ...]
    at: Position


@dataclass(frozen=True)
class ProgramInstance:
    """A program instance: `PROGRAM name WITH task : program`.

    `connected` is true if variables are connected in parentheses.
    """

    name: Name
    task: Name | None
    program: Name
    connected: bool
    at: Position


@dataclass(frozen=True)
class ConfigEntry:
    """The address or initial value of a variable of an instance, in VAR_CONFIG.

    `path` leads from the program to the variable: `Main.Front.Ready`.
    """

    path: Variable
    address: Name | None
    spec: TypeSpec
    initial: Init | None
    at: Position


@dataclass(frozen=True)
class Configuration:
    """A CONFIGURATION with at most one RESOURCE."""

    name: Name
    globals: tuple[Section, ...]
    tasks: tuple[TaskDeclaration, ...]
    programs: tuple[ProgramInstance, ...]
    resources: int
    at: Position


Declaration = TypeDecl | Pou | Interface | Configuration | GlobalList


@dataclass(frozen=True)
class Namespace:
    """The dotted name of a NAMESPACE, or of a USING if `used` is true."""

    name: Name
    used: bool
    at: Position


@dataclass(frozen=True)
class Source:
    """All declarations of a file, in its order.

    Attributes:
        declarations: The declarations, as far as they could be read.
        uses: Constructs beyond the portable subset (`constructs.Use`).
        pragmas: The contents of { }.
        errors: The errors of the lexer and the parser.
        namespaces: The namespaces that the file declares and uses.
        characters: Length of the text of the file.
        tokens: Number of words, numbers and signs.
        entries: The entries of VAR_CONFIG.
    """

    file: Path
    declarations: tuple[Declaration, ...]
    uses: tuple[Any, ...] = ()
    pragmas: tuple[Name, ...] = ()
    errors: tuple[InputError, ...] = ()
    namespaces: tuple[Namespace, ...] = ()
    characters: int = 0
    tokens: int = 0
    entries: tuple[ConfigEntry, ...] = ()
