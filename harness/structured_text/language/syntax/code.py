"""Expressions and statements as they are written."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

__all__ = [
    "Argument",
    "Assign",
    "AssignChain",
    "Binary",
    "Call",
    "CallStatement",
    "Case",
    "CaseBranch",
    "Continue",
    "Dereference",
    "Exit",
    "Expression",
    "Field",
    "For",
    "If",
    "Index",
    "Invoke",
    "Latch",
    "Literal",
    "Name",
    "Part",
    "Position",
    "Range",
    "Repeat",
    "Return",
    "Statement",
    "This",
    "Unary",
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
class Part:
    """A part of a bit string or integer: `base.3` and `base.%X3` are a bit, `base.%B1` a byte.

    `size` is X, B, W or D.
    """

    base: Variable
    size: str
    number: int
    at: Position


@dataclass(frozen=True)
class Dereference:
    """What a pointer points to: `base^`."""

    base: Variable
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


@dataclass(frozen=True)
class This:
    """`THIS^`, or `SUPER^` where `above` is true; `pointer` for a THIS that has no `^`."""

    above: bool
    at: Position
    pointer: bool = False


@dataclass(frozen=True)
class Invoke:
    """A call of something that is not named by a single word: `a.b(…)`, `SUPER^.m(…)`."""

    callee: Variable
    arguments: tuple[Argument, ...]
    at: Position


Variable = Name | Field | Index | Part | Dereference | This
#: A `Variable` may also begin with a call: `f(…).x`.
Expression = Literal | Variable | Unary | Binary | Call | Invoke


# --- statements ----------------------------------------------------------------------------


@dataclass(frozen=True)
class Assign:
    """`target := value;`."""

    target: Variable
    value: Expression
    at: Position


@dataclass(frozen=True)
class AssignChain:
    """`first := second := value;`."""

    targets: tuple[Variable, ...]
    value: Expression
    at: Position


@dataclass(frozen=True)
class Latch:
    """`target S= value;` or `R=` or `REF=`; `op` is S, R or REF."""

    target: Variable
    op: str
    value: Expression
    at: Position


@dataclass(frozen=True)
class CallStatement:
    """A call as a statement: of a block's instance, a function and the like."""

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

    counter: Variable
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


@dataclass(frozen=True)
class Continue:
    """CONTINUE."""

    at: Position


Statement = (
    Assign
    | AssignChain
    | Latch
    | CallStatement
    | If
    | Case
    | For
    | While
    | Repeat
    | Exit
    | Return
    | Continue
)
