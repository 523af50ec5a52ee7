"""FB_Status shows the dedicated outputs of chapter 5, 2.

The test plays the controller.
"""

from __future__ import annotations

import pytest

from plc_bench import PlcBench
from rcx_harness import spec
from sequence_bench import sequences, servo_on

_EDGES = (
    *("EmergencyRaised", "EmergencyReleased", "AlarmRaised", "AlarmCleared", "WarningRaised"),
    *("WarningCleared", "ServoLost", "AutoLost", "ProgramStarted", "ProgramEnded"),
)


def _edges(plc: PlcBench) -> list[str]:
    return [name for name in _EDGES if plc[f"Condition.{name}"]]


def _level(plc: PlcBench) -> str:
    return " ".join(name for name in ("Valid", "Error", "Ready") if plc[f"Condition.{name}"])


def _watched(plc: PlcBench) -> PlcBench:
    plc.change("Condition.Enable", to=True, scans=2)
    assert _edges(plc) == []
    return plc


@pytest.mark.parametrize("signal", spec.signals().output, ids=lambda signal: str(signal.short))
def test_each_dedicated_output_is_shown(signal: spec.Signal) -> None:
    """Source: manual chapter 5, 2, bit output."""
    plc = _watched(sequences())
    before = plc[f"Condition.SO.{signal.name}"]
    plc.outputs(scans=1, **{signal.short: not before})
    assert plc[f"Condition.SO.{signal.name}"] is not before
    assert plc["Condition.Valid"]


@pytest.mark.parametrize(
    ("output", "on", "off"),
    [
        ("SO00", ["EmergencyRaised"], ["EmergencyReleased"]),
        ("SO03", ["AlarmRaised"], ["AlarmCleared"]),
        ("SO15", ["WarningRaised"], ["WarningCleared"]),
        ("SO02", [], ["ServoLost"]),
        ("SO10", [], ["AutoLost"]),
        ("SO13", ["ProgramStarted"], ["ProgramEnded"]),
        ("SO11", [], []),
    ],
)
def test_a_change_is_shown_for_one_scan(output: str, on: list[str], off: list[str]) -> None:
    """Source: manual chapter 5, 2, SO(00), SO(02), SO(03), SO(10), SO(13) and SO(15)."""
    plc = sequences()
    plc.outputs(SO10=False)
    plc = _watched(plc)
    for level, expected in ((True, on), (False, off)):
        plc.outputs(scans=1, **{output: level})
        assert _edges(plc) == expected
        plc.scan()
        assert _edges(plc) == []


def test_an_alarm_that_is_there_from_the_start_is_a_change() -> None:
    plc = sequences()
    plc.outputs(SO03=True)
    plc.change("Condition.Enable", to=True)
    assert _edges(plc) == ["AlarmRaised"]


def test_a_lost_link_is_not_a_change_but_changes_during_the_loss_are_shown() -> None:
    """Source: manual chapter 1, 5.2."""
    plc = servo_on()
    plc.outputs(SO13=True)
    plc.change("Condition.Enable", to=True, scans=2)
    plc.change("Connected", to=False)
    assert _level(plc) == "Error"
    assert plc["Condition.ErrorID"] == 0x8001
    assert _edges(plc) == []
    assert plc["Condition.SO.SO13_ProgramRunning"], "the last values stay"
    plc.outputs(SO00=True, SO02=False, SO03=True, SO13=False, scans=5)
    assert _edges(plc) == []
    plc.change("Connected", to=True)
    assert _level(plc) == "Valid"
    assert plc["Condition.ErrorID"] == 0
    assert _edges(plc) == ["EmergencyRaised", "AlarmRaised", "ServoLost", "ProgramEnded"]


def test_without_enable_nothing_is_shown() -> None:
    plc = _watched(servo_on())
    assert _level(plc) == "Valid Ready"
    plc["Condition.Enable"] = False
    plc.outputs(SO03=True, scans=1)
    assert _level(plc) == ""
    assert _edges(plc) == []
    assert (plc["Condition.Stage"], plc["Condition.Text"]) == ("POWER_UP_IDLE", "")


@pytest.mark.parametrize(
    ("cause", "stage", "word"),
    [
        ({"SO01": False}, "CPU_OK", "SO(01)"),
        ({"SO00": True}, "EMERGENCY_RELEASE", "SO(00)"),
        ({"SO03": True}, "ALARM_RESET", "SO(03)"),
        ({"SO04": False}, "MP_READY", "SO(04)"),
        ({"SO02": False}, "SERVO_ON", "SO(02)"),
        ({"SO10": False}, "AUTO_MODE", "AUTO"),
        ({"SO13": True}, "COMPLETE", "Complete"),
    ],
)
def test_ready_needs_all_conditions_of_a_program_start(
    cause: dict[str, bool], stage: str, word: str
) -> None:
    """Source: manual chapter 5, 3.2, program execution process."""
    plc = _watched(servo_on())
    assert _level(plc) == "Valid Ready"
    assert plc["Condition.Stage"] == "POWER_UP_PROGRAM_START"
    plc.outputs(scans=1, **cause)
    assert _level(plc) == "Valid"
    assert plc["Condition.Stage"] == f"POWER_UP_{stage}"
    assert word in str(plc["Condition.Text"])


@pytest.mark.parametrize(
    ("pin", "stage", "word"),
    [
        ("Connected", "CONNECTION", "connection"),
        ("EmergencyStopOk", "CELL_SAFE", "SI(00)"),
        ("StopOk", "STOP_RELEASE", "SI(06)"),
    ],
)
def test_ready_needs_the_safety_pins_of_the_application(pin: str, stage: str, word: str) -> None:
    """Source: manual chapter 5, 3.2, note: not with emergency stop or stop input OFF."""
    plc = _watched(servo_on())
    plc[pin] = False
    plc.scan(2)
    assert not plc["Condition.Ready"]
    assert plc["Condition.Stage"] == f"POWER_UP_{stage}"
    assert word in str(plc["Condition.Text"])


@pytest.mark.parametrize(
    ("block", "stage"), [("EmergencyStop", "CELL_SAFE"), ("ProgramStop", "STOP_RELEASE")]
)
def test_a_hold_of_a_block_is_named_in_the_next_scan(block: str, stage: str) -> None:
    plc = _watched(servo_on())
    plc.change(f"{block}.Execute", to=True)
    assert plc["Condition.Stage"] == f"POWER_UP_{stage}"
