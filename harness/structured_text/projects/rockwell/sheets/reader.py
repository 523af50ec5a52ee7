"""The sheets of a routine in an L5X.

Source: Rockwell 1756-RM084, function block diagram routines: FBDContent, Sheet and its elements.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from structured_text.projects.rockwell.ladder.model import LadderError
from structured_text.projects.rockwell.sheets.model import (
    BLOCKS,
    Node,
    Routine,
    Sheet,
    Wire,
    title_of,
)
from structured_text.projects.xml import Element

__all__ = ["drawn_in", "enables_in", "read_sheets"]

_REFERENCES = ("IRef", "ORef", "ICon", "OCon")
_WIRES = ("Wire", "FeedbackWire")
_IGNORED = ("TextBox", "Attachment", "Description", "CustomProperties")
_ENABLE = frozenset(("ENABLEIN", "ENABLEOUT"))
#: Forms of a routine that are not in the controller's program before the edits are accepted.
_EDITS = ("Pending", "Test", "PendingEdits", "TestEdits")


def drawn_in(routine: Element, content: str, note: Callable[[str, Element], None]) -> list[Element]:
    """Return the drawings of a routine that the controller executes.

    `note` takes a message about a drawing that is left out because it is an edit that was not
    accepted, and its element.
    """
    found = []
    for one in routine.all(content):
        kind = one.get("OnlineEditType")
        if kind in _EDITS:
            text = f"{routine.get('Name')} has edits that are not accepted ({kind})"
            note(f"{text}; they are left out", one)
        else:
            found.append(one)
    if len(found) > 1:
        text = f"there are {len(found)} versions of the routine, and none is marked as an edit"
        raise LadderError(text, found[1].at, "accept or cancel all edits, and export it again")
    return found


def enables_in(root: Element) -> set[str]:
    """Return EnableIn and EnableOut in upper case if they matter in a file.

    They matter if a wire leads to them or from them, or if the data of a tag disable a block.
    """
    found: set[str] = set()
    for one in root.below(*_WIRES):
        found |= {one.get(name).upper() for name in ("FromParam", "ToParam")} & _ENABLE
    for one in root.below("DataValueMember"):
        if one.get("Name").upper() == "ENABLEIN" and one.get("Value") == "0":
            found.add("ENABLEIN")
    return found


def read_sheets(routine: Element, note: Callable[[str, Element], None]) -> Routine:
    """Return the sheets that the controller executes, or raise LadderError."""
    sheets: list[Sheet] = []
    nodes: dict[str, Node] = {}
    wires: list[Wire] = []
    for content in drawn_in(routine, "FBDContent", note):
        for place, element in enumerate(content.all("Sheet"), 1):
            number = element.get("Number")
            plain = int(number) if number.isdecimal() and len(number) < 10 else place
            said = element.first("Description")
            sheets.append(Sheet(plain, said.text() if said is not None else "", element.at))
            for one in element.children:
                if one.name in _WIRES:
                    wires.append(_wire(one))
                elif one.name in (*BLOCKS, *_REFERENCES):
                    node = _node(one, plain)
                    if node.id in nodes:
                        text = f"{title_of(plain)}: two elements have the number {node.id}"
                        raise LadderError(text, one.at, "export the routine again")
                    nodes[node.id] = node
                elif one.name not in _IGNORED:
                    text = f"{title_of(plain)}: the element {one.name:.40} is not known"
                    raise LadderError(text, one.at, "remove it, or write the routine as text")
    _check(nodes, wires)
    return Routine(tuple(sheets), tuple(nodes.values()), tuple(wires))


def _wire(element: Element) -> Wire:
    names = ("FromID", "FromParam", "ToID", "ToParam")
    source, output, target, pin = (element.get(name) for name in names)
    return Wire(source, output, target, pin, element.name == "FeedbackWire", element.at)


def _node(element: Element, sheet: int) -> Node:
    kind = element.name
    name = element.get({"Block": "Type", "Function": "Type", "JSR": "Routine"}.get(kind, "Name"))
    return Node(
        element.get("ID"),
        kind,
        name.upper().removesuffix("__F") if kind == "Function" else name,
        element.get("Operand").strip(),
        sheet,
        _number(element.get("X")),
        _number(element.get("Y")),
        tuple(element.get("VisiblePins").split()),
        dict(_arguments(element)),
        element.at,
    )


def _arguments(element: Element) -> Iterator[tuple[str, str]]:
    for one in element.children:
        if one.name == "Array":
            yield one.get("Name").upper(), one.get("Operand").strip()
        elif one.name == "InOutParameter":
            yield one.get("Name").upper(), one.get("Argument").strip()
    for name in ("In", "Ret"):
        if element.get(name).strip():
            yield name.upper(), element.get(name).strip()


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return 0.0


def _check(nodes: Mapping[str, Node], wires: list[Wire]) -> None:
    """Raise LadderError for a wire without an end, or two wires to one pin."""
    ends: set[tuple[str, str]] = set()
    for wire in wires:
        for end in (wire.source, wire.target):
            if end not in nodes:
                text = f"a wire ends at the element {end!r:.20}, which is not on a sheet"
                raise LadderError(text, wire.at, "draw the wire again")
        target = nodes[wire.target]
        key = wire.target, wire.input.upper()
        if key in ends:
            pin = f"the pin {wire.input} of " if wire.input else ""
            text = f"{title_of(target.sheet)}: two wires lead to {pin}{target.title}"
            raise LadderError(text, wire.at, "remove all but one")
        ends.add(key)
