"""The jog keys of FB_Operator move an axis while they are held, or by a step.

The test plays the robot.
"""

from __future__ import annotations

from typing import Any

import pytest

from both_engines import ENGINES
from operator_bench import OperatorBench

_SPEED, _AMOUNT, _STEP, _POSITION = 0x0038, 0x0027, 0x0024, 0x0506
#: Code of a command of another block. The choice of the command has no effect on the test.
_OTHER = 0x0102


def _jogging(plc: OperatorBench, key: str = "JogPlus") -> None:
    """Return a bench on which a jog key is pressed and the axis moves."""
    plc.key(key)
    plc.scan_until(lambda: "Moving" in plc.lamps(), most=20)


@pytest.mark.parametrize("engine", ENGINES)
def test_an_axis_moves_while_the_key_is_held(engine: str) -> None:
    """An axis moves while its jog key is held; the release turns SI(06) OFF in the same scan.

    The manual movement speed is set before the jog is sent.

    Source: guide 4.2.14 (16#0038, speed in the third word), 4.2.6 (16#0020, axis bits, bit 7 = -).
    """
    plc = OperatorBench(engine)
    plc.key("JogPlus", scans=10)
    assert [words[:3] for words in plc.sent] == [[_SPEED, 0, 10], [0x0020, 0, 0x0001]]
    assert "Moving" in plc.lamps()
    plc.scan(50)
    assert "SI06" in plc.inputs
    plc.key("JogPlus", False, scans=1)
    assert "SI06" not in plc.inputs
    assert "Moving" not in plc.lamps()
    assert plc["Operator.Busy"]
    assert plc.message == 0, "stopping a jog is not an error"
    plc.scan(40)
    assert "SI06" in plc.inputs
    assert (plc["Operator.Busy"], plc["Operator.Error"]) == (False, False)
    assert plc.codes == [_SPEED, 0x0020, _POSITION]


@pytest.mark.parametrize(
    ("selections", "code", "data"),
    [
        ({"Frame": "JOG_CARTESIAN", "Axis": 3, "Percent": 55}, 0x0021, 0x0084),
        ({"Frame": "JOG_TOOL", "RobotNumber": 2, "Axis": 6, "Percent": 100}, 0x2022, 0x00A0),
        ({"Axis": 1, "Percent": 1}, 0x0020, 0x0081),
    ],
)
def test_axis_frame_robot_and_speed_are_selected(
    selections: dict[str, Any], code: int, data: int
) -> None:
    """Source: guide 4.2.6: 16#0020 pulses, 16#0021 Cartesian, 16#0022 tool; robot in bits 12 up."""
    plc = OperatorBench(**selections)
    plc.key("JogMinus", scans=10)
    speed, jog = plc.sent
    assert speed[:3] == [_SPEED | code & 0xF000, 0, selections["Percent"]]
    assert (jog[0], jog[2]) == (code, data)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(("amount", "sent"), [(0, 100), (2500, 2500)])
def test_stepwise_one_press_is_one_step_however_long_it_is_held(
    engine: str, amount: int, sent: int
) -> None:
    """Source: guide 4.2.8 (16#0027, amount in the third word), 4.2.7 (16#0024)."""
    plc = OperatorBench(engine, Stepwise=True, Axis=2, Amount=amount)
    plc.key("JogMinus", scans=60)
    assert [words[:3] for words in plc.sent[:3]] == [
        [_SPEED, 0, 10],
        [_AMOUNT, 0, sent],
        [_STEP, 0, 0x0082],
    ]
    assert plc.codes[3:] == [_POSITION]
    plc.key("JogMinus", False, scans=1)
    plc.press("JogMinus", then=60)
    assert plc.codes[4:] == [_SPEED, _AMOUNT, _STEP, _POSITION], "a short press, too"
    plc.scan(150)
    assert not plc["Operator.Error"], "after the step, no key counts as late"


def test_the_selections_count_as_they_stood_at_the_press() -> None:
    """Source: FB_RcxPanelJog."""
    plc = OperatorBench(Axis=2)
    plc.key("JogPlus", scans=1)
    plc.set(Axis=3, Percent=90, Stepwise=True, Frame="JOG_TOOL", RobotNumber=2, scans=10)
    assert [words[:3] for words in plc.sent] == [[_SPEED, 0, 10], [0x0020, 0, 0x0002]]


@pytest.mark.parametrize("scans", range(1, 9))
def test_a_key_released_before_the_axis_moves_starts_no_movement(scans: int) -> None:
    """Source: FB_Jog; hold to run."""
    plc = OperatorBench()
    plc.press("JogPlus", scans=scans, then=1)
    assert 0x0020 not in plc.codes or "SI06" not in plc.inputs
    plc.scan(60)
    assert not plc["Operator.Busy"]
    assert plc.codes.count(0x0020) <= 1
    assert plc.inputs == ["SI00", "SI06"]


def test_the_opposite_jog_key_stops_the_axis_and_starts_no_movement() -> None:
    """Source: FB_RcxPanelKeys: both jog keys together count as no key."""
    plc = OperatorBench()
    _jogging(plc)
    plc.key("JogMinus", scans=1)
    assert "SI06" not in plc.inputs
    assert plc.message == 0x8073
    plc.key("JogPlus", False, scans=80)
    assert plc.codes == [_SPEED, 0x0020, _POSITION], "the other key was pressed too early"
    plc.key("JogPlus", scans=2)
    assert plc.message == 0x8073
    plc.scan(40)
    plc.key("JogMinus", False, scans=80)
    assert plc.codes == [_SPEED, 0x0020, _POSITION]


def test_a_change_of_the_jog_key_within_a_scan_reverses_the_axis_after_its_stop() -> None:
    """Source: FB_RcxPanelJog; guide 4.2.6."""
    plc = OperatorBench()
    _jogging(plc)
    plc.key("JogPlus", False)
    plc.key("JogMinus", scans=1)
    assert "SI06" not in plc.inputs
    assert "Moving" not in plc.lamps()
    plc.scan(60)
    jogs = [words[:3] for words in plc.sent if words[0] == 0x0020]
    assert jogs == [[0x0020, 0, 0x0001], [0x0020, 0, 0x0081]]
    assert "Moving" in plc.lamps()


def test_a_key_pressed_while_the_axis_comes_to_rest_moves_it_afterwards_if_still_held() -> None:
    """Source: FB_RcxPanelJog."""
    plc = OperatorBench()
    _jogging(plc)
    plc.key("JogPlus", False, scans=3)
    plc.key("JogMinus", scans=60)
    assert [words[2] for words in plc.sent if words[0] == 0x0020] == [0x0001, 0x0081]
    plc.key("JogMinus", False, scans=3)
    plc.press("JogPlus", scans=3, then=60)
    assert plc.codes.count(0x0020) == 2
    assert not plc["Operator.Busy"]


@pytest.mark.parametrize(
    ("cause", "back"),
    [
        ("SO00=1", "SO00=0"),
        ("EmergencyStopOk=0", "EmergencyStopOk=1"),
        ("SO03=1", "SO03=0"),
        ("StopOk=0", "StopOk=1"),
        ("SO13=1", "SO13=0"),
        ("Connected=0", "Connected=1"),
    ],
)
def test_after_a_stopped_jog_a_new_press_is_needed(cause: str, back: str) -> None:
    """Source: nothing restarts by itself."""
    plc = OperatorBench()
    _jogging(plc)
    plc.let(cause)
    plc.scan(40)
    assert "Moving" not in plc.lamps()
    assert plc.message or cause == "SO13=1", "a running program is shown by its lamp"
    plc.let(back)
    plc.scan(80)
    assert plc.codes.count(0x0020) == 1
    plc.press("Reset", then=5)
    assert plc.message == 0
    plc.key("JogPlus", False, scans=2)
    _jogging(plc)
    assert plc.codes.count(0x0020) == 2


def test_the_mode_selector_waits_for_the_end_of_a_jog() -> None:
    """Source: RCX_PANEL.Automatic: it counts while nothing is at work."""
    plc = OperatorBench()
    _jogging(plc)
    plc.set(Automatic=True, scans=10)
    assert "Moving" in plc.lamps()
    assert plc["Panel.Mode"] == "PANEL_MANUAL"
    plc.key("JogPlus", False, scans=60)
    assert plc["Panel.Mode"] == "PANEL_AUTOMATIC"


def test_stop_stops_a_jog() -> None:
    """Source: manual chapter 5, 2, SI(06)."""
    plc = OperatorBench()
    _jogging(plc)
    plc.key("Stop", scans=1)
    assert "SI06" not in plc.inputs
    plc.scan(10)
    plc.key("Stop", False, scans=40)
    assert "Moving" not in plc.lamps()
    assert (plc.message, plc["Panel.Lamp.Fault"]) == (0x8007, False), (
        "12.400 is the normal end of a jog"
    )
    plc.press("Reset", then=60)
    assert plc.codes.count(0x0020) == 1, "the key is still held"


@pytest.mark.parametrize(
    ("code", "stepwise"), [(_SPEED, False), (_AMOUNT, True), (_STEP, True), (0x0020, False)]
)
def test_a_command_that_fails_ends_the_press_with_its_alarm(code: int, stepwise: bool) -> None:
    """Source: guide chapter 2, abnormal end."""
    plc = OperatorBench(Stepwise=stepwise)
    plc.refuse = code
    plc.key("JogPlus")
    plc.scan_until(lambda: bool(plc["Operator.Error"]))
    assert not plc["Operator.Busy"], "in the same scan"
    plc.scan(40)
    assert plc.message == 0x8020
    assert (plc["Panel.AlarmGroup"], plc["Panel.AlarmCategory"]) == (2, 334)
    assert plc.codes.count(code) == 1, "the key is still held"
    plc.refuse = 0
    plc.scan(40)
    assert plc.codes.count(code) == 1
    assert not plc["Operator.Busy"]


@pytest.mark.parametrize(
    ("selection", "error"),
    [
        ({"Axis": 7}, 0x8041),
        ({"Axis": -1}, 0x8041),
        ({"Percent": 101}, 0x8042),
        ({"RobotNumber": 5}, 0x8040),
    ],
)
def test_an_illegal_selection_is_reported(selection: dict[str, Any], error: int) -> None:
    """Source: guide 4.2.6, 4.2.14."""
    plc = OperatorBench(**selection)
    plc.key("JogPlus", scans=20)
    assert (plc.message, plc["Panel.Lamp.Fault"]) == (error, True)
    assert not {0x0020, 0x0038} & {*plc.codes}, "no value was set in the controller either"


@pytest.mark.parametrize(
    ("selection", "error"),
    [({"Amount": -1}, 0x8045), ({"Amount": 10_001}, 0x8045), ({"Axis": 7}, 0x8041)],
)
def test_an_illegal_step_sets_no_value_and_the_next_press_is_accepted(
    selection: dict[str, Any], error: int
) -> None:
    """An illegal step is refused, sets no value, and the next press is accepted.

    Without Stepwise, the amount of the step has no effect. Source: guide 4.2.8 and 4.2.14.
    """
    plc = OperatorBench(Stepwise=True, **selection)
    plc.key("JogMinus", scans=20)
    assert plc.message == error
    assert not {0x0024, 0x0027, 0x0038} & {*plc.codes}
    plc.key("JogMinus", False, scans=5)
    before = len(plc.codes)
    plc.set(Stepwise="Amount" not in selection, Axis=6)
    plc.key("JogMinus", scans=20)
    assert (plc.message, plc["Panel.Lamp.Fault"]) == (0, False)
    assert {0x0020, 0x0024} & {*plc.codes[before:]}


@pytest.mark.parametrize("scans", [96, 106])
def test_a_step_begins_within_a_second_or_not_at_all(scans: int) -> None:
    """Source: FB_RcxPanelJog."""
    plc = OperatorBench(Stepwise=True)
    plc.hold = _AMOUNT
    plc.press("JogPlus")
    plc.scan(scans - 2)
    plc.hold = 0
    plc.scan(20)
    if scans < 100:
        assert plc.codes[:3] == [_SPEED, _AMOUNT, _STEP]
        assert plc.message == 0
    else:
        assert _STEP not in plc.codes
        assert plc.message == 0x8076


def test_a_step_that_takes_long_does_not_count_as_late() -> None:
    """Source: FB_RcxPanelJog: the second ends as the step begins."""
    plc = OperatorBench(Stepwise=True)
    plc.hold = _STEP
    plc.press("JogPlus", then=300)
    assert "Moving" in plc.lamps()
    assert plc.message == 0
    plc.hold = 0
    plc.scan(10)
    assert plc.codes == [_SPEED, _AMOUNT, _STEP, _POSITION]
    assert not plc["Operator.Error"]


def test_a_change_of_the_jog_key_together_with_another_key_stops_the_axis() -> None:
    """Source: FB_RcxPanelJog: hold to run."""
    for first, second in (("JogPlus", "JogMinus"), ("JogMinus", "JogPlus")):
        plc = OperatorBench()
        _jogging(plc, first)
        plc.key(first, False)
        plc.key(second)
        plc.key("Teach", scans=1)
        assert "SI06" not in plc.inputs
        plc.scan(60)
        assert plc.codes == [_SPEED, 0x0020, _POSITION]


@pytest.mark.parametrize("again", [True, False])
@pytest.mark.parametrize("hold", [_SPEED, _AMOUNT, _STEP])
def test_a_new_press_waits_for_the_command_of_an_earlier_press(hold: int, again: bool) -> None:
    """Source: guide chapter 1: the command stays until its end."""
    plc = OperatorBench(Stepwise=True)
    plc.hold = hold
    plc.press("JogPlus")
    plc.scan_until(lambda: hold in plc.codes)
    plc.scan(5)
    plc.outputs(SO13=True, scans=2)
    assert plc["Operator.Busy"]
    plc.outputs(SO13=False, scans=2)
    if not again:
        plc.hold = 0
        plc.scan(40)
        assert plc.codes[plc.codes.index(hold) + 1 :] == [_POSITION]
        return
    plc.set(Stepwise=False, Axis=2, Percent=55)
    plc.key("JogMinus", scans=20)
    assert plc.codes[-1] == hold
    plc.hold = 0
    plc.scan(20)
    assert [words[:3] for words in plc.sent[-2:]] == [[_SPEED, 0, 55], [0x0020, 0, 0x0082]]
    assert plc.codes.count(_STEP) == (hold == _STEP)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("key", ["JogPlus", "JogMinus"])
def test_a_jog_ends_if_the_hmi_is_lost_and_needs_a_new_press(engine: str, key: str) -> None:
    """Source: FB_Operator, HmiOk; hold to run."""
    plc = OperatorBench(engine)
    _jogging(plc, key)
    plc.change("Operator.HmiOk", to=False)
    assert "SI06" not in plc.inputs
    assert "Moving" not in plc.lamps()
    plc.scan(80)
    assert plc.message == 0x8001
    plc.change("Operator.HmiOk", to=True)
    assert plc.message == 0x8074
    plc.scan(80)
    assert plc.codes.count(0x0020) == 1
    plc.key(key, False, scans=1)
    _jogging(plc, key)
    assert plc.codes.count(0x0020) == 2


@pytest.mark.parametrize("scans", range(1, 5))
def test_a_waiting_step_is_withdrawn_if_the_hmi_is_lost(scans: int) -> None:
    """Source: FB_Operator, HmiOk."""
    plc = OperatorBench(Stepwise=True)
    plc.key("JogPlus", scans=scans)
    assert _STEP not in plc.codes
    plc.change("Operator.HmiOk", to=False, scans=80)
    assert _STEP not in plc.codes
    assert not plc["Operator.Busy"]


@pytest.mark.parametrize("hold", [_SPEED, _AMOUNT, _STEP])
def test_a_key_pressed_and_released_during_a_command_sends_nothing(hold: int) -> None:
    """Source: FB_RcxPanelJog; hold to run."""
    plc = OperatorBench(Stepwise=True)
    plc.hold = hold
    plc.press("JogPlus")
    plc.scan_until(lambda: hold in plc.codes)
    plc.outputs(SO13=True, scans=2)
    plc.outputs(SO13=False, scans=2)
    plc.set(Stepwise=False)
    plc.press("JogMinus", scans=3)
    plc.hold = 0
    plc.scan(40)
    assert plc.codes[plc.codes.index(hold) + 1 :] == [_POSITION]
    assert not plc["Operator.Busy"]


def test_a_key_released_while_the_speed_is_set_starts_no_movement() -> None:
    """Source: FB_RcxPanelJog; hold to run."""
    plc = OperatorBench()
    plc.hold = _SPEED
    plc.press("JogPlus", scans=5, then=5)
    plc.hold = 0
    plc.scan(40)
    assert plc.codes == [_SPEED, _POSITION]


def test_a_jog_may_take_longer_than_a_step_may_wait() -> None:
    """Source: FB_RcxPanelJog: only a step is to begin within a second."""
    plc = OperatorBench()
    _jogging(plc)
    plc.scan(300)
    assert "Moving" in plc.lamps()
    assert (plc.message, plc.codes) == (0, [_SPEED, 0x0020])


def test_a_step_does_not_wait_long_for_another_command() -> None:
    """Source: FB_RcxPanelJog: within a second or not at all."""
    plc = OperatorBench(Stepwise=True)
    plc.hold = _AMOUNT
    plc.press("JogPlus")
    plc.scan_until(lambda: _AMOUNT in plc.codes)
    plc["Other.Code"], plc["Other.Execute"] = _OTHER, True
    plc.scan()
    plc.hold = _OTHER
    plc.scan(120)
    assert plc.codes == [_SPEED, _AMOUNT, _OTHER]
    assert plc.message == 0x8076
    plc.hold = 0
    plc.scan(40)
    assert _STEP not in plc.codes


@pytest.mark.parametrize("key", ["ServoOn", "ProgramReset", "StepLine", "Teach"])
def test_during_a_jog_another_key_is_refused_and_the_jog_continues(key: str) -> None:
    """Source: docs/reference/errors.md, 16#8072."""
    plc = OperatorBench()
    _jogging(plc)
    assert plc.can(key) == [False]
    plc.press(key)
    assert plc.message == 0x8072
    plc.scan(20)
    assert "Moving" in plc.lamps()
    assert plc.inputs == ["SI00", "SI06"]
    assert plc.codes == [_SPEED, 0x0020]


@pytest.mark.parametrize("stepwise", [False, True])
def test_each_press_has_the_direction_of_its_own_key(stepwise: bool) -> None:
    """Source: guide 4.2.6, 4.2.7: bit 7 of the third word is ON for the minus direction."""
    plc = OperatorBench(Stepwise=stepwise)
    for key in ("JogMinus", "JogPlus", "JogMinus"):
        plc.press(key, scans=20, then=60)
    code = _STEP if stepwise else 0x0020
    sent = [words[2] for words in plc.sent if words[0] == code]
    assert sent == [0x0081, 0x0001, 0x0081]


@pytest.mark.parametrize(
    ("code", "harm", "stepwise"),
    [
        *((code, True, stepwise) for code in (0x038, 0x1038) for stepwise in (False, True)),
        *((0x039, False, stepwise) for stepwise in (False, True)),
        (0x027, True, True),
    ],
)
def test_another_block_that_changes_speed_or_step_before_the_movement_ends_the_press(
    code: int, harm: bool, stepwise: bool
) -> None:
    """If another block changes speed or step before the movement, the press has no further effect.

    The robot must not move at a speed or by a distance that was not selected at this panel.

    Source: guide 4.2.14, manual movement speed; 4.2.15, automatic movement speed; 4.2.8
    """
    plc = OperatorBench(Stepwise=stepwise)
    plc.key("JogPlus", scans=1)
    plc["Other.Code"], plc["Other.Execute"] = code, True
    plc.scan(20)
    assert plc.codes[:2] == [0x038, code]
    moved = bool({0x020, 0x024} & set(plc.codes))
    assert moved is not harm
    assert (plc.message == 0x805D) is harm
    plc["Other.Execute"] = False
    plc.key("JogPlus", False, scans=40)
    plc.key("JogPlus", scans=20)
    assert {0x020, 0x024} & set(plc.codes), "the next press counts"


@pytest.mark.parametrize(("key", "code"), [("StepLine", 0x403), ("JogPlus", 0x024)])
@pytest.mark.parametrize("missed", [False, True])
def test_a_step_that_moves_after_missed_calls_is_stopped_without_the_hmi(
    key: str, code: int, missed: bool
) -> None:
    """If the HMI is lost during missed calls, a step that still moves is stopped afterwards.

    The command of the step is held to its end.

    Source: head of FB_Operator, HmiOk.
    """
    plc = OperatorBench(Stepwise=True)
    plc.hold = code
    plc.key(key)
    plc.scan_until(lambda: plc.codes[-1:] == [code])
    plc.scan(3)
    plc.change("Call", to=not missed)
    plc.change("Call", to=True, scans=3)
    assert "SI06" in plc.inputs
    plc.change("Operator.HmiOk", to=False, scans=2)
    assert "SI06" not in plc.inputs
