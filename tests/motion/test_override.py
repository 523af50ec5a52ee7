"""FB_Override changes the automatic movement speed in steps.

The test plays the controller.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import pytest

from both_engines import ENGINES
from part_bench import PartBench
from plc_bench import ROOT, PlcBench

PROGRAM = ROOT / "tests/data/library/Watch.st"


def _plc(engine: str = "auto", **pins: Any) -> PlcBench:
    plc = PlcBench(program=PROGRAM, engine=engine)
    plc.power_up()
    plc.scan(3)
    for name, value in pins.items():
        plc[f"SpeedOverride.{name}"] = value
    return plc


def _end(plc: PlcBench) -> None:
    """Let the running command end normally, and reset the status."""
    plc.answer(0x0200)
    plc.scan()
    plc.answer(0)


def _answer(plc: PlcBench, code: int, *response: int) -> int:
    """Wait for a command with this code, answer and reset it, and return data word n + 4."""
    plc.scan_until(lambda: plc.words[0] == code)
    data = plc.words[2]
    plc.answer(0x0200, response)
    plc.scan()
    plc.answer(0)
    return data


def _begun(engine: str = "auto", auto: int = 50, **pins: Any) -> PlcBench:
    """Return an enabled bench after the controller has reported the automatic speed `auto`."""
    plc = _plc(engine, Enable=True, **pins)
    _answer(plc, 0x050A, 0, auto, 70, 80)
    return plc


def _moving(engine: str = "auto", percent: int = 50, **pins: Any) -> PlcBench:
    """Return a bench at 50 % in which a step up waits for the end of a running movement."""
    plc = _begun(engine, percent, Percent=percent)
    plc.scan(3)
    plc["First.Code"], plc["First.Execute"] = 0x0001, True
    plc.scan_until(lambda: plc.words[0] == 0x0001)
    for name, value in pins.items():
        plc[f"SpeedOverride.{name}"] = value
    plc.scan(5)
    return plc


def _percents(plc: PlcBench, count: int, code: int = 0x0039) -> list[int]:
    return [_answer(plc, code) for _ in range(count)]


@pytest.mark.parametrize("engine", ENGINES)
def test_the_speed_is_read_and_raised_in_steps(engine: str) -> None:
    """The speed rises from 50 to 75 % in steps of at most 10 %.

    Word n + 4 is the speed, and the code is that of the automatic speed.

    Source: remote command guide 4.7.8, AUTO mode speed in m + 4; 4.2.15
    """
    plc = _begun(engine, Percent=75)
    assert plc["SpeedOverride.Actual"] == 50
    assert (plc["SpeedOverride.Busy"], plc["SpeedOverride.Valid"]) == (True, False)
    assert _percents(plc, 3) == [60, 70, 75]
    assert (plc["SpeedOverride.Actual"], plc["SpeedOverride.Valid"]) == (75, True)
    plc.scan(100)
    assert not any(plc.words)
    assert (plc["SpeedOverride.Busy"], plc["SpeedOverride.Valid"]) == (False, True)


def test_the_command_goes_to_the_designated_robot() -> None:
    """The robot number is in the code of the command, and is sampled at the start.

    Source: remote command guide 4.2.15 and 4.7.8: R in bits 15 to 12.
    """
    plc = _plc(Enable=True, RobotNumber=2, Percent=20)
    assert _answer(plc, 0x250A, 0, 10) == 0
    plc["SpeedOverride.RobotNumber"] = 3
    assert _percents(plc, 1, 0x2039) == [20]


def test_a_lower_speed_is_sent_at_once_in_one_step() -> None:
    """A lower speed is sent at once, also while a step up waits for its time."""
    plc = _begun(Percent=80, Pace="T#10s")
    assert _percents(plc, 1) == [60]
    plc.scan(10)
    plc["SpeedOverride.Percent"] = 5
    assert plc.scan_until(lambda: plc.words[0] == 0x0039) == 2
    assert _percents(plc, 1) == [5]
    assert plc["SpeedOverride.Valid"]


@pytest.mark.parametrize("pace", [None, 500])
def test_the_interval_between_steps_up_is_pace(pace: int | None) -> None:
    """The time from code to code is 200 ms and at most three scans more.

    Source: pin Pace: from one step up to the next, at least
    """
    pins: dict[str, Any] = {} if pace is None else {"Pace": f"T#{pace}ms"}
    plc = _begun(Percent=100, **pins)
    moments = []
    for _ in range(5):
        plc.scan_until(lambda: plc.words[0] == 0x0039)
        moments.append(plc.now_us // 1000)
        _answer(plc, 0x0039)
    apart = {b - a for a, b in pairwise(moments)}
    assert all((pace or 200) <= one <= (pace or 200) + 30 for one in apart), apart


@pytest.mark.parametrize("engine", ENGINES)
def test_pace_is_measured_from_the_scan_in_which_a_step_is_sent(engine: str) -> None:
    """Pace is measured from the scan in which a step is sent.

    The step has waited longer than Pace for the end of a movement.

    Source: pin Pace: from one step up to the next, at least
    """
    plc = _moving(engine, Pace="T#500ms", Percent=100)
    plc.scan(100)
    _end(plc)
    plc.scan_until(lambda: plc.words[0] == 0x0039)
    out = plc.now_us
    assert _percents(plc, 1) == [60]
    plc.scan_until(lambda: plc.words[0] == 0x0039, most=100)
    assert plc.now_us - out >= 500_000


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("lower", [55, 50, 5])
def test_a_waiting_step_is_sent_with_a_lower_percent(engine: str, lower: int) -> None:
    """If Percent is lowered while a step up waits, the step is sent with the lower speed.

    The next movement must not run at the higher speed.

    Source: head: a lower Percent goes out at once
    """
    plc = _moving(engine, Percent=80)
    plc["Last.Code"], plc["Last.Execute"] = 0x0003, True
    plc.scan(3)
    plc["SpeedOverride.Percent"] = lower
    plc.scan(50)
    _end(plc)
    assert _percents(plc, 1) == [lower]
    assert (plc["SpeedOverride.Actual"], plc["SpeedOverride.Valid"]) == (lower, True)
    plc.scan_until(lambda: plc.words[0] == 0x0003, most=6)

    assert plc["Last.Busy"], "no command of this block lies between them"


@pytest.mark.parametrize("engine", ENGINES)
def test_valid_is_false_while_a_step_to_another_speed_is_sent(engine: str) -> None:
    """Source: pins: Valid, the controller has accepted Percent; Busy, changing the speed."""
    plc = _begun(engine, Percent=80, auto=5, Rise=30)
    plc.scan_until(lambda: plc.words[0] == 0x0039)
    assert plc.words[2] == 35
    plc["SpeedOverride.Percent"] = 5
    for _ in range(20):
        plc.scan()
        shown = [plc[f"SpeedOverride.{pin}"] for pin in ("Valid", "Busy", "Actual")]
        assert shown == [False, True, 5]
    assert _percents(plc, 2) == [35, 5]
    plc.scan(2)
    assert plc["SpeedOverride.Valid"]


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    ("first", "then", "percents"),
    [(5, [50], [50]), (5, [100], [50, 60]), (5, [30], [30]), (80, [5, 100], [60, 70])],
)
def test_a_waiting_step_is_sent_with_the_latest_percent(
    engine: str, first: int, then: list[int], percents: list[int]
) -> None:
    """Source: head: Keep the automatic movement speed at a percentage; pin Rise."""
    plc = _moving(engine, Percent=first)
    for percent in then:
        plc["SpeedOverride.Percent"] = percent
        plc.scan(5)
    assert not plc["SpeedOverride.Valid"]
    _end(plc)
    assert _percents(plc, len(percents)) == percents


@pytest.mark.parametrize("scans", range(5))
def test_the_speed_is_sent_one_scan_before_its_code_and_then_held(scans: int) -> None:
    """The speed is sent one scan before its code, and stays if Percent is lowered afterwards.

    Source: remote command guide chapter 2: the data first; both held until the end status
    """
    plc = _begun(Percent=80)
    plc.scan(scans)
    plc["SpeedOverride.Percent"] = 5
    before = plc.words
    while plc.words[0] != 0x0039:
        before = plc.words
        plc.scan()
    assert before[1:] == plc.words[1:]
    out = list(plc.words)
    plc.scan(20)
    assert plc.words == out
    assert _percents(plc, 1) == [out[2]]
    assert plc["SpeedOverride.Actual"] == out[2]
    if out[2] != 5:
        assert _percents(plc, 1) == [5]
    assert plc["SpeedOverride.Valid"]


def test_after_a_step_down_the_next_one_up_need_not_wait() -> None:
    plc = _begun(Percent=40, Pace="T#10s")
    assert _percents(plc, 1) == [40]
    plc["SpeedOverride.Percent"] = 45
    assert plc.scan_until(lambda: plc.words[0] == 0x0039, most=4) <= 4
    assert _percents(plc, 1) == [45]


@pytest.mark.parametrize(
    ("auto", "percent", "rise", "steps"),
    [
        (50, 50, 10, []),
        (50, 51, 10, [51]),
        (50, 60, 10, [60]),
        (50, 61, 10, [60, 61]),
        (85, 100, 10, [95, 100]),
        (90, 100, 10, [100]),
        (95, 100, 10, [100]),
        (0, 30, 20, [20, 30]),
        (1, 100, 100, [100]),
        (1, 3, 1, [2, 3]),
        (100, 1, 1, [1]),
    ],
)
def test_no_step_exceeds_rise_or_percent(
    auto: int, percent: int, rise: int, steps: list[int]
) -> None:
    """No step exceeds Rise or Percent. A robot without axes reports the speed 0.

    Source: remote command guide 4.7.8.
    """
    plc = _begun(auto=auto, Percent=percent, Rise=rise, Pace="T#0s")
    assert _percents(plc, len(steps)) == steps
    assert plc["SpeedOverride.Valid"]
    plc.scan(50)
    assert not any(plc.words)


def test_the_defaults_go_to_10_percent() -> None:
    plc = _begun(auto=100)
    assert _percents(plc, 1) == [10]


def test_a_step_waits_for_the_end_of_a_command_and_a_command_for_one_step() -> None:
    plc = _begun(Percent=100, Pace="T#0s")
    plc.scan_until(lambda: plc.words[0] == 0x0039)
    plc["First.Code"], plc["First.Execute"] = 0x0501, True
    plc.scan()
    _answer(plc, 0x0039)
    plc.scan_until(lambda: plc.words[0] != 0)
    assert plc.words[0] == 0x0501
    plc.scan(50)
    assert plc.words[0] == 0x0501
    _end(plc)
    assert _percents(plc, 1) == [70]


def test_a_percent_that_changes_on_the_way_is_the_new_target() -> None:
    plc = _begun(Percent=100)
    plc.scan_until(lambda: plc.words[0] == 0x0039)
    plc["SpeedOverride.Percent"] = 55
    assert _percents(plc, 2) == [60, 55]
    assert plc["SpeedOverride.Valid"]
    plc["SpeedOverride.Percent"] = 56
    plc.scan()
    assert (plc["SpeedOverride.Valid"], plc["SpeedOverride.Busy"]) == (False, True)


@pytest.mark.parametrize(
    ("pin", "value", "error"),
    [
        ("Percent", 0, 0x8042),
        ("Percent", 101, 0x8042),
        ("Percent", -1, 0x8042),
        ("Rise", 0, 0x8045),
        ("Rise", 101, 0x8045),
        ("RobotNumber", 5, 0x8040),
    ],
)
def test_a_value_beyond_the_manuals_range_is_refused(pin: str, value: int, error: int) -> None:
    """Source: remote command guide 4.2.15: 1 to 100."""
    pins: dict[str, Any] = {pin: value}
    plc = _plc(Enable=True, **pins)
    plc.scan(5)
    assert (plc["SpeedOverride.Error"], plc["SpeedOverride.ErrorID"]) == (True, error)
    assert not any(plc.words)
    plc[f"SpeedOverride.{pin}"] = 1
    plc.scan(5)
    assert plc["SpeedOverride.ErrorID"] == error, "the error stays until Enable falls"
    plc["SpeedOverride.Enable"] = False
    plc.scan()
    assert (plc["SpeedOverride.Error"], plc["SpeedOverride.ErrorID"]) == (False, 0)
    plc["SpeedOverride.Enable"] = True
    plc.scan_until(lambda: plc.words[0] != 0, most=3)


@pytest.mark.parametrize("step", ["read", "change"])
def test_an_abnormal_end_is_shown_with_its_alarm(step: str) -> None:
    plc = _plc(Enable=True) if step == "read" else _begun()
    code = {"read": 0x050A, "change": 0x0039}[step]
    plc.scan_until(lambda: plc.words[0] == code)
    plc.answer(0x4000, [14, 303])
    plc.scan()
    plc.answer(0)
    for _ in range(50):
        assert (plc["SpeedOverride.ErrorID"], plc["SpeedOverride.Error"]) == (0x8020, True)
        assert (plc["SpeedOverride.AlarmGroup"], plc["SpeedOverride.AlarmCategory"]) == (14, 303)
        assert plc["SpeedOverride.Actual"] == (0 if step == "read" else 50)
        plc.scan()
        assert not any(plc.words)
    plc["SpeedOverride.Enable"] = False
    plc.scan()
    assert (plc["SpeedOverride.AlarmGroup"], plc["SpeedOverride.AlarmCategory"]) == (0, 0)
    assert (plc["SpeedOverride.Error"], plc["SpeedOverride.Actual"]) == (False, 0)


@pytest.mark.parametrize("moment", [0, 1, 2, 4, 30])
@pytest.mark.parametrize(("lost", "error"), [("link", 0x8001), ("CPU_OK", 0x8002)])
def test_a_loss_ends_it_at_once_and_nothing_restarts(moment: int, lost: str, error: int) -> None:
    plc = _begun(Percent=50) if moment == 30 else _plc(Enable=True)
    plc.scan(moment)
    plc["Connected"] = lost != "link"
    plc.outputs(SO01=lost == "link")
    plc.scan()
    assert plc["SpeedOverride.ErrorID"] == error
    plc["Connected"] = True
    plc.outputs(SO01=True)
    plc.answer(0)
    plc.scan(100)
    assert plc["SpeedOverride.ErrorID"] == error
    assert not any(plc.words)


@pytest.mark.parametrize("step", ["read", "change"])
def test_a_missing_answer_ends_the_block_after_timeout(step: str) -> None:
    """A missing answer ends the block after Timeout, which is sampled when Enable rises.

    Source: docs/reference/errors.md, 16#8011.
    """
    pins: dict[str, Any] = {"Timeout": "T#100ms"}
    plc = _plc(Enable=True, **pins) if step == "read" else _begun(**pins)
    plc["SpeedOverride.Timeout"] = "T#0s" if step == "change" else "T#100ms"
    plc.scan_until(lambda: bool(plc["SpeedOverride.Error"]), most=14)
    assert plc["SpeedOverride.ErrorID"] == 0x8011


@pytest.mark.parametrize("lost", ["no end", "link", "CPU_OK", "status", "an illegal Percent first"])
def test_without_the_end_of_a_step_the_speed_is_unknown(lost: str) -> None:
    """If the end of a step was not received, Actual is 0: perhaps the controller has executed it.

    Source: pin Actual: 0 = not known.
    """
    plc = _begun(Percent=80, Timeout="T#100ms")
    plc.scan_until(lambda: plc.words[0] == 0x0039)
    assert plc["SpeedOverride.Actual"] == 50
    if lost == "link":
        plc["Connected"] = False
    elif lost == "CPU_OK":
        plc.outputs(SO01=False)
    elif lost == "status":
        plc.answer(0x0100)
        plc.scan(2)
        plc.answer(0)
    elif lost == "an illegal Percent first":
        plc["SpeedOverride.Percent"] = 0
    plc.scan(15)
    assert plc["SpeedOverride.Error"]
    assert plc["SpeedOverride.Actual"] == 0


def test_the_speed_stays_known_if_the_step_was_not_sent() -> None:
    """Source: docs/reference/errors.md, 16#8012: an earlier command has no end."""
    plc = _moving(Percent=80)
    plc["Connected"] = False
    plc.scan()
    assert (plc["SpeedOverride.ErrorID"], plc["SpeedOverride.Actual"]) == (0x8001, 50)


def test_a_command_of_an_earlier_enable_has_no_effect() -> None:
    """A command of an earlier Enable does not set Actual. The block reads the speed again."""
    plc = _begun(Percent=100, Pace="T#0s")
    plc.scan_until(lambda: plc.words[0] == 0x0039)
    plc["SpeedOverride.Enable"] = False
    plc.scan()
    shown = [plc[f"SpeedOverride.{pin}"] for pin in ("Valid", "Busy", "Error", "Actual")]
    assert shown == [False, False, False, 0]
    plc["SpeedOverride.Enable"] = True
    plc.scan()
    _answer(plc, 0x0039)
    assert (plc["SpeedOverride.Busy"], plc["SpeedOverride.Actual"]) == (True, 0)
    _answer(plc, 0x050A, 0, 65)
    assert plc["SpeedOverride.Actual"] == 65
    assert _percents(plc, 1) == [75]


def _waiting() -> PlcBench:
    """Return a bench in which a step from 50 to 20 % waits for another command to end."""
    plc = _begun(Percent=50)
    plc["First.Code"], plc["First.Execute"] = 0x0501, True
    plc.scan(4)
    plc["SpeedOverride.Percent"] = 20
    plc.scan(5)
    return plc


def test_a_step_that_still_waits_is_withdrawn_when_enable_falls() -> None:
    """If Enable falls, a waiting step is withdrawn: the block no longer controls the speed."""
    plc = _waiting()
    plc["SpeedOverride.Enable"] = False
    plc.scan()
    _end(plc)
    plc.scan(20)
    assert not any(plc.words)


@pytest.mark.parametrize(("pin", "value", "error"), [("Percent", 0, 0x8042), ("Rise", 101, 0x8045)])
def test_a_waiting_step_is_withdrawn_after_an_illegal_input(
    pin: str, value: int, error: int
) -> None:
    """If an input becomes illegal, a waiting step is withdrawn and the Error stays.

    A command that was already sent is held to its end.
    """
    plc = _waiting()
    plc[f"SpeedOverride.{pin}"] = value
    plc.scan()
    assert plc["SpeedOverride.ErrorID"] == error
    _end(plc)
    plc.scan(20)
    assert not any(plc.words)
    shown = [plc[f"SpeedOverride.{name}"] for name in ("ErrorID", "Error", "Busy", "Actual")]
    assert shown == [error, True, False, 50]


def test_a_sent_step_is_held_to_its_end_despite_an_illegal_input() -> None:
    """If an input becomes illegal after a step was sent, the step is held to its end.

    The controller executes the step, and Actual shows its speed.

    Source: remote command guide chapter 2: the code stays until the end status.
    """
    plc = _begun(Percent=40)
    plc.scan_until(lambda: plc.words[0] == 0x0039)
    plc["SpeedOverride.Percent"] = 0
    plc.scan(5)
    assert (plc.words[0], plc["SpeedOverride.ErrorID"]) == (0x0039, 0x8042)
    _answer(plc, 0x0039)
    assert (plc["SpeedOverride.ErrorID"], plc["SpeedOverride.Actual"]) == (0x8042, 40)


def test_the_pace_of_an_earlier_enable_does_not_hold_a_step() -> None:
    plc = _begun(Percent=100, Pace="T#10s")
    _percents(plc, 1)
    plc["SpeedOverride.Enable"] = False
    plc.scan()
    plc["SpeedOverride.Enable"] = True
    _answer(plc, 0x050A, 0, 60)
    assert plc.scan_until(lambda: plc.words[0] == 0x0039) <= 4


def _steady(engine: str = "builtin", **pins: Any) -> PartBench:
    """Return a bench with a speed of 60 %, from which any other speed is reached in one step."""
    bench = PartBench(engine)
    for name, value in {**pins, "Percent": 60, "Rise": 100, "Enable": True}.items():
        bench[f"Speed.{name}"] = value
    bench.until(lambda: bool(bench["Speed.Valid"]))
    return bench


@pytest.mark.parametrize("engine", ENGINES)
def test_the_speed_is_unknown_after_scans_without_a_call(engine: str) -> None:
    """After scans without a call, Actual is 0: perhaps the step was sent and executed.

    Source: docs/explanation/scan-model.md, one scan
    """
    bench = _steady(engine)
    bench["Speed.Percent"] = 20
    bench.scan(2)
    assert (bench.plc.words[0], bench["Speed.Actual"]) == (0x0039, 60)
    bench["CallSpeed"] = False
    bench.scan(10)
    assert bench.told[-1] == "039"
    bench["CallSpeed"] = True
    bench.scan()
    assert (bench["Speed.ErrorID"], bench["Speed.Actual"]) == (0x8013, 0)


@pytest.mark.parametrize(("code", "seen"), [(0x0039, True), (0x1039, True), (0x2039, False)])
@pytest.mark.parametrize("robot", [0, 1])
def test_a_speed_set_by_another_block_is_detected(code: int, seen: bool, robot: int) -> None:
    """If another block sets the speed of the same robot, FB_Override detects this.

    Robot 0 means robot 1.

    Source: guide 4.2.15; 1.1, robot designation.
    """
    bench = _steady(RobotNumber=robot)
    bench.send(code, 0, 100)
    bench.scan(8)
    shown = (bench["Speed.Valid"], bench["Speed.ErrorID"], bench["Speed.Actual"])
    assert shown == ((False, 0x805D, 0) if seen else (True, 0, 60))


@pytest.mark.parametrize(
    ("pin", "value", "error"), [("EarlySpeed", True, 0x8017), ("Speed.Percent", 0, 0x8042)]
)
@pytest.mark.parametrize("scans", [2, 1])
def test_the_speed_is_unknown_after_missing_calls_that_end_in_another_error(
    scans: int, pin: str, value: int, error: int
) -> None:
    """If missing calls end in another error, Actual is 0: perhaps the step was executed.

    This holds even if only the data of the step had been sent.

    Source: head of FB_Override: after a step without an end status Actual is 0
    """
    bench = _steady()
    bench["Speed.Percent"] = 20
    bench.scan(scans)
    assert bench.plc.words[0] == (0x0039 if scans == 2 else 0)
    bench["CallSpeed"] = False
    bench.scan(10)
    bench["CallSpeed"] = True
    bench[pin] = value
    bench.scan()
    assert (bench["Speed.ErrorID"], bench["Speed.Actual"]) == (error, 0)


def test_a_step_that_was_not_sent_leaves_the_speed_known() -> None:
    """If a call is missing while a step waits for a movement, Actual keeps its value.

    Source: head of FB_Override.
    """
    bench = _steady()
    bench.fault = "late"
    bench.send(0x0001, 0, 0, 0, 30)
    bench.scan(5)
    bench["Speed.Percent"] = 20
    bench.scan(5)
    bench["CallSpeed"] = False
    bench.scan()
    bench["CallSpeed"] = True
    bench.scan()
    assert (bench["Speed.ErrorID"], bench["Speed.Actual"]) == (0x8013, 60)
