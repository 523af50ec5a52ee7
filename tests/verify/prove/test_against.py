"""Two versions of an example are proved equal, or a replay shows their first difference."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

import pytest

from rcx_harness.verify.prove.against import Versions, compare
from structured_text.prove.against.compare import Wishes
from structured_text.prove.user import Result

EXAMPLES = Path(__file__).parents[3] / "plc" / "examples"
_HOMES = {
    "PowerUp": "01_power_up",
    "GeneralIo": "03_general_io",
    "JogPanel": "05_jog_panel",
    "Conveyor": "17_conveyor",
}


@dataclass(frozen=True)
class Change:
    """A change of an example: replaced texts, and first those that make the old version."""

    name: str
    example: str
    new: dict[str, str]
    old: dict[str, str] | None = None
    outputs: tuple[str, ...] = ()
    related: tuple[tuple[str, str], ...] = ()


EQUAL = [
    Change(
        "de_morgan",
        "PowerUp",
        {"ResetEdge.Q AND CellSafe AND NOT Start": "NOT (Start OR NOT CellSafe) AND ResetEdge.Q"},
    ),
    Change(
        "renamed_local",
        "Conveyor",
        {"Wanted": "Requested"},
        related=(("Main.Requested", "Main.Wanted"),),
        outputs=("Main.TrayMoves", "Main.OutputArea"),
    ),
    Change(
        "timer_call_moved",
        "Conveyor",
        {
            "  Moved(IN := TrayMoves, PT := T#800ms);\n": "",
            "  TrayMoves := TrayMoves AND NOT Moved.Q;\n": "",
            "Value := Granted);\n": "Value := Granted);\n"
            "  Moved(IN := TrayMoves, PT := T#800ms);\n"
            "  TrayMoves := TrayMoves AND NOT Moved.Q;\n",
        },
        outputs=("Main.TrayMoves", "Main.OutputArea"),
    ),
    Change(
        "reordered_statements",
        "Conveyor",
        {
            "  Belt := BeltBit.Valid AND BeltBit.Value AND Robot.SO.SO13_ProgramRunning;\n": "",
            "  Pressed(CLK": "  Belt := BeltBit.Valid AND BeltBit.Value AND "
            "Robot.SO.SO13_ProgramRunning;\n  Pressed(CLK",
        },
        outputs=("Main.Belt", "Main.OutputArea"),
    ),
    Change(
        "extracted_function",
        "GeneralIo",
        {
            "PROGRAM GeneralIo": "FUNCTION AllOf : BOOL\n  VAR_INPUT A, B, C : BOOL; END_VAR\n"
            "  AllOf := C AND B AND A;\nEND_FUNCTION\n\nPROGRAM GeneralIo",
            "IF Acknowledge.Value AND ReadPart.Valid AND ReadHeight.Valid AND": "IF AllOf("
            "A := Acknowledge.Value, B := ReadPart.Valid, C := ReadHeight.Valid) AND",
        },
        outputs=("Main.OutputArea", "Main.PartBack", "Main.Complete"),
    ),
    Change(
        "case_instead_of_if",
        "JogPanel",
        {
            "  IF Stage = JOG_FAULT THEN\n": "  CASE Stage OF\n  JOG_FAULT:\n",
            "  ELSIF Fault <> WORD#16#0000 THEN\n": "  ELSE\n  IF Fault <> WORD#16#0000 THEN\n",
            "has no effect *)\n  END_IF;\n\n  Write": "*)\n  END_IF;\n  END_CASE;\n\n  Write",
        },
        outputs=("Main.Stage", "Main.OutputArea"),
    ),
    Change(
        "unrolled_loop",
        "JogPanel",
        {
            "    FOR Number := 1 TO 6 DO\n      Shown[Number] := Position.Pulses[Number];\n"
            "    END_FOR;\n": "".join(
                f"    Shown[{axis}] := Position.Pulses[{axis}];\n" for axis in range(1, 7)
            )
        },
        old={
            "    Shown := Position.Pulses;\n": "    FOR Number := 1 TO 6 DO\n"
            "      Shown[Number] := Position.Pulses[Number];\n    END_FOR;\n",
            "    Axis       : INT := 1;": "    Number : INT;\n    Axis : INT := 1;",
        },
        outputs=("Main.Shown",),
    ),
    Change(
        "merged_conditions",
        "Conveyor",
        {
            "  IF Wanted AND AreaBit.Valid AND NOT AreaBit.Value AND NOT Granted THEN\n": "  IF "
            "NOT (AreaBit.Value OR Granted) THEN\n  IF Wanted AND AreaBit.Valid THEN\n",
            "    Wanted := FALSE;\n  END_IF;\n": "    Wanted := FALSE;\n  END_IF;\n  END_IF;\n",
        },
        outputs=("Main.TrayMoves", "Main.Wanted"),
    ),
    Change(
        "dead_code_removed",
        "GeneralIo",
        {},
        old={
            "    Taken       : BOOL;": "    Mode : INT;\n    Taken : BOOL;",
            "  Complete := ": "  IF Mode = 7 THEN Taken := FALSE; Mode := 6; END_IF;\n"
            "  Complete := ",
        },
        outputs=("Main.Taken", "Main.OutputArea"),
    ),
    Change(
        "folded_constants",
        "Conveyor",
        {"T#800ms": "T#300ms + T#500ms"},
        outputs=("Main.TrayMoves",),
    ),
]

DIFFERENT = [
    Change(
        "swapped_operand",
        "Conveyor",
        {"Belt := BeltBit.Valid AND BeltBit.Value": "Belt := BeltBit.Valid AND AreaBit.Value"},
        outputs=("Main.Belt",),
    ),
    Change(
        "missing_else",
        "JogPanel",
        {"  Way := DIRECTION_PLUS;\n": ""},
        outputs=("Main.Way",),
    ),
    Change(
        "initial_value",
        "Conveyor",
        {"Granted    : BOOL;": "Granted : BOOL := TRUE;"},
        outputs=("Main.Granted",),
    ),
    Change(
        "greater_or_equal",
        "Conveyor",
        {"WORD_TO_INT(Parts.Value) >": "WORD_TO_INT(Parts.Value) >="},
        old={"Belt := BeltBit.Valid": "Belt := WORD_TO_INT(Parts.Value) > 3 AND BeltBit.Valid"},
        outputs=("Main.Belt",),
    ),
    Change("lost_reset", "Conveyor", {"    Wanted := FALSE;\n": ""}, outputs=("Main.Wanted",)),
    Change(
        "edge_or_level",
        "Conveyor",
        {"Wanted OR Pressed.Q": "Wanted OR ChangeTray"},
        outputs=("Main.TrayMoves",),
    ),
    Change(
        "timer_constant",
        "Conveyor",
        {"T#800ms": "T#900ms"},
        outputs=("Main.TrayMoves",),
    ),
    Change(
        "order_of_statements",
        "Conveyor",
        {
            "  Moved(IN := TrayMoves, PT := T#800ms);\n": "",
            "  TrayMoves := TrayMoves AND NOT Moved.Q;\n": "  TrayMoves := TrayMoves AND "
            "NOT Moved.Q;\n  Moved(IN := TrayMoves, PT := T#800ms);\n",
        },
        outputs=("Main.TrayMoves",),
    ),
    Change(
        "overflow",
        "GeneralIo",
        {"Twice : INT": "Twice : DINT", "Twice := Level * 2": "Twice := INT_TO_DINT(Level) * 2"},
        old={
            "    Taken       : BOOL;": "    Level : INT;\n    Twice : INT;\n    Taken : BOOL;",
            "  Complete := Taken": "  Twice := Level * 2;\n  Complete := Twice > 100 OR Taken",
        },
        outputs=("Main.Complete",),
    ),
    Change(
        "state_never_left",
        "Conveyor",
        {"  TrayMoves := TrayMoves AND NOT Moved.Q;\n": ""},
        outputs=("Main.TrayMoves",),
    ),
]

_QUICK_EQUAL = ["de_morgan"]


def compared(
    change: Change, folder: Path, limit_s: float = 30.0, runs: int = 20
) -> dict[str, Result]:
    """Make both versions of the example, and compare them."""
    versions: list[list[Path]] = []
    for title, edits in (("old", [change.old]), ("new", [change.old, change.new])):
        source = EXAMPLES / _HOMES[change.example]
        target = folder / title
        shutil.copytree(
            source, target, ignore=lambda _, names: [n for n in names if n[-3:] != ".st"]
        )
        file = target / f"{change.example}.st"
        text = file.read_text(encoding="utf-8")
        for edit in edits:
            for before, after in (edit or {}).items():
                assert before in text
                text = text.replace(before, after)
        file.write_text(text, encoding="utf-8")
        versions.append([target])
    wishes = Wishes(
        outputs=change.outputs,
        related=dict(change.related),
        out=folder / "out",
        limit_s=limit_s,
        runs=runs,
    )
    found = compare(Versions(versions[0], versions[1]), wishes)
    return {one.name: one for one in found.results}


@pytest.mark.exhaustive(but=_QUICK_EQUAL)
@pytest.mark.parametrize("change", EQUAL, ids=lambda change: change.name)
def test_a_refactoring_is_proved(change: Change, tmp_path: Path) -> None:
    """A refactoring of an example is proved: no output can differ."""
    found = compared(change, tmp_path)
    assert {name: one.status for name, one in found.items()} == dict.fromkeys(found, "proved")
    assert set(change.outputs) < set(found)


@pytest.mark.exhaustive
@pytest.mark.parametrize("change", DIFFERENT, ids=lambda change: change.name)
def test_a_seeded_change_is_refuted(change: Change, tmp_path: Path) -> None:
    """A seeded change is refuted with a run, which is in a stimulus file."""
    found = compared(change, tmp_path)
    name = change.outputs[0] if change.outputs else "Main.OutputArea"
    assert found[name].status == "refuted", found[name]
    assert Path(found[name].stimulus).is_file()
    assert found["stops"].status == "proved"


@pytest.mark.exhaustive
def test_a_changed_argument_of_a_library_block_is_not_proved(tmp_path: Path) -> None:
    """The robot moves to another point, which the telegram in the output area contains.

    The block itself is unchanged, so its calls have equal results only for equal arguments.
    """
    change = Change("point", "PowerUp", {"Point := 19": "Point := 20"})
    found = compared(change, tmp_path, limit_s=1.0, runs=0)
    assert found["Main.OutputArea"].status != "proved"
