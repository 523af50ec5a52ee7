"""Places in a drawing: messages name its rung or network, and positions are unique."""

from __future__ import annotations

import pickle
from dataclasses import replace
from pathlib import Path

import pytest

from drawing import drawing
from plcopen_drawings import element, project
from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import NO_COLUMN, InputError, located, place_text
from structured_text.language.lexer import tokens
from structured_text.language.load import load
from structured_text.language.source import (
    ELSEWHERE,
    Extract,
    Line,
    NetworkLine,
    in_dialect,
    origin,
    source_text,
)
from structured_text.projects.diagrams.networks.model import Diagram, Network, Rail
from structured_text.projects.model import Piece
from structured_text.projects.sources import source_files


def test_a_message_names_the_rung_and_no_column(tmp_path: Path) -> None:
    """The last statement of rung 3 has line 8; its column in the translation is of no use."""
    source = drawing(tmp_path, rung_3="Last := Firts;")
    with pytest.raises(InputError) as caught:
        load([source])
    assert str(caught.value).startswith(f"{tmp_path / 'main.xml'}:8: Main, rung 3: ")
    assert (caught.value.line, caught.value.column) == (8, None)
    assert "Firts" in caught.value.message


def test_an_error_in_a_scan_names_the_rung(tmp_path: Path) -> None:
    source = drawing(tmp_path, rung_3="Count := 1 / (Count - Count);")
    program = BuiltinProgram.build(load([source]))
    with pytest.raises(InputError, match=r"main\.xml:8: Main, rung 3: "):
        program.scan(0)


def test_statements_of_a_line_have_different_positions(tmp_path: Path) -> None:
    """Rung 2 has eight lines of statements for line 6 of the file."""
    source = drawing(tmp_path)
    found = [(token.line, token.column) for token in tokens(source_text(source), source)]
    assert len(set(found)) == len(found)
    assert {line for line, _ in found} == {1, 4, 6, 8, 9, 11}


def test_the_position_of_a_text_stays_as_it_is(tmp_path: Path) -> None:
    """A line that was copied from the file has its column in the file.

    The first line was copied from column 5 on, the second is made by the translation.
    """
    lines = (Line("Go AND Ready", 3, 4, "transition 1"), Line("Go := TRUE;", 3, network="step A"))
    source = Extract.make(tmp_path / "a.st", lines)
    assert origin(source, 1, 1) == (3, 5)
    assert origin(source, 2, 1)[0] == 3
    assert origin(source, 2, 1)[1] > NO_COLUMN


def test_positions_are_the_same_in_another_dialect(tmp_path: Path) -> None:
    """Making a source again from the lines of a source changes no position."""
    source = drawing(tmp_path)
    again = in_dialect(source, "codesys")
    assert getattr(again, "lines", None) == source.lines
    assert pickle.loads(pickle.dumps(source)).lines == source.lines


def test_lines_without_a_drawing_keep_their_columns(tmp_path: Path) -> None:
    lines = (Line("a := 1;", 3), Line("b := 1;", 3))
    assert Extract.make(tmp_path / "a.xml", lines).lines == lines


def test_generated_statements_have_different_positions(tmp_path: Path) -> None:
    """All lines of the function of an instruction have line 1; `b` would be at the place of `a`."""
    lines = (Line("a := 1;", 1), Line("b := 1;", 1))
    source = Extract.make(tmp_path / "a.L5X", lines, generated=True)
    assert origin(source, 1, 1) == (1, 1)
    assert origin(source, 2, 1)[1] > NO_COLUMN


def test_a_line_number_knows_its_rung_after_pickle() -> None:
    """The line number behaves as a number, and a process that receives it can name the rung."""
    line = NetworkLine(8, "Main", Line("  Last := First;", 8, 0, "rung 3"))
    again = pickle.loads(pickle.dumps({"line": line}))["line"]
    assert (again, hash(again), f"{again}") == (8, hash(8), "8")
    assert (again.place, again.network, again.text) == ("Main, rung 3", "rung 3", "Last := First;")


def test_places_in_messages_and_sentences() -> None:
    line = NetworkLine(8, "Main", Line("A := B;", 8, 0, "rung 3"))
    assert place_text("main.xml", line, 5) == "main.xml:8:5: Main, rung 3"
    assert place_text("main.xml", line, NO_COLUMN + 5) == "main.xml:8: Main, rung 3"
    assert place_text("main.st", 8, 5) == "main.st:8:5"
    assert located("main.xml", line) == "main.xml:8 (Main, rung 3)"
    assert located("main.st", 8) == "main.st:8"


def test_a_rung_in_the_project_of_a_replaced_body_is_named(tmp_path: Path) -> None:
    """If the user replaces one body, the other lines have the path of the project."""
    source = drawing(tmp_path)
    moved = tuple(replace(line, at=line.at + ELSEWHERE) for line in source.lines or ())
    new = Extract.make(tmp_path / "New.st", moved, "Main", str(source))
    error = InputError("is wrong", file=new, line=origin(new, 15, 1)[0])
    assert str(error) == f"{source}:9: Main, rung 3: is wrong"


def test_a_source_carries_its_diagrams_to_other_processes(tmp_path: Path) -> None:
    """Coverage draws the networks of a POU; its methods have their own diagrams."""
    inner = Diagram("FBD", (Network(1),), (Rail("1", at=3),))
    outer = Diagram("LD", (Network(1), Network(2)))
    parts = (Piece("Main.Work", (), diagram=inner), Piece("Main.Other", ()))
    piece = Piece("Main", (Line("PROGRAM Main", 1),), parts=parts, diagram=outer)
    diagrams = tuple(piece.diagrams())
    assert diagrams == (("Main", outer), ("Main.Work", inner))
    source = Extract.make(tmp_path / "main.xml", piece.lines(), "Main", diagrams=diagrams)
    for again in (pickle.loads(pickle.dumps(source)), in_dialect(source, "codesys")):
        assert getattr(again, "diagrams", ()) == diagrams


def test_a_rung_of_a_method_is_not_a_rung_of_its_block(tmp_path: Path) -> None:
    """Body and method both have a network 1; coverage must not mix them."""
    own = (Line("A := B;", 2, network="network 1"),)
    inner = (Line("C := D;", 3, network="network 1"),)
    parts = (Piece("Main.Work", (Line("METHOD Work", 3),), inner),)
    piece = Piece("Main", (Line("FUNCTION_BLOCK Main", 1),), own, parts=parts)
    source = Extract.make(tmp_path / "main.xml", piece.lines(), "Main")
    places = [getattr(origin(source, line, 1)[0], "place", "") for line in (1, 2, 3, 4)]
    assert places == ["", "", "Main.Work, network 1", "Main, network 1"]


def test_the_source_of_a_ladder_body_has_its_diagram(tmp_path: Path) -> None:
    """A rail, a contact A and a coil B are network 1 of Main."""
    file = tmp_path / "p.xml"
    rail = element("leftPowerRail", 1, at="0 0")
    rung = rail + element("contact", 2, "A", "1", "10 0") + element("coil", 3, "B", "2", "20 0")
    file.write_text(project("A B : BOOL", f"<LD>{rung}</LD>"), encoding="utf-8")
    own = source_files(file, None).own
    main = next(one for one in own if isinstance(one, Extract) and one.title == "Main")
    ((name, diagram),) = main.diagrams
    assert name == "Main"
    assert [type(one).__name__ for one in diagram.elements] == ["Rail", "Contact", "Coil"]
    networks = {line.network for line in getattr(main, "lines", ()) if line.text == "B := A;"}
    assert networks == {"network 1"}
