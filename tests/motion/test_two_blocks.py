"""A block of several commands ends if another block moves the same robot or its hand."""

from __future__ import annotations

import pytest

from alone import Alone
from both_engines import ENGINES
from part_bench import AWAY, PartBench

_MOVES = (0x001, 0, 0, 0, AWAY)
#: Some commands that move the robot or change the meaning of its points (guide 4.2, 4.6).
_HARMFUL: dict[str, tuple[int, ...]] = {
    "moves": _MOVES,
    "inches": (0x024, 0, 1),
    "returns to the origin": (0x033, 0, 1),
    "switches the servos off": (0x036,),
    "switches the motors": (0x043,),
    "selects a shift": (0x03B, 0, 1),
    "selects a hand": (0x03C, 0, 1),
    "selects an arm": (0x03D, 0, 1),
    "pushes": (0x04B, 0, 0, 0, AWAY),
    "runs programs": (0x402,),
    "resets programs": (0x406,),
    "returns all robots to the origin": (0x032, 0, 0),
}
_HAND: dict[str, tuple[int, ...]] = {
    "switches the hand": (0x301, 0, 0x1020, 1),
    "writes the port of the hand": (0x300, 0, 0x1020, 1),
}
#: Blocks that use a dedicated input to move the robot, or to let a program move it (chapter 5, 2).
_SEQUENCES = {
    "SI12": ("Start", {}),
    "SI15": ("Reset", {}),
    "SI14": ("Origin", {}),
    "SI17": ("Origin", {"Axes": "ORIGIN_ABSOLUTE"}),
}
#: Outputs of the hand, data that another block writes, and whether the data concern the hand. In
#: the data, bits 11 to 4 are tens and units of a port, and bits 3 to 0 are its bit (guide 4.5.1).
_PLACES = [
    ((0, 0), 0x301, 0x1020, True),  # CloseOutput 0 means DO(20)
    ((23, 31), 0x301, 0x1023, True),
    ((23, 31), 0x301, 0x1031, True),
    ((23, 31), 0x301, 0x1020, False),
    ((23, 31), 0x301, 0x1030, False),
    ((23, 31), 0x300, 0x1020, True),
    ((23, 31), 0x300, 0x1030, True),
    ((23, 31), 0x300, 0x1040, False),
    ((23, 31), 0x300, 0x2030, False),  # MO3()
    ((107, 176), 0x301, 0x1107, True),
    ((107, 176), 0x300, 0x1170, True),
    ((107, 176), 0x300, 0x1100, True),
    ((107, 176), 0x301, 0x1077, False),
]
#: Some commands that do not affect the work (guide 4.2 to 4.8).
_HARMLESS: dict[str, tuple[int, ...]] = {
    "reads the position": (0x506,),
    "reads a port": (0x304, 0, 0x0020),
    "switches another output": (0x301, 0, 0x1021, 1),
    "writes another port": (0x300, 0, 0x1030, 255),
    "switches an output of another kind": (0x301, 0, 0x2020, 1),
    "sets the automatic speed": (0x039, 0, 50),
    "sets the manual speed": (0x038, 0, 50),
    "sets the program speed": (0x03A, 0, 50),
    "sets the inching amount": (0x027, 0, 50),
    "teaches a point": (0x028, 0, 100),
    "limits the torque": (0x048, 0, 1),
    "writes a point": (0x100, 0, 100),
    "registers a program": (0x401,),
    "reads the date": (0x511,),
    "moves robot 2": (0x2001, 0, 0, 0, AWAY),
    "returns an axis of robot 2": (0x2033, 0, 1),
}


def _sent(bench: PartBench, count: int) -> None:
    bench["Pick.Execute"] = True
    bench.until(lambda: bench.sent == count)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_foreign_movement_between_two_commands_ends_the_block_before_the_hand_opens(
    engine: str,
) -> None:
    """If another block moves the robot between two commands, FB_PickPlace ends.

    The hand stays closed.

    The hand opens only at the target, after the next Execute.

    Source: design of the library, 3; head of FB_PickPlace
    """
    bench = PartBench(engine)
    _sent(bench, 4)
    bench.send(*_MOVES)
    bench.ends()
    assert bench.end == ("Error", 0x805D, True)
    bench.until(lambda: bench.place == AWAY)
    bench.scan(60)
    assert (bench.held, bench.told[-1]) == (True, "move 30")
    assert bench.work() == "Done"
    assert bench.told[-3:] == ["read DO2", "move 20", "DO(20) OFF"]


@pytest.mark.parametrize("name", _HARMFUL | _HAND)
def test_a_command_that_moves_the_robot_its_points_or_the_hand_ends_the_work(name: str) -> None:
    """A command that moves the robot, its points or the hand ends the work of FB_PickPlace.

    It is sent between source and closing, and between target and release.

    Source: guide 4.2, 4.5.1, 4.6
    """
    for count in (2, 4):
        bench = PartBench()
        _sent(bench, count)
        bench.foreign = True
        bench.send(*(_HARMFUL | _HAND)[name])
        bench.ends()
        assert bench.end[:2] == ("Error", 0x805D)
        assert bench["Pick.Stage"] == ("PICK_CLOSE" if count == 2 else "PICK_RELEASE")
        bench.scan(40)
        assert bench.sent == count + 1


@pytest.mark.parametrize("name", _HARMLESS)
def test_a_command_without_effect_on_the_work_does_not_end_it(name: str) -> None:
    """Source: guide 4.2 to 4.8."""
    bench = PartBench()
    for count in (2, 4):
        _sent(bench, count)
        bench.send(*_HARMLESS[name])
    bench.ends()
    assert bench.end[0] == "Done"
    assert len(bench.told) == 7


def test_blocks_that_read_and_set_the_speed_do_not_end_the_work() -> None:
    """Source: heads of FB_Override and FB_ToolPosition."""
    bench = PartBench()
    for name, value in (("Speed.Percent", 60), ("Speed.Pace", "T#10ms"), ("Place.Period", "T#0s")):
        bench[name] = value
    bench["Speed.Enable"] = bench["Place.Enable"] = True
    for _ in range(3):
        assert bench.work() == "Done"
    assert (bench["Speed.Error"], bench["Place.Error"], bench.delivered) == (False, False, 3)
    assert bench.told.count("506") > 5
    assert bench.told.count("039") >= 2


def test_the_block_waits_for_the_end_of_a_foreign_movement() -> None:
    """If another block moves the robot at the start, the block waits for the end of the movement.

    Source: docs/explanation/scan-model.md, two blocks on one robot
    """
    bench = PartBench()
    bench.send(*_MOVES)
    bench.fault = "late"
    bench.scan(5)
    bench["Pick.Execute"] = True
    bench.scan(30)
    assert (bench.end[0], bench["Pick.Active"], bench.told) == ("Busy", False, [])
    bench.fault = ""
    bench.ends()
    assert (bench.end[0], bench.told[0]) == ("Done", "move 30")


def test_a_switch_of_the_hand_that_ends_in_the_scan_of_the_start_is_harmless() -> None:
    """If another block switches the hand until the scan of the start, the block works normally.

    Source: scan-model.md, two blocks.
    """
    bench = PartBench()
    bench.foreign = True
    bench.send(0x301, 0, 0x1020, 0)
    bench.until(lambda: bench.told == ["DO(20) OFF"])
    assert bench.plc.words[0] == 0x301
    bench["Pick.Execute"] = True
    bench.scan()
    bench.ends()
    assert (bench.end[0], bench.delivered) == ("Done", 1)


@pytest.mark.parametrize("signal", _SEQUENCES)
def test_a_start_input_that_turns_on_ends_the_block(signal: str) -> None:
    """If a dedicated input starts or resets a program or a return-to-origin, the block ends.

    Source: manual chapter 5, 2.1: SI(12), SI(14), SI(15), SI(17)
    """
    bench = PartBench()
    _sent(bench, 4)
    bench.fault = "late"
    block, pins = _SEQUENCES[signal]
    for pin, value in pins.items():
        bench[f"{block}.{pin}"] = value
    bench[f"{block}.Execute"] = True
    bench.until(lambda: signal in bench.plc.inputs)
    bench.scan()
    bench.fault = ""
    bench.ends()
    assert bench.end == ("Error", 0x805D, True)
    bench.scan(60)
    assert (bench.held, bench.told[-1]) == (True, "move 20"), "the hand does not open"


def test_a_robot_program_that_starts_ends_the_block() -> None:
    """A robot program that starts ends the block; a program that already runs does not.

    Source: manual chapter 5, 2.2: SO(13).
    """
    bench = PartBench()
    bench.plc.outputs(SO13=True)
    bench.scan(2)
    _sent(bench, 4)
    bench.plc.outputs(SO13=False)
    bench.scan()
    assert bench.end[0] == "Busy"
    bench.plc.outputs(SO13=True)
    bench.scan()
    bench.ends()
    assert bench.end == ("Error", 0x805D, True)


def test_a_robot_program_that_starts_while_robot_2_moves_ends_the_block() -> None:
    """A robot program that starts ends the work, because it may move either robot.

    Source: manual chapter 5, 2.2: SO(13).
    """
    bench = PartBench()
    _sent(bench, 4)
    bench.send(*_HARMLESS["moves robot 2"])
    bench.until(lambda: bench.plc.words[0] == 0x2001)
    assert bench.end[0] == "Busy"
    bench.plc.outputs(SO13=True)
    bench.ends()
    assert bench.end == ("Error", 0x805D, True)


def test_no_other_block_may_switch_one_of_two_outputs_of_the_hand() -> None:
    """The work ends if another block switches one of the hand's outputs.

    This includes the output that opens the hand.

    Source: guide 4.5.1; RCX_GRIPPER, OpenOutput.
    """
    for words in ((0x301, 0, 0x1021, 1), (0x301, 0, 0x1020, 0)):
        bench = PartBench(outputs=2)
        _sent(bench, 6)
        bench.foreign = True
        bench.send(*words)
        bench.ends()
        assert bench.end[:2] == ("Error", 0x805D)


def test_a_write_to_an_output_of_the_hand_is_detected_as_bit_and_as_port() -> None:
    """A command that writes an output of the hand is detected, as a bit and as a port.

    Source: guide 4.5.1.
    """
    block = Alone("FB_RcxMayGoOn", {"Robot": "RCX_REF"}, "builtin")
    block["Block.HasHand"] = True
    block["Robot.Inner.Phase"] = "PHASE_COMMAND_RUN"
    for now, ((close, opens), code, place, expected) in enumerate(_PLACES):
        block["Block.CloseOutput"], block["Block.OpenOutput"] = close, opens
        block["Robot.Inner.Code"], block["Robot.Inner.Data[2]"] = code, place
        block["Block.Begin"] = True
        block.scan(now)
        assert block["Block.Switches"] is expected, (close, opens, hex(code), hex(place))


def test_a_second_block_of_several_commands_is_refused() -> None:
    """A second block of several commands on the same robot is refused, and the first continues.

    The second may start in the scan in which the first ends.

    Source: docs/explanation/scan-model.md, two blocks on one robot
    """
    bench = PartBench()
    for count in (1, 3):
        _sent(bench, count)
        for second in ("Second", "Table"):
            assert bench.work(second) == "805D", second
            assert bench["Pick.Busy"]
    bench["Second.Execute"] = False
    bench.ends()
    assert (bench.end[0], bench.delivered) == ("Done", 1)
    assert bench.work("Second") == "Done"


def test_blocks_for_two_robots_of_one_controller_work_side_by_side() -> None:
    """Blocks for two robots of one controller work at the same time. Each robot has its own hand.

    Source: guide 3.1, robot designation.
    """
    bench = PartBench()
    bench["Second.RobotNumber"] = 2
    bench["Second.Gripper.CloseOutput"] = 24
    bench["Second.Execute"] = True
    assert bench.work() == "Done"
    bench.until(lambda: not bench["Second.Busy"])
    assert bench["Second.Done"]


def test_a_part_left_in_the_hand_by_one_block_is_not_dropped_by_another() -> None:
    """If a block has left a part in the hand, another block does not open the hand.

    It may do so after HandEmpty, or after the first block has placed the part.

    Source: head of FB_PickPlace
    """
    for empty in (False, True):
        bench = PartBench()
        _sent(bench, 4)
        bench.fault = "refused"
        bench.ends()
        assert bench.work("Second") == "805E"
        assert bench.held
        if empty:
            bench.taken_out()
        else:
            assert bench.work() == "Done"
        assert bench.work("Second", HandEmpty=empty) == "Done"
        assert bench.work("Second", HandEmpty=False) == "Done", (
            "HandEmpty counted for the earlier start only"
        )


def test_hand_empty_of_a_refused_start_has_no_effect() -> None:
    """If a start is refused, its HandEmpty has no effect.

    Another block works, and its part is in the hand.

    Source: docs/explanation/scan-model.md, two blocks on one robot
    """
    bench = PartBench()
    _sent(bench, 4)
    bench.fault = "late"
    assert bench.work("Second", HandEmpty=True) == "805D"
    bench.fault = "refused"
    bench.ends()
    assert bench.work("Second", HandEmpty=False) == "805E"
    assert bench.held


def test_a_table_may_move_the_robot_with_a_part_in_the_hand() -> None:
    """A table may move the robot with a part in the hand, because a table does not open it.

    Source: head of FB_RcxClaim.
    """
    bench = PartBench()
    _sent(bench, 4)
    bench.fault = "refused"
    bench.ends()
    bench["Moves[1].Kind"], bench["Moves[1].Point"], bench["Table.Rows"] = "MOVE_PTP", AWAY, 1
    assert bench.work("Table") == "Done"
    assert (bench.place, bench.held) == (AWAY, True)
    assert bench.work() == "Done"


@pytest.mark.parametrize("number", [-1, 5, 17])
def test_a_table_for_a_robot_that_does_not_exist_is_refused(number: int) -> None:
    """Source: guide 3.1, robot designation: 1 to 4; docs/reference/errors.md, 16#8040."""
    bench = PartBench()
    bench["Moves[1].Kind"], bench["Table.Rows"] = "MOVE_PTP", 1
    assert bench.work("Table", RobotNumber=number) == "8040"
    assert bench.told == []
    assert bench.work() == "Done"


def test_a_block_that_is_no_longer_called_releases_the_robot() -> None:
    """If a block is no longer called, the robot is free for other blocks after one scan.

    Source: docs/explanation/scan-model.md, two turns.
    """
    bench = PartBench()
    _sent(bench, 2)
    bench["Call"] = False
    bench.scan(4)
    assert bench.work("Second") == "Done"


@pytest.mark.parametrize("engine", ENGINES)
def test_a_table_ends_if_another_block_moves_the_robot(engine: str) -> None:
    """If another block moves the robot, the table ends, except at a row with CallNumber.

    Source: head of FB_MoveTable.
    """
    bench = PartBench(engine)
    for row, point in ((1, 20), (2, 40)):
        bench[f"Moves[{row}].Kind"], bench[f"Moves[{row}].Point"] = "MOVE_PTP", point
    bench["Table.Rows"], bench["Table.Timeout"] = 2, "T#10s"
    bench["Table.Execute"] = True
    bench.until(lambda: bench.sent == 1)
    bench.send(*_MOVES)
    bench.until(lambda: not bench["Table.Busy"])
    assert (bench["Table.ErrorID"], bench["Table.Row"]) == (0x805D, 2)
    bench.scan(20)
    assert bench.told == ["move 20", "move 30"]
    bench["Moves[1].AtArrival"], bench["Moves[1].Number"] = "ARRIVE_CALL", 7
    bench["Table.Execute"] = False
    bench.scan(2)
    bench["Table.Execute"] = True
    bench.until(lambda: bench["Table.CallNumber"] == 7)
    bench.scan()
    assert bench.work() == "Done", "this includes another block of several commands"
    bench["Table.Acknowledge"] = True
    bench.until(lambda: not bench["Table.Busy"])
    assert (bench["Table.Done"], bench.told[-1]) == (True, "move 40")
