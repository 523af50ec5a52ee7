"""The parsed source as it is written: declarations, statements and expressions with positions.

Nothing here is checked yet; names are as the user spelt them. The nodes are immutable, so that
one parse of a library file serves every project that uses it.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

__all__ = [
    "Argument",
    "ArrayInit",
    "ArraySpec",
    "Assign",
    "Binary",
    "Call",
    "CallStatement",
    "Case",
    "CaseBranch",
    "Configuration",
    "EnumSpec",
    "Exit",
    "Expression",
    "Field",
    "For",
    "If",
    "Index",
    "Init",
    "Literal",
    "Name",
    "NamedSpec",
    "Position",
    "Pou",
    "ProgramInstance",
    "Range",
    "Repeat",
    "Return",
    "Section",
    "Source",
    "Statement",
    "StructInit",
    "StructSpec",
    "Task",
    "TypeDecl",
    "TypeSpec",
    "Unary",
    "VarDecl",
    "Variable",
    "While",
]


class Position(NamedTuple):
    """Where a construct begins; line and column count from 1."""

    line: int
    column: int


@dataclass(frozen=True)
class Name:
    """An identifier where it is declared or used."""

    text: str
    at: Position

    @property
    def key(self) -> str:
        """The name as names are compared: without case."""
        return self.text.upper()


# --- expressions ---------------------------------------------------------------------------


@dataclass(frozen=True)
class Literal:
    """A literal as written.

    `kind` is INTEGER, REALNUM, STRING, BOOLEAN or TYPED (`WORD#16#FF`, `T#1s`, `COLOUR#RED`).
    """

    kind: str
    text: str
    at: Position


@dataclass(frozen=True)
class Field:
    """A member of a structure or block: `base.name`."""

    base: Variable
    name: Name
    at: Position


@dataclass(frozen=True)
class Index:
    """An element of an array: `base[i, j]`."""

    base: Variable
    indices: tuple[Expression, ...]
    at: Position


@dataclass(frozen=True)
class Unary:
    """`-x` or `NOT x`."""

    op: str
    operand: Expression
    at: Position


@dataclass(frozen=True)
class Binary:
    """`left op right`; `op` in upper case."""

    op: str
    left: Expression
    right: Expression
    at: Position


@dataclass(frozen=True)
class Argument:
    """One argument of a call; `name` is None for a positional one, `output` true for `=>`."""

    name: Name | None
    value: Expression
    output: bool
    at: Position


@dataclass(frozen=True)
class Call:
    """A function call in an expression."""

    function: Name
    arguments: tuple[Argument, ...]
    at: Position


Variable = Name | Field | Index
Expression = Literal | Name | Field | Index | Unary | Binary | Call


# --- statements ----------------------------------------------------------------------------


@dataclass(frozen=True)
class Assign:
    """`target := value;`."""

    target: Variable
    value: Expression
    at: Position


@dataclass(frozen=True)
class CallStatement:
    """A call of a function block instance."""

    callee: Variable
    arguments: tuple[Argument, ...]
    at: Position


@dataclass(frozen=True)
class If:
    """`branches` holds (condition, statements) of IF and each ELSIF."""

    branches: tuple[tuple[Expression, tuple[Statement, ...]], ...]
    otherwise: tuple[Statement, ...]
    at: Position


@dataclass(frozen=True)
class Range:
    """`low..high` as a CASE label or an array dimension."""

    low: Expression
    high: Expression
    at: Position


@dataclass(frozen=True)
class CaseBranch:
    """The labels of one branch of a CASE and its statements."""

    labels: tuple[Expression | Range, ...]
    body: tuple[Statement, ...]
    at: Position


@dataclass(frozen=True)
class Case:
    """CASE … OF … ELSE … END_CASE."""

    selector: Expression
    branches: tuple[CaseBranch, ...]
    otherwise: tuple[Statement, ...]
    at: Position


@dataclass(frozen=True)
class For:
    """FOR counter := start TO end BY step DO …; `step` is None where it is left out."""

    counter: Name
    start: Expression
    end: Expression
    step: Expression | None
    body: tuple[Statement, ...]
    at: Position


@dataclass(frozen=True)
class While:
    """WHILE condition DO … END_WHILE."""

    condition: Expression
    body: tuple[Statement, ...]
    at: Position


@dataclass(frozen=True)
class Repeat:
    """REPEAT … UNTIL condition END_REPEAT."""

    body: tuple[Statement, ...]
    condition: Expression
    at: Position


@dataclass(frozen=True)
class Exit:
    """EXIT."""

    at: Position


@dataclass(frozen=True)
class Return:
    """RETURN."""

    at: Position


Statement = Assign | CallStatement | If | Case | For | While | Repeat | Exit | Return


# --- declarations --------------------------------------------------------------------------


@dataclass(frozen=True)
class NamedSpec:
    """A type given by its name; `extra` names what follows it and is not supported."""

    name: Name
    at: Position
    extra: str = ""


@dataclass(frozen=True)
class ArraySpec:
    """ARRAY [dimensions] OF element."""

    dimensions: tuple[Range, ...]
    element: TypeSpec
    at: Position


@dataclass(frozen=True)
class EnumSpec:
    """(MEMBER, MEMBER, …); `explicit` where a member is given a value."""

    members: tuple[Name, ...]
    at: Position
    explicit: bool = False


@dataclass(frozen=True)
class StructSpec:
    """STRUCT … END_STRUCT."""

    fields: tuple[VarDecl, ...]
    at: Position


TypeSpec = NamedSpec | ArraySpec | EnumSpec | StructSpec


@dataclass(frozen=True)
class ArrayInit:
    """`[1, 2, 3(0)]`: pairs of (how often, value)."""

    items: tuple[tuple[Expression | None, Init], ...]
    at: Position


@dataclass(frozen=True)
class StructInit:
    """`(field := value, …)`."""

    fields: tuple[tuple[Name, Init], ...]
    at: Position


Init = ArrayInit | StructInit | Expression


@dataclass(frozen=True)
class VarDecl:
    """One or more variables of one type; `address` is the `%QW3` of an AT."""

    names: tuple[Name, ...]
    spec: TypeSpec
    initial: Init | None
    address: Name | None
    at: Position


@dataclass(frozen=True)
class Section:
    """A VAR … END_VAR section; `kind` is its upper-case opening word."""

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


@dataclass(frozen=True)
class Pou:
    """A function, function block or program; `kind` is its upper-case opening word."""

    kind: str
    name: Name
    result: NamedSpec | None
    sections: tuple[Section, ...]
    body: tuple[Statement, ...]
    at: Position


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


@dataclass(frozen=True)
class Source:
    """Everything one file declares, in its order."""

    file: Path
    declarations: tuple[TypeDecl | Pou | Configuration, ...]
