"""The model of a Ladder Diagram or Function Block Diagram, which no file format determines.

An element has inputs. An input names the outputs that it is connected to: in ladder, several
connections to one input are joined by OR. An element has the number of its network (in ladder: its
rung), so that messages, comments and drawings can name it.

Source: IEC 61131-3, 4.1 to 4.3 (third edition: 8.1 to 8.3); PLCopen TC6 XML 2.01, chapters 5 and 6.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias

__all__ = ["EDGES", "SORTINGS", "STORAGES", "Block", "Coil", "Connection", "Connector", "Contact"]
__all__ += ["Continuation", "Diagram", "Element", "InVariable", "Input", "Jump", "Network"]
__all__ += ["OutVariable", "Output", "Position", "Rail", "Return"]

#: Edges of a contact, a coil or a pin; empty for none.
EDGES = ("", "rising", "falling")
#: What a coil or an assignment does with a variable: assign the value, set it or reset it.
STORAGES = ("", "set", "reset")
#: Orders of elements without a number. position: outputs and coils, then blocks, then connectors,
#: each by their position (Beremiz until 2022). file: the same, but each in the order of the file
#: (Beremiz since its version for Python 3). together: all by position (OpenPLC Editor).
SORTINGS = ("position", "file", "together")


@dataclass(frozen=True)
class Position:
    """The place of an element's upper left corner in the drawing; (0, 0) if the file has none.

    Attributes:
        x: To the right, in the units of the file.
        y: Downwards, in the units of the file.
    """

    x: float = 0.0
    y: float = 0.0


@dataclass(frozen=True)
class Connection:
    """A line from an output to an input.

    Attributes:
        source: The `id` of the element on the left side of the line.
        pin: The formal name of the output pin, if the element is a block; otherwise empty.
    """

    source: str
    pin: str = ""


@dataclass(frozen=True)
class Input:
    """An input pin of a block, or the only input of another element.

    Attributes:
        name: The formal name of a block's input; empty for elements with one input.
        connections: The lines that end here; several are joined by OR. Empty if there are none.
        value: An expression that is written at the pin instead of a line; otherwise empty.
        negated: Whether the value is inverted.
        edge: One of `EDGES`: whether the value is TRUE only at an edge.
        in_out: Whether the pin is a VAR_IN_OUT, so that the value must be a variable.
    """

    name: str = ""
    connections: tuple[Connection, ...] = ()
    value: str = ""
    negated: bool = False
    edge: str = ""
    in_out: bool = False


@dataclass(frozen=True)
class Output:
    """An output pin of a block.

    Attributes:
        name: The formal name.
        target: A variable that is written at the pin instead of a line; otherwise empty.
        negated: Whether the value is inverted.
        storage: One of `STORAGES`, for the target.
    """

    name: str = ""
    target: str = ""
    negated: bool = False
    storage: str = ""


@dataclass(frozen=True)
class _Element:
    """What all elements have.

    Attributes:
        id: The number by which connections name the element; unique in the diagram.
        network: The number of the element's network, from 1.
        order: The number that the file gives for the order of execution; 0 if it gives none.
        position: The place in the drawing.
        at: Line in the file.
    """

    id: str
    network: int = 1
    order: int = 0
    position: Position = Position()
    at: int = 1


@dataclass(frozen=True)
class Rail(_Element):
    """A power rail. The left rail has power; the right rail ends a rung and has no effect.

    CODESYS has one left rail for all networks; its `network` is 0.
    """

    left: bool = True


@dataclass(frozen=True)
class Contact(_Element):
    """A contact: the power on its left side AND the variable.

    Attributes:
        translation: The condition that it became, if this is not the variable itself.
    """

    variable: str = ""
    input: Input = Input()
    negated: bool = False
    edge: str = ""
    translation: str = ""


@dataclass(frozen=True)
class Coil(_Element):
    """A coil: it assigns the power on its left side, and passes the power on.

    Attributes:
        translation: The statement that it became, if it does not assign the variable itself; `?`
            stands for the power.
    """

    variable: str = ""
    input: Input = Input()
    negated: bool = False
    edge: str = ""
    storage: str = ""
    translation: str = ""


@dataclass(frozen=True)
class InVariable(_Element):
    """A variable, literal or expression that is read."""

    expression: str = ""
    negated: bool = False


@dataclass(frozen=True)
class OutVariable(_Element):
    """A variable that is written. An inOutVariable has both an input and an output.

    Attributes:
        expression: The variable.
        read: Whether the element also has an output, as an inOutVariable has.
    """

    expression: str = ""
    input: Input = Input()
    negated: bool = False
    edge: str = ""
    storage: str = ""
    read: bool = False


@dataclass(frozen=True)
class Block(_Element):
    """A call of a function, a function block, or an operator.

    Attributes:
        type: The name of the function or function block.
        instance: The name of the instance; empty for a function.
        inputs: The inputs from top to bottom, with EN if the block has it.
        outputs: The outputs from top to bottom, with ENO if the block has it.
        statements: Statements of Structured Text that the block executes in place of a call, as the
            execute box of CODESYS has; otherwise empty.
        operands: The names and texts of operands that stand in the box, as in Logix.
        translation: The condition or the first line of the statements that it became, if they are
            known; `?` stands for the power.
    """

    type: str = ""
    instance: str = ""
    inputs: tuple[Input, ...] = ()
    outputs: tuple[Output, ...] = ()
    statements: tuple[str, ...] = ()
    operands: tuple[tuple[str, str], ...] = ()
    translation: str = ""


@dataclass(frozen=True)
class Connector(_Element):
    """The end of a line that goes on at each `Continuation` of the same name."""

    name: str = ""
    input: Input = Input()


@dataclass(frozen=True)
class Continuation(_Element):
    """The other end of the line of a `Connector`."""

    name: str = ""


@dataclass(frozen=True)
class Jump(_Element):
    """A jump to the network with a label, if its input is TRUE."""

    label: str = ""
    input: Input = Input()


@dataclass(frozen=True)
class Return(_Element):
    """A return from the POU, if its input is TRUE."""

    input: Input = Input()


Element: TypeAlias = (
    Rail
    | Contact
    | Coil
    | InVariable
    | OutVariable
    | Block
    | Connector
    | Continuation
    | Jump
    | Return
)


@dataclass(frozen=True)
class Network:
    """A network, in ladder a rung.

    Attributes:
        number: From 1, in the order of the file; for a file without networks, the number of the
            connected part, from the top of the drawing to its bottom. Rungs of Logix count from 0.
        title: Its title; may be empty.
        comment: Its comment; may have several lines and may be empty.
        label: The label that jumps name; may be empty.
        at: Line in the file.
    """

    number: int
    title: str = ""
    comment: str = ""
    label: str = ""
    at: int = 1


@dataclass(frozen=True)
class Diagram:
    """A body in LD or FBD.

    Attributes:
        language: LD or FBD; RLL for a ladder routine of Logix, whose networks are called rungs;
            SHEETS for a function block diagram of Logix, whose networks are called sheets.
        networks: The networks in the order of their numbers.
        elements: All elements in the order of the file.
        by_position: How elements without a number are ordered. True: by their positions in the
            whole drawing, as Beremiz and OpenPLC do. False: network after network, and in the
            order of the file within a network, as CODESYS does.
        sorting: One of `SORTINGS`, for `by_position`: how outputs, coils and blocks without a
            number are ordered.
    """

    language: str
    networks: tuple[Network, ...] = ()
    elements: tuple[Element, ...] = field(default=())
    by_position: bool = True
    sorting: str = "position"

    @property
    def word(self) -> str:
        """Return what a network is called: rung, sheet or network."""
        return {"RLL": "rung", "SHEETS": "sheet"}.get(self.language, "network")
