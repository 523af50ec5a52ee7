"""The power in a network, from the values of its variables.

The script of the page (networks.js) does the same for a recording.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import pairwise
from typing import Any

from structured_text.projects.diagrams.networks.draw.drawing import RAIL, Output

__all__ = ["power_of"]

#: TRUE, FALSE, or None if it is not known.
_State = bool | None


def power_of(
    elements: Sequence[Mapping[str, Any]], value: Callable[[str], object]
) -> dict[str, bool]:
    """Return whether the outputs of elements have power, as in `State.energised`.

    An output whose power is not known is not in the result.

    Args:
        elements: The entries of the elements (`LiveNetwork.elements`).
        value: Returns the value of a variable by its path: a bool, an int, or another object if it
            is not known or of another type.
    """
    power = _Power(elements, value)
    found = {}
    for element in elements:
        for pin in [out["pin"] for out in element.get("out", ())] or [""]:
            state = power.output((element["id"], pin))
            if state is not None:
                found[f"{element['id']}.{pin}" if pin else element["id"]] = state
    return found


class _Power:
    def __init__(
        self, elements: Sequence[Mapping[str, Any]], value: Callable[[str], object]
    ) -> None:
        self._elements = {element["id"]: element for element in elements}
        self._value = value
        self._found: dict[Output, _State] = {}

    def output(self, output: Output) -> _State:
        """Return the power at an output; a line that leads back to itself is not known."""
        if output == RAIL:
            return True
        if output not in self._found:
            self._found[output] = None
            element = self._elements.get(output[0])
            self._found[output] = self._of(element, output[1]) if element is not None else None
        return self._found[output]

    def _of(self, element: Mapping[str, Any], pin: str) -> _State:
        kind = element["kind"]
        if element.get("number"):
            return None
        if kind == "contact":
            tested = self._known(element["tests"])
            if element.get("compare"):
                tested = self._compared(*element["compare"])
            return _and([self._input(element["in"][0]), _turned(tested, element)])
        if kind == "coil":
            # Tools differ in what several lines at a coil mean for an element behind it.
            several = len(element["in"][0]["from"]) > 1
            return None if several and self._leads(element) else self._input(element["in"][0])
        if kind == "read":
            always = element["always"]
            return _turned(self._known(element["name"]) if always is None else always, element)
        if kind == "write":
            return self._known(element["name"])
        if kind == "connector":
            return self._input(element["in"][0])
        if kind == "continuation":
            ends = [
                other["id"]
                for other in self._elements.values()
                if other["kind"] == "connector" and other["line"] == element["line"]
            ]
            return self.output((ends[0], "")) if ends else None
        return self._block(element, pin) if kind == "block" else None

    def _block(self, element: Mapping[str, Any], pin: str) -> _State:
        out = next((out for out in element["out"] if out["pin"] == pin), None)
        if out is None or out["number"]:
            return None
        if out["name"] is not None:
            return _turned(self._known(out["name"]), out)
        enable = next((given for given in element["in"] if given["pin"].upper() == "EN"), None)
        if pin.upper() == "ENO":
            return _turned(self._input(enable), out) if enable else None
        # A function that is not executed keeps its result.
        if enable is not None and self._input(enable) is not True:
            return None
        return _turned(self._result(element, [one for one in element["in"] if one != enable]), out)

    def _result(self, element: Mapping[str, Any], inputs: Sequence[Mapping[str, Any]]) -> _State:
        """Return the result of a Boolean operator, or of a comparison of integers."""
        if element["type"] in _OPERATORS:
            return _OPERATORS[element["type"]]([self._input(given) for given in inputs])
        return _all(element["type"], [self._number(given) for given in inputs])

    def _compared(self, kind: str, *operands: Mapping[str, Any]) -> _State:
        """Return the result of a comparison that is a condition of its own."""
        return _all(kind, [self._integer(operand) for operand in operands])

    def _number(self, given: Mapping[str, Any]) -> int | None:
        """Return the integer at a pin; None if it is not known."""
        if len(given["from"]) != 1:
            constant: int | None = given["constant"]
            return constant
        ident, pin = given["from"][0]
        source = self._elements.get(ident, {})
        outputs = [out for out in source.get("out", ()) if out["pin"] == pin]
        return self._integer(outputs[0] if outputs else source)

    def _integer(self, part: Mapping[str, Any]) -> int | None:
        """Return a constant, or the value of a variable if it is an integer."""
        if part.get("constant") is not None:
            return int(part["constant"])
        found = self._value_at(part.get("name"))
        return found if isinstance(found, int) and not isinstance(found, bool) else None

    def _input(self, given: Mapping[str, Any]) -> _State:
        if given["edge"]:
            return None
        states = [self.output(tuple(end)) for end in given["from"]]
        return _turned(_or(states) if states else given["always"], given)

    def _known(self, path: str | None) -> _State:
        found = self._value_at(path)
        return found if isinstance(found, bool) else None

    def _value_at(self, path: str | None) -> object:
        return self._value(path) if path is not None else None

    def _leads(self, element: Mapping[str, Any]) -> bool:
        return any(
            end[0] == element["id"]
            for other in self._elements.values()
            for given in other["in"]
            for end in given["from"]
        )


def _all(kind: str, numbers: Sequence[int | None]) -> _State:
    """Return whether a comparison holds for each pair of neighbours."""
    compare = _COMPARISONS.get(kind)
    if compare is None or None in numbers:
        return None
    return all(compare(first, second) for first, second in pairwise(numbers))


def _not(state: _State) -> _State:
    return None if state is None else not state


def _turned(state: _State, part: Mapping[str, Any]) -> _State:
    return _not(state) if part["negated"] else state


def _and(states: Iterable[_State]) -> _State:
    every = list(states)
    return False if False in every else None if None in every else True


def _or(states: Iterable[_State]) -> _State:
    return _not(_and(map(_not, states)))


def _xor(states: Iterable[_State]) -> _State:
    every = list(states)
    return None if None in every else every.count(True) % 2 == 1


_OPERATORS: dict[str, Callable[[Sequence[_State]], _State]] = {
    "AND": _and,
    "OR": _or,
    "XOR": _xor,
    "NOT": lambda states: _not(states[0]) if states else None,
}
_COMPARISONS: dict[str, Callable[[Any, Any], bool]] = {
    "GT": operator.gt,
    "GE": operator.ge,
    "EQ": operator.eq,
    "LE": operator.le,
    "LT": operator.lt,
    "NE": operator.ne,
}
