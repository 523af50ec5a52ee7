"""FB_ServoOnFromEmergencyStop follows chapter 5, 3.1, step by step.

The test plays the controller.
"""

from __future__ import annotations

import pytest

from plc_bench import PlcBench
from sequence_bench import in_emergency_stop, pins


def _restarted() -> PlcBench:
    """Return a bench in which the block has just turned SI(00) ON again."""
    plc = in_emergency_stop()
    plc["Restart.Timeout"] = "T#300ms"
    plc.change("Restart.Execute", to=True)
    return plc


def test_servo_on_process_from_emergency_stop_status() -> None:
    """Source: manual chapter 5, 3.1, servo ON process from emergency stop status."""
    plc = in_emergency_stop()
    plc.change("Restart.Execute", to=True)
    assert plc.inputs == ["SI00", "SI06"]
    assert pins(plc, "Restart") == "Busy"
    assert plc["Restart.Stage"] == "POWER_UP_EMERGENCY_RELEASE"
    plc.scan(30)
    assert plc.inputs == ["SI00", "SI06"], "no alarm reset before SO(00) is OFF"

    plc.outputs(SO00=False, scans=1)
    assert plc.inputs == ["SI00", "SI06", "SI16"]
    assert pins(plc, "Restart") == "Busy Active"
    assert plc["Restart.Stage"] == "POWER_UP_ALARM_RESET"
    plc.scan(30)
    assert plc.inputs == ["SI00", "SI06", "SI16"], (
        "SI(16) stays ON until SO(03) is OFF, and SI(01) stays OFF"
    )

    plc.outputs(SO03=False, scans=1)
    assert plc.inputs == ["SI00", "SI06"]
    assert plc["Restart.Stage"] == "POWER_UP_SERVO_ON"
    assert plc.scan_until(lambda: plc.inputs != ["SI00", "SI06"]) == 12
    assert plc.inputs == ["SI00", "SI01", "SI06"]
    plc.scan(30)
    assert pins(plc, "Restart") == "Busy Active"

    plc.outputs(SO02=True, scans=1)
    assert pins(plc, "Restart") == "Done"
    assert plc["Restart.Stage"] == "POWER_UP_COMPLETE"
    assert plc.inputs == ["SI00", "SI06"]
    plc.change("Restart.Execute", to=False)
    assert pins(plc, "Restart") == ""
    assert plc["Restart.Stage"] == "POWER_UP_IDLE"


def test_without_an_alarm_there_is_no_alarm_reset() -> None:
    """Without an alarm, no alarm reset is sent. An emergency stop at power-on causes no alarm.

    Source: manual chapter 5, 3.1, initial servo ON process after power ON.
    """
    plc = in_emergency_stop()
    plc.outputs(SO03=False)
    plc.change("Restart.Execute", to=True)
    plc.outputs(SO00=False)
    seen = set()
    for _ in range(20):
        plc.scan()
        seen.update(plc.inputs)
    assert seen == {"SI00", "SI01", "SI06"}


def test_servo_on_waits_for_mp_ready() -> None:
    """Source: manual chapter 5, 2, SO(04)."""
    plc = in_emergency_stop()
    plc.change("Restart.Execute", to=True, scans=12)
    plc.outputs(SO00=False, SO04=False, scans=1)
    assert plc.inputs == ["SI00", "SI06", "SI16"]
    plc.outputs(SO03=False, scans=30)
    assert plc["Restart.Stage"] == "POWER_UP_MP_READY"
    assert pins(plc, "Restart") == "Busy"
    plc.outputs(SO04=True, scans=1)
    assert plc.inputs == ["SI00", "SI01", "SI06"]


def test_the_block_is_refused_while_the_application_keeps_si00_off() -> None:
    """While the application keeps SI(00) OFF, the block is refused and the hold remains.

    Source: manual chapter 5, 2, SI(01): SI(00) must be ON.
    """
    plc = in_emergency_stop()
    plc["EmergencyStopOk"] = False
    plc.change("Restart.Execute", to=True)
    assert pins(plc, "Restart") == "Busy"
    plc.scan()
    assert plc["Restart.ErrorID"] == 0x8003
    plc.change("EmergencyStopOk", to=True, scans=50)
    assert plc.inputs == ["SI06"]


@pytest.mark.parametrize("stop", ["EarlyStop", "EmergencyStop"])
def test_the_block_is_refused_while_an_emergency_stop_block_is_busy(stop: str) -> None:
    """While FB_EmergencyStop is Busy, FB_ServoOnFromEmergencyStop is refused.

    FB_EmergencyStop is called before or after it in the scan.
    """
    plc = in_emergency_stop()
    plc.change(f"{stop}.Execute", to=True, scans=5)
    plc.change("Restart.Execute", to=True, scans=4)
    assert plc["Restart.ErrorID"] == 0x8003
    assert plc["Robot.Inner.HoldEmergency"]
    plc.scan(50)
    assert plc.inputs == ["SI06"]


def test_without_a_link_the_block_is_refused_and_the_hold_stays() -> None:
    """Source: manual chapter 1, 5.2."""
    plc = in_emergency_stop()
    plc.change("Connected", to=False)
    plc.change("Restart.Execute", to=True, scans=2)
    assert plc["Restart.ErrorID"] == 0x8001
    plc.change("Connected", to=True, scans=50)
    assert plc.inputs == ["SI06"]


@pytest.mark.parametrize(
    ("outputs", "error", "stage"),
    [
        ({}, 0x8009, "EMERGENCY_RELEASE"),
        ({"SO00": False}, 0x800A, "ALARM_RESET"),
        ({"SO00": False, "SO03": False}, 0x800B, "SERVO_ON"),
    ],
    ids=["another emergency stop", "an alarm", "servos off"],
)
def test_a_remaining_emergency_stop_or_alarm_ends_the_block_at_the_time_limit(
    outputs: dict[str, bool], error: int, stage: str
) -> None:
    """If an emergency stop or an alarm remains, the block ends at its time limit.

    All emergency stop states must be cancelled. An alarm may need a power restart.

    Source: manual chapter 5, 2, SI(01) and SI(16); 3.1, servo ON from emergency stop, step 7.
    """
    plc = _restarted()
    plc.outputs(**outputs)
    taken = plc.scan_until(lambda: plc["Restart.Error"] is True, most=50)
    assert taken >= 30
    assert (plc["Restart.ErrorID"], plc["Restart.Stage"]) == (error, f"POWER_UP_{stage}")
    plc.scan(30)
    assert plc.inputs == ["SI00", "SI06"], "the block's own emergency stop is released"


def test_missing_main_power_ends_the_block_at_the_time_limit() -> None:
    """Source: manual chapter 5, 2, SO(04)."""
    plc = _restarted()
    plc.outputs(SO00=False, SO03=False, SO04=False)
    plc.scan_until(lambda: plc["Restart.Error"] is True, most=50)
    assert plc["Restart.ErrorID"] == 0x8005
    assert plc["Restart.Stage"] == "POWER_UP_MP_READY"
    plc.outputs(SO04=True, scans=30)
    assert plc.inputs == ["SI00", "SI06"], "a late signal starts nothing"
    assert plc["Restart.Stage"] == "POWER_UP_MP_READY", "Stage shows where the block failed"
    assert pins(plc, "Restart") == "Error"


def _play(plc: PlcBench, stage: str) -> None:
    """Run the process until it has reached a stage and its input is on the wire."""
    for last, outputs in (
        ("EMERGENCY_RELEASE", {"SO00": False}),
        ("ALARM_RESET", {"SO03": False, "SO04": False}),
        ("MP_READY", {"SO04": True}),
    ):
        if stage == last:
            break
        plc.outputs(scans=15, **outputs)
    plc.scan(5)
    assert plc["Restart.Stage"] == f"POWER_UP_{stage}"


_STAGES = ("EMERGENCY_RELEASE", "ALARM_RESET", "MP_READY", "SERVO_ON")


@pytest.mark.parametrize("stage", _STAGES)
def test_a_new_emergency_stop_ends_the_block_in_every_stage(stage: str) -> None:
    """Source: manual chapter 5, 3.1, shift to emergency stop."""
    plc = in_emergency_stop()
    plc.change("Restart.Execute", to=True)
    _play(plc, stage)
    plc.change("EmergencyStop.Execute", to=True)
    assert "SI00" not in plc.inputs
    plc.outputs(SO00=True, SO03=True, SO02=False, scans=35)
    assert plc["Restart.ErrorID"] == 0x8003
    assert plc["EmergencyStop.Done"]
    assert plc.inputs == ["SI06"]
    assert plc["Robot.Inner.Sequence.Serving"] == plc["Robot.Inner.Sequence.NextTicket"]


@pytest.mark.parametrize("scans", [1, 2])
@pytest.mark.parametrize("stage", _STAGES)
def test_a_lost_link_ends_the_block_in_every_stage_and_nothing_restarts(
    stage: str, scans: int
) -> None:
    """Source: manual chapter 1, 5.2."""
    plc = in_emergency_stop()
    plc.change("Restart.Execute", to=True)
    _play(plc, stage)
    plc.change("Connected", to=False, scans=scans)
    assert plc["Restart.ErrorID"] == 0x8001
    plc.change("Connected", to=True, scans=60)
    assert plc.inputs == ["SI00", "SI06"]
    assert plc["Restart.ErrorID"] == 0x8001


def test_the_alarm_reset_waits_for_its_turn() -> None:
    """Source: design of the channel: first come, first served."""
    plc = in_emergency_stop()
    plc["AutoStart.Timeout"] = "T#0s"
    plc.outputs(SO00=False, SO03=False)
    plc.change("Restart.Execute", "AutoStart.Execute", to=True, scans=30)
    assert plc["AutoStart.Active"]
    assert pins(plc, "Restart") == "Busy"
    plc.outputs(SO13=True, scans=1)
    assert plc["AutoStart.Done"]
    assert plc.scan_until(lambda: plc["Restart.Active"] is True) == 1


def test_a_block_that_is_no_longer_called_loses_its_turn() -> None:
    plc = _restarted()
    plc.outputs(SO00=False, scans=3)
    plc.change("CallRestart", to=False, scans=3)
    plc.change("CallRestart", to=True)
    assert plc["Restart.ErrorID"] == 0x8013


def test_it_can_be_tried_again_after_an_error() -> None:
    plc = _restarted()
    plc.scan(31)
    assert plc["Restart.ErrorID"] == 0x8009
    plc.change("Restart.Execute", to=False)
    assert pins(plc, "Restart") == ""
    plc.outputs(SO00=False)
    plc.change("Restart.Execute", to=True)
    plc.change("Restart.Execute", to=False)
    plc.outputs(SO03=False, scans=30)
    assert plc.inputs == ["SI00", "SI01", "SI06"]
    plc.outputs(SO02=True, scans=1)
    assert pins(plc, "Restart") == "Done"
    plc.scan()
    assert pins(plc, "Restart") == ""


def test_the_wait_for_mp_ready_has_a_time_limit_of_its_own() -> None:
    """The wait for MP RDY has the full time limit, although the alarm reset waited longer.

    Source: manual chapter 5, 2, SO(04).
    """
    plc = in_emergency_stop()
    plc["ProgramReset.Timeout"] = "T#0s"
    plc["Restart.Timeout"] = "T#300ms"
    plc.outputs(SO00=False, SO14=False)
    plc.change("ProgramReset.Execute", "Restart.Execute", to=True, scans=50)
    assert plc["ProgramReset.Active"]
    assert plc["Restart.Stage"] == "POWER_UP_ALARM_RESET"
    plc.outputs(SO14=True)
    plc.outputs(SO03=False, SO04=False)
    plc.scan_until(lambda: plc["Restart.Stage"] == "POWER_UP_MP_READY")
    plc.scan(20)
    assert pins(plc, "Restart") == "Busy"


def test_the_applications_emergency_stop_ends_the_wait_for_mp_ready() -> None:
    """If the application requests an emergency stop, the wait for MP RDY ends at once.

    The block does not wait for SO(00). Source: manual chapter 5, 2, SI(00).
    """
    plc = in_emergency_stop()
    plc.change("Restart.Execute", to=True)
    _play(plc, "MP_READY")
    plc.change("EmergencyStopOk", to=False, scans=20)
    assert plc["Restart.ErrorID"] == 0x8003


@pytest.mark.parametrize(
    ("outputs", "error"),
    [({"SO01": False}, 0x8002), ({"SO00": True}, 0x8003), ({"SO03": True}, 0x8004)],
)
def test_a_condition_against_servo_on_ends_the_wait_for_mp_ready(
    outputs: dict[str, bool], error: int
) -> None:
    """Source: manual chapter 5, 2, SI(01): CPU_OK, no emergency stop, no alarm."""
    plc = in_emergency_stop()
    plc.change("Restart.Execute", to=True)
    _play(plc, "MP_READY")
    plc.outputs(scans=2, **outputs)
    assert (plc["Restart.Error"], plc["Restart.ErrorID"]) == (True, error)
    assert plc["Restart.Stage"] == "POWER_UP_SERVO_ON"
    assert "SI01" not in plc.inputs


@pytest.mark.parametrize("stop", ["EarlyStop", "EmergencyStop"])
@pytest.mark.parametrize("since_change", [3, 30])
def test_an_emergency_stop_in_the_scan_of_the_release_has_priority(
    stop: str, since_change: int
) -> None:
    """If an emergency stop comes in the scan of the release, even for one scan, the block ends.

    The interval may prevent SI(00) from turning ON at once.

    Source: manual chapter 5, 2, SI(00).
    """
    plc = in_emergency_stop()
    plc.change("StopOk", to=False, scans=since_change)
    plc.change(f"{stop}.Execute", "Restart.Execute", to=True)
    plc.change(f"{stop}.Execute", to=False, scans=50)
    assert plc["Restart.ErrorID"] == 0x8003
    assert plc["Robot.Inner.HoldEmergency"]
    assert plc.inputs == []


def test_an_edge_in_the_scan_after_an_error_has_the_whole_time_again() -> None:
    plc = _restarted()
    plc["Restart.Execute"] = False
    plc.scan_until(lambda: plc["Restart.Error"] is True, most=40)
    assert plc["Restart.ErrorID"] == 0x8009
    plc.change("Restart.Execute", to=True)
    assert pins(plc, "Restart") == "Busy"
    assert 29 <= plc.scan_until(lambda: plc["Restart.Error"] is True, most=40) <= 32
