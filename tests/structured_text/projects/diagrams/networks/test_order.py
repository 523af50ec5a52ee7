"""The order in which outputs, coils and blocks are executed."""

from __future__ import annotations

from pathlib import Path

import pytest

from drawn import Drawing, scanned
from structured_text.projects.diagrams.networks.model import Position

_COPIES = "A, B, C, D, E : INT;"


def _copies(sorting: str) -> Drawing:
    """Return four copies of variables: in the drawing D from A stands above and left.

    The file has B from A, C from B, D from C and E from D, each above the last.
    """
    drawing = Drawing(_COPIES, sorting=sorting, language="FBD")
    for number, (target, source) in enumerate([("B", "A"), ("C", "B"), ("D", "C"), ("E", "D")]):
        place = Position(10, 200 - 50 * number)
        drawing.write(target, drawing.read(source), position=place)
    return drawing


@pytest.mark.parametrize(
    ("sorting", "scans"),
    [
        # From the top E, D, C, B are written: a value needs a scan for each step.
        ("position", [(7, 0, 0, 0), (7, 7, 0, 0)]),
        ("together", [(7, 0, 0, 0), (7, 7, 0, 0)]),
        # In the order of the file, the value goes through at once.
        ("file", [(7, 7, 7, 7), (7, 7, 7, 7)]),
    ],
)
def test_outputs_are_written_from_the_top(
    tmp_path: Path, sorting: str, scans: list[tuple[int, ...]]
) -> None:
    """Source: PLCGenerator.py, SortInstances, of Beremiz in 2021 and 2022, and of xml2st."""
    got = scanned(_copies(sorting), tmp_path, [{"A": 7}, {}], "B C D E")
    assert got == scans


def test_outputs_with_less_than_10_between_them_are_a_row() -> None:
    """A row is written from left to right. Source: PLCGenerator.py, SortInstances."""
    drawing = Drawing(_COPIES)
    drawing.write("B", drawing.read("A"), position=Position(50, 100))
    drawing.write("C", drawing.read("A"), position=Position(20, 109))
    drawing.write("D", drawing.read("A"), position=Position(10, 125))
    assert drawing.text()[1:] == ["C := A;", "B := A;", "D := A;"]


def test_numbers_come_before_positions() -> None:
    """An output variable with a number is written before the others.

    Source: PLCGenerator.py, ComputeProgram: orderedInstances.
    """
    drawing = Drawing(_COPIES)
    drawing.write("B", drawing.read("A"))
    drawing.write("C", drawing.read("A"), order=2)
    drawing.write("D", drawing.read("A"), order=1)
    assert drawing.text()[1:] == ["D := A;", "C := A;", "B := A;"]


def test_a_block_is_called_when_its_value_is_first_used() -> None:
    """The timer that stands below is called first, because the upper coil uses it."""
    drawing = Drawing("A, X, Y : BOOL; T1, T2 : TON;")
    first = drawing.block("TON", {"IN": "=A", "PT": "=T#1s"}, ["Q"], "T1")
    second = drawing.block("TON", {"IN": f"{first}.Q", "PT": "=T#2s"}, ["Q"], "T2")
    drawing.coil("X", second, position=Position(0, 50))
    drawing.coil("Y", first, position=Position(0, 10))
    assert drawing.text()[1:] == [
        "T1(IN := A, PT := T#1s);",
        "Y := T1.Q;",
        "T2(IN := T1.Q, PT := T#2s);",
        "X := T2.Q;",
    ]


def test_a_block_with_a_number_waits_for_its_turn(tmp_path: Path) -> None:
    """The first block has the number 1 and reads the second one, which has the number 2.

    So it has the value of the last scan. Source: PLCGenerator.py, GenerateBlock, order.
    """
    drawing = Drawing("A, N, M : INT;")
    double = drawing.block("MUL", {"IN1": "=A", "IN2": "=2"}, order=2)
    drawing.write("N", drawing.block("ADD", {"IN1": double, "IN2": "=1"}, order=1))
    drawing.write("M", double)
    assert scanned(drawing, tmp_path, [{"A": 5}, {}], "N M") == [(1, 10), (11, 10)]


def test_blocks_that_no_output_uses_come_behind_the_outputs() -> None:
    """In the order by position together, they stand between them."""
    drawing = Drawing("A, X : BOOL; T1 : TON;")
    drawing.block("TON", {"IN": "=A", "PT": "=T#1s"}, ["Q"], "T1", position=Position(0, 10))
    drawing.coil("X", drawing.contact("A"), position=Position(0, 50))
    timer, coil = "T1(IN := A, PT := T#1s);", "X := A;"
    assert drawing.text()[1:] == [coil, timer]
    drawing.sorting = "together"
    assert drawing.text()[1:] == [timer, coil]


def test_networks_are_executed_one_after_the_other() -> None:
    """Within a network, the order of the file counts, and not the position."""
    drawing = Drawing("A, X, Y : BOOL;", by_position=False)
    drawing.network("First")
    drawing.coil("X", drawing.contact("A"), position=Position(0, 500))
    drawing.coil("Y", drawing.contact("A"), position=Position(0, 5))
    drawing.network("Second")
    drawing.coil("X", drawing.contact("Y"), position=Position(0, 1))
    assert drawing.text() == [
        "(* Network 1: First *)",
        "X := A;",
        "Y := A;",
        "(* Network 2: Second *)",
        "X := Y;",
    ]


def test_what_follows_a_coil_with_parallel_lines() -> None:
    """Beremiz joins the lines by AND for what follows the coil, OpenPLC Editor by OR.

    Source: PLCGenerator.py, GeneratePaths, CoilClass: append and extend.
    """
    drawing = Drawing("A, B, X, Y : BOOL;")
    both = f"{drawing.contact('A')} {drawing.contact('B')}"
    drawing.coil("Y", drawing.coil("X", both))
    assert drawing.text()[1:] == ["X := A OR B;", "Y := A AND B;"]
    drawing.sorting = "together"
    assert drawing.text()[1:] == ["X := A OR B;", "Y := A OR B;"]
