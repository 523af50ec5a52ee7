"""The results of the solver are shown with the names of the program."""

from __future__ import annotations

import pytest
import z3

from rcx_harness.verify.prove.surroundings import CellSurroundings
from structured_text.language.load import load
from structured_text.prove.naming import Names
from structured_text.prove.program import ProgramMachine

PROGRAM = """TYPE CELL_STEP : (CELL_WAITS, CELL_MOVES); END_TYPE
TYPE WAITS : ARRAY [1..2] OF TIME; END_TYPE
TYPE CELL_WORK : STRUCT Step : CELL_STEP; Waits : WAITS; END_STRUCT; END_TYPE
TYPE RCX_IMAGE : ARRAY [0..47] OF BYTE; END_TYPE
PROGRAM Cell
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Go   : BOOL;
    Work : CELL_WORK;
    Late : TON;
    Mask : WORD;
    Rate : REAL;
  END_VAR
  Late(IN := Go, PT := T#50ms);
  Work.Step := CELL_MOVES;
  Mask := WORD#16#00FF;
  Rate := 0.5;
END_PROGRAM
"""


@pytest.fixture(scope="module")
def machine(tmp_path_factory: pytest.TempPathFactory) -> tuple[ProgramMachine, Names]:
    """Return the solver's machine for a program, and the names of its elements."""
    file = tmp_path_factory.mktemp("named") / "Cell.st"
    file.write_text(PROGRAM)
    project = load([file])
    around = CellSurroundings(project)
    made = ProgramMachine(project, frozenset(), exact=False, outline=True)
    around.anything(made)
    return made, Names(made, around)


@pytest.mark.parametrize(
    ("place", "value", "expected"),
    [
        (("MAIN", "WORK", "STEP"), 1, "Main.Work.Step = CELL_MOVES"),
        (("MAIN", "WORK", "WAITS", 1), 1_500_000_000, "Main.Work.Waits[2] = T#1500ms"),
        (("MAIN", "MASK"), 0x8020, "Main.Mask = 16#8020"),
        (("MAIN", "LATE", "Q"), True, "Main.Late.Q = TRUE"),
        (("MAIN", "LATE", "phase"), 1, ""),  # inside the timer: not a variable of the program
    ],
)
def test_variables_have_their_declared_names_and_literals(
    machine: tuple[ProgramMachine, Names], place: tuple[str | int, ...], value: int, expected: str
) -> None:
    """Source: docs/how-to/prove.md, proved, refuted, unknown."""
    made, names = machine
    term, solver = made.term(place), z3.Solver()
    solver.add(term == value)
    assert solver.check() == z3.sat
    assert names.told(solver.model(), term) == expected


@pytest.mark.parametrize(
    ("term", "value", "expected"),
    [
        (z3.Bool("Main.Go.0"), True, "Main.Go = TRUE"),
        (z3.Bool("connected.1.0"), False, "the connection = FALSE"),
        (z3.BitVec("area.1.0.32", 8), 5, "byte m+32 = 16#05"),
        (z3.BitVec("now", 72), 7, ""),  # the clock
    ],
)
def test_inputs_from_outside_have_names(
    machine: tuple[ProgramMachine, Names], term: z3.ExprRef, value: int, expected: str
) -> None:
    """Source: docs/how-to/prove.md, assumptions: the inputs."""
    solver = z3.Solver()
    solver.add(term == value)
    assert solver.check() == z3.sat
    assert machine[1].told(solver.model(), term) == expected


def test_a_real_is_a_number_and_not_its_bits(machine: tuple[ProgramMachine, Names]) -> None:
    """A REAL is shown as a number and not as its bits. By IEEE 754, 16#3F000000 is 0.5."""
    made, names = machine
    [name] = [one for one, place in made.places.items() if place == ("MAIN", "RATE")]
    solver, term = z3.Solver(), z3.BitVec(name, 32)
    solver.add(term == 0x3F000000)
    assert solver.check() == z3.sat
    assert names.told(solver.model(), term) == "Main.Rate = 0.5"
