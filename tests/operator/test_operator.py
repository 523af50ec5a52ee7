"""Each key of FB_Operator has its effect, its conditions and its messages.

The test plays the robot.
"""

from __future__ import annotations

import pytest

from both_engines import ENGINES
from operator_bench import OperatorBench
from plc_bench import ROOT
from structured_text.output.toml_files import load_toml

_KEYS = ("ServoOn", "Start", "ProgramReset", "StepLine", "JogPlus", "JogMinus", "Teach")


#: Key, the condition that prevents its action, and the ErrorID.
#: The blocks that the key starts check these conditions.
_REASONS = [
    ("ServoOn", "Connected=0", 0x8001),
    ("ServoOn", "SO01=0", 0x8002),
    ("ServoOn", "EmergencyStopOk=0", 0x8003),
    ("ServoOn", "SO02=1", 0x8075),
    ("Start", "Connected=0", 0x8001),
    ("Start", "SO01=0", 0x8002),
    ("Start", "SO00=1", 0x8003),
    ("Start", "EmergencyStopOk=0", 0x8003),
    ("Start", "SO03=1", 0x8004),
    ("Start", "other mode", 0x8070),
    ("Start", "SO10=0", 0x8006),
    ("Start", "SO13=1", 0x8008),
    ("Start", "SO02=0", 0x800C),
    ("Start", "StopOk=0", 0x8007),
    ("ProgramReset", "Connected=0", 0x8001),
    ("ProgramReset", "SO01=0", 0x8002),
    ("ProgramReset", "SO10=0", 0x8006),
    ("ProgramReset", "SO13=1", 0x8008),
    *[
        (key, hindrance, error)
        for key in ("StepLine", "JogPlus", "JogMinus")
        for hindrance, error in (
            ("Connected=0", 0x8001),
            ("SO01=0", 0x8002),
            ("SO00=1", 0x8003),
            ("EmergencyStopOk=0", 0x8003),
            ("SO03=1", 0x8004),
            ("other mode", 0x8071),
            ("SO13=1", 0x8008),
            ("SO02=0", 0x800C),
            ("StopOk=0", 0x8007),
        )
    ],
    ("StepLine", "SO10=0", 0x8006),
    ("Teach", "Connected=0", 0x8001),
    ("Teach", "SO01=0", 0x8002),
    ("Teach", "SO00=1", 0x8003),
    ("Teach", "SO03=1", 0x8004),
    ("Teach", "other mode", 0x8071),
    ("Teach", "SO13=1", 0x8008),
]


def test_a_key_that_is_not_possible_is_shown_and_reports_the_reason() -> None:
    """Source: manual chapter 5, 3.1 to 3.3; guide 4.2.6, 4.6.2."""
    plc = OperatorBench(contract=False)
    start = plc.program.snapshot(), bytes(plc.so)
    for key, hindrance, error in _REASONS:
        plc.program.restore(start[0])
        plc.so[:] = start[1]
        plc.set(Automatic=key == "Start", scans=2)
        if (key, error) != ("ServoOn", 0x8075):
            if key == "ServoOn":
                plc.outputs(SO02=False, scans=2)
            assert plc.can(key) == [True], (key, hex(error))
        if hindrance == "other mode":
            plc.set(Automatic=not plc["Panel.Automatic"])
        else:
            plc.let(hindrance)
        plc.scan(2)
        assert plc.can(key) == [False], (key, hex(error))
        before = [one for one in plc.inputs if one not in ("SI00", "SI06")]
        plc.press(key)
        assert (plc.message, plc["Panel.Lamp.Fault"]) == (error, True), key
        assert (plc["Operator.Error"], plc["Operator.ErrorID"]) == (True, error)
        plc.scan(40)
        assert [one for one in plc.inputs if one not in ("SI00", "SI06")] == before
        assert plc.sent == []
        plc.press("Reset")
        assert not plc["Panel.Lamp.Fault"], (key, hex(error))


@pytest.mark.parametrize("engine", ENGINES)
def test_servo_on_resets_the_alarm_and_switches_the_servos_on(engine: str) -> None:
    """Source: manual chapter 5, 3.1."""
    plc = OperatorBench(engine)
    plc.outputs(SO02=False, SO03=True, scans=20)
    assert plc["Panel.Following"] == "PANEL_NEXT_RESET"
    plc.outputs(SO03=False, scans=2)
    assert plc["Panel.Following"] == "PANEL_NEXT_SERVO_ON"
    assert (plc.message, plc["Panel.Lamp.Fault"]) == (0x800C, False), "the message is a hint"
    plc.press("ServoOn")
    assert (plc["Panel.Following"], plc["Operator.Busy"]) == ("PANEL_NEXT_NONE", True)
    assert plc.can(*_KEYS) == [False] * len(_KEYS)
    plc.scan_until(lambda: "SI01" in plc.inputs)
    plc.outputs(SO02=True, scans=2)
    assert (plc["Operator.Busy"], plc.message) == (False, 0)
    assert "ServoOn" in plc.lamps()


def test_servo_on_leads_out_of_an_emergency_stop() -> None:
    """Source: manual chapter 5, 3.1, servo ON from emergency stop."""
    plc = OperatorBench()
    plc["EmergencyStopOk"] = False
    plc.outputs(SO00=True, SO02=False, SO03=True, scans=20)
    assert (plc["Panel.Following"], plc.message) == ("PANEL_NEXT_NONE", 0x8003)
    plc.change("EmergencyStopOk", to=True, scans=2)
    assert (plc["Panel.Following"], plc.message) == ("PANEL_NEXT_SERVO_ON", 0x8003)
    plc.press("ServoOn")
    plc.outputs(SO00=False)
    plc.scan_until(lambda: "SI16" in plc.inputs)
    plc.outputs(SO03=False)
    plc.scan_until(lambda: "SI01" in plc.inputs)
    plc.outputs(SO02=True, scans=2)
    assert (plc["Operator.Busy"], plc["Operator.Error"]) == (False, False)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_program_is_started_stopped_and_continued(engine: str) -> None:
    """Source: manual chapter 5, 3.3."""
    plc = OperatorBench(engine)
    assert plc["Panel.Mode"] == "PANEL_MANUAL"
    plc.set(Automatic=True, scans=2)
    assert (plc["Panel.Mode"], plc["Operator.Automatic"]) == ("PANEL_AUTOMATIC", True)
    assert plc["Panel.Following"] == "PANEL_NEXT_START"
    plc.press("Start")
    assert plc["Panel.Following"] == "PANEL_NEXT_NONE"
    plc.scan_until(lambda: "SI12" in plc.inputs)
    plc.outputs(SO13=True, scans=20)
    assert "Running" in plc.lamps()
    assert plc.message == 0
    assert plc.can("Start", "Stop") == [False, True]

    plc.key("Stop", scans=1)
    assert "SI06" not in plc.inputs, "in the same scan"
    plc.outputs(SO13=False, scans=15)
    assert "Stopped" in plc.lamps()
    assert plc.can("Start", "Stop", "Reset") == [False] * 3
    plc.press("Start", then=3)
    assert plc.message == 0x8007, "Stop is still held"
    plc.key("Stop", False, scans=1)
    assert plc.can("Start", "Stop", "Reset") == [True, False, True]
    plc.press("Reset")
    plc.press("Stop", then=15)
    assert plc["Panel.Following"] == "PANEL_NEXT_START"
    plc.press("Start")
    assert plc.message == 0
    plc.scan_until(lambda: "SI12" in plc.inputs)
    assert "SI06" in plc.inputs
    plc.outputs(SO13=True, scans=2)
    assert "Stopped" not in plc.lamps()


def test_stop_acts_in_manual_mode_and_reset_releases_it_without_a_start() -> None:
    """Stop also acts in MANUAL mode, and Reset releases it without starting the program.

    Source: manual chapter 5, 2, SI(06).
    """
    plc = OperatorBench()
    plc.press("Stop")
    assert "SI06" not in plc.inputs
    plc.scan(30)
    assert (plc.message, plc.can("JogPlus")) == (0x8007, [False])
    assert plc["Panel.Following"] == "PANEL_NEXT_RESET"
    plc.press("Reset", then=30)
    assert plc.inputs == ["SI00", "SI06"]
    assert (plc.message, plc.can("JogPlus", "Reset")) == (0, [True, False])


def test_reset_does_not_release_a_stop_held_by_another_block() -> None:
    """Source: FB_ProgramStop: it holds SI(06) until FB_ProgramContinue."""
    plc = OperatorBench()
    plc.change("Robot.Inner.HoldStop", to=True, scans=30)
    assert plc.can("Reset", "Stop") == [False, False]
    assert plc["Panel.Following"] == "PANEL_NEXT_NONE"
    plc.press("Reset", then=30)
    assert "SI06" not in plc.inputs


def test_reset_resets_the_alarm_of_the_controller() -> None:
    """Source: manual chapter 5, 3.1: SI(16), then SO(03) OFF."""
    plc = OperatorBench()
    plc.outputs(SO03=True, SO02=False, scans=20)
    assert (plc.message, plc.can("Reset")) == (0x8004, [True])
    plc.press("Reset")
    plc.scan_until(lambda: "SI16" in plc.inputs)
    assert plc["Operator.Busy"]
    plc.outputs(SO03=False, scans=2)
    assert (plc.message, plc["Operator.Busy"]) == (0x800C, False)


def test_reset_in_an_emergency_stop_reports_that_it_must_be_released_first() -> None:
    """Source: manual chapter 5, 3.1: the chart releases it before the alarm reset."""
    plc = OperatorBench()
    plc.outputs(SO00=True, SO03=True, SO02=False, scans=20)
    assert plc["Panel.Following"] == "PANEL_NEXT_NONE"
    plc.press("Reset", then=3)
    assert (plc.message, plc["Panel.Lamp.Fault"]) == (0x8003, True)
    plc["EmergencyStopOk"] = False
    plc.outputs(SO00=False, scans=2)
    assert plc["Panel.Following"] == "PANEL_NEXT_NONE", "CellSafe is FALSE"


def test_the_program_is_reset() -> None:
    """Source: manual chapter 5, 3.2: SI(15), then SO(14) ON."""
    plc = OperatorBench()
    plc.press("ProgramReset")
    assert plc["Operator.Busy"]
    plc.scan_until(lambda: "SI15" in plc.inputs)
    plc.outputs(SO14=True, scans=2)
    assert not plc["Operator.Busy"]


@pytest.mark.parametrize(("number", "sent"), [(0, 1), (7, 7)])
def test_a_line_of_the_program_is_stepped(number: int, sent: int) -> None:
    """Source: guide 4.6.2: code 16#0403, program number 16#0001 and n."""
    plc = OperatorBench(ProgramNumber=number)
    plc.press("StepLine", then=8)
    assert [words[:3] for words in plc.sent[:1]] == [[0x0403, 0x0001, sent]]
    assert plc.codes[1:] == [0x0506], "the robot's present position"
    assert plc.message == 0


def test_teach_stores_the_present_position_as_the_point_of_the_panel() -> None:
    """Source: guide 4.2.9: code 16#n028, point, unit 1 = mm."""
    plc = OperatorBench(RobotNumber=2, Point=4000, Units="UNIT_MM")
    plc.press("Teach")
    assert "Taught" not in plc.lamps()
    plc.scan(8)
    assert [words[:4] for words in plc.sent] == [[0x2028, 0, 4000, 1]]
    assert "Taught" in plc.lamps()
    plc.scan(5)
    assert "Taught" in plc.lamps()
    plc.press("Reset")
    assert "Taught" not in plc.lamps(), "the lamp belongs to the last key"


def test_a_point_can_be_taught_with_the_servos_off() -> None:
    """Source: guide 4.2.9; the section does not require the servos to be on."""
    plc = OperatorBench()
    plc.outputs(SO02=False, scans=2)
    assert plc.can("Teach") == [True]


def test_while_a_key_is_busy_all_other_keys_except_stop_are_refused() -> None:
    """Source: FB_Operator: one thing after the other."""
    plc = OperatorBench()
    plc.hold = 0x0028
    plc.press("Teach", then=5)
    for key in ("ProgramReset", "StepLine", "JogPlus", "JogMinus", "Teach"):
        assert plc.can(key) == [False]
        plc.press(key)
        assert plc.message == 0x8072, key
    assert plc.codes == [0x0028]
    assert plc.can("Stop") == [True]
    plc.press("Stop")
    assert "SI06" not in plc.inputs


@pytest.mark.parametrize("key", ["ServoOn", "Start"])
def test_a_busy_key_is_refused_if_it_is_pressed_again(key: str) -> None:
    """Source: docs/reference/errors.md, 16#8072."""
    plc = OperatorBench()
    plc.outputs(SO02=key != "ServoOn")
    plc.set(Automatic=key == "Start", scans=20)
    plc.press(key)
    assert (plc.can(key), plc.message) == ([False], 0)
    plc.press(key)
    assert plc.message == 0x8072


def test_a_command_that_ends_with_an_alarm_is_reported_with_the_text_of_the_alarm() -> None:
    """Source: guide chapter 2, abnormal end; manual chapter 4, 4: 12.600."""
    plc = OperatorBench()
    plc.refuse, plc.alarm = 0x0028, (12, 600)
    alarms = {(one["group"], one["category"]): one for one in _alarms()}
    plc.press("Teach", then=8)
    assert plc.message == 0x8020
    assert (plc["Panel.AlarmGroup"], plc["Panel.AlarmCategory"]) == (12, 600)
    assert plc["Panel.Message.Name"] == alarms[12, 600]["name"]
    plc.refuse = 0
    plc.press("Teach")
    assert (plc["Panel.AlarmGroup"], plc["Panel.AlarmCategory"]) == (0, 0)
    assert plc["Panel.Message.Name"] == ""
    plc.scan(8)
    plc.refuse, plc.alarm = 0x0403, (99, 999)
    plc.press("StepLine", then=8)
    assert (plc["Panel.AlarmGroup"], plc["Panel.AlarmCategory"]) == (99, 999)
    assert plc["Panel.Message.Name"] == "Abnormal end", "this alarm has no text of its own"


def _alarms() -> list[dict[str, object]]:
    rows = load_toml(ROOT / "spec/alarms.toml")["alarm"]
    assert isinstance(rows, list)
    return rows


@pytest.mark.parametrize("engine", ENGINES)
def test_messages_name_the_next_action_in_two_languages(engine: str) -> None:
    """Source: spec/errors.toml, 16#8070."""
    row = next(one for one in load_toml(ROOT / "spec/errors.toml")["error"]
               if one["id"] == 0x8070)  # fmt: skip
    plc = OperatorBench(engine)
    plc.press("Start")
    assert plc["Panel.Message.Name"] == row["name"] == "Panel in manual mode"
    assert plc["Panel.Message.Remedy1"] == row["remedy"]
    plc.set(Language="LANGUAGE_JAPANESE", scans=1)
    shown = str(plc["Panel.Message.Name"])
    assert shown.encode("latin-1").decode("utf-8") == row["name_ja"]
    plc.set(Language="LANGUAGE_ENGLISH", scans=1)
    assert plc["Panel.Message.Name"] == row["name"]


def test_a_fault_stays_until_reset_or_until_the_next_key_is_taken() -> None:
    """Source: FB_Operator.Error."""
    plc = OperatorBench()
    plc.press("Start", then=50)
    assert (plc.message, plc.can("Reset")) == (0x8070, [True])
    plc.press("Reset")
    assert (plc.message, plc.can("Reset")) == (0, [False])
    plc.press("Start")
    plc.press("Teach")
    assert (plc.message, plc["Operator.ErrorID"]) == (0, 0)


def test_a_failed_action_of_a_key_gives_a_message() -> None:
    """Source: design of the library, link loss."""
    for key, servo, automatic in (
        ("ServoOn", False, False),
        ("Start", True, True),
        ("ProgramReset", True, False),
        ("StepLine", True, False),
        ("Teach", True, False),
        ("JogPlus", True, False),
        ("Stop", True, False),
        ("Reset", True, False),
    ):
        plc = OperatorBench()
        plc.hold = {"StepLine": 0x0403, "Teach": 0x0028, "JogPlus": 0x0038}.get(key, 0)
        plc.outputs(SO02=servo, SO03=key == "Reset", SO13=key == "Stop")
        plc.set(Automatic=automatic, scans=3)
        plc.key(key, scans=3)
        plc.key(key, False, scans=4)
        if key != "JogPlus":
            assert plc["Operator.Busy"], key
        plc.change("Connected", to=False, scans=3)
        assert (plc.message, plc["Panel.Lamp.Fault"]) == (0x8001, True), key
        assert not plc["Operator.Busy"]
        if key != "Stop":
            assert plc.lamps() == ["Fault"]
        plc.change("Connected", to=True, scans=60)
        assert not plc["Operator.Busy"]
        assert [one for one in plc.inputs if one not in ("SI00", "SI06")] == []


def test_the_lamps_show_the_dedicated_outputs() -> None:
    """Source: manual chapter 5, 2."""
    names = {
        "SO00": "EmergencyStop",
        "SO02": "ServoOn",
        "SO03": "Alarm",
        "SO10": "AutoMode",
        "SO11": "Origin",
        "SO13": "Running",
        "SO15": "Warning",
    }
    plc = OperatorBench()
    plc.outputs(scans=1, **dict.fromkeys(names, False))
    assert plc.lamps() == ["Connected"]
    for output, lamp in names.items():
        plc.outputs(scans=1, **{output: True})
        assert sorted(plc.lamps()) == sorted(["Connected", lamp])
        plc.outputs(**{output: False})
    plc.change("Connected", to=False)
    assert plc.lamps() == []


def test_the_mode_follows_its_selector_only_while_no_key_is_busy() -> None:
    """Source: FB_Operator; manual chapter 5, 3.2: AUTO is selected at the controller."""
    plc = OperatorBench(Automatic=True)
    plc.outputs(SO10=False, scans=2)
    assert (plc["Panel.Mode"], plc["Operator.Automatic"]) == ("PANEL_AUTO_MISSING", False)
    assert plc.message == 0x8006
    plc.outputs(SO10=True, SO13=True, scans=2)
    plc.set(Automatic=False, scans=2)
    assert plc["Panel.Mode"] == "PANEL_AUTOMATIC", "a program runs"
    plc.outputs(SO13=False, scans=2)
    assert plc["Panel.Mode"] == "PANEL_MANUAL"
    plc.hold = 0x0028
    plc.press("Teach")
    plc.set(Automatic=True, scans=5)
    assert plc["Panel.Mode"] == "PANEL_MANUAL", "a key is at work"


@pytest.mark.parametrize("key", [*_KEYS, "Reset", "Stop"])
def test_a_key_that_is_pressed_when_the_link_comes_is_reported_and_starts_nothing(key: str) -> None:
    """Source: FB_Operator: nothing starts by itself."""
    plc = OperatorBench(up=False)
    plc["Connected"] = False
    plc.key(key)
    plc.outputs(SO01=True, SO02=key != "ServoOn", SO04=True, SO10=True, SO03=key == "Reset")
    plc.set(Automatic=key == "Start", scans=3)
    assert plc.message == 0x8001
    assert plc["Panel.Lamp.Fault"] is (key == "Stop"), "the key acts without an answer"
    plc.change("Connected", to=True)
    assert (plc.message, plc["Panel.Lamp.Fault"]) == (0x8074, True)
    plc.scan(60)
    assert not plc["Operator.Busy"]
    assert plc.inputs == (["SI00"] if key == "Stop" else ["SI00", "SI06"])
    plc.change("Connected", to=False, scans=5)
    plc.change("Connected", to=True)
    assert plc.message == 0x8074, "the key is pressed once more"
    plc.scan(60)
    assert plc.inputs == (["SI00"] if key == "Stop" else ["SI00", "SI06"])
    assert plc.sent == []


def test_a_key_that_is_true_in_the_first_scan_has_not_been_pressed() -> None:
    """Source: FB_RcxPanelKeys."""
    plc = OperatorBench(up=False)
    plc.outputs(SO01=True, SO04=True, SO10=True)
    plc.key("ServoOn", scans=60)
    assert plc.inputs == ["SI00", "SI06"]
    assert plc.message == 0x8074
    plc.key("ServoOn", False, scans=1)
    plc.press("ServoOn")
    assert plc["Operator.Busy"]


def test_two_keys_pressed_at_once_have_no_effect() -> None:
    """Source: FB_RcxPanelKeys: which of them was meant?"""
    keys = (*_KEYS, "Reset")
    for first, second in zip(keys, [*keys[1:], keys[0]], strict=True):
        plc = OperatorBench()
        plc.press(first, second)
        assert (plc.message, plc["Panel.Lamp.Fault"]) == (0x8073, True), first
        plc.scan(30)
        assert plc.inputs == ["SI00", "SI06"]
        assert plc.sent == []


@pytest.mark.parametrize("key", [*_KEYS, "Reset"])
def test_a_possible_key_has_no_effect_together_with_another_one(key: str) -> None:
    """Source: FB_RcxPanelKeys: which of them was meant?"""
    plc = OperatorBench()
    plc.outputs(SO02=key != "ServoOn", SO03=key == "Reset")
    plc.set(Automatic=key == "Start", scans=20)
    assert plc.can(key) == [True]
    plc.key(key)
    plc.key("StepLine" if key == "Teach" else "Teach")
    for _ in range(30):
        plc.scan()
        assert plc.inputs == ["SI00", "SI06"]
        assert not plc["Operator.Busy"]
    assert plc.message == 0x8073
    assert plc.sent == []
