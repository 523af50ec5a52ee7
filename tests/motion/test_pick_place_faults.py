"""FB_PickPlace ends at events that stop the robot, before, between and during its commands."""

from __future__ import annotations

import pytest

from both_engines import ENGINES
from pick_bench import PickBench, picking

_PLAIN = ["DO(20) OFF", "PTP 10 at 50", "DO(20) ON", "PTP 20 at 50", "DO(20) OFF"]
_ASKING = ["DI2?", "DO(20) OFF", "DI2?", "PTP 10 at 50", "DO(20) ON", "DI2?", "PTP 20 at 50"]
_ASKING += ["DI2?", "DO(20) OFF", "DI2?"]
#: Maps a condition that is not met to its ErrorID.
_FAULTS = [
    *(("StopOk", False, 0x8007), ("SafeOk", False, 0x8003), ("SO00", True, 0x8003)),
    *(("SO03", True, 0x8004), ("SO02", False, 0x800C), ("SO01", False, 0x8002)),
    ("Connected", False, 0x8001),
]
#: Events that end the block if it was started in AUTO mode. A start in MANUAL mode is possible.
_ENDS = [*_FAULTS, ("SO10", False, 0x8006)]
#: Indices of _ASKING for the quick tier: a reading of inputs, an output and a movement.
_PLACES = [
    pytest.param(place, marks=[] if place in (0, 1, 3) else pytest.mark.exhaustive)
    for place in range(len(_ASKING))
]


def _set(plc: PickBench, name: str, value: bool) -> None:
    if name.startswith("SO"):
        plc.outputs(**{name: value})
    else:
        plc[name] = value


def _for_one_scan(plc: PickBench, name: str, value: bool) -> None:
    _set(plc, name, value)
    plc.scan()
    _set(plc, name, not value)
    if name.endswith("Ok"):
        plc.scan()  # this is a pin of FB_WriteArea, which is called after the blocks


def _let_another_command_out(plc: PickBench) -> None:
    """Send an endless command of another block, so the next command of FB_PickPlace waits."""
    plc["Other.Execute"] = True
    plc.scan_until(lambda: plc.told[-1:] == ["date"], most=20)
    plc.scan(5)


def _let_that_command_end(plc: PickBench) -> None:
    plc.scan(3)
    plc.answer(0x0200)
    plc["Other.Execute"], plc.silent = False, ""


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(("name", "value", "error"), _ENDS)
def test_a_fault_between_commands_ends_the_block(
    engine: str, name: str, value: bool, error: int
) -> None:
    """A fault between two commands ends the block, and nothing continues after the fault.

    Source: manual chapter 5, 3.1 and 3.3; design of the library, 2
    """
    plc = picking(engine, Gripper__Settle="T#1s")
    plc.until("DO(20) ON")
    plc.scan(20)
    assert plc.end == ("Busy", 0, "PICK_CLOSE", False)
    _for_one_scan(plc, name, value)
    assert plc.end == ("Error", error, "PICK_CLOSE", False)
    plc.scan(300)
    assert plc.told[-1] == "DO(20) ON"
    assert plc.work() == ["DO2?", *_PLAIN[2:]]


@pytest.mark.parametrize(("name", "value", "error"), _FAULTS)
def test_no_work_begins_during_a_fault(name: str, value: bool, error: int) -> None:
    """Source: manual chapter 5, 3.1 and 3.3."""
    plc = picking()
    _set(plc, name, value)
    plc.scan(3)
    assert plc.work() == []
    assert plc.end == ("Error", error, "PICK_EMPTY", False)


@pytest.mark.parametrize(("name", "value", "error"), [*_FAULTS[:5], _ENDS[-1]])
@pytest.mark.parametrize(
    ("out", "stage"), [("DO(20) ON", "CLOSE"), ("PTP 10 at 50", "CLOSE"), ("DI2?", "EMPTY")]
)
def test_a_fault_ends_the_block_after_the_running_command(
    out: str, stage: str, name: str, value: bool, error: int
) -> None:
    """A fault during a command ends the block after the command, even if the fault is over.

    The block remembers the effect of the command.

    Source: remote command guide chapter 2: no command can be taken back
    """
    plc = picking(Gripper__PartInput=21, Gripper__Settle="T#100ms")
    plc.follows = {21: 20}
    plc.silent = out
    plc.until(out)
    plc.scan(2)
    _for_one_scan(plc, name, value)
    plc.scan(20)
    assert (plc.end[0], plc["Pick.Active"]) == ("Busy", True)
    plc.silent = ""
    plc.answer(0x0200, [0, 0x0200, 0])
    plc.scan_until(lambda: not plc["Pick.Busy"], most=4)
    assert plc.end[:2] == ("Error", error)
    assert plc.end[2] in (f"PICK_{stage}", "PICK_OPEN")
    plc.scan(100)
    assert plc.told[-1] == out


@pytest.mark.parametrize(("name", "value", "error"), _ENDS)
@pytest.mark.parametrize("place", _PLACES)
def test_a_command_that_waits_for_its_turn_is_withdrawn(
    place: int, name: str, value: bool, error: int
) -> None:
    """A stop withdraws a command that waits, so that it is not sent after the stop.

    Source: docs/explanation/scan-model.md; manual chapter 5, 3.1 and 3.3
    """
    plc = picking(Gripper__PartInput=21)
    plc.follows = {21: 20}
    plc.silent = "date"
    if place:
        plc.start()
        plc.scan_until(lambda: plc.told == _ASKING[:place], most=600)
    plc["Other.Execute"] = True
    if not place:
        plc.start()
    plc.scan_until(lambda: plc.told[-1:] == ["date"], most=20)
    plc.scan(5)
    assert (plc.end[0], plc["Pick.Active"]) == ("Busy", False)
    _for_one_scan(plc, name, value)
    assert plc.end[:2] == ("Error", error)
    stage = plc.end[2]
    plc.scan(3)
    plc.answer(0x0200)
    plc.scan(100)
    assert plc.told == [*_ASKING[:place], "date"]
    assert plc.end[1:3] == (error, stage)
    plc["Other.Execute"], plc.silent = False, ""
    assert plc.work()[-1] == "DI2?"
    assert plc.end == ("Done", 0, "PICK_START", False)


@pytest.mark.parametrize("restart", [False, True])
@pytest.mark.parametrize("again", [0, 1])
def test_a_second_call_in_the_scan_of_an_error_sends_nothing(again: int, restart: bool) -> None:
    """After an error, a second call in the same scan sends no command.

    A call or a new edge in the next scan does not send a command either.

    Source: scan-model.md, one scan.
    """
    plc = picking()
    plc.silent = "date"
    plc.until("DO(20) OFF")
    _let_another_command_out(plc)
    plc["Pick.Execute"] = not restart
    plc.scan()
    plc["StopOk"] = False
    plc.scan()
    plc["Twice"] = again == 0
    plc["Pick.Execute"] = not restart or again == 0
    plc.scan()
    assert plc["Pick.ErrorID"] == 0x8007 or restart
    plc["Twice"] = again == 1
    plc["Pick.Execute"] = True
    plc.scan()
    plc["Twice"] = False
    plc.answer(0x0200)
    plc.scan(60)
    assert plc.told == ["DO(20) OFF", "date"]


@pytest.mark.parametrize("engine", ENGINES)
def test_a_movement_begins_when_the_stop_inputs_have_settled(engine: str) -> None:
    """A movement begins only after the stop inputs have been ON for the interval.

    Before that, the controller would refuse the movement or stop it at once.

    Source: manual chapter 5, 3.3; RCX_REF.Settled
    """
    plc = picking(engine)
    plc["StopOk"] = False
    plc.scan(30)
    plc["StopOk"] = True
    plc.start()
    while plc.told[-1:] != ["PTP 10 at 50"]:
        unsettled = not plc["Robot.Settled"]
        assert plc.end[0] == "Busy"
        plc.scan()
    assert not unsettled
    assert "SI06" in plc.inputs
    plc.scan_until(lambda: not plc["Pick.Busy"], most=300)
    assert plc.told == _PLAIN


@pytest.mark.parametrize("engine", ENGINES)
def test_a_close_command_that_was_not_sent_is_repeated_only_at_the_source(engine: str) -> None:
    """If a close command was not sent, the next start opens the hand and returns to the source.

    The robot may be at any place by then.

    Source: head of FB_PickPlace: before a close went out
    """
    plc = picking(engine)
    plc.silent = "date"
    plc.until("PTP 10 at 50")
    _let_another_command_out(plc)
    assert plc.end == ("Busy", 0, "PICK_CLOSE", False)
    _for_one_scan(plc, "SO00", True)
    assert plc.end == ("Error", 0x8003, "PICK_CLOSE", False)
    _let_that_command_end(plc)
    plc.scan(50)
    assert plc.work() == _PLAIN


@pytest.mark.parametrize(("name", "value"), [("SO00", True), ("StopOk", False)])
def test_a_part_that_falls_before_the_release_was_sent_is_lost(name: str, value: bool) -> None:
    """A part that is missing before the release was sent is reported as lost.

    After the release was sent, a missing part is not an error, because it is at the target.

    Source: docs/reference/errors.md, 16#8059
    """
    plc = picking(Gripper__PartInput=21)
    plc.follows = {21: 20}
    plc.silent = "date"
    plc.until("PTP 20 at 50")
    plc.until("DI2?")
    _let_another_command_out(plc)
    assert plc.end == ("Busy", 0, "PICK_RELEASE", True)
    _for_one_scan(plc, name, value)
    _let_that_command_end(plc)
    plc.follows = {}
    plc.scan(50)
    assert plc.work() == ["DO2?", "DI2?"]
    assert plc.end == ("Error", 0x8059, "PICK_START", False)


@pytest.mark.parametrize("part", [True, False])
def test_after_a_sent_release_the_hand_may_be_empty(part: bool) -> None:
    """After a release was sent, the next start opens the hand at the target again.

    The part sensor has no effect.

    Source: head of FB_PickPlace
    """
    plc = picking(Gripper__PartInput=21, Gripper__MaxWait="T#100ms")
    plc.follows = {21: 20}
    plc.until("PTP 20 at 50")
    plc.follows, plc.inputs_on = {}, {21}
    plc.scan_until(lambda: not plc["Pick.Busy"], most=300)
    assert plc.end == ("Error", 0x805B, "PICK_RELEASE", True)
    plc.inputs_on = {21} if part else set()
    found = plc.work()
    assert found[:3] == ["DO2?", "PTP 20 at 50", "DO(20) OFF"]
    assert plc.end[0] == ("Error" if part else "Done")


def test_the_block_can_start_in_manual_mode_and_ignores_the_mode() -> None:
    """Source: docs/explanation/fidelity.md, program-mode: remote commands work in both modes."""
    plc = picking()
    plc.outputs(SO10=False)
    plc.scan()
    plc.until("DO(20) OFF")
    for auto in (True, False):
        plc.outputs(SO10=auto)
        plc.scan(3)
    plc.scan_until(lambda: not plc["Pick.Busy"], most=300)
    assert plc.told == _PLAIN


def test_a_start_in_the_scan_of_an_error_is_refused() -> None:
    """A start in the scan of an error is refused while the earlier command still waits.

    Source: docs/reference/errors.md, 16#8016
    """
    plc = picking()
    plc.silent = "date"
    plc.until("DO(20) OFF")
    plc["Other.Execute"] = True
    plc.scan_until(lambda: plc.told[-1:] == ["date"], most=20)
    plc["Pick.Execute"] = False
    plc.scan(5)
    plc["StopOk"] = False
    plc.scan()
    plc["StartAgain"] = True
    plc.scan()
    plc["StartAgain"] = False
    plc["StopOk"] = True
    plc.scan()
    assert plc.end[:2] == ("Error", 0x8016)
    plc.answer(0x0200)
    plc.scan(60)
    assert plc.told == ["DO(20) OFF", "date"]
