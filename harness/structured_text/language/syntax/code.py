"""Expressions and statements as they are written."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

__all__ = [
    "Argument",
    "Assign",
    "AssignChain",
    "Assigned",
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
    "Try",
    "TypeName",
    "Unary",
    "Variable",
    "While",
]


class Position(NamedTuple):
    """The place where a construct begins; line and column count from 1."""

    line: int
    column: int


@dataclass(frozen=True)
class Name:
    """An identifier at its declaration or use."""

    text: str
    at: Position

    @property
    def key(self) -> str:
        """Return the name in upper case, the form in which names are compared."""
        return self.text.upper()


# --- expressions ---------------------------------------------------------------------------


@dataclass(frozen=True)
class Literal:
    """A literal as it is written.

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
    """The variable that a pointer points to: `base^`."""

    base: Variable
    at: Position


@dataclass(frozen=True)
class Unary:
    """A unary operation: `-x` or `NOT x`."""

    op: str
    operand: Expression
    at: Position


@dataclass(frozen=True)
class Binary:
    """A binary operation: `left op right`, with `op` in upper case."""

    op: str
    left: Expression
    right: Expression
    at: Position


@dataclass(frozen=True)
class Argument:
    """An argument of a call; `name` is None if it is positional, `output` is true for `=>`."""

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
    """`THIS^`, or `SUPER^` if `above` is true; `pointer` is true for a THIS without `^`."""

    above: bool
    at: Position
    pointer: bool = False


@dataclass(frozen=True)
class Invoke:
    """A call of an element with a path: `a.b(…)`, `SUPER^.m(…)`."""

    callee: Variable
    arguments: tuple[Argument, ...]
    at: Position


@dataclass(frozen=True)
class Assigned:
    """An assignment inside an expression, `(target := value)`; it has the value of the target."""

    target: Variable
    value: Expression
    at: Position


@dataclass(frozen=True)
class TypeName:
    """A type as an argument, as in `__NEW(POINTER TO INT, 3)`; `spec` is its specification."""

    spec: Any
    at: Position


Variable = Name | Field | Index | Part | Dereference | This
#: A `Variable` may also begin with a call: `f(…).x`.
Expression = Literal | Variable | Unary | Binary | Call | Invoke | Assigned | TypeName


# --- statements ----------------------------------------------------------------------------


@dataclass(frozen=True)
class Assign:
    """An assignment: `target := value;`."""

    target: Variable
    value: Expression
    at: Position


@dataclass(frozen=True)
class AssignChain:
    """An assignment to several targets: `first := second := value;`."""

    targets: tuple[Variable, ...]
    value: Expression
    at: Position


@dataclass(frozen=True)
class Latch:
    """A latch, `target S= value;` or `R=`, or a binding `REF=`; `op` is S, R or REF."""

    target: Variable
    op: str
    value: Expression
    at: Position


@dataclass(frozen=True)
class CallStatement:
    """A call as a statement: of a block instance, a function, a method or an action.

    `bare` is true for a name alone, without parentheses.
    """

    callee: Variable
    arguments: tuple[Argument, ...]
    at: Position
    bare: bool = False


@dataclass(frozen=True)
class If:
    """An IF; `branches` holds (condition, statements) of IF and each ELSIF."""

    branches: tuple[tuple[Expression, tuple[Statement, ...]], ...]
    otherwise: tuple[Statement, ...]
    at: Position


@dataclass(frozen=True)
class Range:
    """A range `low..high`: a CASE label or an array dimension."""

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
    """A CASE statement: `CASE … OF … ELSE … END_CASE`."""

    selector: Expression
    branches: tuple[CaseBranch, ...]
    otherwise: tuple[Statement, ...]
    at: Position


@dataclass(frozen=True)
class For:
    """A loop `FOR counter := start TO end BY step DO …`; `step` is None without BY."""

    counter: Variable
    start: Expression
    end: Expression
    step: Expression | None
    body: tuple[Statement, ...]
    at: Position


@dataclass(frozen=True)
class While:
    """A loop `WHILE condition DO … END_WHILE`."""

    condition: Expression
    body: tuple[Statement, ...]
    at: Position


@dataclass(frozen=True)
class Repeat:
    """A loop `REPEAT … UNTIL condition END_REPEAT`."""

    body: tuple[Statement, ...]
    condition: Expression
    at: Position


@dataclass(frozen=True)
class Try:
    """A `__TRY` with the handler of its exceptions; `code` is the variable of `__CATCH(code)`.

    `last` has the statements of `__FINALLY`.
    """

    body: tuple[Statement, ...]
    code: Variable | None
    handler: tuple[Statement, ...]
    last: tuple[Statement, ...]
    at: Position


@dataclass(frozen=True)
class Exit:
    """An EXIT statement."""

    at: Position


@dataclass(frozen=True)
class Return:
    """A RETURN statement."""

    at: Position


@dataclass(frozen=True)
class Continue:
    """A CONTINUE statement."""

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
    | Try
    | Exit
    | Return
    | Continue
)
