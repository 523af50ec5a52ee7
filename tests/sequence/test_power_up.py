"""FB_PowerUp executes the processes of chapter 5, 3.1 and 3.2, in order.

The test plays the controller.
"""

from __future__ import annotations

import pytest

from plc_bench import ROOT, PlcBench
from sequence_bench import pins, servo_on

#: Maps each stage to the condition that it waits for: pins of the area blocks, or outputs.
_CONDITIONS: dict[str, str | dict[str, bool]] = {
    "CONNECTION": "Connected",
    "CPU_OK": {"SO00": True, "SO01": True, "SO03": True},
    "CELL_SAFE": "EmergencyStopOk",
    "EMERGENCY_RELEASE": {"SO00": False},
    "ALARM_RESET": {"SO03": False},
    "MP_READY": {"SO04": True},
    "SERVO_ON": {"SO02": True},
    "STOP_RELEASE": "StopOk",
    "AUTO_MODE": {"SO10": True},
    "PROGRAM_RESET": {"SO14": True},
    "PROGRAM_START": {"SO14": False, "SO13": True},
}
_STAGES = tuple(_CONDITIONS)


def _off(timeout: str = "T#300ms") -> PlcBench:
    """Return a bench without power and link, and with the safety pins FALSE."""
    plc = PlcBench(program=ROOT / "tests/data/library/Sequences.st")
    plc.change("Connected", "EmergencyStopOk", "StopOk", to=False, scans=30)
    plc["PowerUp.Timeout"] = timeout
    plc.change("PowerUp.Execute", to=True)
    return plc


def _give(plc: PlcBench, stage: str) -> None:
    """Fulfil the condition that this stage waits for."""
    gift = _CONDITIONS[stage]
    if isinstance(gift, str):
        plc[gift] = True
    else:
        plc.outputs(**gift)


def _until(plc: PlcBench, stage: str) -> None:
    """Run until the block waits in this stage with its inputs on the wire.

    The test plays the controller and the operator.
    """
    for last in _STAGES:
        plc.scan_until(lambda: plc["PowerUp.Stage"] == f"POWER_UP_{last}")  # noqa: B023
        if last == stage:
            return
        plc.scan(14)
        _give(plc, last)


def test_from_power_on_to_a_running_program_with_one_execute() -> None:
    """The inputs turn ON in the order of the stages. Source: manual chapter 5, 3.1 and 3.2."""
    plc = _off()
    seen: list[str] = []
    for stage in _STAGES:
        plc.scan_until(lambda: plc["PowerUp.Stage"] == f"POWER_UP_{stage}")  # noqa: B023
        for _ in range(14):
            plc.scan()
            seen += [name for name in plc.inputs if name not in seen]
        assert plc["PowerUp.Busy"]
        assert not plc["PowerUp.Done"]
        _give(plc, stage)
    plc.scan_until(lambda: plc["PowerUp.Busy"] is False, most=3)
    assert pins(plc, "PowerUp") == "Done"
    assert plc["PowerUp.Stage"] == "POWER_UP_COMPLETE"
    assert seen == ["SI00", "SI16", "SI01", "SI06", "SI15", "SI12"]
    plc.scan(12)
    assert plc.inputs == ["SI00", "SI06"]
    plc.change("PowerUp.Execute", to=False)
    assert pins(plc, "PowerUp") == ""
    assert (plc["PowerUp.Stage"], plc["PowerUp.Text"]) == ("POWER_UP_IDLE", "")


@pytest.mark.parametrize(
    ("stage", "error", "word"),
    [
        ("CONNECTION", 0x8001, "connection"),
        ("CPU_OK", 0x8002, "SO(01)"),
        ("CELL_SAFE", 0x8003, "EmergencyStopOk"),
        ("EMERGENCY_RELEASE", 0x8009, "SO(00)"),
        ("ALARM_RESET", 0x800A, "SO(03)"),
        ("MP_READY", 0x8005, "SO(04)"),
        ("SERVO_ON", 0x800B, "SO(02)"),
        ("STOP_RELEASE", 0x8007, "StopOk"),
        ("AUTO_MODE", 0x8006, "AUTO"),
        ("PROGRAM_RESET", 0x8010, "SO(14)"),
        ("PROGRAM_START", 0x8010, "SO(13)"),
    ],
)
def test_each_wait_is_limited_and_says_what_it_waits_for(stage: str, error: int, word: str) -> None:
    plc = _off()
    _until(plc, stage)
    assert word in str(plc["PowerUp.Text"])
    taken = plc.scan_until(lambda: plc["PowerUp.Busy"] is False, most=40)
    assert 29 <= taken <= 32
    assert plc["PowerUp.ErrorID"] == error
    assert plc["PowerUp.Stage"] == f"POWER_UP_{stage}", "Stage shows where the block failed"
    plc.scan(40)
    assert set(plc.inputs) <= {"SI00", "SI06"}
    _give(plc, stage)
    plc.scan(40)
    assert set(plc.inputs) <= {"SI00", "SI06"}, "a late signal starts nothing"
    assert pins(plc, "PowerUp") == "Error"
    assert plc["Robot.Inner.Sequence.Serving"] == plc["Robot.Inner.Sequence.NextTicket"]


@pytest.mark.parametrize("stage", _STAGES[1:])
def test_a_lost_link_ends_the_block_in_every_stage_and_nothing_restarts(stage: str) -> None:
    """Source: manual chapter 1, 5.2."""
    plc = _off()
    _until(plc, stage)
    plc.change("Connected", to=False, scans=2)
    assert plc["PowerUp.ErrorID"] == 0x8001
    plc.change("Connected", to=True, scans=60)
    assert set(plc.inputs) <= {"SI00", "SI06"}
    assert plc["PowerUp.ErrorID"] == 0x8001


@pytest.mark.parametrize("stage", _STAGES[3:])
def test_an_emergency_stop_ends_power_up_in_every_stage(stage: str) -> None:
    """Source: manual chapter 5, 3.1, shift to emergency stop."""
    plc = _off()
    _until(plc, stage)
    plc.change("EmergencyStop.Execute", to=True)
    assert "SI00" not in plc.inputs
    plc.outputs(SO14=True, scans=31)
    assert plc["PowerUp.ErrorID"] == 0x8003
    plc.scan(30)
    assert set(plc.inputs) <= {"SI06"}
    assert plc["Robot.Inner.HoldEmergency"]


@pytest.mark.parametrize(
    ("stage", "output", "error"),
    [
        ("STOP_RELEASE", {"SO01": False}, 0x8002),
        ("STOP_RELEASE", {"SO00": True}, 0x8003),
        ("STOP_RELEASE", {"SO03": True}, 0x8004),
        ("STOP_RELEASE", {"SO02": False}, 0x800C),
        ("STOP_RELEASE", {"SO13": True}, 0x8008),
        ("AUTO_MODE", {"SO01": False}, 0x8002),
        ("AUTO_MODE", {"SO00": True}, 0x8003),
        ("AUTO_MODE", {"SO03": True}, 0x8004),
        ("AUTO_MODE", {"SO02": False}, 0x800C),
        ("AUTO_MODE", {"SO13": True}, 0x8008),
        ("PROGRAM_RESET", {"SO10": False}, 0x8006),
        ("PROGRAM_START", {"SO10": False}, 0x8006),
        ("PROGRAM_START", {"SO03": True}, 0x8004),
    ],
)
def test_a_lost_condition_ends_power_up_at_once(
    stage: str, output: dict[str, bool], error: int
) -> None:
    """Source: manual chapter 5, 3.2."""
    plc = _off()
    _until(plc, stage)
    plc.scan(14)
    plc.outputs(scans=1, **output)
    assert plc["PowerUp.ErrorID"] == error


def test_without_a_program_power_up_is_done_when_the_servos_are_on() -> None:
    """Source: manual chapter 5, 3.1, initial servo ON process after power ON."""
    plc = PlcBench(program=ROOT / "tests/data/library/Sequences.st")
    plc["PowerUp.StartProgram"] = False
    plc.change("PowerUp.Execute", to=True)
    plc["PowerUp.StartProgram"] = True
    plc.outputs(SO01=True, SO04=True, SO10=True)
    plc.scan_until(lambda: "SI01" in plc.inputs)
    assert pins(plc, "PowerUp") == "Busy Active"
    plc.outputs(SO02=True, scans=1)
    assert pins(plc, "PowerUp") == "Done"
    plc.scan(40)
    assert "SI15" not in plc.inputs


@pytest.mark.parametrize(("block", "error"), [("EmergencyStop", 0x8003), ("ProgramStop", 0x8007)])
def test_it_does_not_end_the_hold_of_another_block(block: str, error: int) -> None:
    plc = servo_on()
    plc["PowerUp.Timeout"] = "T#300ms"
    plc.change(f"{block}.Execute", to=True)
    if block == "EmergencyStop":
        plc.outputs(SO00=True, SO03=True, SO02=False)
    plc.scan(20)
    plc.change(f"{block}.Execute", to=False, scans=20)
    plc.scan_until(lambda: plc["PowerUp.Error"] is True, execute="PowerUp")
    assert plc["PowerUp.ErrorID"] == error
    plc.scan(60)
    assert plc.inputs == (["SI06"] if block == "EmergencyStop" else ["SI00"])


def test_it_can_be_tried_again_after_an_error() -> None:
    plc = _off()
    plc.scan(40)
    assert plc["PowerUp.ErrorID"] == 0x8001
    plc.change("PowerUp.Execute", to=False)
    plc.change("PowerUp.Execute", to=True)
    assert pins(plc, "PowerUp") == "Busy"
    assert plc["PowerUp.Stage"] == "POWER_UP_CONNECTION"
    _until(plc, "PROGRAM_START")
    plc.scan(14)
    _give(plc, "PROGRAM_START")
    plc.scan_until(lambda: plc["PowerUp.Done"] is True)


def test_an_emergency_stop_in_the_scan_of_a_safe_cell_has_priority() -> None:
    """Source: manual chapter 5, 2, SI(00)."""
    plc = servo_on()
    plc.scan_until(lambda: plc["PowerUp.Stage"] == "POWER_UP_CELL_SAFE", execute="PowerUp")
    plc.change("EarlyStop.Execute", to=True)
    assert plc["Robot.Inner.HoldEmergency"]
    assert plc["PowerUp.Stage"] == "POWER_UP_CELL_SAFE"
    assert plc.inputs == ["SI06"]


def test_a_program_that_runs_without_servos_does_not_complete_power_up() -> None:
    """If the servos turn OFF while the program starts, the block does not report Done."""
    plc = _off()
    plc["PowerUp.Execute"] = True
    _until(plc, "PROGRAM_START")
    plc.scan_until(lambda: "SI12" in plc.inputs)
    plc.outputs(SO02=False, SO14=False, SO13=True)
    plc.scan_until(lambda: not plc["PowerUp.Busy"])
    assert plc["PowerUp.ErrorID"] == 0x800C


def test_an_edge_in_the_scan_after_an_error_has_the_whole_time_again() -> None:
    plc = _off()
    plc["PowerUp.Execute"] = False
    plc.scan_until(lambda: plc["PowerUp.Error"] is True, most=40)
    plc.change("PowerUp.Execute", to=True)
    assert pins(plc, "PowerUp") == "Busy"
    assert 29 <= plc.scan_until(lambda: plc["PowerUp.Error"] is True, most=40) <= 32


def test_a_running_program_does_not_matter_before_the_servos_are_on() -> None:
    """A running program has no effect before the servos are ON.

    When a PLC restarts, the robot may be working. FB_ServoOn checks its own conditions.
    """
    plc = _off()
    _until(plc, "CELL_SAFE")
    plc.outputs(SO13=True, scans=10)
    assert pins(plc, "PowerUp") == "Busy"
    assert plc["PowerUp.Stage"] == "POWER_UP_CELL_SAFE"


def test_without_a_time_limit_power_up_waits_in_every_stage() -> None:
    """Source: head of FB_PowerUp: T#0s = no limit."""
    plc = _off("T#0s")
    for stage in _STAGES:
        plc.scan(40)
        assert plc["PowerUp.Stage"] == f"POWER_UP_{stage}"
        _give(plc, stage)
    plc.scan(40)
    assert plc["PowerUp.Done"] is True
