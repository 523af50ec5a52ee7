"""FB_Operator starts nothing by itself, and nothing long after its key was pressed.

The test plays the robot.
"""

from __future__ import annotations

import pytest

from both_engines import ENGINES
from operator_bench import OperatorBench

_LINE, _TEACH, _STEP = 0x0403, 0x0028, 0x0024
#: Codes of other blocks: read a point, move to a point.
_READ, _MOVE = 0x0102, 0x0001
_CODES = {"StepLine": _LINE, "Teach": _TEACH}


def _under_way(plc: OperatorBench, code: int) -> None:
    """Start a command of another block, which gets no answer until `plc.hold` is 0."""
    plc.hold = code
    plc["Other.Code"], plc["Other.Execute"] = code, True
    plc.scan_until(lambda: code in plc.codes)


def _rose(plc: OperatorBench, scans: int) -> set[str]:
    """Run scans, and return the inputs that were ON in any scan, except SI(00) and SI(06)."""
    found: set[str] = set()
    for _ in range(scans):
        plc.scan()
        found.update(plc.inputs)
    return found - {"SI00", "SI06"}


# ---- StepLine and Teach


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("key", ["StepLine", "Teach"])
@pytest.mark.parametrize("scans", [92, 104])
def test_stepline_and_teach_are_sent_within_a_second_or_not_at_all(
    engine: str, key: str, scans: int
) -> None:
    """StepLine and Teach send their command within a second after the key, or not at all.

    Another block uses the channel for 0.92 s or 1.04 s.

    Source: FB_RcxPanelCommands; RCX_PANEL_KEYS.Teach: where the robot is becomes the point.
    """
    plc = OperatorBench(engine)
    _under_way(plc, _READ)
    assert plc.can(key) == [True]
    plc.press(key)
    plc.scan(scans - 2)
    assert plc.codes == [_READ]
    plc.hold = 0
    plc.scan(20)
    assert (_CODES[key] in plc.codes) is (scans < 100)
    assert plc.message == (0 if scans < 100 else 0x8076)
    assert not plc["Operator.Busy"]


@pytest.mark.parametrize("key", ["StepLine", "Teach"])
def test_stepline_and_teach_are_not_possible_during_a_movement_of_another_block(key: str) -> None:
    """StepLine and Teach are refused while another block has a movement to complete.

    After this movement, the robot would be at another place.

    Source: RCX_PANEL_KEYS.Teach; guide 4.2: category 1.
    """
    plc = OperatorBench()
    _under_way(plc, _MOVE)
    assert plc.can(key) == [False]
    plc.press(key)
    assert (plc.message, plc["Panel.Lamp.Fault"]) == (0x8076, True)
    plc.hold = 0
    plc.scan(60)
    assert plc.codes == [_MOVE]
    plc.press(key, then=8)
    assert plc.codes[:2] == [_MOVE, _CODES[key]]


@pytest.mark.parametrize("key", ["StepLine", "Teach"])
def test_a_movement_that_comes_first_withdraws_a_line_or_a_point_that_waits(key: str) -> None:
    """Source: FB_RcxPanelCommands."""
    plc = OperatorBench()
    _under_way(plc, _READ)
    plc["Third.Code"], plc["Third.Execute"] = _MOVE, True
    plc.scan()
    plc.press(key, then=10)
    assert (plc.message, plc["Operator.Busy"]) == (0, True)
    plc.hold = _MOVE
    plc.scan_until(lambda: _MOVE in plc.codes)
    plc.scan(3)
    assert (plc.message, plc["Operator.Busy"]) == (0x8076, False)
    plc.hold = 0
    plc.scan(40)
    assert plc.codes == [_READ, _MOVE]


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("key", ["StepLine", "Teach"])
def test_waiting_stepline_and_teach_are_withdrawn_if_the_hmi_is_lost(engine: str, key: str) -> None:
    """Source: FB_Operator, HmiOk: only Stop acts."""
    plc = OperatorBench(engine)
    _under_way(plc, _READ)
    plc.press(key)
    plc.change("Operator.HmiOk", to=False, scans=2)
    assert not plc["Operator.Busy"]
    plc.hold = 0
    plc.scan(60)
    assert plc.codes == [_READ]
    plc.change("Operator.HmiOk", to=True, scans=60)
    assert plc.codes == [_READ]
    assert (plc.message, plc["Operator.Error"]) == (0, False)


@pytest.mark.parametrize("scans", range(1, 6))
@pytest.mark.parametrize("key", ["StepLine", "Teach"])
def test_after_the_loss_of_the_hmi_no_command_is_sent(key: str, scans: int) -> None:
    """Source: FB_Operator, HmiOk."""
    plc = OperatorBench()
    plc.hold = _CODES[key]
    plc.key(key, scans=scans)
    out = list(plc.codes)
    plc.change("Operator.HmiOk", to=False, scans=30)
    assert plc.codes == out


def test_stop_withdraws_a_line_that_waits_and_that_is_no_fault() -> None:
    """Source: RCX_PANEL_KEYS.Stop."""
    plc = OperatorBench()
    _under_way(plc, _READ)
    plc.press("StepLine")
    plc.press("Stop", then=2)
    plc.hold = 0
    plc.scan(60)
    assert plc.codes == [_READ]
    assert (plc.message, plc["Panel.Lamp.Fault"]) == (0x8007, False)


def test_a_point_is_taught_while_stop_is_pressed() -> None:
    """Source: guide 4.2.9: nothing moves."""
    plc = OperatorBench()
    plc.key("Stop", scans=30)
    plc.press("Teach", then=8)
    assert "Taught" in plc.lamps()


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("way", ["hmi", "stop"])
@pytest.mark.parametrize("what", ["line", "step"])
def test_a_moving_line_or_step_is_stopped_by_stop_and_by_the_loss_of_the_hmi(
    engine: str, way: str, what: str
) -> None:
    """Stop or the loss of the HMI stops a StepLine or a step that moves the robot.

    SI(06) turns OFF in the same scan and stays OFF until Reset. Alarm 12.400 is not a fault.

    Source: FB_Operator, HmiOk; manual chapter 5, 2, SI(06).
    """
    plc = OperatorBench(engine, Stepwise=True)
    code = _LINE if what == "line" else _STEP
    plc.hold = code
    plc.press("StepLine" if what == "line" else "JogPlus")
    plc.scan_until(lambda: code in plc.codes)
    plc.scan(10)
    if way == "hmi":
        plc["Operator.HmiOk"] = False
    else:
        plc.key("Stop")
    plc.scan()
    assert plc.inputs == ["SI00"]
    plc.key("Stop", False)
    plc.hold, plc.refuse, plc.alarm = 0, code, (12, 400)
    plc.scan(60)
    assert plc.inputs == ["SI00"]
    assert "Stopped" in plc.lamps()
    assert (plc["Operator.Error"], plc["Operator.Busy"]) == (False, False)
    plc.change("Operator.HmiOk", to=True, scans=2)
    assert (plc.message, plc["Panel.Following"]) == (0x8007, "PANEL_NEXT_RESET")
    plc.press("Reset", then=40)
    assert plc.inputs == ["SI00", "SI06"]
    assert plc.codes.count(code) == 1
    assert plc.message == 0


@pytest.mark.parametrize("what", ["line", "step"])
@pytest.mark.parametrize("alarm", [(12, 401), (2, 400)])
def test_another_alarm_is_reported_although_stop_was_pressed(
    what: str, alarm: tuple[int, int]
) -> None:
    """Source: guide chapter 2, abnormal end."""
    plc = OperatorBench(Stepwise=True)
    code = _LINE if what == "line" else _STEP
    plc.hold = code
    plc.press("StepLine" if what == "line" else "JogPlus")
    plc.scan_until(lambda: code in plc.codes)
    plc.press("Stop")
    plc.hold, plc.refuse, plc.alarm = 0, code, alarm
    plc.scan(20)
    assert (plc.message, plc["Panel.Lamp.Fault"]) == (0x8020, True)


# ---- ServoOn


@pytest.mark.parametrize("engine", ENGINES)
def test_servo_on_is_refused_in_an_emergency_stop_and_does_not_wait_for_its_end(
    engine: str,
) -> None:
    """During an emergency stop, ServoOn is refused, and it is not executed after the release.

    Source: manual chapter 5, 3.1: the emergency stop is released before servo ON.
    """
    plc = OperatorBench(engine)
    plc.outputs(SO00=True, SO02=False, SO03=True, scans=60)
    assert plc.can("ServoOn", "Reset") == [False, False]
    assert (plc["Panel.Following"], plc.message) == ("PANEL_NEXT_NONE", 0x8003)
    plc.press("ServoOn")
    assert (plc.message, plc["Panel.Lamp.Fault"]) == (0x8003, True)
    plc.outputs(SO00=False)
    assert _rose(plc, 100) == set()
    plc.outputs(SO03=False)
    assert _rose(plc, 100) == set()
    assert plc.can("ServoOn") == [True], "now servo on is possible"


def test_servo_on_ends_an_emergency_stop_of_the_plc_without_a_delay() -> None:
    """If the emergency stop of the PLC itself was just released, ServoOn continues without a delay.

    The key is pressed before SI(00) is ON and answered.

    Source: manual chapter 5, 3.1, servo ON from emergency stop.
    """
    plc = OperatorBench()
    plc["EmergencyStopOk"] = False
    plc.outputs(SO00=True, SO02=False, SO03=True, scans=40)
    plc.change("EmergencyStopOk", to=True, scans=2)
    assert plc.can("ServoOn") == [True]
    plc.press("ServoOn")
    plc.scan_until(lambda: "SI00" in plc.inputs)
    plc.scan(10)
    plc.outputs(SO00=False)
    plc.scan_until(lambda: "SI16" in plc.inputs)


def test_servo_on_is_withdrawn_if_another_emergency_stop_is_on() -> None:
    """If another emergency stop is on, ServoOn is withdrawn.

    This stop can be detected only after SI(00) is ON and answered.

    Source: manual chapter 5, 2, SI(01): all emergency stop states are cancelled.
    """
    plc = OperatorBench()
    plc["EmergencyStopOk"] = False
    plc.outputs(SO00=True, SO02=False, SO03=True, scans=40)
    plc.change("EmergencyStopOk", to=True, scans=2)
    plc.press("ServoOn")
    plc.scan_until(lambda: not plc["Operator.Busy"], most=60)
    assert (plc.message, plc["Panel.Lamp.Fault"]) == (0x8003, True)
    plc.outputs(SO00=False)
    assert _rose(plc, 100) == set()


def test_a_new_emergency_stop_withdraws_servo_on() -> None:
    """Source: nothing starts by itself."""
    plc = OperatorBench()
    plc.outputs(SO02=False, SO03=True, scans=20)
    plc.press("ServoOn")
    plc.outputs(SO00=True, scans=4)
    assert (plc.message, plc["Operator.Busy"]) == (0x8003, False)
    plc.outputs(SO00=False, scans=15)
    plc.outputs(SO03=False)
    assert _rose(plc, 100) == set()


@pytest.mark.parametrize("engine", ENGINES)
def test_without_main_power_servo_on_is_refused_with_a_message(engine: str) -> None:
    """Source: manual chapter 5, 2, SO(04)."""
    plc = OperatorBench(engine)
    plc.outputs(SO02=False, SO04=False, scans=20)
    for automatic in (False, True):
        plc.set(Automatic=automatic, scans=2)
        assert (plc.message, plc["Panel.Lamp.Fault"]) == (0x8005, False)
        assert (plc["Panel.Following"], plc.can("ServoOn")) == ("PANEL_NEXT_NONE", [False])
    plc.press("ServoOn")
    assert (plc.message, plc["Panel.Lamp.Fault"]) == (0x8005, True)
    plc.press("Start")
    assert plc.message == 0x8005
    plc.outputs(SO04=True)
    assert _rose(plc, 100) == set()
    plc.press("Reset")
    assert (plc.message, plc["Panel.Following"]) == (0x800C, "PANEL_NEXT_SERVO_ON")


@pytest.mark.parametrize(
    ("what", "error"), [("alarm", 0x800A), ("power", 0x8005), ("turn", 0x8076)]
)
def test_servo_on_is_withdrawn_after_waiting_for_two_seconds(what: str, error: int) -> None:
    """If ServoOn has to wait longer than two seconds, it is withdrawn and the servos stay OFF.

    It waits for an alarm reset of another block, for main power, or for another sequence.

    Source: FB_RcxPanelSequences.
    """
    plc = OperatorBench()
    plc.outputs(SO02=False, SO03=what != "turn", scans=20)
    if what == "turn":
        plc.scan_until(lambda: "SI15" in plc.inputs, execute="Sequence")
    plc.press("ServoOn")
    if what != "turn":
        plc.scan_until(lambda: "SI16" in plc.inputs)
    if what == "power":
        plc.outputs(SO03=False, SO04=False)
    plc.scan(150)
    assert plc["Operator.Busy"]
    plc.scan(70)
    assert (plc.message, plc["Operator.Busy"]) == (error, False)
    plc.outputs(SO03=False, SO04=True, SO14=True, scans=5)
    assert "SI01" not in _rose(plc, 100)


@pytest.mark.parametrize(
    ("key", "signal"), [("Start", "SI12"), ("ProgramReset", "SI15"), ("Reset", "SI16")]
)
@pytest.mark.parametrize("scans", [190, 210])
def test_a_sequence_that_waits_longer_than_two_seconds_is_withdrawn(
    key: str, signal: str, scans: int
) -> None:
    """A sequence that waits longer than two seconds for the dedicated inputs is withdrawn.

    Another sequence uses them for 1.9 s and for 2.1 s.

    Source: FB_RcxPanelSequences.
    """
    plc = OperatorBench(Automatic=key == "Start")
    plc.scan_until(lambda: "SI15" in plc.inputs, execute="Sequence")
    plc.outputs(SO03=key == "Reset", scans=20)
    plc.press(key)
    plc.scan(scans - 2)
    plc.outputs(SO14=True, scans=13)
    plc.outputs(SO14=False)
    assert (signal in _rose(plc, 100)) is (scans < 200)
    assert plc.message == (0x8076 if scans > 200 else 0x8004 if key == "Reset" else 0)


def test_the_answer_of_servo_on_may_take_as_long_as_timeout_says() -> None:
    """Source: FB_Operator.Timeout."""
    plc = OperatorBench()
    plc.outputs(SO02=False, scans=20)
    plc.press("ServoOn")
    plc.scan_until(lambda: "SI01" in plc.inputs)
    plc.scan(900)
    assert plc["Operator.Busy"]
    plc.outputs(SO02=True, scans=2)
    assert (plc.message, plc["Operator.Busy"]) == (0, False)


# ---- Stop and the loss of the HMI


@pytest.mark.parametrize("way", ["stop", "hmi"])
@pytest.mark.parametrize("scans", [1, 2, 8, 20, 30])
def test_stop_and_the_hmis_loss_withdraw_servo_on(way: str, scans: int) -> None:
    """Source: FB_RcxPanelSequences."""
    plc = OperatorBench()
    plc.outputs(SO02=False, SO03=True, scans=20)
    plc.press("ServoOn", scans=scans)
    if way == "stop":
        plc.press("Stop")
    else:
        plc.change("Operator.HmiOk", to=False, scans=2)
    plc.outputs(SO03=False, scans=15)
    assert _rose(plc, 100) == set()
    plc.change("Operator.HmiOk", to=True, scans=2)
    assert not plc["Operator.Error"]


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("way", ["stop", "hmi"])
@pytest.mark.parametrize("waits", ["stop", "turn"])
def test_stop_and_the_loss_of_the_hmi_withdraw_start(engine: str, way: str, waits: str) -> None:
    """Source: FB_RcxPanelSequences; FB_ProgramContinue."""
    plc = OperatorBench(engine)
    plc.set(Automatic=True, scans=20)
    if waits == "stop":
        plc.press("Stop", then=30)
    else:
        plc.scan_until(lambda: "SI15" in plc.inputs, execute="Sequence")
    plc.press("Start")
    if way == "stop":
        plc.press("Stop")
    else:
        plc.change("Operator.HmiOk", to=False, scans=2)
    plc.outputs(SO14=True)
    assert "SI12" not in _rose(plc, 100)
    assert ("SI06" in plc.inputs) is (way == "hmi")
    plc.change("Operator.HmiOk", to=True, scans=2)
    assert not plc["Operator.Error"]
    assert _rose(plc, 100) == set()


@pytest.mark.parametrize(("key", "signal"), [("ProgramReset", "SI15"), ("Reset", "SI16")])
def test_the_loss_of_the_hmi_withdraws_waiting_sequences(key: str, signal: str) -> None:
    """Source: FB_Operator, HmiOk: only Stop acts."""
    plc = OperatorBench()
    plc.scan_until(lambda: "SI15" in plc.inputs, execute="Sequence")
    plc.outputs(SO03=key == "Reset", scans=1)
    plc.press(key)
    assert plc["Operator.Busy"]
    plc.change("Operator.HmiOk", to=False, scans=2)
    assert not plc["Operator.Busy"]
    plc.outputs(SO14=True, scans=15)
    plc.outputs(SO14=False)
    assert signal not in _rose(plc, 100)


# ---- possible keys


@pytest.mark.parametrize("engine", ENGINES)
def test_while_stop_is_pressed_only_keys_with_an_effect_are_shown_as_possible(engine: str) -> None:
    """Source: RCX_PANEL.Can: what would do something if it was pressed now."""
    plc = OperatorBench(engine)
    plc.key("Stop", scans=30)
    assert plc.can("Start", "Reset", "JogPlus", "JogMinus", "StepLine") == [False] * 5
    assert plc["Panel.Following"] == "PANEL_NEXT_NONE"
    plc.outputs(SO02=False, scans=2)
    assert plc.can("ServoOn") == [False]
    plc.press("ServoOn")
    assert plc.message == 0x8007
    plc.press("Reset")
    plc.outputs(SO02=True)
    plc.set(Automatic=True, scans=2)
    assert plc.can("Start", "Reset") == [False, False]
    assert (plc["Panel.Following"], plc.message) == ("PANEL_NEXT_NONE", 0x8007)
    plc.key("Stop", False, scans=2)
    assert plc.can("Start", "Reset") == [True, True]
    assert (plc["Panel.Following"], plc.message) == ("PANEL_NEXT_START", 0)
    plc.press("Reset")
    assert "Stopped" not in plc.lamps()


def test_reset_is_possible_only_if_there_is_something_to_reset() -> None:
    """Reset is shown as possible only if there is something to reset.

    An alarm reset is not possible during an emergency stop or during another alarm reset.

    Source: manual chapter 5, 3.1; RCX_PANEL.Can.
    """
    plc = OperatorBench()
    plc.outputs(SO03=True, SO02=False, scans=20)
    assert (plc.can("Reset"), plc["Panel.Following"]) == ([True], "PANEL_NEXT_RESET")
    plc.change("EmergencyStopOk", to=False, scans=2)
    assert (plc.can("Reset"), plc["Panel.Following"]) == ([False], "PANEL_NEXT_NONE")
    plc.change("EmergencyStopOk", to=True, scans=40)
    plc.press("Reset")
    assert plc.can("Reset") == [False], "the key is at work"


@pytest.mark.parametrize("stop", [False, True])
@pytest.mark.parametrize(("key", "code"), [("StepLine", _LINE), ("JogPlus", _STEP)])
def test_a_line_or_step_stopped_by_another_block_is_a_fault(
    key: str, code: int, stop: bool
) -> None:
    """If another block stops a StepLine or a step, alarm 12.400 is reported as a fault.

    It is not a fault if the Stop key of this panel caused it.

    Source: guide 4.2.8 and 4.6.2; chapter 5, 3.3.
    """
    plc = OperatorBench(Stepwise=True)
    plc.hold = code
    plc.press(key)
    plc.scan_until(lambda: plc.words[0] == code)
    if stop:
        plc.press("Stop", scans=3)
    plc.answer(0x4000, (12, 400))
    plc.hold = 0
    plc.scan(5)
    assert (plc.message == 0x8020) is not stop


def _reset_behind() -> OperatorBench:
    """Return a bench in which ProgramReset gets no answer, and Reset waits behind it."""
    plc = OperatorBench()
    plc.press("ProgramReset", then=20)
    plc.outputs(SO03=True, scans=3)
    plc.press("Reset")
    return plc


def test_a_waiting_reset_is_withdrawn_and_the_running_sequence_continues() -> None:
    """A Reset that waits is withdrawn; the block that uses the inputs continues until its Timeout.

    Source: errors.md, 16#8076.
    """
    plc = _reset_behind()
    plc.scan(250)
    assert plc.message == 0x8076
    assert plc["Operator.Sequences.Again.Active"]
    assert not plc["Operator.Sequences.Acknowledge.Busy"]


def test_a_waiting_key_is_withdrawn_without_a_message_if_the_hmi_is_lost() -> None:
    """If the HMI is lost, a key that waited is withdrawn without a message.

    If the key was withdrawn in the previous scan, after too long a wait, it is still reported.

    Source: head of FB_Operator: without the HMI what waits is withdrawn
    """
    told = []
    for scans in range(190, 210):
        plc = _reset_behind()
        plc.scan(scans)
        before = plc.message == 0x8076
        plc.change("Operator.HmiOk", to=False, scans=20)
        told.append((before, plc.message == 0x8076))
        assert not plc["Operator.Busy"]
    assert told == sorted(told)
    assert told[0] == (False, False)
    assert told[-1] == (True, True)
    assert told.count((False, True)) == 1


def test_an_emergency_stop_during_an_alarm_reset_is_reported() -> None:
    """If an emergency stop comes during an alarm reset, the message names the emergency stop.

    It does not say that the alarm remains.

    Source: docs/reference/errors.md, 16#8003 and 16#800A.
    """
    plc = OperatorBench()
    plc.outputs(SO02=False, SO03=True, scans=20)
    plc.press("ServoOn", then=20)
    assert plc["Operator.Sequences.Powering.Stage"] == "POWER_UP_ALARM_RESET"
    plc.change("EmergencyStopOk", to=False, scans=10)
    assert plc.message == 0x8003
