"""A running program is read and written from outside: paths, bytes, snapshots, tasks, instances."""

from __future__ import annotations

from collections.abc import Callable
from datetime import timedelta

import pytest

from structured_text.engines.base import Program
from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError
from structured_text.language.types import ElementaryType

Build = Callable[[str], BuiltinProgram]

_SOURCE = """\
TYPE Pair : STRUCT A : INT; Flags : ARRAY [0..1] OF BOOL; END_STRUCT; END_TYPE
TYPE Pairs : ARRAY [1..2] OF Pair; END_TYPE
TYPE Mode : (IDLE, BUSY); END_TYPE
FUNCTION_BLOCK Counter
  VAR_INPUT Up : BOOL := TRUE; END_VAR
  VAR_OUTPUT N : INT; Late : BOOL; END_VAR
  VAR Delay : TON; Wait : CTU; END_VAR
  IF Up THEN N := N + 1; END_IF;
  Delay(IN := N > 2, PT := T#50ms);
  Wait(CU := N MOD 2 = 0, PV := 3);
  Late := Delay.Q;
END_FUNCTION_BLOCK
PROGRAM Plant
  VAR C1 : Counter; C2 : Counter; P : Pairs; M : Mode; W : ARRAY [0..3] OF WORD;
      B : ARRAY [0..4] OF BYTE; T1 : TIME; S1 : STRING; R : REAL; END_VAR
  VAR Lamp AT %QX0.0 : BOOL; END_VAR
  C1(); C2(Up := C1.N > 3);
  P[2].A := C1.N; P[1].Flags[1] := Lamp; P[2].Flags[0] := C1.Late;
  Lamp := NOT Lamp; T1 := T1 + T#10ms; S1 := CONCAT(S1, 'x'); R := R + REAL#0.5;
  IF C1.N > 2 THEN M := BUSY; END_IF;
  W[0] := INT_TO_WORD(C1.N);
END_PROGRAM
"""


def _state(program: BuiltinProgram) -> dict[str, object]:
    return {path: program.read(path) for path, _ in program.walk()}


def test_a_built_in_program_has_the_interface_program(build: Build) -> None:
    program: Program = build(_SOURCE)
    assert isinstance(program, Program)
    assert (program.engine, program.tick_us) == ("builtin", None)
    assert [(name, kind.name) for name, kind in program.instances().items()] == [("Main", "Plant")]
    assert program.type_of("Main.T1") == ElementaryType("TIME")
    assert [(item.address, item.path) for item in program.located()] == [("%QX0.0", "Main.Lamp")]
    program.close()


def test_a_snapshot_holds_everything_and_can_be_restored_again_and_again(build: Build) -> None:
    program = build(_SOURCE)
    for k in range(4):
        program.scan(k * 10_000)
    saved, then = program.snapshot(), _state(program)
    for k in range(4, 20):
        program.scan(k * 10_000)
    later = _state(program)
    for _ in range(2):
        program.restore(saved)
        assert _state(program) == then
        for k in range(4, 20):
            program.scan(k * 10_000)
        assert _state(program) == later
    assert then != later


def test_a_snapshot_fits_other_instances_but_not_other_programs(build: Build) -> None:
    program = build(_SOURCE)
    program.scan(0)
    twin = program.instance()
    twin.restore(program.snapshot())
    assert _state(twin) == _state(program)
    with pytest.raises(InputError, match="another program"):
        build(_SOURCE).restore(program.snapshot())


def test_instances_share_nothing(build: Build) -> None:
    program = build(_SOURCE)
    fresh = _state(program)
    twin = program.instance()
    for k in range(5):
        program.scan(k * 10_000)
    assert _state(twin) == fresh


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("Main.C1.N", -5),
        ("Main.M", "BUSY"),
        ("Main.W[3]", 65535),
        ("Main.P[2]", {"A": 3, "Flags": [True, False]}),
        ("Main.P", [{"A": 1, "Flags": [True, True]}, {"A": 2, "Flags": [False, True]}]),
        ("Main.T1", timedelta(seconds=-3)),
        ("Main.S1", "abc"),
        ("Main.R", 0.5),
        ("Main.Lamp", True),
        ("Main.C1.Delay.PT", timedelta(seconds=9)),
    ],
)
def test_a_written_value_is_read_back(build: Build, path: str, value: object) -> None:
    program = build(_SOURCE)
    program.write(path, value)
    assert program.read(path) == value
    assert program.read(path.lower()) == value


def test_a_dict_may_name_some_fields_only(build: Build) -> None:
    program = build(_SOURCE)
    program.write("Main.P[1].A", 7)
    program.write("Main.P[1]", {"flags": [True, True]})
    program.write("Main", {"Lamp": True, "C2": {"N": 4}})
    assert program.read("Main.P[1]") == {"A": 7, "Flags": [True, True]}
    assert program.read("Main.C2.N") == 4
    assert program.read("Main.Lamp") is True


def test_a_wrong_value_or_path_changes_nothing(build: Build) -> None:
    program = build(_SOURCE)
    before = _state(program)
    for path, value in [("Main.W[0]", 65536), ("Main.W[4]", 0), ("Main.P[1]", {"A": 1, "B": 2})]:
        with pytest.raises(InputError):
            program.write(path, value)
    assert _state(program) == before


def test_process_images_are_read_and_written_as_bytes_low_byte_first(build: Build) -> None:
    program = build(_SOURCE)
    program.write_bytes("Main.W", bytes([0x34, 0x12, 0xFF, 0x00]))
    program.write_bytes("Main.B", b"\x01\x02")
    assert program.read("Main.W") == [0x1234, 0x00FF, 0, 0]
    assert program.read("Main.B") == [1, 2, 0, 0, 0]
    assert program.read_bytes("Main.W") == bytes([0x34, 0x12, 0xFF, 0, 0, 0, 0, 0])
    assert program.read_bytes("Main.B") == b"\x01\x02\x00\x00\x00"


@pytest.mark.parametrize(
    ("path", "data", "message"),
    [
        ("Main.W", b"\x01", "Main.W holds 8 bytes and cannot take 1"),
        ("Main.B", b"123456", "Main.B holds 5 bytes and cannot take 6"),
        ("Main.S1", b"x", "an array of BYTE or WORD"),
        ("Main.P", b"x", "an array of BYTE or WORD"),
    ],
)
def test_bytes_that_do_not_fit_are_refused(
    build: Build, path: str, data: bytes, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        build(_SOURCE).write_bytes(path, data)


_TASKS = """\
PROGRAM P1
  VAR N : INT; Seen : INT; END_VAR
  VAR_EXTERNAL Order1 : INT; END_VAR
  N := N + 1; Order1 := Order1 + 1; Seen := Order1;
END_PROGRAM
CONFIGURATION Cell
  VAR_GLOBAL Order1 : INT := 100; END_VAR
  RESOURCE Plc ON Computer
    TASK Slow(INTERVAL := T#30ms, PRIORITY := 5);
    TASK Fast(INTERVAL := T#20ms, PRIORITY := 1);
    PROGRAM S1 WITH Slow : P1;
    PROGRAM F1 WITH Fast : P1;
    PROGRAM E1 : P1;
  END_RESOURCE
END_CONFIGURATION
"""


def test_each_task_runs_in_every_scan_of_its_interval_in_order_of_priority(build: Build) -> None:
    program = build(_TASKS)
    rows = []
    for k in range(7):
        program.scan(k * 10_000)
        rows.append(tuple(program.read(f"{name}.N") for name in ("F1", "S1", "E1")))
    assert program.tick_us == 10_000
    assert rows == [(1, 1, 1), (1, 1, 2), (2, 1, 3), (2, 2, 4), (3, 2, 5), (3, 2, 6), (4, 3, 7)]
    # All three programs ran in the last scan: first the highest priority, last the program without
    # a task.
    assert [program.read(f"{name}.Seen") for name in ("F1", "S1", "E1")] == [112, 113, 114]
    assert program.read("Order1") == program.read("S1.Order1") == 114


def test_a_program_is_read_with_its_variables_at_addresses(build: Build) -> None:
    program = build(
        "PROGRAM P\nVAR\n  A : INT;\n  B AT %QW0 : INT;\n  C AT %QX4.0 : BOOL;\nEND_VAR\n"
        "A := 1; B := 2; C := TRUE;\nEND_PROGRAM\n"
    )
    program.scan(0)
    assert program.read("Main") == {"A": 1, "B": 2, "C": True}


def test_variables_at_one_address_are_one(build: Build) -> None:
    program = build(
        "PROGRAM P1\nVAR A AT %MW5 : INT; B AT %mw5 : INT; Seen : INT; END_VAR\n"
        "A := A + 1; Seen := B;\nEND_PROGRAM"
    )
    program.write("Main.B", 41)
    program.scan(0)
    assert (program.read("Main.A"), program.read("Main.Seen")) == (42, 42)


@pytest.mark.parametrize(
    ("source", "scans", "path", "value"),
    [
        pytest.param(
            "PROGRAM P1\nVAR A AT %MW0 : WORD; B AT %MW1 : WORD; END_VAR\n"
            "A := B; B := WORD#5;\nEND_PROGRAM",
            2, "Main.A", 5, id="variables at addresses only"),
        pytest.param(
            "PROGRAM P1\nVAR A AT %MW5 : INT; END_VAR\nA := A + 1;\nEND_PROGRAM\n"
            "PROGRAM P2\nVAR Seen : INT; END_VAR\nSeen := P1.A;\nEND_PROGRAM\n"
            "CONFIGURATION C1 RESOURCE R1 ON Plc\n"
            "PROGRAM P1 : P1; PROGRAM Y : P2; END_RESOURCE END_CONFIGURATION",
            1, "Y.Seen", 1, id="an address of another program"),
        pytest.param(
            "TYPE Pair : STRUCT A : INT; B : INT; END_STRUCT; END_TYPE\n"
            "PROGRAM P1\nVAR_EXTERNAL G1 : Pair; END_VAR\nG1.A := G1.A + 1;\nEND_PROGRAM\n"
            "CONFIGURATION C1 VAR_GLOBAL G1 : Pair := (A := 5); END_VAR RESOURCE R1 ON Plc\n"
            "PROGRAM X : P1; PROGRAM Y : P1; END_RESOURCE END_CONFIGURATION",
            1, "G1", {"A": 7, "B": 0}, id="a global structure shared by programs"),
    ],
)  # fmt: skip
def test_programs_share_variables_at_the_same_address(
    build: Build, source: str, scans: int, path: str, value: object
) -> None:
    program = build(source)
    for scan in range(scans):
        program.scan(scan * 10_000)
    assert program.read(path) == value
