"""FB_WorkCycle reacts to Start, Stop and Reset, and shows the first fault.

The test plays the controller.
"""

from __future__ import annotations

import pytest

from plc_bench import ROOT, PlcBench


def _bench() -> PlcBench:
    """Return a bench in AUTO with the servos on, SI(00) and SI(06) ON and settled.

    The work of `Cycle` is a movement. `Bare` has no work block; the test plays its work.
    """
    plc = PlcBench(program=ROOT / "tests/data/library/WorkCycle.st")
    plc.power_up()
    plc.outputs(SO02=True)
    plc.scan()
    return plc


def _press(plc: PlcBench, pin: str) -> None:
    plc[pin] = True
    plc.scan()
    plc[pin] = False
    plc.scan()


def _running(block: str = "Bare") -> PlcBench:
    """Return a bench with a cycle that has powered up, with Run TRUE."""
    plc = _bench()
    _press(plc, f"{block}.Start")
    plc.scan_until(lambda: bool(plc[f"{block}.Run"]))
    return plc


def _shown(plc: PlcBench, block: str = "Bare") -> tuple[str, bool, bool, int]:
    """Return State, Run, Busy and ErrorID; check that Error is TRUE if ErrorID is not 0."""
    error_id = int(plc[f"{block}.ErrorID"])
    assert plc[f"{block}.Error"] is (error_id != 0)
    state = str(plc[f"{block}.State"]).removeprefix("WORK_")
    return state, bool(plc[f"{block}.Run"]), bool(plc[f"{block}.Busy"]), error_id


_IDLE, _RUN, _STOP = ("IDLE", False, False, 0), ("RUN", True, True, 0), ("STOP", True, True, 0)


def _fault(error_id: int) -> tuple[str, bool, bool, int]:
    return "FAULT", False, False, error_id


def _end(plc: PlcBench, status: int = 0x0200) -> None:
    """End the running command, and let the status be reset."""
    plc.scan_until(lambda: plc.words[0] != 0)
    plc.answer(status, [12, 600] if status == 0x4000 else [])
    plc.scan_until(lambda: plc.words[0] == 0)
    plc.answer(0)


def test_start_powers_up_and_then_the_work_is_repeated() -> None:
    """Start powers up the robot, then the work is repeated. Run falls for a scan after each work.

    Source: a rule of this library; servo on: chapter 5, 3.1.
    """
    plc = _bench()
    plc.outputs(SO02=False)
    plc.scan(20)
    assert _shown(plc, "Cycle") == _IDLE
    _press(plc, "Cycle.Start")
    assert _shown(plc, "Cycle") == ("POWER_UP", False, True, 0)
    plc.scan_until(lambda: "SI01" in plc.inputs)
    plc.outputs(SO02=True)
    plc.scan_until(lambda: bool(plc["Cycle.Run"]))
    assert _shown(plc, "Cycle") == _RUN
    for count in (1, 2, 3):
        _end(plc)
        plc.scan()
        assert plc["Cycle.Count"] == count
        assert _shown(plc, "Cycle") == ("RUN", False, True, 0)
        plc.scan()
        assert _shown(plc, "Cycle") == _RUN


def test_run_stays_false_as_long_as_workdone_is_true() -> None:
    """Run stays FALSE as long as WorkDone is TRUE. The work is counted once.

    Source: a rule of this library.
    """
    plc = _running()
    plc["Bare.WorkDone"] = True
    for _ in range(5):
        plc.scan()
        assert _shown(plc) == ("RUN", False, True, 0)
        assert plc["Bare.Count"] == 1
    plc["Bare.WorkDone"] = False
    plc.scan()
    assert _shown(plc) == _RUN


def test_lost_auto_mode_is_a_fault_after_the_running_command() -> None:
    """If AUTO mode is lost, the cycle ends with a fault after the command on the wire has ended.

    The cycle continues only after a new Start.

    Source: head of FB_WorkCycle; errors.md, 16#8006.
    """
    plc = _running("Cycle")
    plc.scan_until(lambda: plc.words[0] != 0)
    plc.outputs(SO10=False)
    plc.scan(20)
    assert _shown(plc, "Cycle") == _RUN, "the command on the wire ends first"
    _end(plc)
    plc.scan(3)
    assert _shown(plc, "Cycle") == _fault(0x8006)
    plc.outputs(SO10=True)
    plc.scan(50)
    assert _shown(plc, "Cycle") == _fault(0x8006)
    assert not any(plc.words)
    plc = _running()
    plc.outputs(SO10=False)
    plc.scan(2)
    assert _shown(plc) == _fault(0x8006)
    _press(plc, "Bare.Reset")
    _press(plc, "Bare.Start")
    plc.scan_until(lambda: bool(plc["Bare.Run"]))
    plc.scan(20)
    assert _shown(plc) == _RUN, "the cycle has begun without its work"


@pytest.mark.parametrize("later", [0, 1, 5])
def test_a_work_that_ends_with_or_after_a_fault_is_counted(later: int) -> None:
    """A work that ends in the scan of a fault, or after it, is counted once.

    A work that ends with an error is not counted.

    Source: comment of Count.
    """
    plc = _running()
    plc.outputs(SO10=False)
    plc.scan(later)
    plc["Bare.WorkDone"] = True
    plc.scan(3)
    assert _shown(plc) == _fault(0x8006)
    assert plc["Bare.Count"] == 1
    plc["Bare.WorkDone"] = False
    plc.scan(2)
    plc["Bare.WorkDone"] = True
    plc.scan(2)
    assert plc["Bare.Count"] == 1
    plc = _running()
    for pin, value in (("WorkErrorID", 0x8059), ("WorkErrorID", 0), ("WorkDone", True)):
        plc[f"Bare.{pin}"] = value
        plc.scan(2)
    assert plc["Bare.Count"] == 0


def test_only_work_that_the_cycle_began_is_counted() -> None:
    """WorkDone is counted only if the cycle has started the work.

    WorkDone in the first call or without a Start is not counted.

    Source: comment of Count.
    """
    plc = _bench()
    plc["Bare.WorkDone"] = True
    plc.scan(3)
    for work_done in (False, True, False, True, False):
        plc["Bare.WorkDone"] = work_done
        plc.scan()
    assert plc["Bare.Count"] == 0


def test_stop_ends_the_cycle_after_the_running_work() -> None:
    """Source: a rule of this library."""
    plc = _running("Cycle")
    plc.scan_until(lambda: plc.words[0] != 0)
    _press(plc, "Cycle.Stop")
    plc.scan(50)
    assert _shown(plc, "Cycle") == _STOP
    _end(plc)
    plc.scan(50)
    assert _shown(plc, "Cycle") == _IDLE
    assert plc["Cycle.Count"] == 1
    assert plc.words[0] == 0
    _press(plc, "Cycle.Start")
    plc.scan_until(lambda: bool(plc["Cycle.Run"]))
    plc.scan(20)
    assert _shown(plc, "Cycle") == _RUN, "the stop belonged to the last cycle"


def test_start_cancels_a_stop_after_stop_was_released() -> None:
    """Source: a rule of this library."""
    plc = _running()
    _press(plc, "Bare.Stop")
    assert _shown(plc) == _STOP
    _press(plc, "Bare.Start")
    assert _shown(plc) == _RUN
    plc["Bare.Stop"] = True
    _press(plc, "Bare.Start")
    assert _shown(plc) == _STOP


def test_after_stop_the_cycle_is_idle_in_the_scan_of_workdone() -> None:
    """Source: a rule of this library."""
    plc = _running()
    _press(plc, "Bare.Stop")
    plc["Bare.WorkDone"] = True
    plc.scan()
    assert _shown(plc) == _IDLE


def test_after_a_stop_between_two_works_no_work_begins() -> None:
    """Source: a rule of this library."""
    plc = _running()
    plc["Bare.WorkDone"] = True
    plc.scan()
    plc["Bare.WorkDone"] = False
    _press(plc, "Bare.Stop")
    assert _shown(plc) == _IDLE


@pytest.mark.parametrize("when", ["before", "meanwhile"])
def test_after_a_stop_during_power_up_no_work_begins(when: str) -> None:
    """After a Stop during power-up, no work begins. A Start while Stop is TRUE has no effect.

    Source: a rule of this library.
    """
    plc = _bench()
    plc["Bare.Stop"] = when == "before"
    _press(plc, "Bare.Start")
    assert _shown(plc)[0] == ("IDLE" if when == "before" else "POWER_UP")
    plc["Bare.Stop"] = True
    for _ in range(50):
        plc.scan()
        assert not plc["Bare.Run"]
    assert _shown(plc) == _IDLE


def test_the_first_fault_is_shown_until_reset_and_then_start_works_again() -> None:
    """The first fault is shown until Reset. Afterwards Start works again.

    Source: guide 1.2, abnormal end; a rule of this library: nothing restarts by itself.
    """
    plc = _running("Cycle")
    _end(plc, 0x4000)
    plc.scan()
    assert _shown(plc, "Cycle") == _fault(0x8020)
    alarm = plc["Cycle.AlarmGroup"], plc["Cycle.AlarmCategory"]
    assert alarm == (12, 600)
    plc["Connected"] = False
    plc.scan(30)
    plc["Connected"] = True
    plc.scan(30)
    _press(plc, "Cycle.Start")
    assert _shown(plc, "Cycle") == _fault(0x8020), "a later error is not the first one"
    assert (plc["Cycle.AlarmGroup"], plc["Cycle.AlarmCategory"]) == alarm
    _press(plc, "Cycle.Reset")
    plc.scan(50)
    assert _shown(plc, "Cycle") == _IDLE
    assert (plc["Cycle.AlarmGroup"], plc["Cycle.AlarmCategory"]) == (0, 0)
    _press(plc, "Cycle.Start")
    plc.scan_until(lambda: bool(plc["Cycle.Run"]))


def test_a_later_error_of_the_work_does_not_replace_the_first() -> None:
    """Source: a rule of this library."""
    plc = _running()
    for error_id, group in ((0x8020, 1), (0x8059, 2), (0x8020, 3), (0, 4)):
        plc["Bare.WorkErrorID"], plc["Bare.WorkAlarmGroup"] = error_id, group
        plc.scan()
        assert _shown(plc) == _fault(0x8020)
        assert plc["Bare.AlarmGroup"] == 1


def test_reset_acts_only_with_its_edge_in_a_safe_cell() -> None:
    """Reset acts only on its rising edge and while the cell is safe.

    Source: a rule of this library.
    """
    plc = _running()
    plc["Bare.WorkErrorID"] = 0x8011
    plc["Bare.Reset"] = True
    plc.scan(2)
    plc["Bare.WorkErrorID"] = 0
    plc.scan(2)
    assert _shown(plc) == _fault(0x8011), "the button was pressed before the fault"
    plc["Bare.Reset"] = False
    plc["EmergencyStopOk"] = False
    plc.scan()
    plc["Bare.Reset"] = True
    plc.scan()
    plc["EmergencyStopOk"] = True
    plc.scan(2)
    assert _shown(plc) == _fault(0x8011)
    plc["Bare.Reset"] = False
    plc.scan()
    plc["Bare.Reset"] = plc["Bare.Start"] = True
    plc.scan(2)
    assert _shown(plc) == _IDLE, "Start is a separate button"


@pytest.mark.parametrize("state", ["POWER_UP", "RUN", "STOP"])
def test_reset_without_a_fault_does_nothing(state: str) -> None:
    """Source: a rule of this library."""
    plc = _bench() if state == "POWER_UP" else _running()
    if state == "POWER_UP":
        plc.outputs(SO02=False)
        plc.scan(20)
        _press(plc, "Bare.Start")
    elif state == "STOP":
        _press(plc, "Bare.Stop")
    before = _shown(plc)
    assert before[0] == state
    _press(plc, "Bare.Reset")
    assert _shown(plc) == before


def test_reset_acknowledges_an_error_shown_in_the_same_scan() -> None:
    """Reset also acknowledges an error of the work that is shown in the same scan.

    If the work is called after the cycle, the cycle reads the end of the work one scan later.

    Source: a rule of this library.
    """
    plc = _running()
    plc["Bare.WorkErrorID"] = 0x8059
    plc.scan()
    plc["Bare.Reset"] = True
    plc.scan()
    assert _shown(plc) == _IDLE
    plc.scan()
    assert _shown(plc) == _fault(0x8059), "an error that stays is still shown"


def test_an_error_of_the_work_is_a_fault_in_every_state() -> None:
    """An error of the work is a fault in every state: the work may end long after its cycle.

    Source: a rule of this library.
    """
    plc = _bench()
    plc["Bare.WorkErrorID"] = 0x8011
    plc.scan()
    assert _shown(plc) == _fault(0x8011)


@pytest.mark.parametrize(
    ("cause", "error_id"), [("link", 0x8001), ("SO01", 0x8002), ("cell", 0x8003)]
)
@pytest.mark.parametrize("when", ["before", "meanwhile"])
def test_a_start_without_link_or_cell_is_a_fault(cause: str, error_id: int, when: str) -> None:
    """A start without a link or a safe cell is a fault and is not delayed.

    A closing door or a plugged cable must not start the robot.

    Source: a rule of this library.
    """
    plc = _bench()
    plc.outputs(SO02=False)
    plc.scan(20)
    if when == "meanwhile":
        _press(plc, "Bare.Start")
        assert _shown(plc)[0] == "POWER_UP"
    if cause == "SO01":
        plc.outputs(SO01=False)
    else:
        plc["Connected" if cause == "link" else "EmergencyStopOk"] = False
    if when == "before":
        plc["Bare.Start"] = True
    plc.scan()
    assert _shown(plc) == _fault(error_id)
    assert when == "meanwhile" or not plc["Bare.Powering.Busy"], (
        "a later start is not delayed either"
    )
    plc.outputs(SO01=True)
    plc["Connected"] = plc["EmergencyStopOk"] = True
    plc.scan(100)
    assert _shown(plc) == _fault(error_id)


def test_a_power_up_that_fails_is_a_fault() -> None:
    """Source: manual chapter 5, 3.1; FB_PowerUp: MP RDY stays OFF for its Timeout of 60 s."""
    plc = _bench()
    plc.outputs(SO02=False, SO04=False)
    plc.scan(20)
    _press(plc, "Bare.Start")
    plc.scan(5900)
    assert _shown(plc)[0] == "POWER_UP"
    plc.scan(200)
    assert _shown(plc) == _fault(0x8005)


@pytest.mark.parametrize("back", [True, False])
def test_a_power_up_that_ends_after_its_cycle_starts_no_work(back: bool) -> None:
    """A power-up that ends after its cycle starts no work.

    If the link is lost at once, the power-up waits for at most 60 s.

    Source: a rule of this library.
    """
    plc = _bench()
    plc["Bare.Start"] = True
    plc.scan()
    plc["Bare.Start"] = plc["Connected"] = False
    plc.scan(5)
    plc["Bare.WorkErrorID"] = 0x8058
    plc["Connected"] = back
    plc.scan(100 if back else 6100)
    assert _shown(plc) == _fault(0x8001)
    assert not plc["Bare.Powering.Busy"]


@pytest.mark.exhaustive
def test_a_later_failure_of_the_power_up_does_not_replace_the_first_fault() -> None:
    """Source: a rule of this library."""
    plc = _bench()
    plc.outputs(SO02=False, SO04=False)
    plc.scan(20)
    _press(plc, "Bare.Start")
    plc["Bare.WorkErrorID"] = 0x8058
    plc.scan(6100)
    assert plc["Bare.Powering.Busy"] is False
    assert _shown(plc) == _fault(0x8058)


@pytest.mark.parametrize("cause", ["link", "SO01", "SO02"])
def test_a_lost_link_while_the_cycle_is_idle_is_not_a_fault(cause: str) -> None:
    """A lost link while the cycle is idle is not a fault: only the work needs the connection.

    Source: a rule of this library.
    """
    plc = _bench()
    if cause == "link":
        plc["Connected"] = False
    else:
        plc.outputs(**{cause: False})
    plc.scan(200)
    assert _shown(plc) == _IDLE


@pytest.mark.parametrize(("cause", "error_id"), [("link", 0x8001), ("SO01", 0x8002)])
def test_a_lost_controller_is_always_a_fault(cause: str, error_id: int) -> None:
    """Source: manual chapter 1, 5.2."""
    plc = _running()
    _press(plc, "Bare.Stop")
    if cause == "link":
        plc["Connected"] = False
    else:
        plc.outputs(SO01=False)
    plc.scan()
    assert _shown(plc) == _fault(error_id)


def test_lost_servos_are_a_fault_at_once_if_no_command_runs() -> None:
    """If the servos turn OFF while no command runs, the cycle reports a fault at once.

    The work may be waiting for another robot. Source: manual chapter 5, 3.1.
    """
    plc = _running()
    plc["EmergencyStopOk"] = False
    plc.scan(20)
    assert _shown(plc) == _RUN, "the servos count, not the reason"
    plc.outputs(SO02=False)
    plc.scan()
    assert _shown(plc) == _fault(0x800C)


def test_if_servos_are_lost_during_a_command_its_alarm_is_reported() -> None:
    """If the servos turn OFF during a command, the cycle reports the alarm of the command (12.600).

    Source: guide 1.2.
    """
    plc = _running("Cycle")
    plc.scan_until(lambda: plc.words[0] != 0)
    plc.outputs(SO02=False)
    plc.scan(20)
    assert _shown(plc, "Cycle") == _RUN
    _end(plc, 0x4000)
    plc.scan()
    assert _shown(plc, "Cycle") == _fault(0x8020)


def test_during_a_command_of_another_block_lost_servos_are_reported_after_a_second() -> None:
    """If a command of another block runs, lost servos are reported after one second.

    An example is a continuous output of the position. Source: a rule of this library.
    """
    plc = _running()
    plc["Other.Execute"] = True
    plc.scan_until(lambda: plc.words[0] != 0)
    plc.scan(300)
    plc.outputs(SO02=False)
    plc.scan(99)
    assert _shown(plc) == _RUN
    plc.scan(3)
    assert _shown(plc) == _fault(0x800C)


def test_the_count_does_not_overflow() -> None:
    """Source: IEC 61131-3: DINT is up to 2147483647."""
    plc = _running()
    plc["Bare.Count"] = 2_147_483_646
    for count in (2_147_483_647, 2_147_483_647):
        plc["Bare.WorkDone"] = True
        plc.scan()
        plc["Bare.WorkDone"] = False
        plc.scan()
        assert plc["Bare.Count"] == count


def test_a_start_that_is_true_in_the_first_scan_is_ignored() -> None:
    """A Start that is TRUE in the first scan has no effect.

    The button may be stuck, or held during a restart of the PLC. Nothing starts by itself.

    Source: head of FB_WorkCycle; FB_Operator treats its keys in this way.
    """
    plc = PlcBench(program=ROOT / "tests/data/library/WorkCycle.st")
    plc["Bare.Start"] = True
    plc.outputs(SO02=True)
    plc.power_up()
    for _ in range(50):
        assert _shown(plc) == _IDLE
        plc.scan()
    plc["Bare.Start"] = False
    plc.scan()
    _press(plc, "Bare.Start")
    plc.scan_until(lambda: bool(plc["Bare.Run"]))
