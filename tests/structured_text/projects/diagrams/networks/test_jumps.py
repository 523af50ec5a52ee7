"""Jumps, labels and returns: the translation has IF, or a loop over the parts of the diagram."""

from __future__ import annotations

from pathlib import Path

import pytest

from drawn import Drawing, matiec_rows, scanned
from structured_text.engines.matiec.build import Matiec
from structured_text.projects.diagrams.networks.check import DiagramError


def _drawing(variables: str) -> Drawing:
    return Drawing(variables, by_position=False)


def _count(drawing: Drawing, variable: str, label: str = "") -> None:
    """Draw a network that adds 1 to a variable."""
    drawing.network(label=label)
    one = drawing.block("ADD", {"IN1": drawing.read(variable), "IN2": drawing.read("1")})
    drawing.write(variable, one)


def _forward() -> Drawing:
    """Return a jump over two networks; the second one has a jump of its own to the same label."""
    drawing = _drawing("A, B : BOOL; N, M, K : INT;")
    drawing.network()
    drawing.jump("End", drawing.contact("A"))
    _count(drawing, "N")
    drawing.network()
    drawing.jump("End", drawing.contact("B"))
    _count(drawing, "M")
    _count(drawing, "K", label="End")
    return drawing


_INPUTS = [{}, {"A": True}, {"A": False, "B": True}, {"A": True}, {"A": False, "B": False}]
#: N counts without A, M without A and B, K always.
_COUNTS = [(1, 1, 1), (1, 1, 2), (2, 1, 3), (2, 1, 4), (3, 2, 5)]


def test_a_jump_forward_skips_networks(tmp_path: Path) -> None:
    """Source: IEC 61131-3, 4.1.4, execution control."""
    assert scanned(_forward(), tmp_path, _INPUTS, "N M K") == _COUNTS


def test_a_jump_forward_becomes_an_if() -> None:
    """What the jump skips stands in the IF, with the heading of its network."""
    assert _forward().text() == [
        "(* Network 1 *)",
        "IF NOT A THEN",
        "  (* Network 2 *)",
        "  N := N + 1;",
        "  (* Network 3 *)",
        "  IF NOT B THEN",
        "    (* Network 4 *)",
        "    M := M + 1;",
        "  END_IF;",
        "END_IF;",
        "(* Network 5 *)",
        "K := K + 1;",
    ]


def _crossed() -> Drawing:
    """Return two jumps forward of which the first one ends within the second one."""
    drawing = _drawing("A, B : BOOL; N, M, K : INT;")
    drawing.network()
    drawing.jump("Mid", drawing.contact("A"))
    drawing.network()
    drawing.jump("End", drawing.contact("B"))
    _count(drawing, "N")
    _count(drawing, "M", label="Mid")
    _count(drawing, "K", label="End")
    return drawing


def test_jumps_that_cross_each_other(tmp_path: Path) -> None:
    """A: M and K count; B without A: only K counts; neither: all three count."""
    got = scanned(_crossed(), tmp_path, _INPUTS, "N M K")
    assert got == [(1, 1, 1), (1, 2, 2), (1, 2, 3), (1, 3, 4), (2, 4, 5)]


def _backward() -> Drawing:
    """Return a loop: N is halved until it is below 10, and K counts the rounds."""
    drawing = _drawing("N : INT; K : INT; Big : BOOL;")
    drawing.network()
    drawing.write("K", drawing.read("0"))
    _count(drawing, "K", label="Again")
    drawing.network()
    drawing.write("N", drawing.block("DIV", {"IN1": drawing.read("N"), "IN2": drawing.read("2")}))
    drawing.network()
    big = drawing.block("GE", {"IN1": drawing.read("N"), "IN2": drawing.read("10")})
    drawing.jump("Again", big)
    drawing.network()
    drawing.coil("Big", drawing.contact("Big", negated=True))
    return drawing


def test_a_jump_backward_repeats_networks(tmp_path: Path) -> None:
    """50 is halved to 25, 12 and 6; 6 to 3; then the diagram goes on behind the jump."""
    given = [{"N": 50}, {"N": 6}, {"N": 1000}]
    got = scanned(_backward(), tmp_path, given, "N K Big")
    assert got == [(6, 3, True), (3, 1, False), (7, 7, True)]


def test_jumps_run_on_matiec(tmp_path: Path, matiec: Matiec) -> None:
    """The loop and the crossed jumps give the same values on matiec."""
    assert matiec_rows(_backward(), tmp_path, [{"N": 50}, {"N": 6}], "N K", matiec) == [
        (6, 3),
        (3, 1),
    ]
    got = matiec_rows(_crossed(), tmp_path, _INPUTS, "N M K", matiec)
    assert got == [(1, 1, 1), (1, 2, 2), (1, 2, 3), (1, 3, 4), (2, 4, 5)]


def test_a_return_ends_the_scan_of_the_program(tmp_path: Path) -> None:
    """What stands behind the return is not executed while A is TRUE."""
    drawing = _drawing("A : BOOL; N, M : INT;")
    _count(drawing, "N")
    drawing.network()
    drawing.leave(drawing.contact("A"))
    _count(drawing, "M")
    got = scanned(drawing, tmp_path, [{}, {"A": True}, {"A": False}], "N M")
    assert got == [(1, 1), (2, 1), (3, 2)]


def test_outputs_behind_a_jump_in_one_network_are_skipped(tmp_path: Path) -> None:
    """The jump stands between two coils: the coil behind it keeps its value.

    Source: docs/reference/language.md, Ladder and Function Block Diagram (assumed).
    """
    drawing = _drawing("A, B, C : BOOL;")
    drawing.network()
    power = drawing.contact("A")
    drawing.coil("B", power)
    drawing.jump("End", power)
    drawing.coil("C", power, negated=True)
    drawing.network(label="End")
    got = scanned(drawing, tmp_path, [{}, {"A": True}], "B C")
    assert got == [(False, True), (True, True)]


def test_a_jump_to_an_unknown_label_names_similar_labels() -> None:
    """The message has the network of the jump, the hint the labels of the diagram."""
    drawing = _drawing("A : BOOL;")
    drawing.network()
    drawing.jump("Ende", drawing.contact("A"))
    drawing.network(label="End")
    with pytest.raises(DiagramError) as caught:
        drawing.text()
    assert caught.value.message == "network 1: there is no label Ende to jump to"
    assert "End" in caught.value.hint


def test_a_jump_is_refused_in_the_order_by_position() -> None:
    """Beremiz and OpenPLC ignore jumps; networks are no parts of their programs."""
    drawing = Drawing("A : BOOL;")
    drawing.network(label="End")
    drawing.jump("End", drawing.contact("A"))
    with pytest.raises(DiagramError, match="network 1: a jump is not supported"):
        drawing.text()
