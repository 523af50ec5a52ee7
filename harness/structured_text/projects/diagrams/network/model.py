"""The model of a network. It depends on no file format.

A network is a graph. Each element has input pins and output pins. An input pin names the outputs
that are connected to it; several outputs at an input pin are a wired OR. A ladder uses the same
graph: contacts and coils have one input pin and one output pin, and the left power rail has an
output pin that is always TRUE.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

from structured_text.errors import InputError

__all__ = ["Edge", "Element", "Kind", "Link", "Network", "Pin", "Storage"]


class Kind(Enum):
    """The kind of an element, with its name in messages."""

    LEFT_RAIL = "left power rail"
    RIGHT_RAIL = "right power rail"
    CONTACT = "contact"
    COIL = "coil"
    INPUT = "input variable"
    OUTPUT = "output variable"
    IN_OUT = "in-out variable"
    BLOCK = "block"
    CONNECTOR = "connector"
    CONTINUATION = "continuation"
    JUMP = "jump"
    LABEL = "label"
    RETURN = "return"
    COMMENT = "comment"
    STATEMENT = "statement"


class Edge(Enum):
    """The edge that a contact, a coil or a pin waits for."""

    NONE = ""
    RISING = "rising"
    FALLING = "falling"


class Storage(Enum):
    """How a coil or an output writes its variable."""

    NONE = ""
    SET = "set"
    RESET = "reset"


@dataclass(frozen=True)
class Link:
    """An output that is connected to an input pin.

    Attributes:
        source: The id of the element with the output.
        pin: The name of the output; empty for the only output of an element.
        points: The corners of the line [units of the drawing], from the input to the output.
    """

    source: int
    pin: str = ""
    points: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True)
class Pin:
    """A pin of an element.

    Attributes:
        name: The name of the parameter; empty for contacts, coils and the result of a function.
        links: The outputs that are connected to an input pin.
        in_out: Whether the pin belongs to a VAR_IN_OUT parameter.
        x, y: The position relative to the element [units of the drawing].
        value: An expression at the pin that has no element of its own. At an output pin, it is
            the variable that receives the value.
    """

    name: str = ""
    links: tuple[Link, ...] = ()
    negated: bool = False
    edge: Edge = Edge.NONE
    storage: Storage = Storage.NONE
    in_out: bool = False
    x: float = 0
    y: float = 0
    value: str = ""


@dataclass(frozen=True)
class Element:
    """An element of a network.

    Attributes:
        id: The number of the element, unique in its body.
        at: The line in the project file.
        text: By kind: the variable of a contact or coil, the expression of a variable, the type
            name of a block, the name of a connector, continuation or label, the target of a jump,
            the text of a comment, a statement in Structured Text.
        instance: The instance of a function block; empty for a function.
        x, y: The position of the upper left corner [units of the drawing].
        order: The number in the order of execution (executionOrderId); 0 if there is none.
        comment: The text that the user has written to the element.
    """

    kind: Kind
    id: int
    at: int
    text: str = ""
    instance: str = ""
    inputs: tuple[Pin, ...] = ()
    outputs: tuple[Pin, ...] = ()
    negated: bool = False
    edge: Edge = Edge.NONE
    storage: Storage = Storage.NONE
    x: float = 0
    y: float = 0
    width: float = 0
    height: float = 0
    order: int = 0
    comment: str = ""

    @property
    def place(self) -> tuple[float, float]:
        """Return the key for the order by position: from top to bottom, then from left to right."""
        return self.y, self.x


@dataclass(frozen=True)
class Network:
    """A network or rung.

    Attributes:
        number: The number, from 1.
        at: The line in the project file.
        elements: The elements in the order of the file.
        label: The label at which jumps to the network arrive; empty if there is none.
        title: A short text of the user.
        comment: The comment of the user.
        ladder: Whether the network belongs to a Ladder Diagram.
    """

    number: int
    at: int
    elements: tuple[Element, ...] = field(default=())
    label: str = ""
    title: str = ""
    comment: str = ""
    ladder: bool = False

    @property
    def name(self) -> str:
        """Return the name of the network in comments and messages."""
        return f"{'Rung' if self.ladder else 'Network'} {self.number}"

    def source(self, link: Link, at: int) -> Element:
        """Return the element at the other end of a connection; `at` is the line of the connection.

        Raise InputError if there is none.
        """
        found = next((element for element in self.elements if element.id == link.source), None)
        if found is None:
            raise InputError(
                f"{self.name}: an element is connected to element {link.source}, which does not "
                "exist",
                line=at,
                hint="draw the connection again",
            )
        return found
