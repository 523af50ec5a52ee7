"""Networks for a page whose script shows in them what was energised at a time.

An entry of the page has the drawing (`svg.live_svg`) and the elements of a network as data for
JSON. The script finds the power of each line from the values of variables. A value that is not
recorded is unknown, and so is everything that depends on it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from structured_text.language.source import Line
from structured_text.projects.diagrams.networks.draw.drawing import RAIL
from structured_text.projects.diagrams.networks.draw.shapes import input_of
from structured_text.projects.diagrams.networks.draw.svg import VALUE, live_svg
from structured_text.projects.diagrams.networks.model import (
    Block,
    Coil,
    Connector,
    Contact,
    Continuation,
    Diagram,
    Element,
    InVariable,
    OutVariable,
    Rail,
)

__all__ = ["Found", "LiveNetwork", "edges_of", "live_network"]

#: The call of the trigger that the translation of a network has for a contact with an edge.
_TRIGGER = re.compile(r"\s*(\w*?(Rising|Falling)\w*)\(CLK := (.+)\);")
_COMPARISON = re.compile(r"\(?([^()\s]+) (=|<>|<=|>=|<|>) ([^()\s]+)\)?")
_NAMES = {"=": "EQ", "<>": "NE", "<=": "LE", ">=": "GE", "<": "LT", ">": "GT"}
_INTEGER = re.compile(r"[-+]?\d{1,15}")
_LITERAL = re.compile(r"[-+]?\d|['\"]|\w+#")
_TRUTH = {"TRUE": True, "FALSE": False, "BOOL#TRUE": True, "BOOL#FALSE": False}
_TRUTH |= {"BOOL#1": True, "BOOL#0": False}


def _constant(text: str) -> int | None:
    """Return the value of an integer literal; None for any other text."""
    return int(text) if _INTEGER.fullmatch(text.strip()) else None


def _is_condition(block: Block) -> bool:
    """Return whether an instruction of Logix became a condition, and not statements."""
    text = block.translation
    return bool(text) and "?" not in text and not text.endswith((";", " THEN", " DO"))


def edges_of(lines: Iterable[Line]) -> dict[tuple[str, str], str]:
    """Return the variables that are TRUE at the edges in a network.

    The keys are the tested variable in upper case, and the kind of edge. An edge with several
    triggers is left out.

    Args:
        lines: The translation of the network.
    """
    found: dict[tuple[str, str], list[str]] = {}
    for match in filter(None, (_TRIGGER.fullmatch(line.text) for line in lines)):
        key = match[3].strip().upper(), match[2].lower()
        found.setdefault(key, []).append(f"{match[1]}.Q")
    return {key: names[0] for key, names in found.items() if len(names) == 1}


@dataclass(frozen=True)
class Found:
    """A variable of the program.

    Attributes:
        path: Its path.
        boolean: Whether it is a BOOL.
        shown: Whether it has a value for a drawing: it is not a structure, array or block.
    """

    path: str
    boolean: bool
    shown: bool


def live_network(
    diagram: Diagram,
    number: int,
    find: Callable[[str], Found | None],
    edges: Mapping[tuple[str, str], str],
    *,
    width: int,
    name: str,
) -> dict[str, Any]:
    """Return the entry of a network for a page; `paths` are the variables that it shows.

    Args:
        diagram: The diagram.
        number: The number of the network.
        find: Returns a variable by its text in the diagram; None if there is none.
        edges: The variable that is TRUE at an edge, by the tested variable and the kind of edge.
        width: Number of columns from which on the drawing goes on below.
        name: The beginning of the ids in the drawing, which must be unique in a page.
    """
    made = LiveNetwork(diagram, number, find, edges)
    heading = [entry for entry in diagram.networks if entry.number == number]
    title = heading[0].title if heading else ""
    word = diagram.word.capitalize()
    return {
        "title": f"{word} {number}{': ' if title else ''}{title}",
        "comment": heading[0].comment if heading else "",
        "svg": live_svg(
            diagram, number, dict.fromkeys(made.values(), VALUE), width=width, name=name
        ),
        "elements": made.elements(),
        "paths": list(made.paths),
    }


class LiveNetwork:
    """A network as entries for what shows its state: a page, or a drawing as text.

    Args:
        diagram: The diagram.
        number: The number of the network.
        find: Returns a variable by its text in the diagram; None if there is none.
        edges: The variable that is TRUE at an edge, by the tested variable and the kind of edge.

    Attributes:
        paths: The variables that the entries name.
    """

    def __init__(
        self,
        diagram: Diagram,
        number: int,
        find: Callable[[str], Found | None],
        edges: Mapping[tuple[str, str], str],
    ) -> None:
        self._find, self._edges = find, edges
        self.paths: dict[str, None] = {}
        self._is_logix = diagram.language == "RLL"
        self._all = {element.id: element for element in diagram.elements}
        self._own = [element for element in diagram.elements if element.network == number]
        self._plain = self._numbers()

    def _numbers(self) -> set[tuple[str, str]]:
        """Return the outputs whose values are not Boolean, as far as this is known."""
        found = set()
        for element in self._own:
            if isinstance(element, InVariable) and self._is_number(element.expression):
                found.add((element.id, ""))
            if isinstance(element, Block) and element.instance:
                for output in element.outputs:
                    if self._is_number(f"{element.instance}.{output.name}"):
                        found.add((element.id, output.name))
            for pin in input_of(element):
                if isinstance(element, OutVariable):
                    target = element.expression
                else:
                    target = f"{element.instance}.{pin.name}" if isinstance(element, Block) else ""
                if target and self._is_number(target):
                    found |= {self._end(line.source, line.pin) for line in pin.connections}
        # A block shows a VAR_IN_OUT on both sides.
        for element in self._own:
            for pin in element.inputs if isinstance(element, Block) else ():
                if any(self._end(line.source, line.pin) in found for line in pin.connections):
                    found.add((element.id, pin.name))
        return found

    def _end(self, source: str, pin: str) -> tuple[str, str]:
        """Return the output at which a line begins; without a name it is the first one."""
        element = self._all.get(source)
        if isinstance(element, Rail):
            return RAIL
        if isinstance(element, Block):
            return source, pin or (element.outputs[0].name if element.outputs else "")
        return source, ""

    def _is_number(self, text: str) -> bool:
        if text.strip().upper() in _TRUTH:
            return False
        variable = self._find(text)
        return not variable.boolean if variable else bool(_LITERAL.match(text.strip()))

    def values(self) -> dict[str, str]:
        """Return the variables whose values are shown as texts, by the keys of `State.values`."""
        used = {
            self._end(line.source, line.pin)
            for element in self._own
            for pin in input_of(element)
            for line in pin.connections
        }
        names = {}
        for element in self._own:
            if isinstance(element, (InVariable, OutVariable)):
                names[element.id] = element.expression
            elif isinstance(element, Block) and element.instance:
                for output in element.outputs:
                    if (element.id, output.name) not in used and not output.target:
                        names[f"{element.id}.{output.name}"] = f"{element.instance}.{output.name}"
        found = {key: self._find(name) for key, name in names.items()}
        return {
            key: variable.path
            for key, variable in found.items()
            if variable is not None and variable.shown and not variable.boolean
        }

    # --- entries ---

    def elements(self) -> list[dict[str, Any]]:
        """Return the entries of the elements, which networks.js and `power_of` read."""
        return [
            {"id": element.id, "kind": self._kind(element), "in": self._inputs(element)}
            | self._more(element)
            for element in self._own
            if not isinstance(element, Rail)
        ]

    def _kind(self, element: Element) -> str:
        if isinstance(element, Block) and self._is_logix:
            return self._instruction_kind(element)
        kinds: dict[type, str] = {Contact: "contact", Coil: "coil", Block: "block"}
        kinds |= {InVariable: "read", OutVariable: "write"}
        kinds |= {Connector: "connector", Continuation: "continuation"}
        return kinds.get(type(element), "end")

    def _inputs(self, element: Element) -> list[dict[str, Any]]:
        return [
            {
                "pin": pin.name,
                "from": [self._end(line.source, line.pin) for line in pin.connections],
                "always": _TRUTH.get(pin.value.strip().upper()),
                "constant": _constant(pin.value),
                "negated": pin.negated,
                "edge": bool(pin.edge),
            }
            for pin in input_of(element)
        ]

    def _more(self, element: Element) -> dict[str, Any]:
        if isinstance(element, Contact):
            return self._contact(element)
        if isinstance(element, Coil):
            target = element.translation.partition(" := ")[0] or element.variable
            more = {"name": self._path(target), "negated": element.negated}
            return more | {"stores": bool(element.storage or element.edge)}
        if isinstance(element, InVariable):
            text = element.expression
            always, constant = _TRUTH.get(text.strip().upper()), _constant(text)
            more = {"name": self._path(text), "negated": element.negated}
            return {
                **more,
                "always": always,
                "constant": constant,
                "number": (element.id, "") in self._plain,
            }
        if isinstance(element, OutVariable):
            more = {"name": self._path(element.expression), "negated": False}
            return more | {"number": self._is_number(element.expression)}
        if isinstance(element, Block):
            return self._instruction(element) if self._is_logix else self._block(element)
        if isinstance(element, (Connector, Continuation)):
            return {"line": element.name.upper()}
        return {}

    def _contact(self, element: Contact) -> dict[str, Any]:
        """Return what a contact tests. The edge of a negated contact differs between tools."""
        name = self._path(element.translation or element.variable)
        tests = name
        if element.edge:
            edge = self._edges.get((element.variable.strip().upper(), element.edge))
            tests = None if element.negated or edge is None else self._path(edge)
        return {"name": name, "tests": tests, "negated": element.negated}

    def _block(self, element: Block) -> dict[str, Any]:
        outputs = []
        for output in element.outputs:
            path = self._path(f"{element.instance}.{output.name}") if element.instance else None
            end = (element.id, output.name)
            entry = {"pin": output.name, "name": path, "negated": output.negated}
            outputs.append(entry | {"number": end in self._plain})
        return {"type": "" if element.instance else element.type.upper(), "out": outputs}

    # --- instructions of Logix: boxes that pass power if a condition holds, or always ---

    def _instruction_kind(self, element: Block) -> str:
        if _is_condition(element):
            return "contact"
        # An Add-On Instruction decides itself, and ONS passes power for one scan.
        return "end" if element.instance or element.type == "ONS" else "coil"

    def _instruction(self, element: Block) -> dict[str, Any]:
        if not _is_condition(element):
            return {"negated": False, "stores": True}
        tests = self._path(element.translation)
        match = None if tests else _COMPARISON.fullmatch(element.translation)
        compare = (
            [_NAMES[match[2]], self._operand(match[1]), self._operand(match[3])] if match else None
        )
        return {"tests": tests, "negated": False, "compare": compare}

    def _operand(self, text: str) -> dict[str, Any]:
        return {"name": self._path(text), "constant": _constant(text)}

    def _path(self, text: str) -> str | None:
        variable = self._find(text)
        if variable is None or not variable.shown:
            return None
        self.paths[variable.path] = None
        return variable.path
