"""At its end, a run prints the errors that blocks have reported."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from rcx_harness import Cell
from rcx_harness.watch.block_errors import BlockErrors

_PROGRAM = """
FUNCTION_BLOCK Axis  (* a block of the user, with a block of the library inside *)
  VAR_IN_OUT Robot : RCX_REF; END_VAR
  VAR_INPUT Go : BOOL; END_VAR
  VAR Inner : FB_MovePtp; END_VAR
  Inner(Robot := Robot, Execute := Go, Point := 2, SpeedMode := SPEED_PERCENT, Speed := 200.0);
END_FUNCTION_BLOCK
PROGRAM Moves
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Connected, Safe, First, Second, Off : BOOL;
    Robot : RCX_REF;
    ReadArea : FB_ReadArea;
    Bit : FB_ReadWord;
    ServoOn : FB_ServoOn;
    Move : FB_MovePtp;
    Own : Axis;
    WriteArea : FB_WriteArea;
  END_VAR
  ReadArea(Robot := Robot, Image := InputArea, m := 0, Size := 48, Connected := Connected);
  Bit(Robot := Robot, Image := InputArea, Number := 2);
  ServoOn(Robot := Robot, Execute := Safe);
  Move(Robot := Robot, Execute := First AND NOT Off, Point := 2, SpeedMode := SPEED_PERCENT,
       Speed := 50.0);
  Off := Off OR Move.Error;  (* the error is shown for one scan only *)
  Own(Robot := Robot, Go := Second);
  WriteArea(Robot := Robot, Image := OutputArea, n := 0, Size := 48, EmergencyStopOk := Safe,
            StopOk := Safe);
END_PROGRAM
CONFIGURATION Config0
  RESOURCE Res0 ON PLC
    TASK Cyclic(INTERVAL := T#10ms, PRIORITY := 0);
    PROGRAM Main WITH Cyclic : Moves;
  END_RESOURCE
END_CONFIGURATION
"""


@pytest.fixture(scope="module")
def errors(tmp_path_factory: pytest.TempPathFactory) -> Iterator[BlockErrors]:
    """Return the errors of a run: point 2 does not exist, and a speed of 200 % is refused."""
    file: Path = tmp_path_factory.mktemp("errors") / "Moves.st"
    file.write_text(_PROGRAM, encoding="utf-8")
    with Cell.build([file], engine="builtin") as cell:
        errors = BlockErrors(cell.program)

        def scans(number: int) -> None:
            for _ in range(number):
                cell.scan()
                errors.scan(cell.now_us)

        scans(5)
        cell["Main.Safe"] = True
        scans(100)
        cell["Main.First"] = True
        scans(30)
        assert not cell["Main.Move.Error"]
        cell["Main.Second"] = True
        scans(5)
        yield errors


def test_an_error_has_its_name_its_alarm_and_its_time(errors: BlockErrors) -> None:
    """An error is reported with name, alarm and time, even if it was shown for one scan only.

    Source: remote command guide 4.2.1, alarm 6.204; spec/errors.toml, 16#8020.
    """
    (text, *_) = errors.texts(5)
    begin, _, at = text.rpartition(" at ")
    assert begin == (
        "Main.Move ended with error 16#8020 (Abnormal end, alarm 6.204: Point doesn't exist)"
    )
    assert 1050 <= float(at.removesuffix(" ms")) <= 1350


def test_a_block_inside_a_block_of_the_user_is_named_by_its_path(errors: BlockErrors) -> None:
    """A block inside a block of the user is named by its path. A speed of 200 % is refused.

    Source: spec/errors.toml, 16#8042.
    """
    (_, text) = errors.texts(5)
    assert text.startswith("Main.Own.Inner ended with error 16#8042 (Illegal speed) at ")


def test_errors_beyond_the_limit_are_counted(errors: BlockErrors) -> None:
    (_, rest) = errors.texts(1)
    assert rest == "further errors of blocks: 1"
