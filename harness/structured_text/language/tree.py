"""The checked program: every name resolved, every expression typed, every conversion explicit.

This is what engines generate code from. Untyped literals have the type they were used as;
operators and standard functions are resolved to their operand type.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from structured_text.language.later import Part
from structured_text.language.scalars import Scalar
from structured_text.language.syntax import Continue, Exit, Position, Return
from structured_text.language.types import BlockType, ReferenceType, Type

__all__ = [
    "Address",
    "Assign",
    "Binary",
    "CallBase",
    "CallBlock",
    "CallFunction",
    "CallMethod",
    "Case",
    "Constant",
    "Continue",
    "Deref",
    "Evaluate",
    "Exit",
    "Expression",
    "For",
    "If",
    "Index",
    "Member",
    "Null",
    "Offset",
    "Pou",
    "Recast",
    "Repeat",
    "Return",
    "Same",
    "Standard",
    "Statement",
    "Symbol",
    "This",
    "Unary",
    "Use",
    "Valid",
    "Variable",
    "While",
]


@dataclass(eq=False)
class Symbol:
    """A declared variable.

    `section` is VAR, VAR_INPUT, VAR_OUTPUT, VAR_IN_OUT, VAR_TEMP, VAR_EXTERNAL, VAR_GLOBAL or,
    for the variable that holds a function's result, RESULT. `initial` is the complete initial
    value as `resolve.Types.initial_value` gives it. `source` is the key of the global variable
    that a VAR_EXTERNAL stands for, where that is not its own name. `addressed` says that a
    pointer is made to it, `started` that its declaration gives the block arguments, `shared` that
    methods of the block use this VAR_IN_OUT of it, `calculated` that its initial value is no
    constant; `parts` are those of its initial value that are none. `retain`: it keeps its value
    over a warm start. `area` is I, Q or M where its address is left to the tool (`%I*`).
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


@dataclass(frozen=True)
class Constant:
    """A literal or enumeration member; `typed` where the source names its type."""

    value: Scalar
    type: Type
    typed: bool = False


@dataclass(frozen=True)
class Use:
    """A variable of the POU by its symbol."""

    symbol: Symbol
    type: Type


@dataclass(frozen=True)
class Member:
    """A field of a structure or a pin of a block instance; the base may be a call's result."""

    base: Variable
    name: str
    type: Type


@dataclass(frozen=True)
class Index:
    """An element of an array, one index per dimension."""

    base: Variable
    indices: tuple[Expression, ...]
    type: Type


@dataclass(frozen=True)
class Unary:
    """`op` is - or NOT; the operand has the same type."""

    op: str
    operand: Expression
    type: Type


@dataclass(frozen=True)
class Binary:
    """Both operands have one type, except `TIME * number`, `TIME / number` and `real ** number`.

    `op` is one of + - * / MOD ** AND OR XOR AND_THEN OR_ELSE = <> < > <= >=.
    """

    op: str
    left: Expression
    right: Expression
    type: Type


@dataclass(frozen=True)
class CallFunction:
    """A call of a function of the sources; one argument per VAR_INPUT, None for the default.

    `in_outs` are (pin, variable) for every VAR_IN_OUT, `outputs` (pin, target). The type of a
    function without a result is the elementary type without a name.
    """

    function: str
    arguments: tuple[Expression | None, ...]
    type: Type
    in_outs: tuple[tuple[str, Variable], ...] = ()
    outputs: tuple[tuple[str, Variable], ...] = ()


@dataclass(frozen=True)
class Standard:
    """A call of a standard function by its upper-case name, conversions included."""

    name: str
    arguments: tuple[Expression, ...]
    type: Type


# Object orientation and references: what only the built-in engine runs.


@dataclass(frozen=True)
class This:
    """The instance that a method or body runs for: `THIS^`."""

    type: Type


@dataclass(frozen=True)
class CallMethod:
    """A call of a method, or of the GET or SET of a property.

    Attributes:
        instance: The block, or a value of an interface.
        method: Its name and parameters, as the static type of the instance declares it.
        final: Whether just this method is meant (SUPER^), not what a derived block makes of it.
        arguments: One per VAR_INPUT, None for its default.
        in_outs: (name, variable) for every VAR_IN_OUT.
        outputs: (name, target) of each `=>`.
        type: Of the result; the empty type where it has none.
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
    """What a pointer or reference leads to, `offset` elements further."""

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
    """A pointer moved by some bytes; `size` is that of an element, `sign` 1 or -1."""

    base: Expression
    bytes: Expression
    size: int
    sign: int
    type: Type


@dataclass(frozen=True)
class Recast:
    """A pointer to the same memory, which is looked at as another type."""

    base: Expression
    type: ReferenceType


@dataclass(frozen=True)
class Null:
    """The pointer to nothing, or an interface without a block."""

    type: Type


@dataclass(frozen=True)
class Valid:
    """Whether a reference refers to something."""

    reference: Expression
    type: Type


@dataclass(frozen=True)
class Same:
    """Whether two pointers or interfaces lead to the same, or not (`op` is = or <>).

    Of two pointers `op` may also be < > <= >=: which of them leads further on in one memory.
    """

    op: str
    left: Expression
    right: Expression
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
)


@dataclass(frozen=True)
class Assign:
    """target := value, of equal types."""

    target: Variable
    value: Expression
    at: Position


@dataclass(frozen=True)
class CallBlock:
    """A call of a block instance.

    `inputs` are (pin, value) in the order of the declaration, `in_outs` (pin, variable) for
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
    """(condition, statements) of IF and every ELSIF, then ELSE."""

    branches: tuple[tuple[Expression, tuple[Statement, ...]], ...]
    otherwise: tuple[Statement, ...]
    at: Position


@dataclass(frozen=True)
class Case:
    """Each branch has its labels as inclusive (low, high) pairs and its statements."""

    selector: Expression
    branches: tuple[tuple[tuple[tuple[int, int], ...], tuple[Statement, ...]], ...]
    otherwise: tuple[Statement, ...]
    at: Position


@dataclass(frozen=True)
class For:
    """Counts `counter` from `start` to `end`; all four have its type."""

    counter: Variable
    start: Expression
    end: Expression
    step: Expression
    body: tuple[Statement, ...]
    at: Position


@dataclass(frozen=True)
class While:
    """Tests before each round."""

    condition: Expression
    body: tuple[Statement, ...]
    at: Position


@dataclass(frozen=True)
class Repeat:
    """Tests after each round; ends when the condition is true."""

    body: tuple[Statement, ...]
    condition: Expression
    at: Position


@dataclass(frozen=True)
class Evaluate:
    """A call whose result is not used."""

    value: Expression
    at: Position


@dataclass(frozen=True)
class CallBase:
    """`SUPER^()`: the body of the block that this one extends, on the same instance."""

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
    | Exit
    | Return
    | Continue
    | Evaluate
)


_FIRST = Position(1, 1)


@dataclass(eq=False)
class Pou:
    """A function, function block or program.

    `block` is None for a function, `result` None for the others. `symbols` are in the order of
    declaration, by upper-case name. A method is a POU, too: its kind is METHOD, its name
    `Block.Method` (`Block.Property.Get`), and `owner` the block it belongs to. `at` is where it
    begins.
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
    """Functions of the sources that it calls, by upper-case name."""
    clock: bool = False
    """Whether it reads the time."""
    at: Position = _FIRST
    copied: set[str] = field(default_factory=set)
    """Upper-case names of VAR_INPUT that a function writes."""

    def section(self, kind: str) -> list[Symbol]:
        """The variables of one kind of section."""
        return [symbol for symbol in self.symbols.values() if symbol.section == kind]
