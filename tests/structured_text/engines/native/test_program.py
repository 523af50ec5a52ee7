"""Programs compiled by matiec or STruC++ are run, read and written in the same way."""

from __future__ import annotations

import platform
from collections.abc import Callable
from datetime import timedelta
from pathlib import Path

import pytest

from structured_text.engines.native.program import NativeProgram
from structured_text.errors import InputError
from structured_text.language.types import ElementaryType, Located

Compile = Callable[..., NativeProgram]

COUNTING = """
TYPE IMAGE_TYPE : ARRAY [0..7] OF BYTE; END_TYPE
TYPE WORDS_TYPE : ARRAY [1..3] OF WORD; END_TYPE
TYPE MODE_TYPE : (MODE_OFF, MODE_ON); END_TYPE
TYPE PART_TYPE : STRUCT
    Count : DINT;
    Name  : STRING;
    Mode  : MODE_TYPE;
  END_STRUCT;
END_TYPE
TYPE GRID_TYPE : ARRAY [0..1, 1..2] OF INT; END_TYPE
TYPE PARTS_TYPE : ARRAY [1..2] OF PART_TYPE; END_TYPE

PROGRAM PROBE
  VAR
    Image : IMAGE_TYPE;
    Words : WORDS_TYPE;
    Part  : PART_TYPE;
    Parts : PARTS_TYPE;
    Grid  : GRID_TYPE;
    Delay : TON;
    Go    : BOOL := TRUE;
    Level : SINT;
  END_VAR
  VAR
    Lamp AT %QX1.3 : BOOL;
    Speed AT %QW4 : UINT;
  END_VAR

  Part.Count := Part.Count + 1;
  Image[0] := BYTE#16#AB;
  Words[3] := WORD#16#1234;
  Grid[1, 2] := 12;
  Delay(IN := Go, PT := T#30ms);
  Lamp := Delay.Q;
  Speed := Speed + 3;
END_PROGRAM
"""


def test_values_are_read_by_path(compiled: Compile) -> None:
    program = compiled(COUNTING)
    for scan in range(3):
        program.scan(scan * 10_000)
    assert program.read("Main.Part.Count") == 3
    assert program.read("main.PART.count") == 3
    assert program.read("PROBE.Part") == {"Count": 3, "Name": "", "Mode": "MODE_OFF"}
    assert program.read("Main.Grid") == [[0, 0], [0, 12]]
    assert program.read("Main.Grid[1,2]") == 12
    assert program.read("Main.Delay.ET") == timedelta(milliseconds=20)
    assert program.read("Main.Parts[2].Mode") == "MODE_OFF"
    assert program.type_of("Main.Delay.ET") == ElementaryType("TIME")


def test_structured_values_are_written_as_a_whole_or_in_part(compiled: Compile) -> None:
    program = compiled(COUNTING)
    program.write("Main.Parts[2]", {"Name": "gripper", "mode": "MODE_ON"})
    program.write("Main.Parts[1].Count", -5)
    program.write("Main.Grid", [[1, 2], [3, 4]])
    program.write("Main.Delay.PT", timedelta(seconds=-2, milliseconds=500))
    assert program.read("Main.Parts") == [
        {"Count": -5, "Name": "", "Mode": "MODE_OFF"},
        {"Count": 0, "Name": "gripper", "Mode": "MODE_ON"},
    ]
    assert program.read("Main.Grid[1,1]") == 3
    assert program.read("Main.Delay.PT") == timedelta(milliseconds=-1500)


@pytest.mark.parametrize(
    ("path", "value"),
    [("Main.Level", 128), ("Main.Level", True), ("Main.Go", 1), ("Main.Part.Mode", "MODE_X")],
)
def test_a_value_that_does_not_fit_is_refused(compiled: Compile, path: str, value: object) -> None:
    program = compiled(COUNTING)
    before = program.read(path)
    with pytest.raises(InputError):
        program.write(path, value)
    assert program.read(path) == before


def test_an_unknown_path_names_those_near_it(compiled: Compile) -> None:
    program = compiled(COUNTING)
    with pytest.raises(InputError) as caught:
        program.read("Main.Levle")
    assert "Level" in caught.value.hint
    with pytest.raises(InputError):
        program.read("Main.Grid[2,1]")


def test_the_process_image_is_read_and_written_as_bytes(compiled: Compile) -> None:
    program = compiled(COUNTING)
    program.write_bytes("Main.Image", bytes([1, 2, 3]))
    assert program.read_bytes("Main.Image") == bytes([1, 2, 3, 0, 0, 0, 0, 0])
    program.write_bytes("Main.Words", bytes([0x34, 0x12]))
    assert program.read("Main.Words[1]") == 0x1234
    program.scan(0)
    assert program.read_bytes("Main.Image")[0] == 0xAB
    assert program.read_bytes("Main.Words") == bytes([0x34, 0x12, 0, 0, 0x34, 0x12])
    with pytest.raises(InputError, match="holds 8 bytes and cannot take 9"):
        program.write_bytes("Main.Image", bytes(9))
    with pytest.raises(InputError, match="holds 6 bytes and cannot take 3"):
        program.write_bytes("Main.Words", bytes(3))
    with pytest.raises(InputError, match="of type GRID_TYPE"):
        program.read_bytes("Main.Grid")


def test_located_variables_have_storage_and_are_listed(compiled: Compile) -> None:
    program = compiled(COUNTING)
    assert program.located() == [
        Located("%QX1.3", "Main.Lamp", ElementaryType("BOOL")),
        Located("%QW4", "Main.Speed", ElementaryType("UINT")),
    ]
    program.write("Main.Speed", 65534)
    program.scan(0)
    assert program.read("Main.Speed") == 1
    assert program.read("Main.Lamp") is False


def test_two_instances_share_nothing(compiled: Compile) -> None:
    first = compiled(COUNTING)
    second = first.instance()
    for scan in range(5):
        first.scan(scan * 10_000)
    second.scan(0)
    assert first.read("Main.Part.Count") == 5
    assert second.read("Main.Part.Count") == 1
    assert (first.read("Main.Speed"), second.read("Main.Speed")) == (15, 3)
    assert (first.read("Main.Delay.Q"), second.read("Main.Delay.Q")) == (True, False)
    first.close()
    second.scan(10_000)
    assert second.read("Main.Part.Count") == 2


TASKS = """
PROGRAM QUICK_PROGRAM
  VAR Calls : INT; END_VAR
  VAR_EXTERNAL Total : DINT; END_VAR
  Calls := Calls + 1;
  Total := Total + 1;
END_PROGRAM
PROGRAM SLOW_PROGRAM
  VAR Calls : INT; END_VAR
  VAR_EXTERNAL Total : DINT; END_VAR
  Calls := Calls + 1;
  Total := Total + 100;
END_PROGRAM
CONFIGURATION PLANT
  VAR_GLOBAL Total : DINT := 7; Lamp AT %QX0.0 : BOOL; END_VAR
  RESOURCE CPU ON PLC
    TASK QUICK_TASK(INTERVAL := T#20ms, PRIORITY := 0);
    TASK SLOW_TASK(INTERVAL := T#50ms, PRIORITY := 1);
    PROGRAM Quick WITH QUICK_TASK : QUICK_PROGRAM;
    PROGRAM Slow WITH SLOW_TASK : SLOW_PROGRAM;
  END_RESOURCE
END_CONFIGURATION
"""


def test_a_task_runs_in_every_kth_base_tick_from_the_first_on(compiled: Compile) -> None:
    program = compiled(TASKS)
    assert program.tick_us == 10_000
    calls = []
    for scan in range(11):
        program.scan(scan * 10_000)
        calls.append((program.read("Quick.Calls"), program.read("Slow.Calls")))
    assert calls[0] == (1, 1)
    assert calls[1] == (1, 1)
    assert calls[2] == (2, 1)
    assert calls[5] == (3, 2)
    assert calls[10] == (6, 3)
    assert program.read("Total") == 7 + 6 + 300
    assert program.read("Quick.Total") == program.read("Total")


def test_a_global_variable_can_be_written(compiled: Compile) -> None:
    program = compiled(TASKS)
    program.write("Total", -50)
    program.write("Lamp", True)
    program.scan(0)
    assert program.read("Slow.Total") == -50 + 1 + 100
    assert program.read("Lamp") is True


def test_restore_goes_back_to_the_whole_state(compiled: Compile) -> None:
    program = compiled(TASKS)
    for scan in range(3):
        program.scan(scan * 10_000)
    kept = program.snapshot()

    def run_on() -> list[tuple[int, int, int]]:
        seen = []
        for scan in range(3, 12):
            program.scan(scan * 10_000)
            seen.append(
                (program.read("Quick.Calls"), program.read("Slow.Calls"), program.read("Total"))
            )
        return seen

    first = run_on()
    program.restore(kept)
    assert program.read("Total") == 7 + 2 + 100
    assert run_on() == first


def test_restore_takes_timers_and_located_variables_back(compiled: Compile) -> None:
    program = compiled(COUNTING)
    for scan in range(3):
        program.scan(scan * 10_000)
    kept = program.snapshot()
    program.scan(30_000)
    assert (program.read("Main.Lamp"), program.read("Main.Speed")) == (True, 12)
    program.restore(kept)
    assert (program.read("Main.Lamp"), program.read("Main.Speed")) == (False, 9)
    program.scan(25_000)
    assert program.read("Main.Lamp") is False
    program.scan(30_000)
    assert program.read("Main.Lamp") is True


def test_another_instance_takes_a_snapshot_over_without_sharing_anything(compiled: Compile) -> None:
    for text, path in ((TASKS, "Quick.Total"), (COUNTING, "Main.Speed")):
        first = compiled(text)
        for scan in range(4):
            first.scan(scan * 10_000)
        second = first.instance()
        second.restore(first.snapshot())
        value = first.read(path)
        assert second.read(path) == value
        second.scan(40_000)
        assert second.read(path) != value
        assert first.read(path) == value


def test_two_programs_have_globals_of_the_same_name_each_for_itself(compiled: Compile) -> None:
    first, second = compiled(TASKS), compiled(TASKS.replace(":= 7", ":= 8"))
    first.write("Total", 50)
    first.scan(0)
    assert (first.read("Total"), second.read("Total")) == (50 + 1 + 100, 8)


def test_a_snapshot_of_another_program_is_refused(compiled: Compile) -> None:
    with pytest.raises(InputError, match="belongs to another program"):
        compiled(COUNTING).restore(compiled(TASKS).snapshot())


@pytest.mark.skipif(
    platform.machine() not in ("x86_64", "AMD64"), reason="division by zero traps only on x86"
)
def test_a_division_by_zero_ends_the_scan_not_the_process(compiled: Compile) -> None:
    program = compiled(
        "PROGRAM PROBE VAR N : INT; D : INT; R : INT; END_VAR\n"
        "N := N + 1; R := 10 / D; N := N + 10; END_PROGRAM"
    )
    for scan in range(3):
        with pytest.raises(InputError, match="divides by zero"):
            program.scan(scan)
    program.write("Main.D", 5)
    program.scan(3)
    assert (program.read("Main.N"), program.read("Main.R")) == (14, 2)


def test_an_index_far_away_ends_the_scan_not_the_process(compiled: Compile) -> None:
    program = compiled(
        "PROGRAM PROBE VAR A : ARRAY [0..3] OF DINT; K : DINT := 500000000; N : INT; END_VAR\n"
        "N := N + 1; A[K] := 1; N := N + 10; END_PROGRAM"
    )
    with pytest.raises(InputError, match=r"has left its memory|is out of range"):
        program.scan(0)
    program.write("Main.K", 3)
    program.scan(1)
    assert (program.read("Main.N"), program.read("Main.A")) == (12, [0, 0, 0, 1])


def test_a_program_may_itself_be_named_main(compiled: Compile) -> None:
    program = compiled("PROGRAM Main VAR N : INT; END_VAR N := N + 1; END_PROGRAM")
    program.scan(0)
    assert program.read("Main.N") == 1


def test_sources_come_in_any_order(compiled: Compile) -> None:
    program = compiled(
        "PROGRAM PROBE VAR Step1 : ADDER; P : POINT; END_VAR Step1(Where1 := P); END_PROGRAM",
        "FUNCTION_BLOCK ADDER VAR_IN_OUT Where1 : POINT; END_VAR"
        " Where1.X := Where1.X + TWICE(2); END_FUNCTION_BLOCK",
        "FUNCTION TWICE : INT VAR_INPUT N : INT; END_VAR TWICE := N * 2; END_FUNCTION",
        "TYPE POINT : STRUCT X : INT; END_STRUCT; END_TYPE",
    )
    program.scan(0)
    program.scan(1)
    assert program.read("Main.P.X") == 8


def test_walk_names_every_variable_parents_first(compiled: Compile) -> None:
    program = compiled(COUNTING)
    paths = [path for path, _ in program.walk()]
    assert paths[:6] == ["Main.Image", "Main.Words", "Main.Part", "Main.Part.Count",
                         "Main.Part.Name", "Main.Part.Mode"]  # fmt: skip
    for path in paths:
        program.read(path)


def test_nothing_is_left_in_the_temporary_directory(
    compiled: Compile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(folder))
    monkeypatch.setenv("RCX_CACHE", "off")
    program = compiled(COUNTING)
    program.scan(0)
    assert list(folder.iterdir()) == []
