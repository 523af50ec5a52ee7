"""The checked program: every name resolved, every expression typed, every conversion explicit.

This is what engines generate code from. Untyped literals have the type they were used as;
operators and standard functions are resolved to their operand type.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from rcx_harness.engine.frontend.scalars import Scalar
from rcx_harness.engine.frontend.syntax import Exit, Position, Return
from rcx_harness.engine.types import BlockType, Type

__all__ = [
    "Assign",
    "Binary",
    "CallBlock",
    "CallFunction",
    "Case",
    "Constant",
    "Exit",
    "Expression",
    "For",
    "If",
    "Index",
    "Member",
    "Pou",
    "Repeat",
    "Return",
    "Standard",
    "Statement",
    "Symbol",
    "Unary",
    "Use",
    "Variable",
    "While",
]


@dataclass(eq=False)
class Symbol:
    """A declared variable.

    `section` is VAR, VAR_INPUT, VAR_OUTPUT, VAR_IN_OUT, VAR_TEMP, VAR_EXTERNAL, VAR_GLOBAL or,
    for the variable that holds a function's result, RESULT. `initial` is the complete initial
    value as `declare.initial_value` gives it; a block has none.
    """

    name: str
    type: Type
    section: str
    at: Position
    initial: Any = None
    constant: bool = False
    address: str | None = None


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
    """A field of a structure or a pin of a block instance."""

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

    `op` is one of + - * / MOD ** AND OR XOR = <> < > <= >=.
    """

    op: str
    left: Expression
    right: Expression
    type: Type


@dataclass(frozen=True)
class CallFunction:
    """A call of a function of the sources; one argument per VAR_INPUT, None for the default."""

    function: str
    arguments: tuple[Expression | None, ...]
    type: Type


@dataclass(frozen=True)
class Standard:
    """A call of a standard function by its upper-case name, conversions included."""

    name: str
    arguments: tuple[Expression, ...]
    type: Type


Variable = Use | Member | Index
Expression = Constant | Use | Member | Index | Unary | Binary | CallFunction | Standard


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

    counter: Use
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


Statement = Assign | CallBlock | If | Case | For | While | Repeat | Exit | Return


@dataclass(eq=False)
class Pou:
    """A function, function block or program.

    `block` is None for a function, `result` None for the others. `symbols` are in the order of
    declaration, by upper-case name.
    """

    kind: str
    name: str
    file: str
    symbols: dict[str, Symbol]
    block: BlockType | None = None
    result: Symbol | None = None
    body: tuple[Statement, ...] = field(default_factory=tuple)

    def section(self, kind: str) -> list[Symbol]:
        """The variables of one kind of section."""
        return [symbol for symbol in self.symbols.values() if symbol.section == kind]
