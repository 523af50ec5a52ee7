"""Counters (CTU, CTD, CTUD) with other results on matiec than in the standard.

In the standard, CV counts as far as the limits of its type. matiec stops counting up at PV, and
counting down at 0. The difference is visible in CV, and in both outputs of CTUD. Q of CTD does not
differ, because only values of CV up to 0 differ. Q of CTU does not differ as long as PV is
constant.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from structured_text.engines.matiec.hits import Hit, Sources, expressions
from structured_text.language import tree as t
from structured_text.language.scalars import INT_RANGE
from structured_text.language.standard import BLOCKS
from structured_text.language.types import BlockType
from structured_text.language.walk import calls_of, nodes, root_of, statements

__all__ = ["other_counts"]

_OUTPUTS = ("CV", "Q", "QU", "QD")


def other_counts(sources: Sources) -> Iterator[Hit]:
    """Yield the places that read an output of a counter whose value may differ on matiec.

    If the program reads no output of a counter, a test or an operator panel may read it. In this
    case the first call of the counter is yielded. A counter whose CV cannot differ is left out.
    """
    if sources.counters == "preset":
        return
    counters = _counters(sources)
    for pou in sources.pous:
        for at, node in expressions(pou):
            for variable, pin in _read(node):
                counter = counters.get(_key(variable)) or _Counter(variable, elsewhere=True)
                counter.is_read = True
                if counter.differs(pin, sources.counters):
                    yield Hit(pou.file, at, f"{pin} of {_name(variable)}")
    for counter in counters.values():
        if not counter.is_read and counter.calls and counter.differs("CV", sources.counters):
            pou, call = counter.calls[0]
            yield Hit(pou.file, call.at, f"CV of {_name(call.instance)}")


class _Counter:
    """A declared counter with its calls.

    `elsewhere` is true if calls that are not recorded here are possible.
    """

    def __init__(self, variable: t.Variable, *, elsewhere: bool = False) -> None:
        self.calls: list[tuple[t.Pou, t.CallBlock]] = []
        self.is_read = False
        self.is_steady = not elsewhere
        """True if no statement writes the pin PV."""
        self._block = getattr(variable.type, "name", "").upper()

    def differs(self, pin: str, rule: str) -> bool:
        """Return whether an output may differ on matiec.

        `rule` is the rule `counters` of the dialect.
        """
        kind, _, number = self._block.partition("_")
        if kind == "CTD":
            return pin == "CV" and rule == "type" and INT_RANGE[number or "INT"][0] < 0
        if kind == "CTU" and self._has_one_preset():
            return pin == "CV" and not self._stops_itself()
        return True

    def _counting(self) -> list[dict[str, t.Expression]]:
        """Return the arguments of the calls that may count an edge."""
        every = [dict(call.inputs) for _, call in self.calls]
        return [
            one
            for one in every
            if not _is_literal(one.get("R"), True) and not _is_literal(one.get("CU"), False)
        ]

    def _has_one_preset(self) -> bool:
        """Return whether PV keeps one value from the first counted edge on."""
        if not self.is_steady:
            return False
        given = [dict(call.inputs).get("PV") for _, call in self.calls]
        presets = [one for one in given if one is not None]
        if not presets:
            return True  # nothing sets PV, so it stays 0
        complete = all("PV" in one for one in self._counting())
        return complete and _is_constant(presets[0]) and presets.count(presets[0]) == len(presets)

    def _stops_itself(self) -> bool:
        """Return whether the counter's own Q always prevents it from counting beyond PV."""
        presets = [_value(one["PV"]) for one in self._counting() if "PV" in one]
        if not all(one is not None and one > 0 for one in presets) or not presets:
            return False
        return all(
            self._is_own_q(one.get("R"), "OR") or self._is_own_q(one.get("CU"), "AND")
            for one in self._counting()
        )

    def _is_own_q(self, one: t.Expression | None, op: str) -> bool:
        """Return whether an argument is `Q OR …` or `NOT Q AND …`, with the Q of this counter."""
        if isinstance(one, t.Binary) and one.op == op:
            return self._is_own_q(one.left, op) or self._is_own_q(one.right, op)
        if op == "AND":
            one = one.operand if isinstance(one, t.Unary) and one.op == "NOT" else None
        instance = _key(self.calls[0][1].instance)
        return isinstance(one, t.Member) and one.name == "Q" and _key(one.base) == instance


def _counters(sources: Sources) -> dict[object, _Counter]:
    """Return the counters that are declared as variables, by their declaration."""
    found: dict[object, _Counter] = {}
    for pou in sources.pous:
        for call in calls_of(pou.body):
            key = _key(call.instance)
            if key is not None and _is_counter(call.block):
                found.setdefault(key, _Counter(call.instance)).calls.append((pou, call))
    for pou in sources.pous:
        for one in statements(pou.body):
            target = one.target if isinstance(one, t.Assign) else None
            if isinstance(target, t.Member) and target.name == "PV":
                key = _key(target.base)
                if key in found:
                    found[key].is_steady = False
    return found


def _key(variable: t.Expression) -> object:
    """Return the declaration of a counter; None if the counter is part of another variable."""
    symbol = root_of(variable)
    if symbol is None or not isinstance(variable, t.Use) or symbol.section == "VAR_IN_OUT":
        return None
    if symbol.section in ("VAR_EXTERNAL", "VAR_GLOBAL"):
        return (symbol.source or symbol.name).upper()
    return symbol


def _name(variable: t.Variable) -> str:
    symbol = root_of(variable)
    return "a counter" if symbol is None else symbol.name


def _read(node: Any) -> list[tuple[t.Variable, str]]:
    """Return the outputs of counters that a node of an expression reads."""
    if isinstance(node, t.Member):
        reads = node.name in _OUTPUTS and _is_counter(node.base.type)
        return [(node.base, node.name)] if reads else []
    if isinstance(node, t.CallBlock) and _is_counter(node.block):
        return [(node.instance, pin) for pin, _ in node.outputs]
    return []


def _is_counter(kind: object) -> bool:
    """Return whether a type is a standard counter, and not a user's block with the same name."""
    if not isinstance(kind, BlockType) or not kind.name.upper().startswith(("CTU", "CTD")):
        return False
    return BLOCKS.get(kind.name.upper()) == kind


def _is_literal(one: t.Expression | None, value: bool) -> bool:
    return isinstance(one, t.Constant) and one.value is value


def _is_constant(one: t.Expression) -> bool:
    """Return whether an expression consists of constants only."""
    return all(
        isinstance(node, (t.Constant, t.Unary, t.Binary))
        or (isinstance(node, t.Use) and node.symbol.constant)
        for node in nodes(one)
    )


def _value(one: t.Expression) -> int | None:
    """Return the value of a literal or constant; None if it is calculated."""
    found = one.value if isinstance(one, t.Constant) else None
    if isinstance(one, t.Use) and one.symbol.constant:
        found = one.symbol.initial
    return found if isinstance(found, int) else None
