"""Ladder diagrams behave as they are drawn, on the built-in engine and on matiec."""

from __future__ import annotations

from datetime import timedelta
from pathlib import Path

import pytest

from drawn import Drawing, matiec_rows, scanned
from structured_text.engines.matiec.build import Matiec
from structured_text.projects.diagrams.networks.check import DiagramError
from structured_text.projects.diagrams.networks.model import Network, Output

_ORDERS = pytest.mark.parametrize("by_position", [True, False], ids=["position", "networks"])


def _latch(by_position: bool) -> Drawing:
    """Return a start and stop circuit: (Start OR Motor) AND NOT Stop."""
    drawing = Drawing("Start, Stop, Motor, Lamp : BOOL;", by_position=by_position)
    drawing.network("Motor", "Start has\nno memory.")
    start, motor = drawing.contact("Start"), drawing.contact("Motor")
    stop = drawing.contact("Stop", f"{start} {motor}", negated=True)
    drawing.coil("Motor", stop)
    return drawing


@_ORDERS
def test_series_and_parallel_contacts(tmp_path: Path, by_position: bool) -> None:
    """Parallel lines are OR, contacts in a row are AND, a negated contact is NOT.

    Source: IEC 61131-3, 4.2.3 and table 61.
    """
    given = [{}, {"Start": True}, {"Start": False}, {"Stop": True}, {"Stop": False}]
    got = scanned(_latch(by_position), tmp_path, given, "Motor")
    assert got == [(False,), (True,), (True,), (False,), (False,)]


def test_a_rung_is_one_readable_statement_with_its_comment() -> None:
    """The title stands with the number of the network, the comment behind it."""
    drawing = _latch(by_position=True)
    assert drawing.text() == [
        "(* Network 1: Motor *)",
        "(* Start has *)",
        "(* no memory. *)",
        "Motor := (Start OR Motor) AND NOT Stop;",
    ]
    section, lines = drawing.translated()
    assert section == ()
    assert {line.network for line in lines} == {"network 1"}
    assert [line.at for line in lines] == [100, 100, 100, 104]


def test_what_parallel_branches_have_in_common_is_written_once() -> None:
    """A AND (B OR C): the branches begin behind the contact A."""
    drawing = Drawing("A, B, C, X : BOOL;")
    first = drawing.contact("A")
    ends = drawing.contact("B", first), drawing.contact("C", first)
    drawing.coil("X", " ".join(ends))
    assert drawing.text()[1:] == ["X := A AND (B OR C);"]


def test_a_line_beside_a_contact_bridges_it() -> None:
    """A parallel line without a contact has power whenever the rail has it."""
    drawing = Drawing("A, X, Y : BOOL;")
    first = drawing.contact("A")
    drawing.coil("X", f"0 {first}")
    drawing.coil("Y", f"{first} {drawing.contact('X', first)}")
    assert drawing.text()[1:] == ["X := TRUE;", "Y := A;"]


@_ORDERS
def test_coils_assign_set_reset_and_invert(tmp_path: Path, by_position: bool) -> None:
    """Set and reset keep their variable while they have no power.

    Source: IEC 61131-3, table 62.
    """
    drawing = Drawing("A, B, Same, Inv, Kept : BOOL;", by_position=by_position)
    first = drawing.contact("A")
    drawing.coil("Same", first)
    drawing.coil("Inv", first, negated=True)
    drawing.network()
    drawing.coil("Kept", drawing.contact("A"), storage="set")
    drawing.network()
    drawing.coil("Kept", drawing.contact("B"), storage="reset")
    given = [{}, {"A": True}, {"A": False}, {"B": True}, {"A": True}]
    got = scanned(drawing, tmp_path, given, "Same Inv Kept")
    assert [tuple(map(int, row)) for row in got] == [
        (0, 1, 0),
        (1, 0, 1),
        (0, 1, 1),
        (0, 1, 0),
        (1, 0, 0),  # reset comes after set
    ]


@_ORDERS
def test_edges_of_contacts_and_coils_last_one_scan(tmp_path: Path, by_position: bool) -> None:
    """Source: IEC 61131-3, tables 61 and 62: transition-sensing contacts and coils."""
    drawing = Drawing("A, B, Up, Down, Coil, Fall : BOOL;", by_position=by_position)
    drawing.coil("Up", drawing.contact("A", edge="rising"))
    drawing.network()
    drawing.coil("Down", drawing.contact("A", edge="falling"))
    drawing.network()
    drawing.coil("Coil", drawing.contact("A", drawing.contact("B")), edge="rising")
    drawing.network()
    drawing.coil("Fall", drawing.contact("A"), edge="falling")
    given = [{"A": True}, {}, {"B": True}, {}, {"A": False}, {}]
    got = scanned(drawing, tmp_path, given, "Up Down Coil Fall")
    assert [tuple(map(int, row)) for row in got] == [
        (1, 0, 0, 0),
        (0, 0, 0, 0),
        (0, 0, 1, 0),
        (0, 0, 0, 0),
        (0, 1, 0, 1),
        (0, 0, 0, 0),
    ]


@_ORDERS
def test_a_coil_passes_its_power_on(tmp_path: Path, by_position: bool) -> None:
    """The power behind a coil is the power before it, also if the coil inverts.

    Source: IEC 61131-3, 4.2.4: the left link is copied to the right link.
    """
    drawing = Drawing("A, B, X, Y : BOOL;", by_position=by_position)
    first = drawing.coil("X", drawing.contact("A"), negated=True)
    drawing.coil("Y", drawing.contact("B", first))
    given = [{}, {"A": True}, {"B": True}]
    got = scanned(drawing, tmp_path, given, "X Y")
    assert got == [(True, False), (False, False), (False, True)]


def test_power_is_read_once_in_a_network_of_codesys(tmp_path: Path) -> None:
    """The first coil changes A, but the second one has the power that A gave before.

    Source: docs/reference/language.md, Ladder and Function Block Diagram (assumed).
    """
    drawing = Drawing("A, B, Count : BOOL;", by_position=False)
    first = drawing.contact("A")
    drawing.coil("A", first, storage="reset")
    drawing.coil("B", first)
    assert scanned(drawing, tmp_path, [{"A": True}, {}], "A B") == [(False, True), (False, False)]


def test_contacts_are_read_by_each_coil_in_the_order_by_position(tmp_path: Path) -> None:
    """The second coil reads A after the first one has reset it.

    Source: Beremiz, PLCGenerator.py, GeneratePaths: the variable stands in each statement.
    """
    drawing = Drawing("A, B : BOOL;")
    first = drawing.contact("A")
    drawing.coil("A", first, storage="reset")
    drawing.coil("B", first)
    assert scanned(drawing, tmp_path, [{"A": True}, {}], "A B") == [(False, False), (False, False)]


@_ORDERS
def test_a_timer_stands_in_a_rung(tmp_path: Path, by_position: bool) -> None:
    """The timer expires 20 ms after A, and X follows in the same scan."""
    drawing = Drawing("A, X : BOOL; T1 : TON; E : TIME;", by_position=by_position)
    wait = drawing.block(
        "TON",
        {"IN": drawing.contact("A"), "PT": drawing.read("T#20ms")},
        ("Q", Output("ET", target="E")),
        "T1",
    )
    drawing.coil("X", f"{wait}.Q")
    got = scanned(drawing, tmp_path, [{"A": True}, {}, {}], "X E")
    assert got == [(False, timedelta(milliseconds=10 * n)) for n in (0, 1)] + [
        (True, timedelta(milliseconds=20))
    ]


def test_translations_agree_on_matiec(tmp_path: Path, matiec: Matiec) -> None:
    """A latch, edges, coils and a timer: both engines give the same values."""
    drawing = _latch(by_position=True)
    drawing.variables += "Up : BOOL; T1 : TON;"
    drawing.network()
    up = drawing.contact("Motor", edge="rising")
    drawing.coil("Up", up)
    drawing.network()
    wait = drawing.block(
        "TON", {"IN": drawing.contact("Motor"), "PT": drawing.read("T#10ms")}, ("Q",), "T1"
    )
    drawing.coil("Lamp", drawing.contact("Up", f"{wait}.Q", negated=True), storage="set")
    given = [{}, {"Start": True}, {"Start": False}, {}, {"Stop": True}, {"Stop": False}]
    shown = "Motor Up Lamp"
    theirs = matiec_rows(drawing, tmp_path, given, shown, matiec)
    assert theirs == scanned(drawing, tmp_path, given, shown)
    assert [tuple(map(int, row)) for row in theirs] == [
        (0, 0, 0),
        (1, 1, 0),
        (1, 0, 1),
        (1, 0, 1),
        (0, 0, 1),
        (0, 0, 1),
    ]


def test_an_unconnected_coil_is_an_error_in_a_network() -> None:
    """The message names network and coil; the order by position follows Beremiz: no effect."""
    drawing = Drawing("A, X : BOOL;", by_position=False)
    drawing.coil("X", "")
    with pytest.raises(DiagramError) as caught:
        drawing.text()
    assert caught.value.message == "network 1: the coil X is not connected"
    drawing.by_position = True
    assert drawing.text()[1:] == ["(* The coil X is not connected: it has no effect. *)"]


def test_a_contact_without_a_left_side_is_an_error() -> None:
    """Source: Beremiz refuses it as well."""
    drawing = Drawing("A, X : BOOL;")
    drawing.coil("X", drawing.contact("A", ""))
    with pytest.raises(DiagramError) as caught:
        drawing.text()
    assert caught.value.message == "network 1: the contact A is not connected on its left side"
    assert caught.value.hint == "connect it, or remove it"


@pytest.mark.parametrize("label", ["Ende", "End"])
def test_labels_are_unique_and_known(label: str) -> None:
    """A message for two equal labels, and one with near names for an unknown label."""
    drawing = Drawing("A, X : BOOL;", by_position=False)
    drawing.network(label="End")
    drawing.coil("X", drawing.contact("A"))
    drawing.networks.append(Network(2, label=label, at=7))
    if label == "End":
        with pytest.raises(DiagramError) as caught:
            drawing.text()
        expected = "network 2: the label END is also the label of network 1"
        assert (caught.value.message, caught.value.at) == (expected, 7)
    else:
        assert drawing.text()[-1] == "X := A;"


def test_a_contact_that_leads_nowhere_is_named_in_a_comment() -> None:
    """The contact of a latch is not joined to the line behind the start contact."""
    drawing = Drawing("Start, Motor : BOOL;")
    drawing.coil("Motor", drawing.contact("Start"))
    drawing.contact("Motor")
    assert drawing.text()[1:] == [
        "Motor := Start;",
        "(* The contact Motor leads nowhere: it has no effect. *)",
    ]
