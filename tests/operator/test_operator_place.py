"""FB_Operator shows the position of the robot.

The test plays the robot.
"""

from __future__ import annotations

import pytest

from both_engines import ENGINES
from operator_bench import OperatorBench

_LINE, _MOVE, _POSITION = 0x0403, 0x0001, 0x0506


def _answered(plc: OperatorBench, micrometres: int, code: int = _POSITION) -> None:
    """Answer the request for the position of the robot with this position of axis 1."""
    if plc.words[0] != code:
        plc.scan_until(lambda: plc.words[0] == code)
    plc.answer(0x0200, [0, 0, 0, micrometres, 0], scans=5)
    assert plc["Panel.Position"][0] == micrometres / 1000


def test_the_position_is_read_once_the_servos_are_on() -> None:
    """Source: guide 4.7.4: current position in mm, code 16#0506."""
    plc = OperatorBench()
    plc.outputs(SO02=False, scans=20)
    plc.press("ServoOn")
    plc.scan_until(lambda: "SI01" in plc.inputs)
    plc.outputs(SO02=True)
    plc.hold = 0x0506
    plc.scan(10)
    assert plc.codes == [0x0506]
    plc.answer(0x0200, [0, 0, 0, 1500, 0])
    plc.scan_once()
    assert plc["Panel.Position"][0] == 1.5


def test_a_position_that_cannot_be_read_leaves_the_last_one() -> None:
    """Source: RCX_PANEL.Position."""
    plc = OperatorBench()
    plc.hold = 0x0506
    plc.press("JogPlus", scans=20)
    plc.scan_until(lambda: 0x0506 in plc.codes)
    plc.answer(0x0200, [0, 0, 0, 1500, 0], scans=5)
    assert plc["Panel.Position"][0] == 1.5
    plc.hold, plc.refuse = 0, 0x0506
    plc.press("JogPlus", scans=20, then=60)
    assert plc.codes.count(0x0506) == 2
    assert plc["Panel.Position"][0] == 1.5


@pytest.mark.parametrize("engine", ENGINES)
def test_the_position_is_read_again_after_a_line_and_after_a_program(engine: str) -> None:
    """Source: RCX_PANEL.Position; guide 4.7.4."""
    plc = OperatorBench(engine)
    plc.hold = _POSITION
    plc.press("StepLine")
    _answered(plc, 2500)
    plc.outputs(SO13=True, scans=20)
    assert plc.codes == [_LINE, _POSITION]
    plc.outputs(SO13=False)
    _answered(plc, 3500)
    assert plc.codes == [_LINE, _POSITION, _POSITION]
    plc.scan(30)
    assert plc.codes == [_LINE, _POSITION, _POSITION], "once"


def test_the_position_is_read_again_after_a_line_that_ends_with_an_alarm() -> None:
    """Source: the robot may have moved."""
    plc = OperatorBench()
    plc.refuse, plc.hold = _LINE, _POSITION
    plc.press("StepLine")
    _answered(plc, 2500)


def test_a_lost_link_does_not_count_as_the_end_of_a_program() -> None:
    """Source: FB_ReadArea: without a connection all outputs read as OFF."""
    plc = OperatorBench()
    plc.outputs(SO13=True, scans=5)
    plc.change("Connected", to=False, scans=5)
    plc.outputs(SO13=False)
    plc.change("Connected", to=True, scans=60)
    assert plc.codes == []


def test_the_position_of_the_jogged_robot_is_read() -> None:
    """After a jog, the position of the robot that was jogged is read.

    Another robot is selected while the key is held.

    Source: guide 4.7.4: the robot is in bits 15 to 12 of the code.
    """
    plc = OperatorBench(RobotNumber=2)
    plc.key("JogPlus")
    plc.scan_until(lambda: "Moving" in plc.lamps())
    plc.set(RobotNumber=3)
    plc.key("JogPlus", False, scans=60)
    assert plc.codes == [0x2038, 0x2020, 0x2506]
    plc.outputs(SO13=True, scans=3)
    plc.outputs(SO13=False, scans=20)
    assert plc.codes[3:] == [0x3506], "the position of the selected robot"


def test_what_ends_while_the_position_is_read_is_read_afterwards() -> None:
    """Source: FB_RcxPanelPlace."""
    plc = OperatorBench()
    plc.hold = _POSITION
    plc.outputs(SO13=True, scans=2)
    plc.outputs(SO13=False)
    plc.scan_until(lambda: _POSITION in plc.codes)
    plc.press("StepLine", then=5)
    plc.answer(0x0200, [0, 0, 0, 1000, 0])
    plc.scan_once()
    plc.scan(1)
    plc.scan_until(lambda: _LINE in plc.codes)
    plc.scan_until(lambda: plc.codes[-1] == _POSITION)
    _answered(plc, 4500)
    assert plc.codes == [_POSITION, _LINE, _POSITION]


def test_a_movement_of_another_block_does_not_renew_it() -> None:
    """Source: RCX_PANEL.Position."""
    plc = OperatorBench()
    plc["Other.Code"], plc["Other.Execute"] = _MOVE, True
    plc.scan(40)
    assert plc.codes == [_MOVE]


def test_the_position_is_read_again_after_a_movement_during_a_reading() -> None:
    """If a movement begins while the position is read, the position is read again after it.

    After several movements, it is read once.

    Source: RCX_PANEL.Position
    """
    plc = OperatorBench()
    plc.hold = _POSITION
    plc.press("JogPlus", scans=20)
    plc.scan_until(lambda: plc.words[0] == _POSITION)
    for _ in range(3):
        plc.press("JogPlus", scans=5, then=40)
    assert plc.codes.count(_POSITION) == 1
    _answered(plc, 1000)
    plc.scan(60)
    _answered(plc, 2000)
    plc.scan(60)
    assert plc.codes.count(_POSITION) == 2


@pytest.mark.parametrize("jogs", [False, True])
def test_the_position_is_read_again_if_the_servos_turn_on_during_a_reading(jogs: bool) -> None:
    """If the servos turn ON while the position is read, it is read again.

    If an axis is moved first, it is read after this movement.

    Source: RCX_PANEL.Position.
    """
    plc = OperatorBench()
    plc.hold = _POSITION
    plc.press("JogPlus", scans=20)
    plc.scan_until(lambda: plc.words[0] == _POSITION)
    plc.outputs(SO02=False, scans=5)
    plc.press("ServoOn")
    plc.scan_until(lambda: "SI01" in plc.inputs)
    plc.outputs(SO02=True, scans=30)
    assert plc.codes.count(_POSITION) == 1
    plc.key("JogPlus", jogs, scans=3)
    _answered(plc, 1000)
    plc.scan(60)
    assert (0x0020 in plc.codes[plc.codes.index(_POSITION) :]) is jogs
    assert plc.codes.count(_POSITION) == 2 - jogs
    plc.key("JogPlus", False)
    _answered(plc, 2000)
    assert plc.codes.count(_POSITION) == 2
