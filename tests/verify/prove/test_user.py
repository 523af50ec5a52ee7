"""Properties of a user's program are proved, or refuted by a run that the engine repeats."""

from __future__ import annotations

from pathlib import Path

import pytest

from rcx_harness import InputError
from rcx_harness.cell.stimulus import Stimulus
from rcx_harness.verify.prove.user import Settings, prove
from structured_text.prove.user import Result

HEAD = """PROGRAM Cell
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Connected, Start, Other : BOOL;
    Robot     : RCX_REF;
    ReadArea  : FB_ReadArea;
    WriteArea : FB_WriteArea;
    Servo     : FB_ServoOn;
    Gripper, Conveyor : BOOL; Speed : REAL;
    Stage, Given : INT;
    Table     : ARRAY [0..3] OF INT;
  END_VAR
  ReadArea(Robot := Robot, Image := InputArea, Connected := Connected);
"""
TAIL = """
  WriteArea(Robot := Robot, Image := OutputArea, EmergencyStopOk := TRUE, StopOk := TRUE);
END_PROGRAM
"""


def proved(
    folder: Path, body: str, limit_s: float = 20.0, *, overflow: bool = False
) -> dict[str, Result]:
    file = folder / "Cell.st"
    file.write_text(HEAD + body + TAIL)
    settings = Settings(limit_s=limit_s, out=folder / "out", overflow=overflow)
    results, _ = prove([file], settings)
    return {one.name: one for one in results}


def statuses(found: dict[str, Result]) -> dict[str, str]:
    return {name: one.status for name, one in found.items()}


def test_an_interlock_and_its_bounds_are_proved(tmp_path: Path) -> None:
    """An interlock and the bounds of its stage are proved.

    The stage counts 0, 1, 2, 0. The gripper and the conveyor belong to different stages.
    """
    body = (
        "  Servo(Robot := Robot, Execute := Start);\n"
        "  IF Servo.Done THEN Stage := Stage + 1; END_IF;\n"
        "  IF Stage > 2 THEN Stage := 0; END_IF;\n"
        "  Gripper := Stage = 1; Conveyor := Stage = 2;\n"
        "  Table[Stage] := 1;\n"
        "  (* prove: NOT (Gripper AND Conveyor) *)"
    )
    found = proved(tmp_path, body)
    assert set(statuses(found).values()) == {"proved"}
    assert found["assert Cell.st:19"].says == "NOT (Gripper AND Conveyor)"
    assert "index Cell.st:18" in found


def test_an_invariant_is_found_if_one_scan_does_not_prove_the_property(tmp_path: Path) -> None:
    """If one scan alone does not prove a property, an invariant is found.

    Gripper and Conveyor are FALSE at first. Each turns TRUE only while the other is FALSE.
    """
    body = (
        "  Servo(Robot := Robot, Execute := Start);\n"
        "  IF Start AND NOT Conveyor THEN Gripper := TRUE; END_IF;\n"
        "  IF Other AND NOT Gripper THEN Conveyor := TRUE; END_IF;\n"
        "  (* prove: NOT (Gripper AND Conveyor) *)"
    )
    assert set(statuses(proved(tmp_path, body)).values()) == {"proved"}


@pytest.mark.exhaustive
def test_calls_that_break_the_rules_are_refuted_by_runs(tmp_path: Path) -> None:
    body = (
        "  IF Start THEN Servo(Robot := Robot, Execute := Start); END_IF;\n"
        "  IF Other THEN Servo(Robot := Robot, Execute := Start); END_IF;\n"
    )
    found = proved(tmp_path, body)
    assert statuses(found) == {"inner": "proved", "once": "refuted", "steady": "refuted"}
    assert found["once"].note == "after 1 scans of 10 ms"
    text = Path(found["once"].stimulus).read_text()
    assert '"Main.Start" = true' in text
    assert '"Main.Other" = true' in text
    assert Path(found["steady"].stimulus).with_suffix(".svg").exists()
    assert "--for 20ms --engine builtin --stimulus" in found["steady"].command


def test_a_fault_of_the_program_is_refuted_with_its_line(tmp_path: Path) -> None:
    """A run-time fault of the program is refuted with its line. No statement writes `Given`.

    It may therefore have any value.
    """
    body = (
        "  Servo(Robot := Robot, Execute := Start);\n"
        "  Stage := 10 / Given;\n"
        "  IF Other THEN Table[Given] := 1; END_IF;\n"
        "  // prove: Given < 7\n"
    )
    found = proved(tmp_path, body)
    wrong = [name for name, one in found.items() if one.status == "refuted"]
    assert wrong == ["assert Cell.st:17", "division Cell.st:15", "index Cell.st:16"]
    assert found["index Cell.st:16"].at.endswith("Cell.st:16")


def test_an_answer_of_the_robot_can_break_an_assertion_after_some_scans(tmp_path: Path) -> None:
    """An assertion that an answer of the robot breaks after some scans is refuted.

    The servos are reported ON by SO(02), bit 2 of byte 32, after two scans without it.

    Source: manual chapter 5, 2.
    """
    body = (
        "  Servo(Robot := Robot, Execute := Start);\n"
        "  IF Robot.SO.SO02_ServoOn AND Gripper THEN Conveyor := TRUE; END_IF;\n"
        "  Gripper := Robot.Connected AND NOT Robot.SO.SO02_ServoOn;\n"
        "  (* prove: NOT Conveyor *)"
    )
    found = proved(tmp_path, body)["assert Cell.st:17"]
    assert (found.status, found.note) == ("refuted", "after 2 scans of 10 ms")
    areas = [one.area for one in Stimulus.load(found.stimulus).entries if one.area is not None]
    last = areas[-1]
    assert isinstance(last, bytes)
    assert last[32] & 0b100


@pytest.mark.exhaustive(but=["Stage-Stage := WORD_TO_INT(SHL(WORD#1, {}));-shift-refuted"])
@pytest.mark.parametrize(
    ("statement", "kind", "status"),
    [
        ("Stage := WORD_TO_INT(SHL(WORD#1, {}));", "shift", "refuted"),
        ("Stage := LEN(LEFT('robot', {}));", "text", "refuted"),
        ("Speed := SQRT(INT_TO_REAL({}));", "argument", "refuted"),
        ("Stage := MUX({}, 1, 2);", "index", "refuted"),
        ("Stage := REAL_TO_INT(INT_TO_REAL({}) * 32769.0);", "conversion", "unknown"),
        ("Stage := TRUNC(INT_TO_REAL({}) * 32769.0);", "conversion", "unknown"),
    ],
)
@pytest.mark.parametrize("number", ["Given", "Stage"])
def test_impossible_arguments_have_the_same_message(
    tmp_path: Path, statement: str, kind: str, status: str, number: str
) -> None:
    """Impossible arguments have the same message for variables of any value and known values.

    `Given` may have any value, and `Stage` is -1. No engine stops when a number does not fit.
    """
    body = f"  Servo(Robot := Robot, Execute := Start);\n  Stage := -1; {statement.format(number)}"
    # A proof that does not end uses its whole time limit. A counterexample may take long on a busy
    # machine.
    found = proved(tmp_path, body, limit_s=2.0 if status == "unknown" else 120.0)
    wrong = {name: one.status for name, one in found.items() if one.status != "proved"}
    assert wrong == {f"{kind} Cell.st:15": status}
    assert "TRANSLATION" not in found[f"{kind} Cell.st:15"].note


@pytest.mark.exhaustive(but=["False-noted"])
@pytest.mark.parametrize(("asked", "status"), [(False, "noted"), (True, "unknown")])
def test_overflows_are_noted_or_proved(tmp_path: Path, asked: bool, status: str) -> None:
    """Each arithmetic overflow is noted, or proved not to occur.

    Stage counts without end (line 15), and Given may be -32768 (line 17).
    """
    body = (
        "  Servo(Robot := Robot, Execute := Start);\n"
        "  Stage := Stage + 1;\n"
        "  IF Given < 100 AND Given > -100 THEN Table[0] := 2 * Given; END_IF;\n"
        "  Table[1] := ABS(Given);\n"
    )
    found = proved(tmp_path, body, limit_s=3.0, overflow=asked)
    assert {name: one for name, one in statuses(found).items() if "overflow" in name} == {
        "overflow Cell.st:15": status,
        "overflow Cell.st:16": "proved",
        "overflow Cell.st:17": status,
    }
    assert found["overflow Cell.st:15"].says == "arithmetic stays in its type: Stage + 1"
    assert "from a state that may be unreachable: Main.Stage = 32767" in (
        found["overflow Cell.st:15"].note
    )


def test_the_reference_is_written_only_by_the_library(tmp_path: Path) -> None:
    body = "  Robot.Status := WORD#16#0200;\n  Robot.Inner.InScan := FALSE;\n"
    found = proved(tmp_path, body, limit_s=0.001)["inner"]
    assert found.status == "refuted"
    assert [part.rpartition("/")[2] for part in found.note.split("; ")] == [
        "Cell.st:14: Robot",
        "Cell.st:15: Robot",
    ]


@pytest.mark.exhaustive
def test_an_undecided_property_is_unknown_with_a_state(tmp_path: Path) -> None:
    """A property that is neither proved nor refuted is unknown, with a state that may break it.

    It takes 20000 scans to break this property, and the search does not try such long runs.
    """
    body = (
        "  Servo(Robot := Robot, Execute := Start);\n"
        "  Stage := Stage + 1; IF Stage > 20000 THEN Stage := -20000; END_IF;\n"
        "  (* prove: Stage <> 19999 *)"
    )
    found = proved(tmp_path, body, limit_s=0.5)["assert Cell.st:16"]
    assert found.status == "unknown"
    assert "from a state that may be unreachable: Main.Stage = 19998" in found.note


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("  (* prove: *)", "Cell.st:14: the assertion is empty"),
        ("  (* prove: Grippr *)", "Cell.st:14: in the assertion: "),
        ("  Stage := TRUE;", "Cell.st:14:"),
    ],
)
def test_a_mistake_has_the_users_file(tmp_path: Path, body: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        proved(tmp_path, body)
    assert f"{tmp_path}/{message}" in str(caught.value)


_DEVICE = """<configuration name="{name}"><resource name="Application">
<task name="Main" priority="5" interval="PT0.01S"><pouInstance name="Count" typeName=""/></task>
<addData><data name="http://www.3s-software.com/plcopenxml/pou"><pou name="Count"
pouType="program"><interface><localVars><variable name="n"><type><INT/></type></variable>
</localVars></interface><body><ST><xhtml>n := {body}</xhtml></ST></body></pou></data></addData>
</resource></configuration>
"""


@pytest.mark.exhaustive
def test_a_device_of_a_project_is_proved_and_its_run_names_it(tmp_path: Path) -> None:
    """A device of a project is selected for the proof, and its run names it.

    The property holds on one device only.

    Source: docs/how-to/projects.md.
    """
    devices = "".join(
        _DEVICE.format(name=name, body=f"{value};\n(* prove: n = 1 *)")
        for name, value in (("Press", 1), ("Oven", 2))
    )
    file = tmp_path / "plant.xml"
    file.write_text(
        f"<project><types><pous/></types><instances><configurations>{devices}"
        "</configurations></instances></project>"
    )
    for device, status in (("Press", "proved"), ("Oven", "refuted")):
        settings = Settings(out=tmp_path / "out", robot=False, device=device)
        results, _ = prove([file], settings)
        assert [one.status for one in results] == [status]
        assert all(f" --device {device} --scan" in one.command for one in results if one.command)
