"""The power in a network from the values of its variables. The page's script is tested likewise."""

from __future__ import annotations

from typing import Any

import pytest

from network_elements import block, coil, contact, from_, ladder, plan, read, written
from structured_text.projects.diagrams.networks.draw.live import Found, LiveNetwork
from structured_text.projects.diagrams.networks.draw.power import power_of
from structured_text.projects.diagrams.networks.model import Connector, Continuation, Diagram

_RUNG = ladder(contact("1", "A", "0"), contact("2", "B", "1", negated=True), coil("3", "Q", "2"))


def _power(diagram: Diagram, **values: Any) -> dict[str, bool]:
    def find(text: str) -> Found | None:
        boolean = not text.endswith(("ET", "PT"))
        return Found(text, boolean, True) if text in values or boolean else None

    elements = LiveNetwork(diagram, 1, find, {}).elements()
    return power_of(elements, values.get)


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ({"A": True, "B": False}, {"1": True, "2": True, "3": True}),
        ({"A": True, "B": True}, {"1": True, "2": False, "3": False}),
        ({"A": False}, {"1": False, "2": False, "3": False}),
        ({"A": True}, {"1": True}),
        ({}, {}),
    ],
)
def test_power_flows_through_closed_contacts(
    values: dict[str, bool], expected: dict[str, bool]
) -> None:
    """What is not known is not in the result, and is not off."""
    assert _power(_RUNG, **values) == expected


def test_parallel_lines_are_joined_by_or() -> None:
    """A closed contact hides one that is not known. Tools differ behind a coil of two lines."""
    both = (contact("1", "A", "0"), contact("2", "B", "0"), coil("3", "Q", "1", "2"))
    assert _power(ladder(*both), A=True)["3"] is True
    assert "3" not in _power(ladder(*both), A=False)
    assert _power(ladder(*both), A=False, B=False)["3"] is False
    behind = ladder(*both, contact("4", "C", "3"))
    assert _power(behind, A=True, B=True, C=True) == {"1": True, "2": True}


@pytest.mark.parametrize(
    ("kind", "expected"), [("AND", False), ("OR", True), ("XOR", True), ("GT", None)]
)
def test_operators_are_calculated(kind: str, expected: bool | None) -> None:
    operator = block("9", kind, [from_("1", name="IN1"), from_("2", name="IN2")], ["OUT"])
    diagram = plan(read("1", "A"), read("2", "B"), operator, written("8", "Q", "9.OUT"))
    assert _power(diagram, A=True, B=False, Q=True).get("9.OUT") is expected
    assert (
        _power(plan(read("1", "TRUE"), block("9", "NOT", [from_("1")], ["OUT"])))["9.OUT"] is False
    )


@pytest.mark.parametrize(
    ("kind", "expected"),
    [("GT", "000"), ("GE", "010"), ("EQ", "010"), ("LE", "111"), ("LT", "101"), ("NE", "101")],
)
def test_integers_are_compared(kind: str, expected: str) -> None:
    """PT is compared with 7. In the last case there are three inputs: 5, 6 and 7."""
    inputs = [from_("1", name="IN1"), from_("2", name="IN2")]
    two = plan(read("1", "PT"), read("2", "7"), block("9", kind, inputs, ["OUT"]))
    inputs = [*inputs, from_(name="IN3", value="7")]
    three = plan(read("1", "PT"), read("2", "6"), block("9", kind, inputs, ["OUT"]))
    found = [_power(two, PT=6)["9.OUT"], _power(two, PT=7)["9.OUT"], _power(three, PT=5)["9.OUT"]]
    assert "".join(str(int(state)) for state in found) == expected
    assert _power(two, PT=6.5) == _power(two, PT="T#6s") == {}


def test_a_function_that_is_not_executed_has_an_unknown_result() -> None:
    inputs = [from_("1", name="EN"), from_("2", name="IN1"), from_("3", name="IN2")]
    compared = block("9", "GT", inputs, ["ENO", "OUT"])
    diagram = plan(read("1", "A"), read("2", "PT"), read("3", "7"), compared)
    assert _power(diagram, A=True, PT=8) == {"1": True, "9.ENO": True, "9.OUT": True}
    assert _power(diagram, A=False, PT=8) == {"1": False, "9.ENO": False}


def test_a_block_has_the_values_of_its_outputs_and_eno_that_of_en() -> None:
    timer = block("2", "TON", [from_("1", name="EN")], ["ENO", "Q", "ET"], instance="T")
    diagram = plan(read("1", "A"), timer)
    found = _power(diagram, A=True, **{"T.Q": False, "T.ET": 5, "T.ENO": True})
    assert found == {"1": True, "2.ENO": True, "2.Q": False}
    move = block("2", "MOVE", [from_("1", name="EN")], ["ENO", "OUT"])
    assert _power(plan(read("1", "A"), move), A=False) == {"1": False, "2.ENO": False}


def test_a_line_goes_on_and_a_loop_is_not_known() -> None:
    ends = (Connector("2", name="X", input=from_("1")), Continuation("3", name="x"))
    assert _power(plan(read("1", "A"), *ends), A=True) == {"1": True, "2": True, "3": True}
    assert _power(plan(Connector("2", name="X", input=from_("3")), ends[1])) == {}
