"""FB_ToolPosition reads the position between commands, or gets it directly, and shows the age."""

from __future__ import annotations

import math
from datetime import timedelta
from typing import Any

import pytest

from both_engines import ENGINES
from plc_bench import ROOT, PlcBench

PROGRAM = ROOT / "tests/data/library/Watch.st"

#: m+6 to m+22: right-handed; X 20.001, Y -12.345, Z 0.001 mm and R 90 degrees.
_PLACE = [0x0002, 0x4E21, 0, 0xCFC7, 0xFFFF, 1, 0, 0x5F90, 0x0001]
_SHOWN = [20.001, -12.345, 0.001, 90.0, 0.0, 0.0]


def _plc(engine: str = "auto", **pins: Any) -> PlcBench:
    plc = PlcBench(program=PROGRAM, engine=engine)
    plc.power_up()
    plc.scan(3)
    for name, value in pins.items():
        plc[f"Position.{name}"] = value
    return plc


def _ms(plc: PlcBench) -> float:
    """Return the output Age [ms]."""
    age = plc["Position.Age"]
    assert isinstance(age, timedelta)
    return age / timedelta(milliseconds=1)


def _read(plc: PlcBench, place: list[int] | None = None) -> None:
    """Wait for the reading command, answer it at once, and reset the status."""
    plc.scan_until(lambda: plc.words[0] & 0x0FFF == 0x0506)
    plc.complete(0x0200, [0, 0, *(place or _PLACE)])


def _watching(engine: str = "auto", **pins: Any) -> PlcBench:
    """Return a bench that has just read its first position. The channel is free."""
    plc = _plc(engine, Enable=True, **pins)
    _read(plc)
    assert plc["Position.Valid"]
    return plc


@pytest.mark.parametrize("before", [0, 1, 2])
@pytest.mark.parametrize("engine", ENGINES)
def test_the_first_position_is_read_at_once(engine: str, before: int) -> None:
    """Source: remote command guide 4.7.4, millimeter units."""
    plc = _plc(engine, RobotNumber=3)
    plc.scan(before)
    plc.change("Position.Enable", to=True)
    assert (plc["Position.Busy"], plc["Position.Valid"]) == (True, False)
    plc.scan()
    assert plc.words == [0x3506, *[0] * 15]
    plc.answer(0x0200, [0, 0, *_PLACE], scans=1)
    assert (plc["Position.Busy"], plc["Position.Valid"]) == (False, True)
    assert plc["Position.PositionMm"] == pytest.approx(_SHOWN)
    assert plc["Position.HandSystem"] == "HAND_RIGHT"
    plc.answer(0, scans=20)
    assert plc["Position.Valid"], "a direct position in every scan"
    assert plc["Position.PositionMm"] == pytest.approx(_SHOWN)


@pytest.mark.parametrize(
    ("word", "hand"),
    [
        *((0, "HAND_NONE"), (2, "HAND_RIGHT"), (4, "HAND_LEFT"), (6, "HAND_NONE")),
        *((0x0008, "HAND_NONE"), (0x078A, "HAND_RIGHT"), (0x07FC, "HAND_LEFT")),
    ],
)
def test_a_robot_without_a_hand_system_has_none(word: int, hand: str) -> None:
    """If the robot reports no hand system, the output is HAND_NONE, whatever it was before.

    In bits 2 and 1 of m+6, 01 is right-handed and 10 left-handed. The bits above are arm rotations.

    Source: remote command guide 4.7.4.
    """
    plc = _plc(Enable=True, Period="T#100ms")
    plc["Position.HandSystem"] = "HAND_RIGHT" if hand != "HAND_RIGHT" else "HAND_LEFT"
    _read(plc, [word, *_PLACE[1:]])
    assert plc["Position.HandSystem"] == hand
    assert plc["Position.PositionMm"] == pytest.approx(_SHOWN)


@pytest.mark.parametrize("engine", ENGINES)
def test_the_age_counts_from_the_scan_in_which_the_data_are_sent(engine: str) -> None:
    """Age counts from the scan in which the data of the command are sent.

    The code follows in the second scan. The answer comes 50 ms later.
    """
    plc = _plc(engine, Enable=True)
    plc.scan(2)
    assert plc.words[0] == 0x0506
    plc.scan(5)
    plc.answer(0x0200, [0, 0, *_PLACE], scans=1)
    assert _ms(plc) == pytest.approx(70)
    plc.answer(0, scans=3)
    assert _ms(plc) == pytest.approx(100)


def test_waiting_for_the_channel_does_not_increase_the_age() -> None:
    """The time in which another command uses the channel is not included in Age.

    Age counts from the scan in which the other command ends. It includes reset, data, code and
    answer.
    """
    plc = _plc()
    plc["First.Code"], plc["First.Execute"] = 0x0501, True
    plc.scan(2)
    plc.change("Position.Enable", to=True, scans=30)
    plc.complete()
    _read(plc)
    assert _ms(plc) == pytest.approx(30)


@pytest.mark.parametrize("period", [None, 100, 200])
def test_the_position_is_read_again_after_period(period: int | None) -> None:
    """The position is read again after Period, which is half a second by default."""
    plc = _watching(**({} if period is None else {"Period": f"T#{period}ms"}))
    assert _ms(plc) == pytest.approx(20)
    scans = plc.scan_until(lambda: plc.words[0] == 0x0506)
    assert scans == (period or 500) // 10 - 1, "data in the scan of the period, then the code"
    assert _ms(plc) == pytest.approx((period or 500) + 10), (
        "the last position stays until the answer"
    )
    plc.answer(0x0200, [0, 0, 4, 5], scans=1)
    assert _ms(plc) == pytest.approx(20)
    assert plc["Position.PositionMm"][0] == pytest.approx(0.005)
    assert plc["Position.HandSystem"] == "HAND_LEFT"


def test_while_a_command_is_out_it_waits_and_the_age_grows() -> None:
    plc = _watching(Period="T#100ms")
    plc["First.Code"], plc["First.Execute"], plc["First.Timeout"] = 0x0501, True, "T#0s"
    plc.scan(100)
    assert plc.words[0] == 0x0501
    assert plc["Position.Valid"]
    assert _ms(plc) == pytest.approx(1020)
    assert plc["Robot.Inner.Command.NextTicket"] - plc["Robot.Inner.Command.Serving"] == 1, (
        "the block takes no ticket while a command is on the wire"
    )
    plc.complete()
    _read(plc)
    assert _ms(plc) == pytest.approx(30)


def test_a_chain_of_commands_without_a_gap_is_never_delayed() -> None:
    """The reading never delays a chain of commands without a gap.

    Each command takes its ticket in the scan in which the previous command ends.
    """
    plc = _watching(Period="T#0ms")
    _read(plc)
    plc["First.Code"], plc["Last.Code"] = 0x0501, 0x0502
    plc.scan_until(lambda: plc.words[0] == 0x0501, execute="First")
    for name, code in (("Last", 0x0502), ("First", 0x0501)):
        plc.change(f"{name}.Execute", to=True)
        plc.answer(0x0200, scans=1)
        plc[f"{'First' if name == 'Last' else 'Last'}.Execute"] = False
        plc.answer(0)
        plc.scan_until(lambda code=code: plc.words[0] == code, most=3)  # type: ignore[misc]


def test_another_command_waits_for_one_reading_at_most() -> None:
    """Another command waits for at most one reading, even if Period is 0."""
    plc = _watching(Period="T#0ms")
    plc.scan_until(lambda: plc.words[0] == 0x0506)
    plc["First.Code"], plc["First.Execute"] = 0x0501, True
    plc.scan()
    _read(plc)
    plc.scan_until(lambda: plc.words[0] != 0, most=3)
    assert plc.words[0] == 0x0501


@pytest.mark.parametrize("period", ["T#500ms", "T#0s"])
def test_what_is_given_directly_is_the_position_and_nothing_is_read(period: str) -> None:
    plc = _plc(Enable=True, Direct=True, DirectMm=[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], Period=period)
    plc["Position.DirectHand"] = "HAND_LEFT"
    for _ in range(100):
        plc.scan()
        assert plc["Position.Valid"]
        assert plc["Position.PositionMm"] == [1, 2, 3, 4, 5, 6]
        assert plc["Position.HandSystem"] == "HAND_LEFT"
        assert _ms(plc) == 0
        assert not any(plc.words)


def test_when_nothing_is_given_directly_any_more_it_reads_after_the_period() -> None:
    plc = _plc(Enable=True, Direct=True, DirectMm=[1.0] * 6, Period="T#100ms")
    plc.scan(5)
    plc["Position.Direct"] = False
    scans = plc.scan_until(lambda: plc.words[0] == 0x0506)
    assert scans == 11
    assert plc["Position.PositionMm"] == [1] * 6
    _read(plc)
    assert plc["Position.PositionMm"] == pytest.approx(_SHOWN)


def test_the_more_recent_of_a_reading_and_a_direct_position_is_shown() -> None:
    """Of a reading and a direct position, the more recent one is shown.

    The reading was requested before or after the direct position came.
    """
    plc = _plc(Enable=True, DirectMm=[1.0] * 6, Period="T#0ms")
    plc.scan(2)
    plc.change("Position.Direct", to=True)
    plc["Position.Direct"] = False
    _read(plc)
    assert plc["Position.PositionMm"] == [1] * 6
    assert _ms(plc) == pytest.approx(20)
    _read(plc)
    assert plc["Position.PositionMm"] == pytest.approx(_SHOWN)
    plc.change("Position.Direct", to=True)
    plc["Position.Direct"] = False
    plc.scan_until(lambda: plc.words[0] == 0x0506)
    plc.answer(0x0200, [0, 0, 2, 7], scans=1)
    assert plc["Position.PositionMm"][0] == pytest.approx(0.007), (
        "both were requested in the same scan"
    )


def test_a_reading_that_starts_in_the_scan_of_a_direct_position_is_not_older() -> None:
    """A reading that gets the channel in the scan of a direct position is not older than it.

    The reading has waited for another command.
    """
    plc = _plc(DirectMm=[1.0] * 6, Period="T#10s")
    plc["First.Code"], plc["First.Execute"] = 0x0501, True
    plc.scan(2)
    plc.change("Position.Enable", to=True)
    assert plc["Position.Busy"]
    plc.change("Position.Direct", to=True, scans=5)
    plc.answer(0x0200)
    plc.scan_until(lambda: bool(plc["Position.Reading.Active"]), most=1)
    plc.answer(0)
    plc["Position.Direct"] = False
    assert (plc["Position.PositionMm"], _ms(plc)) == ([1] * 6, 0)
    _read(plc)
    assert plc["Position.PositionMm"] == pytest.approx(_SHOWN)


def test_an_abnormal_end_is_shown_with_its_alarm_until_enable_falls() -> None:
    plc = _plc(Enable=True)
    plc.scan(2)
    plc.complete(0x4000, [4, 2])
    for _ in range(100):
        assert (plc["Position.Error"], plc["Position.ErrorID"]) == (True, 0x8020)
        assert (plc["Position.AlarmGroup"], plc["Position.AlarmCategory"]) == (4, 2)
        assert not plc["Position.Valid"]
        plc.scan()
        assert not any(plc.words), "reading does not start again by itself"
    plc.change("Position.Enable", to=False)
    shown = [plc[f"Position.{pin}"] for pin in ("Error", "ErrorID", "AlarmGroup", "AlarmCategory")]
    assert shown == [False, 0, 0, 0]
    plc["Position.Enable"] = True
    _read(plc)
    assert plc["Position.Valid"]


@pytest.mark.parametrize("moment", [0, 1, 2, 3, 30])
@pytest.mark.parametrize(("lost", "error"), [("link", 0x8001), ("CPU_OK", 0x8002)])
@pytest.mark.parametrize("direct", [False, True])
def test_a_loss_ends_the_block_in_the_same_scan_and_nothing_restarts(
    moment: int, lost: str, error: int, direct: bool
) -> None:
    """A loss of the link ends the block in the same scan, and nothing restarts.

    The loss comes before a reading, during a reading, or between two readings.
    """
    plc = _plc(Enable=True, Direct=direct)
    if moment < 4:
        plc.scan(moment)
    else:
        _read(plc) if not direct else None
        plc.scan(moment)
    plc["Connected"] = lost != "link"
    plc.outputs(SO01=lost == "link", scans=1)
    assert (plc["Position.ErrorID"], plc["Position.Valid"]) == (error, False)
    plc["Connected"] = True
    plc.outputs(SO01=True)
    plc.answer(0, scans=100)
    assert plc["Position.ErrorID"] == error
    assert not any(plc.words)


@pytest.mark.parametrize("number", [0, 1, 4])
def test_the_robot_is_in_the_code(number: int) -> None:
    """Source: remote command guide 4.7.4: bits 15 to 12."""
    plc = _plc(Enable=True, RobotNumber=number)
    plc.scan(2)
    assert plc.words[0] == number << 12 | 0x0506


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("k", range(6))
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 2_147_485.0, -2_147_485.0])
def test_an_illegal_direct_position_is_an_error(engine: str, k: int, value: float) -> None:
    """An illegal direct position is an error, which stays until Enable falls.

    The value is not a number, or does not fit into a double word of 0.001 mm.

    Source: docs/reference/errors.md, 16#8047; remote command guide 4.7.4: 32 bits, integers (x1000)
    """
    plc = _plc(engine, Enable=True, Direct=True, DirectMm=[1.0] * 6)
    plc.scan()
    assert plc["Position.Valid"] is True
    place = [1.0] * 6
    place[k] = value
    plc.change("Position.DirectMm", to=place)
    shown = [plc[f"Position.{pin}"] for pin in ("Valid", "Error", "ErrorID")]
    assert shown == [False, True, 0x8047]
    assert plc["Position.PositionMm"] == [1.0] * 6
    plc.change("Position.DirectMm", to=[2.0] * 6, scans=3)
    assert plc["Position.ErrorID"] == 0x8047
    plc.change("Position.Enable", to=False)
    plc.change("Position.Enable", to=True)
    assert (plc["Position.Valid"], plc["Position.PositionMm"]) == (True, [2.0] * 6)


def test_a_later_reading_does_not_replace_the_first_error() -> None:
    """Source: docs/reference/errors.md, 16#8047; comment of Error: until Enable falls."""
    for words in ([4, 2], [0, 0, *_PLACE]):
        plc = _plc(Enable=True)
        plc.scan(2)
        plc["Position.DirectMm"], plc["Position.Direct"] = [math.nan] * 6, True
        plc.scan(2)
        plc.answer(0x4000 if words == [4, 2] else 0x0200, words, scans=2)
        plc.answer(0, scans=3)
        shown = [plc[f"Position.{pin}"] for pin in ("ErrorID", "AlarmGroup", "Valid")]
        assert shown == [0x8047, 0, False]
        assert plc["Position.PositionMm"] == [0] * 6


def test_an_error_withdraws_a_waiting_reading() -> None:
    """Source: docs/reference/blocks.md, the contract: an error ends the work."""
    plc = _plc()
    plc["First.Code"], plc["First.Execute"], plc["First.Timeout"] = 0x0501, True, "T#0s"
    plc.scan_until(lambda: plc.words[0] == 0x0501)
    plc.change("Position.Enable", to=True, scans=2)
    plc["Position.DirectMm"], plc["Position.Direct"] = [math.nan] * 6, True
    plc.scan(2)
    assert plc["Position.ErrorID"] == 0x8047
    plc["First.Execute"] = False
    plc.complete()
    for _ in range(10):
        plc.scan()
        assert plc.words[0] in (0, 0x0501)


@pytest.mark.parametrize("value", [2_147_483.0, -2_147_483.0])
def test_every_position_that_a_controller_can_report_may_be_given_directly(value: float) -> None:
    """Source: remote command guide 4.7.4."""
    plc = _plc(Enable=True, Direct=True, DirectMm=[value] * 6)
    plc.scan()
    assert (plc["Position.Valid"], plc["Position.PositionMm"]) == (True, [value] * 6)


def test_a_direct_position_is_ignored_without_direct() -> None:
    """Source: comment of DirectMm."""
    plc = _plc(Enable=True, DirectMm=[math.nan] * 6)
    _read(plc)
    assert plc["Position.Valid"]
    assert plc["Position.PositionMm"] == pytest.approx(_SHOWN)


def test_without_enable_it_shows_nothing_whatever_its_pins_and_the_link_are() -> None:
    plc = _plc(Direct=True, DirectMm=[1.0] * 6, RobotNumber=5)
    for connected in (True, False, True):
        plc.change("Connected", to=connected, scans=5)
        shown = [plc[f"Position.{pin}"] for pin in ("Valid", "Busy", "Error", "ErrorID")]
        assert shown == [False, False, False, 0]
        assert plc["Position.PositionMm"] == [0] * 6


def test_after_an_error_a_direct_position_is_ignored() -> None:
    """Source: docs/reference/errors.md, 16#8040; comment of Error: until Enable falls."""
    plc = _plc(Enable=True, RobotNumber=5, DirectMm=[1.0] * 6)
    plc.scan()
    plc.change("Connected", to=False, scans=3)
    assert plc["Position.ErrorID"] == 0x8040
    plc["Connected"], plc["Position.Direct"] = True, True
    plc.scan(3)
    assert (plc["Position.ErrorID"], plc["Position.Valid"]) == (0x8040, False)
    assert plc["Position.PositionMm"] == [0] * 6


@pytest.mark.parametrize(("number", "error"), [(-1, 0x8040), (5, 0x8040)])
def test_an_illegal_robot_number_is_refused_without_a_telegram(number: int, error: int) -> None:
    plc = _plc(Enable=True, RobotNumber=number)
    plc.scan(5)
    assert plc["Position.ErrorID"] == error
    assert not any(plc.words)


def test_a_missing_answer_ends_the_block_after_timeout() -> None:
    """Source: docs/reference/errors.md, 16#8011."""
    plc = _plc(Enable=True, Timeout="T#100ms")
    plc.scan_until(lambda: bool(plc["Position.Error"]), most=12)
    assert plc["Position.ErrorID"] == 0x8011


def test_the_timeout_is_five_seconds_and_shows_no_alarm_of_another_command() -> None:
    """Source: docs/reference/errors.md, 16#8011; comment of AlarmGroup: of an abnormal end."""
    plc = _plc()
    plc.give("First", 0x0501)
    plc.answer(0x0200, [4, 2], scans=1)
    plc.answer(0, [4, 2])
    plc.change("Position.Enable", to=True)
    scans = plc.scan_until(lambda: bool(plc["Position.Error"]), most=520)
    assert 500 <= scans <= 510
    assert plc["Position.ErrorID"] == 0x8011
    assert (plc["Position.AlarmGroup"], plc["Position.AlarmCategory"]) == (0, 0)


def test_what_changes_before_the_first_answer_is_not_sampled_either() -> None:
    plc = _plc(Enable=True, RobotNumber=2, Period="T#100ms")
    plc.scan()
    plc["Position.RobotNumber"], plc["Position.Period"] = 7, "T#10s"
    plc.scan(3)
    assert plc["Position.Busy"]
    _read(plc)
    assert plc["Position.Valid"]
    plc.scan_until(lambda: plc.words[0] != 0, most=12)
    assert plc.words[0] == 0x2506


def test_number_period_and_timeout_are_sampled_at_the_start() -> None:
    plc = _watching(Period="T#100ms", RobotNumber=2, Timeout="T#0s")
    plc["Position.RobotNumber"], plc["Position.Period"] = 4, "T#10s"
    plc["Position.Timeout"] = "T#10ms"
    plc.scan_until(lambda: plc.words[0] != 0, most=12)
    assert plc.words[0] == 0x2506
    plc.scan(20)
    assert not plc["Position.Error"]


def test_a_reading_of_an_earlier_enable_is_ignored() -> None:
    """The answer to a reading of an earlier Enable is ignored.

    The reading belonged to another robot. The next reading starts as soon as it has ended.
    """
    plc = _plc(Enable=True, RobotNumber=2)
    plc.scan(2)
    plc.change("Position.Enable", to=False)
    shown = [plc[f"Position.{pin}"] for pin in ("Valid", "Busy", "Error")]
    assert shown == [False] * 3
    plc["Position.Enable"], plc["Position.RobotNumber"] = True, 3
    plc.scan()
    assert plc["Position.Busy"]
    _read(plc)
    assert not plc["Position.Valid"]
    plc.scan_until(lambda: plc.words[0] != 0, most=4)
    assert plc.words[0] == 0x3506
    _read(plc)
    assert plc["Position.Valid"]


def test_if_enable_falls_before_the_code_nothing_is_sent() -> None:
    """If Enable falls before the code is sent, the reading is dropped.

    The next command is sent without delay.
    """
    plc = _plc(Enable=True)
    plc.scan()
    plc.change("Position.Enable", to=False)
    assert not any(plc.words)
    plc.give("First", 0x0501, most=4)
    plc.change("Position.Enable", to=True, scans=5)
    plc.change("Position.Enable", to=False)
    plc.answer(0x0200, scans=1)
    plc.answer(0, scans=5)
    assert not any(plc.words)
    plc["Position.Enable"] = True
    _read(plc)
    assert plc["Position.Valid"]


def test_an_error_of_an_earlier_enable_counts_for_nothing() -> None:
    plc = _plc(Enable=True)
    plc.scan(2)
    plc.change("Position.Enable", to=False)
    plc.change("Position.Enable", to=True)
    plc.complete(0x4000, [4, 2])
    assert not plc["Position.Error"]
    _read(plc)
    assert plc["Position.Valid"]


def test_the_position_of_before_is_not_valid_in_the_next_enable() -> None:
    plc = _watching()
    plc.change("Position.Enable", to=False)
    assert not plc["Position.Valid"]
    plc.change("Position.Enable", to=True)
    assert (plc["Position.Valid"], plc["Position.Busy"]) == (False, True)


def test_the_age_includes_the_time_without_calls() -> None:
    """Age includes the time without calls, here 10 s.

    If calls are missing during a reading, the reading is lost like any command.

    Source: docs/explanation/scan-model.md, a block that is skipped.
    """
    plc = _watching()
    plc.change("CallPosition", to=False, scans=1000)
    plc.change("CallPosition", to=True)
    assert _ms(plc) == pytest.approx(10_030)
    plc.scan()
    assert plc.words[0] == 0x0506
    plc.change("CallPosition", to=False)
    plc.change("CallPosition", to=True)
    assert plc["Position.ErrorID"] == 0x8013


def test_the_age_stays_at_a_day() -> None:
    """Age is limited to one day, so it always fits into a TIME of 32 bits."""
    plc = _watching(Period="T#48h")
    plc.scan_us = 3_600_000_000
    plc.scan(30)
    age = plc["Position.Age"]
    assert isinstance(age, timedelta)
    assert timedelta(hours=24) <= age <= timedelta(hours=25)
    plc.scan(30)
    assert plc["Position.Age"] == age
    assert not any(plc.words)


def test_an_age_of_a_day_to_the_millisecond_stays() -> None:
    plc = _plc(Enable=True, Direct=True, Period="T#48h")
    plc.scan()
    plc["Position.Direct"] = False
    plc.now_us += 3_600_000_000 - plc.scan_us
    plc.scan_us = 3_600_000_000
    plc.scan(23)
    assert plc["Position.Age"] == timedelta(hours=23)
    plc.scan(30)
    assert plc["Position.Age"] == timedelta(hours=24)


def test_after_a_reading_that_takes_days_the_age_is_a_day() -> None:
    """If an answer takes days, Age is one day. Without a time limit it may come after 60 hours."""
    plc = _plc(Enable=True, Timeout="T#0s")
    plc.scan()
    plc.now_us += 3_600_000_000 - plc.scan_us
    plc.scan_us = 3_600_000_000
    plc.scan(60)
    assert plc.words[0] == 0x0506
    assert plc["Position.Busy"]
    plc.answer(0x0200, [0, 0, *_PLACE], scans=1)
    assert plc["Position.Valid"]
    assert plc["Position.Age"] == timedelta(hours=24)


def test_the_first_reading_is_shown_however_long_it_took() -> None:
    """The first reading is shown however long it took, because there is no more recent position.

    More than a day passes before the reading, and 28 hours during the reading, in steps of 7 hours.
    """
    plc = _plc(Timeout="T#0s")
    plc.scan_us = 3_600_000_000
    plc.scan(30)
    plc.change("Position.Enable", to=True)
    plc.scan_us = 7 * 3_600_000_000
    plc.scan_until(lambda: plc.words[0] == 0x0506)
    plc.scan(6)
    plc.answer(0x0200, [0, 0, *_PLACE], scans=1)
    assert plc["Position.Valid"]
    assert plc["Position.PositionMm"] == pytest.approx(_SHOWN)
