"""Conditions on fields of a telegram, expressed by the pins that fill the fields."""

from __future__ import annotations

from collections.abc import Mapping

from rcx_harness.spec.telegram import Field
from rcx_tools.library.tables import Block, Enumeration, Input, Member
from structured_text.errors import InputError

__all__ = ["Conditions", "both", "either"]

_ZERO = {"WORD": "WORD#16#0000", "REAL": "0.0"}


def both(*conditions: str) -> str:
    """Return the conjunction of conditions as text. An empty text means "always true"."""
    given = [one for one in conditions if one]
    return " AND ".join(f"({one})" if " OR " in one and len(given) > 1 else one for one in given)


def either(*conditions: str) -> str:
    """Return the disjunction of conditions as text. An empty text means "always true"."""
    if not all(conditions):
        return ""
    wrapped = (f"({one})" if " AND " in one and len(conditions) > 1 else one for one in conditions)
    return " OR ".join(wrapped)


class Conditions:
    """Generator of conditions on the pins of a block."""

    def __init__(self, block: Block, enumerations: Mapping[str, Enumeration]) -> None:
        self._block = block
        self._enumerations = enumerations

    def counts(self, pin: Input) -> str:
        """Return the condition under which a pin is used."""
        given = f"{pin.pin} <> {_ZERO.get(pin.type, '0')}" if pin.flag else ""
        return both(self.holds(*pin.when) if pin.when else "", given)

    def matters(self, pin: Input, part: Field) -> str:
        """Return the condition under which a pin is used and its field has an effect."""
        condition = self.counts(pin)
        if not part.by or part.by == pin.flag or (pin.when and pin.when[0] == part.by):
            return condition
        return both(self.among(part.by, tuple(part.ranges)), condition)

    def among(self, name: str, values: tuple[int, ...]) -> str:
        """Return the condition that a field has one of these values. Empty if it is always true."""
        pin = self._filler(name)
        if pin and pin.type in self._enumerations and len(pin.to) == 1:
            return self._member(pin, set(values))
        return either(*(self.holds(name, value, value) for value in values))

    def holds(self, name: str, low: int, high: int) -> str:
        """Return the condition that a field is from `low` to `high`. Empty if it is always true."""
        if self._block.requests[name].fixed is not None:
            return ""
        pin = self._filler(name)
        if pin is None:
            raise InputError(f"{self._block.name}: no pin fills {name}")
        if pin.flag == name:
            return f"{pin.pin} {'<>' if low else '='} {_ZERO.get(pin.type, '0')}"
        if len(pin.to) > 1:
            chosen = self._enumerations[pin.type].members[pin.to.index(name) + 1]
            return f"{pin.pin} {'=' if low else '<>'} {chosen.name}"
        if pin.type in self._enumerations:
            return self._member(pin, set(range(low, high + 1)))
        if pin.type == "BOOL":
            return pin.pin if low else f"NOT {pin.pin}"
        if low == high:
            return f"{pin.pin} = {low}"
        return f"{pin.pin} >= {low} AND {pin.pin} <= {high}"

    def accepted(self, pin: Input, member: Member) -> bool:
        """Return whether a block accepts this member of an enumeration."""
        if pin.flag or pin.when or len(pin.to) > 1:
            return True
        known = self._block.requests[pin.to[0]].values
        return not known or member.value in known

    def _filler(self, name: str) -> Input | None:
        pins = (one for one in self._block.inputs if name in one.to or one.flag == name)
        return next(pins, None)

    def _member(self, pin: Input, values: set[int]) -> str:
        """Return the condition that the pin is a member with one of these values.

        The shorter form is chosen: a list of these members, or a list of all other members.
        """
        members = self._enumerations[pin.type].members
        inside = [one.name for one in members if one.value in values]
        outside = [one.name for one in members if one.value not in values]
        if not any(self.accepted(pin, one) for one in members if one.value not in values):
            return ""
        if len(outside) < len(inside):
            return " AND ".join(f"{pin.pin} <> {name}" for name in outside)
        return " OR ".join(f"{pin.pin} = {name}" for name in inside)
