"""The checked program: every name resolved, every expression typed.

Engines generate code from this tree. Every conversion is an explicit call. An untyped literal has
the type that its context requires. Operators and standard functions are resolved to their operand
type.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from structured_text.language import syntax as s
from structured_text.language.later import Part
from structured_text.language.scalars import Scalar
from structured_text.language.syntax import Position
from structured_text.language.types import BlockType, ReferenceType, Type

__all__ = [
    "AFTER_CALL",
    "Address",
    "Assign",
    "Assigned",
    "Binary",
    "CallBase",
    "CallBlock",
    "CallFunction",
    "CallMethod",
    "Case",
    "Constant",
    "Delete",
    "Deref",
    "Evaluate",
    "Expression",
    "For",
    "Generic",
    "If",
    "Index",
    "Member",
    "New",
    "Null",
    "Offset",
    "Pou",
    "Query",
    "Recast",
    "Repeat",
    "Same",
    "Standard",
    "Statement",
    "Symbol",
    "This",
    "Try",
    "Unary",
    "Use",
    "Valid",
    "Variable",
    "While",
]


@dataclass(eq=False)
class Symbol:
    """A declared variable.

    `section` is VAR, VAR_INPUT, VAR_OUTPUT, VAR_IN_OUT, VAR_TEMP, VAR_EXTERNAL, VAR_GLOBAL or, for
    the variable that holds a function's result, RESULT. `initial` is the complete initial value as
    returned by `resolve.Types.initial_value`. `source` is the key of the global variable behind a
    VAR_EXTERNAL, if the two names differ. `addressed` is true if the program makes a pointer to the
    variable. `started` is true if the declaration passes arguments to the block. `shared` is true
    for a VAR_IN_OUT that methods of the block use. `calculated` is true if its initial value is not
    constant; `parts` are the parts of the initial value that are not constant. `retain` is true if
    it keeps its value over a warm start. `area` is I, Q or M if the tool chooses the address
    (`%I*`). `access` is PRIVATE if only the block `owner` (upper case) may use the variable. It is
    PROTECTED if blocks that extend `owner` may also use it. `passed` is true for a VAR_IN_OUT
    CONSTANT that is passed by value.
    """

    name: str
    type: Type
    section: str
    at: Position
    initial: Any = None
    constant: bool = False
    address: str | None = None
    source: str = ""
    addressed: bool = False
    started: bool = False
    shared: bool = False
    calculated: bool = False
    parts: tuple[Part, ...] = ()
    retain: bool = False
    area: str = ""
    access: str = ""
    owner: str = ""
    passed: bool = False


@dataclass(frozen=True)
class Constant:
    """A literal or enumeration member; `typed` if the source names its type."""

    value: Scalar
    type: Type
    typed: bool = False


@dataclass(frozen=True)
class Use:
    """An access to a variable of the POU by its symbol."""

    symbol: Symbol
    type: Type


@dataclass(frozen=True)
class Member:
    """A field of a structure or a pin of a block instance. The base may be a call's result."""

    base: Variable
    name: str
    type: Type


@dataclass(frozen=True)
class Index:
    """An element of an array, with one index per dimension."""

    base: Variable
    indices: tuple[Expression, ...]
    type: Type


@dataclass(frozen=True)
class Unary:
    """A negation: `op` is - or NOT. The operand has the type of the result."""

    op: str
    operand: Expression
    type: Type


@dataclass(frozen=True)
class Binary:
    """An operation on two operands.

    `op` is one of + - * / MOD ** AND OR XOR AND_THEN OR_ELSE = <> < > <= >=. Both operands have the
    same type, except in `TIME * number`, `TIME / number` and `real ** number`.
    """

    op: str
    left: Expression
    right: Expression
    type: Type


@dataclass(frozen=True)
class CallFunction:
    """A call of a function of the sources, with one argument per VAR_INPUT.

    An argument is None if the default applies. `in_outs` holds (pin, variable) for every
    VAR_IN_OUT, `outputs` (pin, target). The type of a function without a result is the elementary
    type with an empty name.
    """

    function: str
    arguments: tuple[Expression | None, ...]
    type: Type
    in_outs: tuple[tuple[str, Variable], ...] = ()
    outputs: tuple[tuple[str, Variable], ...] = ()


@dataclass(frozen=True)
class Standard:
    """A call of a standard function or conversion by its upper-case name."""

    name: str
    arguments: tuple[Expression, ...]
    type: Type


@dataclass(frozen=True)
class Assigned:
    """An assignment inside an expression; it has the new value of the target."""

    target: Variable
    value: Expression
    type: Type


# Object orientation and references: only the built-in engine runs these nodes.


@dataclass(frozen=True)
class This:
    """The instance that a method or body is executed for: `THIS^`."""

    type: Type


@dataclass(frozen=True)
class CallMethod:
    """A call of a method, or of the GET or SET of a property.

    Attributes:
        instance: The block, or a value of an interface.
        method: Name and parameters, as the static type of the instance declares them.
        final: Whether exactly this method is called (SUPER^), not the override of a derived block.
        arguments: One per VAR_INPUT; None for its default.
        in_outs: (name, variable) for every VAR_IN_OUT.
        outputs: (name, target) of each `=>`.
        type: Type of the result; the empty type if the method has no result.
    """

    instance: Expression
    method: Pou
    final: bool
    arguments: tuple[Expression | None, ...]
    in_outs: tuple[tuple[str, Variable], ...]
    outputs: tuple[tuple[str, Variable], ...]
    type: Type


@dataclass(frozen=True)
class Deref:
    """The variable that a pointer or reference leads to, `offset` elements further."""

    base: Expression
    type: Type
    offset: Expression | None = None


@dataclass(frozen=True)
class Address:
    """A pointer or reference to a variable."""

    variable: Variable
    type: Type


@dataclass(frozen=True)
class Offset:
    """A pointer moved by some bytes; `size` is the size of an element, `sign` is 1 or -1."""

    base: Expression
    bytes: Expression
    size: int
    sign: int
    type: Type


@dataclass(frozen=True)
class Recast:
    """A pointer to the same memory, which is read as another type."""

    base: Expression
    type: ReferenceType


@dataclass(frozen=True)
class Null:
    """The null pointer, or an interface value without a block."""

    type: Type


@dataclass(frozen=True)
class Valid:
    """The test whether a reference, or a VAR_IN_OUT of a block, refers to a variable."""

    reference: Expression
    type: Type


@dataclass(frozen=True)
class Same:
    """The comparison of two pointers or interfaces for equality (`op` is = or <>).

    For two pointers, `op` may also be < > <= >=, which compare positions in the same memory.
    """

    op: str
    left: Expression
    right: Expression
    type: Type


@dataclass(frozen=True)
class Generic:
    """The argument for an ANY input: a pointer to a variable, with its class and size [bytes]."""

    pointer: Expression
    number: int
    size: int
    type: Type


@dataclass(frozen=True)
class Query:
    """A call of `__QUERYINTERFACE` or `__QUERYPOINTER`; `blocks` are upper-case names of blocks.

    If the block of `source` is one of them, `target` becomes that block, or a pointer to it, and
    the result is TRUE. Otherwise `target` becomes 0 and the result is FALSE.
    """

    source: Expression
    target: Variable
    blocks: tuple[str, ...]
    type: Type


@dataclass(frozen=True)
class New:
    """A pointer to a variable made while the program runs, or to `count` variables in a row.

    `made` is the type of the variable, `initial` its initial value.
    """

    made: Type
    initial: Any
    count: Expression | None
    type: ReferenceType


@dataclass(frozen=True)
class Delete:
    """The release of a variable made by `New`; the pointer becomes 0, unless it is THIS."""

    pointer: Variable | Address
    type: Type


Variable = Use | Member | Index | This | CallMethod | Deref
Expression = (
    Constant
    | Unary
    | Binary
    | CallFunction
    | Standard
    | Variable
    | Address
    | Offset
    | Recast
    | Null
    | Valid
    | Same
    | Assigned
    | Generic
    | Query
    | New
    | Delete
)


@dataclass(frozen=True)
class Assign:
    """An assignment `target := value` of equal types."""

    target: Variable
    value: Expression
    at: Position


@dataclass(frozen=True)
class CallBlock:
    """A call of a block instance.

    `inputs` holds (pin, value) in the order of the declaration, `in_outs` (pin, variable) for
    every VAR_IN_OUT, `outputs` (pin, target) in the order of the call.
    """

    instance: Variable
    block: BlockType
    inputs: tuple[tuple[str, Expression], ...]
    in_outs: tuple[tuple[str, Variable], ...]
    outputs: tuple[tuple[str, Variable], ...]
    at: Position


@dataclass(frozen=True)
class If:
    """An IF: (condition, statements) for IF and every ELSIF, then the statements of ELSE."""

    branches: tuple[tuple[Expression, tuple[Statement, ...]], ...]
    otherwise: tuple[Statement, ...]
    at: Position


@dataclass(frozen=True)
class Case:
    """A CASE: each branch has labels as inclusive (low, high) pairs, and statements."""

    selector: Expression
    branches: tuple[tuple[tuple[tuple[int, int], ...], tuple[Statement, ...]], ...]
    otherwise: tuple[Statement, ...]
    at: Position


@dataclass(frozen=True)
class For:
    """A FOR loop from `start` to `end`; start, end and step have the type of the counter."""

    counter: Variable
    start: Expression
    end: Expression
    step: Expression
    body: tuple[Statement, ...]
    at: Position


@dataclass(frozen=True)
class While:
    """A loop that tests its condition before each iteration."""

    condition: Expression
    body: tuple[Statement, ...]
    at: Position


@dataclass(frozen=True)
class Repeat:
    """A loop that tests after each iteration and ends when the condition is true."""

    body: tuple[Statement, ...]
    condition: Expression
    at: Position


@dataclass(frozen=True)
class Try:
    """A `__TRY`: an error at run time in `body` sets `code`, and `handler` runs.

    `last` always runs. `code` is a variable of __SYSTEM.ExceptionCode, or None.
    """

    body: tuple[Statement, ...]
    code: Variable | None
    handler: tuple[Statement, ...]
    last: tuple[Statement, ...]
    at: Position


@dataclass(frozen=True)
class Evaluate:
    """A call with an unused result."""

    value: Expression
    at: Position


@dataclass(frozen=True)
class CallBase:
    """`SUPER^()`: the body of the base block, called on the same instance."""

    block: BlockType
    inputs: tuple[tuple[str, Expression], ...]
    at: Position


Statement = (
    Assign
    | CallBlock
    | CallBase
    | If
    | Case
    | For
    | While
    | Repeat
    | Try
    | s.Exit
    | s.Return
    | s.Continue
    | Evaluate
)


_FIRST = Position(1, 1)

#: Suffix of the name of the variable that holds a block's VAR_IN_OUT after a call.
AFTER_CALL = "after_call"


@dataclass(eq=False)
class Pou:
    """A function, function block or program.

    `block` is None for a function. `result` is None for a block or program. `symbols` is in the
    order of declaration, by upper-case name. A method is also a POU: its kind is METHOD, its name
    is `Block.Method` (`Block.Property.Get`), and `owner` is its block. `at` is the position of its
    first word.
    """

    kind: str
    name: str
    file: str
    symbols: dict[str, Symbol]
    block: BlockType | None = None
    result: Symbol | None = None
    body: tuple[Statement, ...] = field(default_factory=tuple)
    owner: Pou | None = None
    words: tuple[str, ...] = ()
    calls: set[str] = field(default_factory=set)
    """Upper-case names of the functions of the sources that this POU calls."""
    clock: bool = False
    """Whether this POU reads the time, or makes variables while it runs."""
    at: Position = _FIRST
    copied: set[str] = field(default_factory=set)
    """Upper-case names of VAR_INPUT that a function writes."""

    def section(self, kind: str) -> list[Symbol]:
        """Return the variables of all sections of this kind."""
        return [symbol for symbol in self.symbols.values() if symbol.section == kind]
