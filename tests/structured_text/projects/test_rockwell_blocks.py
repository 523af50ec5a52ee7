"""Instructions of function block diagrams of Logix, each in a sheet with one block.

Expected values follow from the section of each instruction in Rockwell 1756-RM003N and 1756-RM006K.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import pytest

from l5x_ladder import program
from l5x_sheets import running, written
from structured_text.engines.builtin import BuiltinProgram


def _block(folder: Path, kind: str, instruction: str, **inputs: object) -> BuiltinProgram:
    """Return a program with one block `f`, whose inputs are set in its tag."""
    made = running(folder, f"Block {instruction} f", tags={"f": kind})
    _set(made, inputs)
    return made


def _set(running_program: BuiltinProgram, inputs: Mapping[str, object]) -> None:
    for name, value in inputs.items():
        running_program.write(f"Main.f.{name}", value)


def _read(running_program: BuiltinProgram, names: str) -> list[object]:
    return [running_program.read(f"Main.f.{name}") for name in names.split()]


def _timeline(
    running_program: BuiltinProgram,
    steps: Sequence[tuple[int, Mapping[str, object]]],
    names: str,
) -> list[list[object]]:
    """Return the outputs after scans at some milliseconds, each behind changes of inputs."""
    found = []
    for at, inputs in steps:
        _set(running_program, inputs)
        running_program.scan(at * 1000)
        found.append(_read(running_program, names))
    return found


@pytest.mark.parametrize(
    ("instruction", "kind", "inputs", "value"),
    [
        ("ADD", "FBD_MATH", {"SourceA": 1.5, "SourceB": 2.0}, 3.5),
        ("MOD", "FBD_MATH", {"SourceA": 7.5, "SourceB": 2.0}, 1.5),
        ("XPY", "FBD_MATH", {"SourceA": 2.0, "SourceB": 3.0}, 8.0),
        ("SQR", "FBD_MATH_ADVANCED", {"Source": 6.25}, 2.5),
        ("NEG", "FBD_MATH_ADVANCED", {"Source": 6.25}, -6.25),
        ("ABS", "FBD_MATH_ADVANCED", {"Source": -6.25}, 6.25),
        ("TRN", "FBD_TRUNCATE", {"Source": -2.75}, -2),
        ("LEQ", "FBD_COMPARE", {"SourceA": 2.0, "SourceB": 2.0}, True),
        ("GRT", "FBD_COMPARE", {"SourceA": 2.0, "SourceB": 2.0}, False),
        ("AND", "FBD_LOGICAL", {"SourceA": 12, "SourceB": 10}, 8),
        ("NOT", "FBD_LOGICAL", {"SourceA": 12}, -13),
        ("LIM", "FBD_LIMIT", {"LowLimit": 1.0, "Test": 5.0, "HighLimit": 5.0}, True),
        ("LIM", "FBD_LIMIT", {"LowLimit": 5.0, "Test": 3.0, "HighLimit": 1.0}, False),
        ("LIM", "FBD_LIMIT", {"LowLimit": 5.0, "Test": 5.0, "HighLimit": 1.0}, True),
        ("MEQ", "FBD_MASK_EQUAL", {"Source": 29, "Mask": 15, "Compare": 13}, True),
        ("MVMT", "FBD_MASKED_MOVE", {"Source": 255, "Mask": 12, "Target": 32}, 44),
        ("TO_BCD", "FBD_CONVERT", {"Source": 25}, 37),
        ("BCD_TO", "FBD_CONVERT", {"Source": 37}, 25),
    ],
)
def test_a_block_calculates_from_its_structure(
    instruction: str, kind: str, inputs: Mapping[str, object], value: object, tmp_path: Path
) -> None:
    """The block takes its inputs from its tag and writes Dest."""
    made = _block(tmp_path, kind, instruction, **inputs)
    made.scan(0)
    assert made.read("Main.f.Dest") == value


@pytest.mark.parametrize(
    ("sheet", "name", "value"),
    [
        ("IRef -2; IRef 3; Function EXPT; ORef x; 0 > 2.SourceA; 1 > 2.SourceB; 2.Dest > 3",
         "x", -8.0),
        ("IRef a; IRef b; IRef c; Function BXOR; ORef d; 0 > 3.In1; 1 > 3.In2; 2 > 3.In3;"
         "3.Out > 4", "d", False),
        ("IRef a; IRef 4; IRef 2.5; Function SEL; ORef x;"
         "0 > 3.SelectorIn; 1 > 3.In1; 2 > 3.In2; 3.Out > 4", "x", 2.5),
        ("IRef 180; Function RAD; ORef x; Function DEG; ORef i;"
         "0 > 1.Source; 1.Dest > 2; 1.Dest > 3.Source; 3.Dest > 4", "i", 180),
        ("IRef 6; IRef 3; Function XOR; ORef i; 0 > 2.SourceA; 1 > 2.SourceB; 2.Dest > 3", "i", 5),
    ],
)  # fmt: skip
def test_a_function_calculates(sheet: str, name: str, value: object, tmp_path: Path) -> None:
    """A function has no tag; a and c are TRUE."""
    made = running(tmp_path, sheet)
    for flag in ("Main.a", "Main.c"):
        made.write(flag, True)
    made.scan(0)
    assert made.read(f"Main.{name}") == value


def test_bor_has_up_to_eight_inputs(tmp_path: Path) -> None:
    """BOR is TRUE if its eighth input is."""
    made = _block(tmp_path, "FBD_BOOLEAN_OR", "BOR")
    assert _timeline(made, [(0, {}), (10, {"In8": True})], "Out") == [[False], [True]]


def test_tofr_times_while_its_input_is_off(tmp_path: Path) -> None:
    """It begins at 10 ms, ends at 60 ms with 50 ms, and a reset sets ACC to PRE.

    Source: 1756-RM003N, TOFR.
    """
    made = _block(tmp_path, "FBD_TIMER", "TOFR", PRE=50, TimerEnable=True)
    steps: list[tuple[int, Mapping[str, object]]] = [
        *((0, {}), (10, {"TimerEnable": False}), (40, {}), (60, {}), (70, {})),
        *((80, {"TimerEnable": True}), (90, {"TimerEnable": False}), (100, {"Reset": True})),
    ]
    assert _timeline(made, steps, "EN TT DN ACC") == [
        [True, False, True, 0],
        [False, True, True, 0],
        [False, True, True, 30],
        [False, False, False, 50],
        [False, False, False, 50],
        [True, False, True, 0],
        [False, True, True, 0],
        [False, False, False, 50],
    ]


def test_rtor_keeps_its_time_while_its_input_is_off(tmp_path: Path) -> None:
    """20 ms and 30 ms make 50 ms; DN stays until the reset. Source: 1756-RM003N, RTOR."""
    made = _block(tmp_path, "FBD_TIMER", "RTOR", PRE=50, TimerEnable=True)
    steps: list[tuple[int, Mapping[str, object]]] = [
        *((0, {}), (20, {}), (30, {"TimerEnable": False}), (50, {"TimerEnable": True})),
        *((80, {}), (90, {"TimerEnable": False}), (100, {"Reset": True})),
    ]
    assert _timeline(made, steps, "EN TT DN ACC") == [
        [True, True, False, 0],
        [True, True, False, 20],
        [False, False, False, 20],
        [True, True, False, 20],
        [True, False, True, 50],
        [False, False, True, 50],
        [False, False, False, 0],
    ]


def test_ctud_counts_edges_up_and_down(tmp_path: Path) -> None:
    """An input that is TRUE in the first scan is not an edge; up is counted before down.

    After a reset, an input that is still TRUE counts. Source: 1756-RM003N, page 151.
    """
    made = _block(tmp_path, "FBD_COUNTER", "CTUD", PRE=2, CUEnable=True)
    steps: list[tuple[int, Mapping[str, object]]] = [
        *((0, {}), (10, {"CUEnable": False}), (20, {"CUEnable": True})),
        *((30, {"CUEnable": False}), (40, {"CUEnable": True}), (50, {"CDEnable": True})),
        *((60, {"Reset": True}), (70, {"Reset": False})),
    ]
    assert _timeline(made, steps, "ACC DN CU CD") == [
        [0, False, True, False],
        [0, False, False, False],
        [1, False, True, False],
        [1, False, False, False],
        [2, True, True, False],
        [1, False, True, True],
        [0, False, False, False],
        [0, False, True, True],
    ]


@pytest.mark.parametrize(("instruction", "both"), [("SETD", True), ("RESD", False)])
def test_latches_differ_if_both_inputs_are_on(instruction: str, both: bool, tmp_path: Path) -> None:
    """Set, then nothing, reset, both. Source: 1756-RM006K, SETD and RESD."""
    kind = {"SETD": "DOMINANT_SET", "RESD": "DOMINANT_RESET"}[instruction]
    made = _block(tmp_path, kind, instruction)
    steps: list[tuple[int, Mapping[str, object]]] = [
        *((0, {"Set": True}), (10, {"Set": False}), (20, {"Reset": True}), (30, {"Set": True})),
    ]
    outs = [True, True, False, both]
    assert _timeline(made, steps, "Out OutNot") == [[out, not out] for out in outs]


def test_one_shots_are_on_for_a_scan(tmp_path: Path) -> None:
    """OSRI follows a rising edge, OSFI a falling one."""
    for instruction, expected in (("OSRI", [True, False, False]), ("OSFI", [False, False, True])):
        made = _block(tmp_path, "FBD_ONESHOT", instruction)
        made.scan(0)
        steps = [(10, {"InputBit": True}), (20, {}), (30, {"InputBit": False})]
        assert _timeline(made, steps, "OutputBit") == [[out] for out in expected]


def test_hll_limits_its_input(tmp_path: Path) -> None:
    """The limits are 0 and 10; SelectLimit 1 uses only the high one, 3 is invalid and means both.

    Source: Studio 5000 help, HLL.
    """
    made = _block(tmp_path, "HL_LIMIT", "HLL", HighLimit=10.0, In=12.0)
    steps: list[tuple[int, Mapping[str, object]]] = [
        *((0, {}), (10, {"In": -1.0}), (20, {"SelectLimit": 1}), (30, {"SelectLimit": 3})),
        *((40, {"In": 5.0, "SelectLimit": 0}), (50, {"LowLimit": 10.0})),
        (60, {"SelectLimit": 1}),
    ]
    assert _timeline(made, steps, "Out HighAlarm LowAlarm SelectLimitInv LimitsInv Status") == [
        [10.0, True, False, False, False, 0],
        [0.0, False, True, False, False, 0],
        [-1.0, False, False, False, False, 0],
        [0.0, False, True, True, False, 5],
        [5.0, False, False, False, False, 0],
        [10.0, False, True, False, True, 3],
        [5.0, False, False, False, False, 0],
    ]


def test_scl_scales_its_input(tmp_path: Path) -> None:
    """0 to 100 becomes 0 to 4: 25 is 1, 150 is 6, with Limiting 4. A wrong range keeps Out.

    Source: 1756-RM006K, SCL.
    """
    made = _block(tmp_path, "SCALE", "SCL", InRawMax=100.0, InEUMax=4.0, In=25.0)
    steps: list[tuple[int, Mapping[str, object]]] = [
        *((0, {}), (10, {"In": 150.0}), (20, {"Limiting": True}), (30, {"InRawMin": 100.0})),
    ]
    assert _timeline(made, steps, "Out MaxAlarm InRawRangeInv Status") == [
        [1.0, False, False, 0],
        [6.0, True, False, 0],
        [4.0, True, False, 0],
        [4.0, True, True, 3],
    ]


def test_btdt_moves_a_field_of_bits(tmp_path: Path) -> None:
    """Bits 4 to 7 of 16#AB5C are 5; behind bit 8 of 16#1F0F they give 16#150F.

    Four bits behind bit 30 are cut to two: 16#5 leaves 01. Source: Studio 5000 help, BTDT.
    """
    made = _block(tmp_path, "FBD_BIT_FIELD_DISTRIBUTE", "BTDT", Source=0xAB5C, SourceBit=4)
    steps: list[tuple[int, Mapping[str, object]]] = [
        (0, {"Length": 4, "DestBit": 8, "Target": 0x1F0F}),
        *((10, {"DestBit": 30, "Target": 0}), (20, {"Length": 33})),
    ]
    assert _timeline(made, steps, "Dest") == [[0x150F], [1 << 30], [1 << 30]]


@pytest.mark.parametrize(("instruction", "most"), [("MAXC", [2, 7, 7]), ("MINC", [2, 2, 1])])
def test_captures_keep_the_extreme_value(instruction: str, most: list[int], tmp_path: Path) -> None:
    """Inputs are 2, 7, 1; while Reset is TRUE, the output is ResetValue. Source: 1756-RM006K."""
    kind = {"MAXC": "MAXIMUM_CAPTURE", "MINC": "MINIMUM_CAPTURE"}[instruction]
    made = _block(tmp_path, kind, instruction, ResetValue=4.0)
    steps: list[tuple[int, Mapping[str, object]]] = [
        *((0, {"In": 2.0}), (10, {"In": 7.0}), (20, {"In": 1.0}), (30, {"Reset": True})),
    ]
    assert _timeline(made, steps, "Out") == [[float(value)] for value in (*most, 4)]


def test_mave_averages_the_last_samples(tmp_path: Path) -> None:
    """With three samples: 3, (3 + 6) / 2, (3 + 6 + 9) / 3, (6 + 9 + 12) / 3.

    Initialize passes In, and the next samples are averaged anew. Source: 1756-RM006K, MAVE.
    """
    made = running(
        tmp_path,
        'Block MAVE f|<Array Name="StorageArray" Operand="store"/><Array Name="WeightArray"/>',
        tags={"f": "MOVING_AVERAGE(NumberOfSamples=3)", "store": "REAL[4]"},
    )
    steps: list[tuple[int, Mapping[str, object]]] = [
        *((0, {"In": 3.0}), (10, {"In": 6.0}), (20, {"In": 9.0}), (30, {"In": 12.0})),
        *((40, {"In": 20.0, "Initialize": True}), (50, {"In": 2.0, "Initialize": False})),
        *((60, {"In": 8.0, "SampleEnable": False}), (70, {"NumberOfSamples": 5})),
    ]
    assert _timeline(made, steps, "Out NumberOfSampInv") == [
        *([3.0, False], [4.5, False], [6.0, False], [9.0, False], [20.0, False], [2.0, False]),
        *([2.0, False], [2.0, True]),
    ]


def test_mave_uses_its_weights(tmp_path: Path) -> None:
    """With the weights 0.75 and 0.25, behind 4 and 8 it gives 6 + 1."""
    arrays = "".join(
        f'<Array Name="{name}Array" Operand="{tag}"/>'
        for name, tag in (("Storage", "store"), ("Weight", "weights"))
    )
    made = running(
        tmp_path,
        f"Block MAVE f|{arrays}",
        tags={
            "f": "MOVING_AVERAGE(NumberOfSamples=2 UseWeights=1)",
            "store": "REAL[2]",
            "weights": "REAL[2]",
        },
    )
    made.write("Main.weights[0]", 0.75)
    made.write("Main.weights[1]", 0.25)
    steps: list[tuple[int, Mapping[str, object]]] = [(0, {"In": 4.0}), (10, {"In": 8.0})]
    assert _timeline(made, steps, "Out") == [[3.0], [7.0]]


def test_structured_text_calls_the_same_instructions(tmp_path: Path) -> None:
    """SETD, SCL and MAVE in text, while the data of a tag disable it: a text executes it.

    Source: 1756-RM003N: EnableIn has no effect in Structured Text.
    """
    code = "SETD(f); MAVE(m, store, 0); x := m.Out;"
    sub = f'<Routine Name="Sub" Type="ST"><STContent><Line Number="0">{code}</Line></STContent>'
    file = written(
        tmp_path,
        "JSR Sub",
        tags={
            "f": "DOMINANT_SET(EnableIn=0 Set=1)",
            "m": "MOVING_AVERAGE(In=2.5)",
            "store": "REAL[2]",
        },
        routines=f"{sub}</Routine>",
    )
    made = program(file)
    made.scan(0)
    assert _read(made, "Out OutNot EnableOut") == [True, False, True]
    assert made.read("Main.x") == 2.5
