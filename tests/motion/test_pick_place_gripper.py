"""FB_PickPlace controls grippers with one or two outputs, and detects lost or missing parts."""

from __future__ import annotations

from functools import cache
from typing import Any

import pytest

from alone import Alone
from pick_bench import PickBench


def _bench(**pins: Any) -> PickBench:
    return PickBench(SourcePoint=10, TargetPoint=20, **pins)


@cache
def _made(name: str) -> Alone:
    return Alone(name, {"Robot": "RCX_REF"}, "builtin")


def _part(name: str) -> Alone:
    """Return a sub-block of FB_PickPlace alone, with a controller that is ready."""
    block = _made(name)
    block.restart()
    for path in ("Connected", "SO.SO01_CpuOk"):
        block[f"Robot.{path}"] = True
    return block


def _ports(told: list[str]) -> list[str]:
    return [text for text in told if text.startswith("D")]


def test_with_two_outputs_one_turns_off_before_the_other_turns_on() -> None:
    """Source: guide 4.5.1: DO(34) is port 3 bit 4, DO(177) port 17 bit 7."""
    plc = _bench(Gripper__CloseOutput=34, Gripper__OpenOutput=177)
    opened = ["DO(34) OFF", "DO(177) ON"]
    assert _ports(plc.work()) == [*opened, "DO(177) OFF", "DO(34) ON", *opened]
    assert plc.end[0] == "Done"


def test_each_wired_input_confirms_a_state_of_the_hand() -> None:
    """Each input that is wired confirms a state of the hand: open, closed, or with a part.

    Source: guide 4.5.1, reference of DI in port units.
    """
    plc = _bench(
        Gripper__OpenOutput=21,
        Gripper__OpenedInput=32,
        Gripper__ClosedInput=43,
        Gripper__PartInput=54,
    )
    plc.follows = {32: 21, 43: 20, 54: 20}
    opened = ["DO(20) OFF", "DO(21) ON", "DI3?", "DI5?"]
    closed = ["DO(21) OFF", "DO(20) ON", "DI4?", "DI5?"]
    assert _ports(plc.work()) == ["DI5?", *opened, *closed, "DI5?", *opened]
    assert plc.end[0] == "Done"


def test_after_an_error_both_outputs_are_read() -> None:
    """After an error, both outputs of the hand are read, the closing output first.

    This holds even if reading the opening output had no answer.

    Source: guide 4.5.1, I/O port reference; head of FB_PickPlace
    """
    plc = _bench(Gripper__OpenOutput=31)
    plc.refuses = "PTP 20"
    plc.work()
    assert plc.end == ("Error", 0x8020, "PICK_TO_TARGET", True)
    plc.refuses = "DO3?"
    assert plc.work() == ["DO2?", "DO3?"]
    assert plc.end == ("Error", 0x8020, "PICK_CHECK", True)
    assert plc.work() == ["DO2?", "DO3?", "PTP 20", "DO(20) OFF", "DO(31) ON"]
    assert plc.end[0] == "Done"


def test_a_hand_that_did_not_open_at_the_target_is_opened_there_again() -> None:
    """If the hand does not open at the target, the next start opens it there again.

    The part in the hand was gripped at the source. Source: docs/reference/errors.md, 16#805A.
    """
    plc = _bench(Gripper__OpenedInput=43, Gripper__MaxWait="T#100ms")
    plc.inputs_on = {43}
    plc.until("PTP 20")
    plc.inputs_on = set()
    plc.scan_until(lambda: not plc["Pick.Busy"], most=100)
    assert plc.end == ("Error", 0x805A, "PICK_RELEASE", True)
    plc.inputs_on = {43}
    assert plc.work() == ["DO2?", "PTP 20", "DO(20) OFF", "DI4?"]
    assert plc.end[0] == "Done"


def test_the_block_waits_until_the_gripper_has_moved() -> None:
    """Source: a rule of this library."""
    plc = _bench(Gripper__ClosedInput=43, Gripper__MaxWait="T#1s")
    plc.until("DO(20) ON")
    plc.scan(60)
    assert plc.end == ("Busy", 0, "PICK_CLOSE", False)
    assert plc.told.count("DI4?") > 5
    plc.inputs_on = {43}
    plc.scan_until(lambda: plc["Pick.Stage"] == "PICK_TO_TARGET", most=12)
    assert plc["Pick.Holds"]


@pytest.mark.parametrize(
    ("pin", "closes", "error_id", "stage"),
    [
        ("OpenedInput", False, 0x805A, "PICK_OPEN"),
        ("ClosedInput", True, 0x805A, "PICK_CLOSE"),
        ("PartInput", True, 0x8058, "PICK_START"),
    ],
)
@pytest.mark.parametrize(("limit", "scans"), [("T#500ms", 50), ("T#0s", 200)])
def test_the_wait_for_an_input_ends_after_max_wait(
    pin: str, closes: bool, error_id: int, stage: str, limit: str, scans: int
) -> None:
    """The wait for an input of the hand ends with an error after MaxWait (2 s by default).

    The controller answers every few scans.

    Source: a rule of this library.
    """
    plc = _bench(Gripper__MaxWait=limit)
    plc[f"Pick.Gripper.{pin}"] = 25
    plc.until("DO(20) ON" if closes else "DO(20) OFF")
    took = plc.scan_until(lambda: not plc["Pick.Busy"], most=300)
    assert scans <= took <= scans + 12
    assert plc.end == ("Error", error_id, stage, False)


def test_a_part_that_was_not_gripped_is_fetched_again() -> None:
    """Source: a rule of this library."""
    plc = _bench(Gripper__PartInput=21, Gripper__MaxWait="T#100ms")
    plc.work()
    assert plc.end == ("Error", 0x8058, "PICK_START", False)
    plc.until("PTP 10")
    assert plc.told[-4:] == ["DI2?", "DO(20) OFF", "DI2?", "PTP 10"]
    plc.follows = {21: 20}
    plc.scan_until(lambda: not plc["Pick.Busy"], most=100)
    assert plc.end == ("Done", 0, "PICK_START", False)


def test_a_hand_with_a_part_is_not_opened_at_the_start() -> None:
    """If the hand has a part at the start, the block does not open it and reports an error.

    This can happen after a restart of the PLC.

    Source: a rule of this library.
    """
    plc = _bench(Gripper__PartInput=21)
    plc.inputs_on = {21}
    assert plc.work() == ["DI2?"]
    assert plc.end == ("Error", 0x805B, "PICK_EMPTY", False)
    plc.inputs_on = set()
    plc.follows = {21: 20}
    assert plc.work()[:2] == ["DI2?", "DO(20) OFF"]
    assert plc.end[0] == "Done"


def test_a_part_that_sticks_to_the_open_hand_is_an_error() -> None:
    """Source: a rule of this library."""
    plc = _bench(Gripper__PartInput=21, Gripper__MaxWait="T#100ms")
    plc.follows = {21: 20}
    plc.until("PTP 20")
    plc.inputs_on = {21}
    plc.scan_until(lambda: not plc["Pick.Busy"], most=100)
    assert plc.end == ("Error", 0x805B, "PICK_RELEASE", True)
    plc.inputs_on = set()
    assert plc.work() == ["DO2?", "PTP 20", "DO(20) OFF", "DI2?"]


@pytest.mark.parametrize("above", [0, 3])
def test_a_part_that_is_lost_on_the_way_is_an_error_before_the_hand_opens(above: int) -> None:
    """Source: a rule of this library."""
    plc = _bench(Gripper__PartInput=21, Shifts__SourceAbove=above)
    plc.follows = {21: 20}
    plc.until("DO(20) ON")
    plc.scan_until(lambda: bool(plc["Pick.Holds"]))
    plc.follows = {}
    plc.scan_until(lambda: not plc["Pick.Busy"], most=100)
    assert plc.end == ("Error", 0x8059, "PICK_START", False)
    assert ("PTP 20" in plc.told) is (above == 0), "the block reads the sensor after lifting"
    plc.until("PTP 10")
    assert "DO(20) OFF" in plc.told[-4:], "the block begins with a new part"


def test_before_continuing_with_a_part_the_sensor_is_read() -> None:
    """Source: a rule of this library."""
    plc = _bench(Gripper__PartInput=21)
    plc.follows = {21: 20}
    plc.refuses = "PTP 20"
    plc.work()
    assert plc.end == ("Error", 0x8020, "PICK_TO_TARGET", True)
    plc.follows = {}
    assert plc.work() == ["DO2?", "DI2?"]
    assert plc.end == ("Error", 0x8059, "PICK_START", False)


def test_a_sensor_at_the_plc_ends_the_block_after_the_movement() -> None:
    """A part sensor wired to the PLC ends the block after the movement that is running.

    A command cannot be withdrawn after it has been sent.

    Source: guide 1.2; a rule of this library.
    """
    plc = _bench()
    plc.silent = "PTP 20"
    plc.until("PTP 20")
    plc["Pick.PartLost"] = True
    plc.scan()
    plc["Pick.PartLost"] = False
    plc.scan(20)
    assert plc.end == ("Busy", 0, "PICK_TO_TARGET", True)
    plc.silent = ""
    plc.answer(0x0200)
    plc.scan_until(lambda: not plc["Pick.Busy"])
    assert plc.end == ("Error", 0x8059, "PICK_START", False)
    assert plc.told[-1] == "PTP 20"
    assert plc.work()[:2] == ["DO(20) OFF", "PTP 10"]
    assert plc.end[0] == "Done", "the error is reported once"


def test_a_sensor_at_the_plc_is_checked_only_while_a_part_is_carried() -> None:
    """Source: a rule of this library."""
    plc = _bench()
    plc["Pick.PartLost"] = True
    plc.until("DO(20) ON")
    plc["Pick.PartLost"] = False
    plc.until("DO(20) OFF")
    plc["Pick.PartLost"] = True
    plc.scan_until(lambda: not plc["Pick.Busy"])
    assert plc.end == ("Done", 0, "PICK_START", False)
    plc["Pick.PartLost"] = False
    plc.refuses = "PTP 20"
    plc.work()
    plc["Pick.PartLost"] = True
    plc.scan(5)
    plc["Pick.PartLost"] = False
    assert plc.work() == ["DO2?", "PTP 20", "DO(20) OFF"], (
        "the sensor is not read while the robot stands either"
    )


def test_the_settle_time_ends_before_the_sensor_is_read() -> None:
    """Source: a rule of this library."""
    plc = _bench(Gripper__Settle="T#300ms", Gripper__ClosedInput=43)
    plc.inputs_on = {43}
    plc.until("DO(20) ON")
    assert 30 <= plc.scan_until(lambda: plc.told[-1] == "DI4?") <= 36
    plc["Pick.Gripper.Settle"] = "T#-1s"
    plc.scan_until(lambda: not plc["Pick.Busy"], most=100)
    plc.until("DO(20) ON")
    assert plc.scan_until(lambda: plc.told[-1] == "DI4?") <= 6


@pytest.mark.parametrize("silent", ["DI4?", "DO(20) ON"])
def test_a_failed_port_command_ends_the_block_with_its_alarm(silent: str) -> None:
    """Source: guide 1.2, abnormal end."""
    plc = _bench(Gripper__ClosedInput=43)
    plc.refuses = silent
    plc.work()
    assert plc.end == ("Error", 0x8020, "PICK_CLOSE", False)
    assert (plc["Pick.AlarmGroup"], plc["Pick.AlarmCategory"]) == (12, 600)


@pytest.mark.parametrize("go", [False, True])
@pytest.mark.parametrize("number", [-1, 8, 19, 21])
def test_the_block_that_reads_inputs_refuses_an_illegal_bit(go: bool, number: int) -> None:
    """FB_PickPlace refuses an illegal bit itself. This check is for other callers.

    Source: guide 4.5.1: bits are 0 to 7
    """
    block = _part("FB_RcxAwaitInput")
    for path, value in (("Go", go), ("Number", number)):
        block[f"Block.{path}"] = value
    block.scan(0)
    legal = number == 21
    assert block["Block.ErrorID"] == (0x8044 if go and not legal else 0)
    assert block["Block.Busy"] is (go and legal)


def _look() -> Alone:
    """Return the sub-block that reads the outputs of the hand, while it reads."""
    block = _part("FB_RcxPickLook")
    block["Block.Asks"] = True
    return block


def _scan(block: Alone, pattern: int = 0) -> bool:
    """Run a scan.

    `pattern` has the bits of the port, as the answer to a request of the previous scan.
    """
    asked = bool(block["Robot.Inner.CodeRequest"])
    block["Robot.Inner.Phase"] = "PHASE_COMMAND_RUN" if asked else "PHASE_READY"
    block["Robot.Inner.Answer"] = 0x0200 if asked else 0
    block["Robot.Response[3]"] = pattern
    block["Robot.Inner.CodeRequest"] = False
    block.scan(0)
    return bool(block["Block.Passed"])


@pytest.mark.parametrize(
    ("on", "closed", "opened"),
    [({20}, True, False), ({21}, False, True), (set(), False, False), ({20, 21}, False, False)],
)
def test_one_output_closes_and_the_other_opens(on: set[int], closed: bool, opened: bool) -> None:
    """One output closes the hand and the other opens it. If both are equal, its state is unknown.

    Both are OFF after power-on. An earlier reading has no effect.

    Source: RCX_GRIPPER; guide 4.5.1: bit k of the answer is DO(20 + k)
    """
    block = _look()
    block["Block.Gripper.OpenOutput"] = 21
    for pattern in (1, 2, sum(1 << one - 20 for one in on)):
        block["Block.Asks"] = False
        _scan(block)
        block["Block.Asks"] = True
        assert [_scan(block, pattern) for _ in range(5)] == [False, False, False, False, True]
    assert (block["Block.Closed"], block["Block.Opened"]) == (closed, opened)


def test_an_answer_after_asks_has_fallen_is_ignored() -> None:
    """If Asks falls before the answer, the answer is ignored.

    The next reading begins with the closing output.

    Source: FB_RcxPickLook: Asks stays TRUE until Passed or an error
    """
    block = _look()
    _scan(block)
    block["Block.Asks"] = False
    assert not _scan(block, 1)
    assert not block["Block.Busy"]


@pytest.mark.parametrize("asks", [False, True])
@pytest.mark.parametrize("number", [-1, 28, 39])
def test_the_block_that_reads_outputs_refuses_an_illegal_bit(asks: bool, number: int) -> None:
    """FB_PickPlace refuses an illegal bit itself. This check is for other callers.

    Source: guide 4.5.1: bits are 0 to 7
    """
    block = _look()
    block["Block.Asks"], block["Block.Gripper.CloseOutput"] = asks, number
    for _ in range(3):
        _scan(block)
        assert block["Block.ErrorID"] == (0x8044 if asks else 0)
        assert not block["Block.Busy"]


def test_an_output_number_that_becomes_illegal_before_the_answer_is_an_error() -> None:
    """If an output number becomes illegal before the answer, the block reports an error.

    Source: guide 4.5.1: bits are 0 to 7.
    """
    block = _look()
    _scan(block)
    block["Block.Gripper.CloseOutput"] = 28
    _scan(block, 0xFF)
    assert (block["Block.ErrorID"], block["Block.Closed"]) == (0x8044, False)
