"""The parsed source as it is written: declarations, statements and expressions with positions.

Nothing here is checked yet; names are as the user spelt them. The nodes are immutable, so that
one parse of a library file serves every project that uses it.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from rcx_harness.errors import InputError

__all__ = [
    "Argument",
    "ArrayInit",
    "ArraySpec",
    "Assign",
    "AssignChain",
    "Binary",
    "Call",
    "CallStatement",
    "Case",
    "CaseBranch",
    "Configuration",
    "Continue",
    "Declaration",
    "Dereference",
    "EnumSpec",
    "Exit",
    "Expression",
    "Field",
    "For",
    "GlobalList",
    "If",
    "Index",
    "Init",
    "Interface",
    "Invoke",
    "Latch",
    "Literal",
    "Method",
    "Name",
    "NamedSpec",
    "Namespace",
    "Part",
    "PointerSpec",
    "Position",
    "Pou",
    "ProgramInstance",
    "Property",
    "Range",
    "Repeat",
    "Return",
    "Section",
    "Sequence",
    "Source",
    "Statement",
    "StructInit",
    "StructSpec",
    "SubrangeSpec",
    "Task",
    "This",
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


# --- declarations --------------------------------------------------------------------------


@dataclass(frozen=True)
class NamedSpec:
    """A type given by its name; `length` is that of a STRING.

    `arguments` are those behind the name of a block: `Drive : FB_Drive(Axis := 1);`.
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
    """

    file: Path
    declarations: tuple[Declaration, ...]
    uses: tuple[Any, ...] = ()
    pragmas: tuple[Name, ...] = ()
    errors: tuple[InputError, ...] = ()
    namespaces: tuple[Namespace, ...] = ()
