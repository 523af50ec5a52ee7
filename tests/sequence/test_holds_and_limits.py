"""FB_EmergencyStop and FB_ProgramStop hold their input OFF until their counterpart releases it.

The hold remains for every reason for which the stop block ends.
"""

from __future__ import annotations

import pytest

from plc_bench import PlcBench
from sequence_bench import in_emergency_stop, pins, servo_on

_PROGRAM = """PROGRAM Holds
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Connected : BOOL := TRUE;
    Robot : RCX_REF;
    ReadArea : FB_ReadArea;
    WriteArea : FB_WriteArea;
    Stop : FB_ProgramStop;
    First, Second : FB_ProgramContinue;
  END_VAR
  ReadArea(Robot := Robot, Image := InputArea, Connected := Connected);
  Stop(Robot := Robot);
  First(Robot := Robot);
  Second(Robot := Robot);
  WriteArea(Robot := Robot, Image := OutputArea, Margin := T#20ms, EmergencyStopOk := TRUE,
            StopOk := TRUE);
END_PROGRAM
"""


@pytest.fixture
def stopped() -> PlcBench:
    """Return a bench in which FB_ProgramStop has just switched SI(06) OFF."""
    plc = PlcBench(program=_PROGRAM)
    plc.outputs(SO01=True, SO02=True, SO04=True, SO10=True, scans=60)
    assert plc.inputs == ["SI00", "SI06"]
    plc.change("Stop.Execute", to=True)
    assert plc.inputs == ["SI00"]
    return plc


def test_a_continuation_ended_by_the_link_restores_the_hold_in_the_same_scan(
    stopped: PlcBench,
) -> None:
    """If the link ends a continuation, the hold is restored in the same scan.

    SI(06) was not ON yet, because the interval since its switch-off was not over.

    Source: manual chapter 5, 3.1, caution, and 3.3; head of FB_ProgramContinue.
    """
    stopped.scan(1)
    stopped.change("Stop.Execute", to=False, scans=60)
    assert stopped["Stop.Busy"] is False
    stopped.change("Connected", to=False)
    stopped["Connected"] = True
    stopped.change("First.Execute", to=True)
    assert stopped["First.Busy"] is True
    assert "SI06" not in stopped.inputs
    stopped["First.Execute"] = False
    stopped.change("Connected", to=False)
    assert stopped["First.ErrorID"] == 0x8001
    stopped.change("Connected", to=True, scans=60)
    assert "SI06" not in stopped.inputs


def test_a_refused_continuation_does_not_prevent_another_one(stopped: PlcBench) -> None:
    """A refused continuation restores the hold only once, so that another one can release it.

    Its Execute stays TRUE. SI(06) waits for its interval.

    Source: manual chapter 5, 3.3; head of FB_ProgramContinue.
    """
    stopped.change("Stop.Execute", to=False, scans=60)
    stopped.change("Connected", to=False)
    stopped["Connected"] = True
    stopped.change("First.Execute", to=True)
    stopped.change("Connected", to=False)
    assert stopped["First.ErrorID"] == 0x8001
    stopped.change("Connected", to=True, scans=60)
    assert "SI06" not in stopped.inputs
    stopped.change("Connected", to=False)
    stopped["Connected"] = True
    stopped.change("Second.Execute", to=True, scans=30)
    assert "SI06" in stopped.inputs


#: Each stop block, and the safety input that it does not hold.
_STOPS = pytest.mark.parametrize(
    ("block", "other"), [("EmergencyStop", "SI06"), ("ProgramStop", "SI00")]
)


def _running() -> PlcBench:
    """Return a bench with the servos on and a running program."""
    plc = servo_on()
    plc.outputs(SO13=True, SO14=False, scans=1)
    return plc


@_STOPS
def test_a_stop_without_an_answer_ends_at_the_time_limit_and_holds_on(
    block: str, other: str
) -> None:
    plc = _running()
    plc[f"{block}.Timeout"] = "T#300ms"
    plc.change(f"{block}.Execute", to=True, scans=30)
    assert pins(plc, block) == "Busy Active"
    plc.scan()
    assert plc[f"{block}.ErrorID"] == 0x8010
    plc.change(f"{block}.Execute", to=False, scans=50)
    assert plc.inputs == [other]


@_STOPS
def test_a_stop_without_a_link_holds_after_the_recovery(block: str, other: str) -> None:
    """Source: manual chapter 1, 5.2."""
    plc = _running()
    plc.change("Connected", to=False, scans=5)
    plc.change(f"{block}.Execute", to=True)
    assert pins(plc, block) == "Busy Active"
    plc.scan()
    assert plc[f"{block}.ErrorID"] == 0x8001
    plc.change(f"{block}.Execute", to=False)
    plc.change("Connected", to=True, scans=100)
    assert plc.inputs == [other]


@_STOPS
def test_a_link_lost_during_a_stop_ends_the_block_and_the_hold_stays(
    block: str, other: str
) -> None:
    """Source: manual chapter 1, 5.2."""
    plc = _running()
    plc.change(f"{block}.Execute", to=True, scans=3)
    plc[f"{block}.Execute"] = False
    plc.change("Connected", to=False)
    assert plc[f"{block}.ErrorID"] == 0x8001
    plc.change("Connected", to=True, scans=100)
    assert plc.inputs == [other]


@_STOPS
def test_a_controller_that_is_not_ready_cannot_answer_a_stop(block: str, other: str) -> None:
    """Source: manual chapter 5, 2, SO(01)."""
    plc = servo_on()
    plc.outputs(SO01=False)
    plc.change(f"{block}.Execute", to=True, scans=2)
    assert plc[f"{block}.ErrorID"] == 0x8002
    assert plc.inputs == [other]


@pytest.mark.parametrize("stop", ["EmergencyStop", "EarlyStop", "ProgramStop", "EarlyHalt"])
def test_while_a_stop_is_busy_no_other_block_releases_its_input(stop: str) -> None:
    """While a stop block is Busy, no other block can release its input.

    The releasing block is called before or after the stop block in the scan.

    Source: manual chapter 5, 2, SI(00) and SI(06): OFF is the emergency stop and the stop state.
    """
    emergency = stop in ("EmergencyStop", "EarlyStop")
    plc = in_emergency_stop() if emergency else servo_on()
    plc.change(f"{stop}.Execute", to=True, scans=30)
    plc["Restart.Execute" if emergency else "Resume.Execute"] = True
    for _ in range(60):
        plc.scan()
        assert ("SI00" if emergency else "SI06") not in plc.inputs
