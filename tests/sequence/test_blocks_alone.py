"""Sequence blocks are run alone, in situations that are rare in a whole program.

The tests concern holds of the stop inputs, and time limits.
"""

from __future__ import annotations

from collections.abc import Mapping

import pytest

from alone import Alone
from structured_text.engines.base import Value

_STOPS = pytest.mark.parametrize(
    ("block", "hold", "keep", "wire"),
    [
        ("FB_EmergencyStop", "HoldEmergency", "KeepEmergency", "SI00_EmergencyStop"),
        ("FB_ProgramStop", "HoldStop", "KeepStop", "SI06_Stop"),
    ],
)


def _alone(block: str) -> Alone:
    """Return a sequence block with link and CPU_OK, and all other dedicated outputs OFF."""
    alone = Alone(block, {"Robot": "RCX_REF"})
    alone["Robot.Connected"] = alone["Robot.SO.SO01_CpuOk"] = True
    return alone


def _pulse(alone: Alone) -> None:
    """Set Execute to TRUE for one scan."""
    alone["Block.Execute"] = True
    alone.scan(0)
    alone["Block.Execute"] = False


@_STOPS
def test_a_stop_sets_its_hold_in_every_call_until_its_end(
    block: str, hold: str, keep: str, wire: str
) -> None:
    """A stop block sets its hold in every call until its end, even in the call that ends it.

    A block that was called before has released the hold in this scan. The loss of the link ends the
    stop block.

    Source: manual chapter 5, 3.1 and 3.3; heads of FB_EmergencyStop and FB_ProgramStop.
    """
    alone = _alone(block)
    alone[f"Robot.SI.{wire}"] = alone["Robot.SO.SO13_ProgramRunning"] = True
    _pulse(alone)
    for now, connected in ((10, True), (20, False)):
        assert alone["Block.Busy"] is True
        alone["Robot.Connected"] = connected
        alone[f"Robot.Inner.{hold}"] = alone[f"Robot.Inner.{keep}"] = False
        alone.scan(now)
        assert alone[f"Robot.Inner.{hold}"] is True
        assert alone[f"Robot.Inner.{keep}"] is True
    assert alone["Block.ErrorID"] == 0x8001
    alone[f"Robot.Inner.{hold}"] = alone[f"Robot.Inner.{keep}"] = False
    alone.scan(30)
    assert alone[f"Robot.Inner.{hold}"] is False
    assert alone[f"Robot.Inner.{keep}"] is False


@_STOPS
def test_a_stop_reports_at_once_that_cpu_ok_is_off(
    block: str, hold: str, keep: str, wire: str
) -> None:
    """A stop block reports at once that CPU_OK is OFF, even if its input is still ON.

    Source: manual chapter 5, 2, SO(01).
    """
    del hold, keep
    alone = _alone(block)
    alone[f"Robot.SI.{wire}"] = True
    alone["Robot.SO.SO01_CpuOk"] = False
    _pulse(alone)
    alone.scan(10)
    assert alone["Block.ErrorID"] == 0x8002


def test_an_emergency_stop_is_not_done_before_its_input_is_off() -> None:
    """In another emergency stop, the block is not done before its own input is OFF.

    Source: manual chapter 5, 3.1, shift to emergency stop, step 1.
    """
    alone = _alone("FB_EmergencyStop")
    alone["Robot.SO.SO00_EmergencyStop"] = alone["Robot.SI.SI00_EmergencyStop"] = True
    _pulse(alone)
    alone.scan(10)
    assert alone["Block.Busy"] is True
    alone["Robot.SI.SI00_EmergencyStop"] = False
    alone.scan(20)
    assert alone["Block.Done"] is True


def test_a_program_that_ended_before_the_stop_input_is_off_needs_no_wait() -> None:
    """If the program ends before the stop input turns OFF, the block does not wait.

    SO(13) was ON at the start of the job.

    Source: manual chapter 5, 3.3; head of FB_ProgramStop.
    """
    alone = _alone("FB_ProgramStop")
    alone["Robot.SI.SI06_Stop"] = alone["Robot.SO.SO13_ProgramRunning"] = True
    _pulse(alone)
    alone["Robot.SO.SO13_ProgramRunning"] = False
    for now in (10, 20):
        alone.scan(now)
        assert alone["Block.Busy"] is True
    alone["Robot.SI.SI06_Stop"] = False
    alone.scan(30)
    assert alone["Block.Done"] is True


def test_a_failed_release_restores_the_hold_once_and_at_once() -> None:
    """A failed release restores the hold once and at once, although Execute stays TRUE.

    A later release by another block is not undone.

    Source: head of FB_ServoOnFromEmergencyStop.
    """
    alone = _alone("FB_ServoOnFromEmergencyStop")
    alone["Robot.Inner.HoldEmergency"] = True
    alone["Robot.Connected"] = False
    alone["Block.Execute"] = True
    alone.scan(0)
    assert alone["Robot.Inner.HoldEmergency"] is False
    alone.scan(10)
    assert alone["Block.ErrorID"] == 0x8001
    assert alone["Robot.Inner.HoldEmergency"] is True
    alone["Robot.Inner.HoldEmergency"] = False
    alone.scan(20)
    assert alone["Block.Error"] is True
    assert alone["Robot.Inner.HoldEmergency"] is False


def _waiting(block: str) -> Alone:
    """Return a sequence block that waits while another block uses the dedicated inputs."""
    alone = _alone(block)
    alone["Robot.Inner.HoldStop"] = True
    alone["Robot.Inner.Sequence.NextTicket"] = 1
    alone["Block.Timeout"] = "T#100ms"
    alone["Block.Execute"] = True
    alone.scan(0)
    assert alone["Block.Busy"] is True
    assert alone["Block.Active"] is False
    return alone


def test_a_continuation_that_ends_in_the_queue_restores_the_hold() -> None:
    """Source: head of FB_ProgramContinue."""
    alone = _waiting("FB_ProgramContinue")
    assert alone["Robot.Inner.HoldStop"] is False
    alone["Robot.Connected"] = False
    alone.scan(10)
    assert alone["Block.ErrorID"] == 0x8001
    assert alone["Robot.Inner.HoldStop"] is True


def test_an_edge_in_the_queue_releases_no_later_hold() -> None:
    """An edge of Execute while the continuation waits does not release a later hold.

    FB_ProgramStop has set the hold in the meantime.

    Source: PLCopen: an edge while Busy is ignored; manual chapter 5, 3.3.
    """
    alone = _waiting("FB_ProgramContinue")
    alone["Robot.Inner.HoldStop"] = True
    for now, execute in ((10, False), (20, True)):
        alone["Block.Execute"] = execute
        alone.scan(now)
    assert alone["Block.Busy"] is True
    assert alone["Robot.Inner.HoldStop"] is True


@pytest.mark.parametrize(
    "block", ["FB_AlarmReset", "FB_ProgramReset", "FB_ReturnToOrigin", "FB_ServoOn"]
)
def test_the_time_limit_is_sampled_at_the_edge_even_if_the_turn_comes_later(block: str) -> None:
    """Source: design of the library, 3: inputs are sampled on the rising edge."""
    alone = _waiting(block)
    alone["Block.Timeout"] = "T#1s"
    alone["Robot.Inner.Elapsed"] = 50
    alone.scan(50)
    assert alone["Block.Busy"] is True
    alone["Robot.Inner.Sequence.Serving"] = 1
    for now in (100, 150):
        alone.scan(now)
        assert alone["Block.Active"] is True
    alone.scan(200)
    assert alone["Block.Error"] is True


@pytest.mark.parametrize(
    "block", ["FB_AlarmReset", "FB_AutoStart", "FB_ProgramReset", "FB_ReturnToOrigin", "FB_ServoOn"]
)
def test_an_edge_in_the_queue_samples_no_input(block: str) -> None:
    """Source: PLCopen: an edge while Busy is ignored."""
    alone = _waiting(block)
    before = alone["Block.Job.Longest"]
    alone["Block.Timeout"] = "T#7s"
    for now, execute in ((10, False), (20, True)):
        alone["Block.Execute"] = execute
        alone.scan(now)
    assert alone["Block.Busy"] is True
    assert alone["Block.Active"] is False
    assert alone["Block.Job.Longest"] == before


#: The dedicated inputs of a block as bits of their word (chapter 5): SI(01), SI(12), SI(14) to
#: SI(17).
_REQUESTS = {
    "FB_AlarmReset": ({"SO03_Alarm": True}, {}, 0x4000),
    "FB_AutoStart": (
        {"SO10_AutoMode": True, "SO02_ServoOn": True, "SO14_ProgramReset": True},
        {},
        0x0400,
    ),
    "FB_ProgramReset": ({"SO10_AutoMode": True}, {}, 0x2000),
    "FB_ReturnToOrigin-incremental": (
        {"SO02_ServoOn": True},
        {"Axes": "ORIGIN_INCREMENTAL"},
        0x1000,
    ),
    "FB_ReturnToOrigin-absolute": ({"SO02_ServoOn": True}, {"Axes": "ORIGIN_ABSOLUTE"}, 0x8000),
    "FB_ServoOn": ({"SO04_MpRdy": True}, {}, 0x0002),
}


@pytest.mark.parametrize("case", _REQUESTS)
def test_requests_of_another_block_in_the_same_scan_are_kept(case: str) -> None:
    """A request of another block in the same scan is not changed.

    A block that holds its level sets SI(10) before the call.
    """
    outputs, pins, bit = _REQUESTS[case]
    alone = _alone(case.partition("-")[0])
    alone["Robot.EmergencyStopOk"] = alone["Robot.StopOk"] = alone["Robot.Settled"] = True
    alone["Robot.SI.SI00_EmergencyStop"] = alone["Robot.SI.SI06_Stop"] = True
    for name, value in outputs.items():
        alone[f"Robot.SO.{name}"] = value
    for name, choice in pins.items():
        alone[f"Block.{name}"] = choice
    alone["Block.Execute"] = True
    for now in (0, 10, 20):
        alone["Robot.Inner.Request"] = 0x0100
        alone.scan(now)
    assert alone["Block.Active"] is True
    assert alone["Robot.Inner.Request"] == 0x0100 | bit


@pytest.mark.parametrize(
    ("block", "fields", "error"),
    [
        ("FB_AlarmReset", {"EmergencyStopOk": False, "SO.SO03_Alarm": True}, 0x8003),
        ("FB_ProgramReset", {"SO.SO01_CpuOk": False, "SO.SO10_AutoMode": True}, 0x8002),
        ("FB_ServoOn", {"SO.SO04_MpRdy": False}, 0x8005),
    ],
)
def test_an_impossible_job_is_refused_before_its_input_is_sent(
    block: str, fields: Mapping[str, bool], error: int
) -> None:
    """Source: manual chapter 5, 3.1 to 3.3; docs/reference/errors.md."""
    alone = _alone(block)
    alone["Robot.EmergencyStopOk"] = alone["Robot.StopOk"] = alone["Robot.Settled"] = True
    for name, value in fields.items():
        alone[f"Robot.{name}"] = value
    alone["Block.Execute"] = True
    for now in range(0, 50, 10):
        alone.scan(now)
        assert alone["Robot.Inner.Request"] == 0
    assert alone["Block.Error"] is True
    assert alone["Block.ErrorID"] == error


@pytest.mark.parametrize(
    ("block", "stage", "passes", "inner"),
    [
        ("FB_PowerUp", "POWER_UP_AUTO_MODE", "SO10_AutoMode", "Reset"),
        ("FB_ServoOnFromEmergencyStop", "POWER_UP_MP_READY", "SO04_MpRdy", "Servo"),
    ],
)
def test_after_a_scan_without_a_call_no_further_step_begins(
    block: str, stage: str, passes: str, inner: str
) -> None:
    """After a scan without a call, the block ends with 16#8013 and begins no further step.

    The condition of its stage became TRUE in that scan.
    """
    alone = _alone(block)
    alone["Robot.EmergencyStopOk"] = alone["Robot.StopOk"] = alone["Robot.Settled"] = True
    alone["Robot.SI.SI00_EmergencyStop"] = alone["Robot.SI.SI06_Stop"] = True
    alone["Robot.SO.SO02_ServoOn"] = block == "FB_PowerUp"
    alone["Block.Execute"] = True
    alone.scan(0)
    alone["Block.Stage"] = stage
    alone.scan(10)
    assert alone["Block.Busy"] is True
    assert alone["Block.Stage"] == stage
    alone["Robot.Inner.Scan"] = 7
    alone[f"Robot.SO.{passes}"] = True
    alone.scan(20)
    assert alone["Block.ErrorID"] == 0x8013
    assert alone[f"Block.{inner}.Busy"] is False


def _jog(**fields: Value) -> Alone:
    alone = _alone("FB_Jog")
    alone["Robot.EmergencyStopOk"] = alone["Robot.StopOk"] = alone["Robot.Settled"] = True
    alone["Robot.SI.SI06_Stop"] = True
    alone["Robot.Inner.Elapsed"] = 10
    alone["Block.Timeout"] = "T#50ms"
    for name, value in fields.items():
        alone[f"Block.{name}"] = value
    return alone


def test_the_time_limit_of_a_jog_counts_from_its_enable() -> None:
    """Timeout of a jog counts from Enable, even while an abandoned command is on the wire.

    Source: head of FB_Jog: Timeout.
    """
    alone = _jog(Enable=True)
    alone.scan(0)
    alone["Block.Enable"] = False
    alone["Robot.Inner.Command.Orphan"] = True
    for now in range(10, 300, 10):
        alone.scan(now)
    assert alone["Block.Job.Busy"] is False
    alone["Block.Enable"] = True
    for now in range(300, 340, 10):
        alone.scan(now)
        assert alone["Block.Error"] is False, now
    for now in range(340, 400, 10):
        alone.scan(now)
    assert alone["Block.ErrorID"] == 0x8012


def test_a_jog_that_waited_too_long_leaves_the_queue() -> None:
    """A jog that waited longer than Timeout leaves the queue and does not begin after its error.

    Source: docs/reference/errors.md, 16#8012.
    """
    alone = _jog()
    alone["Robot.Inner.Command.NextTicket"] = 1
    alone["Robot.Inner.Command.Orphan"] = True
    alone["Block.Enable"] = True
    for now in range(0, 100, 10):
        alone.scan(now)
    assert alone["Block.ErrorID"] == 0x8012
    assert alone["Block.Job.Busy"] is False
    alone["Robot.Inner.Command.Orphan"] = False
    alone["Robot.Inner.Command.Serving"] = 1
    for now in range(100, 150, 10):
        alone.scan(now)
        assert alone["Robot.Inner.CodeRequest"] is False
