"""Drawings of small networks as text. The expected drawings were written by hand."""

from __future__ import annotations

import pytest

from network_elements import block, coil, contact, from_, ladder, plan, read, written
from structured_text.projects.diagrams.networks.draw.drawing import State, columns, wrapped
from structured_text.projects.diagrams.networks.draw.text import network_text
from structured_text.projects.diagrams.networks.model import (
    Connector,
    Continuation,
    Diagram,
    InVariable,
    Jump,
    Network,
    Return,
)

_LATCH = ladder(
    contact("1", "Start", "0"),
    contact("2", "Lamp", "0"),
    contact("3", "Stop", "1", "2", negated=True),
    coil("4", "Lamp", "3"),
    title="Start and stop",
    comment="The lamp stays on.",
)


def _plain(diagram: Diagram, state: State | None = None, width: int = 100) -> str:
    return "\n" + network_text(diagram, 1, state, width=width, plain=True)


def test_a_latch_has_two_branches_that_meet_before_the_stop_contact() -> None:
    assert (
        _plain(_LATCH)
        == """
Network 1: Start and stop
The lamp stays on.
|  Start   Stop  Lamp  |
|---| |--+-|/|---( )---|
|   Lamp |             |
|---| |--+             |
"""
    )


def test_box_characters_draw_the_same_lines() -> None:
    assert (
        network_text(_LATCH, 1)
        == """Network 1: Start and stop
The lamp stays on.
│  Start   Stop  Lamp  │
│───┤ ├──┬─┤/├───( )───│
│   Lamp │             │
│───┤ ├──┘             │
"""
    )


def test_lines_with_power_are_thick_and_values_stand_beside_names() -> None:
    """The lamp holds itself: Start is off, and power comes through the lamp's own contact."""
    on = {"1": False, "2": True, "3": True, "4": True}
    assert (
        _plain(_LATCH, State(on, {"1": "FALSE", "4": "TRUE"}))
        == """
Network 1: Start and stop
The lamp stays on.
|  Start = FALSE   Stop  Lamp = TRUE  |
|=======| |------#=|/|=======( )======|
|       Lamp     #                    |
|=======| |======#                    |
"""
    )


def test_only_the_lines_from_the_rail_have_power_if_no_contact_is_closed() -> None:
    on = {"1": False, "2": False, "3": False, "4": False}
    assert _plain(_LATCH, State(on)).endswith(
        """
|===| |--+-|/|---( )---|
|   Lamp |             |
|===| |--+             |
"""
    )


def test_three_branches_inside_each_other() -> None:
    """((A AND (B OR C)) OR D) AND E sets Out, and the inverted coil."""
    diagram = ladder(
        contact("1", "A", "0"),
        contact("2", "B", "1"),
        contact("3", "C", "1"),
        contact("4", "D", "0"),
        contact("5", "E", "2", "3", "4"),
        coil("6", "Q", "5", storage="set"),
        coil("7", "R", "5", negated=True),
    )
    assert (
        _plain(diagram)
        == """
Network 1
|   A     B     E     Q   |
|--| |-+-| |-+-| |-+-(S)--|
|      |  C  |     |  R   |
|   D  +-| |-+     +-(/)--|
|--| |-------+            |
"""
    )


def test_a_timer_in_a_rung_has_variables_at_its_pins() -> None:
    diagram = ladder(
        contact("1", "Start", "0", edge="rising"),
        read("v", "T#2s"),
        block("2", "TON", [from_("1", name="IN"), from_("v", name="PT")], ["Q", "ET"], "Timer"),
        written("w", "Elapsed", "2.ET"),
        coil("3", "Lamp", "2.Q"),
    )
    assert (
        _plain(diagram)
        == """
Network 1
|                 Timer                   |
|               +-------+                 |
|  Start        |  TON  |           Lamp  |
|---|P|---------|IN    Q|-----------( )---|
|         T#2s--|PT   ET|--Elapsed        |
|               +-------+                 |
"""
    )


def test_a_value_that_two_pins_use_is_drawn_once() -> None:
    """Both blocks are below each other, and a circle inverts an input."""
    diagram = plan(
        read("x", "A"),
        block("1", "AND", [from_("x", name="P"), from_(value="B", name="Q")], ["OUT:=C"]),
        block("2", "OR", [from_("x", name="P", negated=True)], ["OUT"]),
        written("w", "D", "2.OUT"),
    )
    assert (
        _plain(diagram)
        == """
Network 1
       +-------+
       |  AND  |
A-+----|P   OUT|--C
  | B--|Q      |
  |    +-------+
  |
  |    +-------+
  |    |  OR   |
  +---o|P   OUT|--D
       +-------+
"""
    )


def test_a_line_to_the_left_goes_below_the_blocks() -> None:
    """The block counts up: its output is its own input."""
    diagram = plan(
        block("1", "ADD", [from_(value="1", name="P"), from_("1.OUT", name="Q")], ["OUT"]),
        written("w", "N", "1.OUT"),
    )
    assert (
        _plain(diagram)
        == """
Network 1
      +-------+
      |  ADD  |
   1--|P   OUT|-+-N
 +----|Q      | |
 |    +-------+ |
 |              |
 +-------<------+
"""
    )


def test_jumps_returns_and_named_lines_end_rungs() -> None:
    diagram = ladder(
        contact("1", "A", "0"),
        Jump("2", label="End", input=from_("1")),
        contact("3", "B", "0"),
        Return("4", input=from_("3")),
        contact("5", "C", "0"),
        Connector("6", name="L", input=from_("5")),
        Continuation("7", name="L"),
        coil("8", "Q", "7"),
    )
    assert (
        _plain(diagram)
        == """
Network 1
|   A             |
|--| |-->>End     |
|   B             |
|--| |--<RETURN>  |
|   C             |
|--| |-->L>       |
|        Q        |
|  >L>--( )-------|
"""
    )


def test_a_crossing_is_not_a_connection() -> None:
    """SUB(B, A): the vertical line of A is in front of the line of B."""
    diagram = plan(
        read("a", "A"),
        read("b", "B"),
        block("1", "SUB", [from_("a", name="P"), from_("b", name="Q")], ["OUT:=C"]),
        block("2", "SUB", [from_("b", name="P"), from_("a", name="Q")], ["OUT:=D"]),
    )
    assert "B╴│╶┬─│Q" in network_text(diagram, 1)
    assert "B-|-+-|Q" in network_text(diagram, 1, plain=True)


def test_branches_that_share_only_one_source_stay_apart() -> None:
    """X is A OR B, but Y is B alone: the line of B parts before it meets the line of A."""
    diagram = ladder(
        contact("1", "A", "0"),
        contact("2", "B", "0"),
        coil("3", "X", "1", "2"),
        coil("4", "Y", "2"),
    )
    assert (
        _plain(diagram)
        == """
Network 1
|   A        X   |
|--| |----+-( )--|
|   B  +--+  Y   |
|--| |-+----( )--|
"""
    )


def test_forty_contacts_go_on_in_the_next_lines() -> None:
    contacts = [contact(str(k), f"C{k:02}", str(k - 1)) for k in range(1, 41)]
    lines = _plain(ladder(*contacts, coil("41", "Q", "40")), width=60).splitlines()
    assert max(map(len, lines)) <= 60
    text = "\n".join(lines)
    assert [f"C{k:02}" in text for k in range(1, 41)] == [True] * 40
    ends = [line for line in lines if ">1" in line]
    begins = [line for line in lines if "1>" in line]
    assert ends[0].endswith("|->1")
    assert begins[0].lstrip().startswith("1>-")
    assert lines[-1].endswith("-|")


def test_long_names_continue_below_and_lose_no_letter() -> None:
    name = "Machine.Station_12.Conveyor_left.Motor_is_running"
    lines = wrapped(name)
    assert lines == ["Machine.Station_12.", "Conveyor_left.Motor_is_", "running"]
    text = _plain(ladder(contact("1", name, "0"), coil("2", "x" * 60, "1")))
    assert all(line in text for line in lines)
    assert text.count("x") == 60


@pytest.mark.parametrize("text", ["start", "開始スイッチ", "é" * 30, ""])
def test_wide_letters_do_not_move_the_lines(text: str) -> None:
    """Each wide letter fills two columns of a terminal, so the right rail stays straight."""
    lines = _plain(ladder(contact("1", text, "0"), coil("2", "Q", "1"))).splitlines()[2:]
    assert len({columns(line) for line in lines}) == 1


def test_sources_outside_the_network_are_named() -> None:
    diagram = plan(
        InVariable("1", network=2, expression="Other"),
        written("2", "Q", "1"),
        written("3", "R", "missing"),
    )
    assert _plain(diagram) == "\nNetwork 1\nOther--Q\n    ?--R\n"


def test_an_empty_network_has_only_its_heading() -> None:
    diagram = Diagram("LD", (Network(1, "Spare", "", "Skip"),))
    assert _plain(diagram) == "\nNetwork 1: Spare\nSkip:\n\n"
