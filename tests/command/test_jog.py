"""FB_Jog: moves while Enable is TRUE, stops by SI(06), and comes back ready."""

from __future__ import annotations

import pytest

from plc_bench import ROOT, PlcBench

PROGRAM = ROOT / "tests/data/library/Levels.st"

#: 12.400 with the position of the manual's example: 12345, -123, 2000.
STOPPED = [0x000C, 0x0190, 0, 0x3039, 0, 0xFF85, 0xFFFF, 0x07D0, 0]


def _plc() -> PlcBench:
    plc = PlcBench(program=PROGRAM)
    plc.power_up()
    plc.scan(3)
    return plc


def _jogging(plc: PlcBench, **pins: object) -> None:
    """Enable, until the code is out and the controller runs it."""
    for name, value in pins.items():
        plc[f"Jog.{name}"] = value
    plc["Jog.Enable"] = True
    plc.scan_until(lambda: plc.words[0] != 0)
    plc.answer(0x0100)
    plc.scan()


def _stop(plc: PlcBench) -> None:
    """Enable falls, the controller ends the jog with 12.400."""
    plc["Jog.Enable"] = False
    plc.scan(2)
    plc.answer(0x4000, STOPPED)
    plc.scan()
    plc.answer(0)


def _present(plc: PlcBench, what: str, present: bool) -> None:
    if what == "Connected":
        plc["Connected"] = present
    else:
        plc.outputs(SO01_CpuOk=present)


@pytest.mark.parametrize(
    ("frame", "code"), [("JOG_PULSES", 0x20), ("JOG_CARTESIAN", 0x21), ("JOG_TOOL", 0x22)]
)
def test_the_telegram_of_a_jog(frame: str, code: int) -> None:
    """Axis 1 of robot 1 in the minus direction, position in pulses: 0x4000, 0x0081.

    Source: remote command guide 4.2.6, examples
    """
    plc = _plc()
    _jogging(plc, Frame=frame, Direction="DIRECTION_MINUS", PositionOutput="POSITION_PULSES")
    assert plc.words == [code, 0x4000, 0x0081, *[0] * 13]
    assert plc["Jog.Valid"]
    assert not plc["Jog.Busy"]


def test_robot_axis_and_millimetres() -> None:
    """Source: remote command guide 4.2.6: R in bits 15 to 12, one axis in bits 0 to 5."""
    plc = _plc()
    _jogging(plc, RobotNumber=2, Axis=6, PositionOutput="POSITION_MM")
    assert plc.words[:3] == [0x2020, 0x8000, 0x0020]


def test_the_jog_is_stopped_by_the_stop_input_si06() -> None:
    """SI(06) goes OFF in the scan in which Enable falls; the command is held to its end.

    Source: remote command guide 4.2.6
    """
    plc = _plc()
    _jogging(plc)
    plc["Jog.Enable"] = False
    plc.scan()
    assert plc.inputs == ["SI00"]
    assert plc.words[0] == 0x0020
    assert plc["Jog.Stopping"]
    assert not plc["Jog.Busy"]


def test_the_alarm_12_400_is_the_normal_end_of_a_jog_with_the_position() -> None:
    """Source: remote command guide 4.2.6, abnormal end by the stop input, and its example."""
    plc = _plc()
    _jogging(plc, PositionOutput="POSITION_PULSES")
    _stop(plc)
    assert not plc["Jog.Error"]
    assert (plc["Jog.AlarmGroup"], plc["Jog.AlarmCategory"]) == (0, 0)
    assert plc["Jog.Pulses"] == [12345, -123, 2000, 0, 0, 0]
    assert plc["Jog.PositionMm"] == [0.0] * 6


def test_the_position_in_millimetres_has_three_decimals() -> None:
    """Source: remote command guide 4.2.6: integers (x 1000)."""
    plc = _plc()
    _jogging(plc, PositionOutput="POSITION_MM")
    _stop(plc)
    assert plc["Jog.PositionMm"] == pytest.approx([12.345, -0.123, 2.0, 0.0, 0.0, 0.0])
    assert plc["Jog.Pulses"] == [0] * 6


def test_after_the_stop_the_interlock_signal_is_set_on_again_by_itself() -> None:
    """SI(06) comes back 100 ms and the margin after it went OFF; then Stopping ends.

    Source: remote command guide 4.2.6; manual chapter 5, 3, caution
    """
    plc = _plc()
    _jogging(plc)
    _stop(plc)
    assert plc["Jog.Stopping"]
    assert 8 <= plc.scan_until(lambda: "SI06" in plc.inputs) <= 10, "12 scans from OFF to ON"
    plc.scan_until(lambda: not plc["Jog.Stopping"])
    assert plc["Robot.Settled"]


def test_an_enable_that_comes_back_while_stopping_jogs_again_once_ready() -> None:
    plc = _plc()
    _jogging(plc)
    plc["Jog.Enable"] = False
    plc.scan()
    plc["Jog.Enable"], plc["Jog.Axis"] = True, 2
    plc.scan()
    assert plc["Jog.Busy"]
    assert plc.words[:3] == [0x0020, 0, 1], "the first jog is held to its end"
    plc.answer(0x4000, STOPPED)
    plc.scan()
    plc.answer(0)
    plc.scan_until(lambda: plc.words[0] == 0x0020)
    assert plc["Robot.Settled"]
    assert "SI06" in plc.inputs
    assert plc.words[2] == 2


def test_an_enable_that_falls_before_the_code_is_out_sends_nothing() -> None:
    plc = _plc()
    plc["Jog.Enable"] = True
    plc.scan()
    plc["Jog.Enable"] = False
    plc.scan(10)
    assert plc.words[0] == 0
    assert plc.inputs == ["SI00", "SI06"]
    assert not plc["Jog.Stopping"]
    plc["First.Code"], plc["First.Execute"] = 0x0501, True
    plc.scan_until(lambda: plc.words[0] == 0x0501, most=4)


def test_an_enable_of_one_scan_stops_in_the_scan_after_the_code() -> None:
    """Whatever the scan in which Enable falls: code without SI(06) OFF lasts no longer."""
    for scans in range(1, 6):
        plc = _plc()
        plc["Jog.Enable"] = True
        plc.scan(scans)
        plc["Jog.Enable"] = False
        plc.scan()
        assert plc.words[0] == 0 or "SI06" not in plc.inputs, scans


def test_a_jog_whose_block_is_not_called_any_more_is_stopped() -> None:
    """The command has lost its block: SI(06) goes OFF in the same scan."""
    plc = _plc()
    _jogging(plc)
    plc["CallJog"] = False
    plc.scan()
    assert plc.inputs == ["SI00"]
    plc.scan(20)
    assert plc.inputs == ["SI00"], "until the jog has ended"
    plc.answer(0x4000, STOPPED)
    plc.scan()
    plc.answer(0)
    plc.scan_until(lambda: "SI06" in plc.inputs)


def test_a_jog_of_fb_remote_command_is_stopped_at_its_timeout() -> None:
    plc = _plc()
    plc["First.Code"], plc["First.Data[2]"], plc["First.Timeout"] = 0x0020, 1, "T#100ms"
    plc["First.Execute"] = True
    plc.scan_until(lambda: plc.words[0] == 0x0020)
    plc.answer(0x0100)
    plc.scan(5)
    assert "SI06" in plc.inputs
    plc.scan_until(lambda: bool(plc["First.Error"]))
    assert "SI06" not in plc.inputs


def test_another_stop_ends_the_jog_with_an_error() -> None:
    """12.400 that Enable has not asked for, as from a stop of the programming box."""
    plc = _plc()
    _jogging(plc)
    plc.answer(0x4000, STOPPED)
    plc.scan()
    plc.answer(0)
    assert plc["Jog.ErrorID"] == 0x8020
    assert (plc["Jog.AlarmGroup"], plc["Jog.AlarmCategory"]) == (12, 400)
    plc.scan(20)
    assert plc.words[0] == 0, "it does not start again by itself"
    assert (plc["Jog.AlarmGroup"], plc["Jog.AlarmCategory"]) == (12, 400), "until Enable falls"
    plc["Jog.Enable"] = False
    plc.scan()
    assert not plc["Jog.Error"]
    assert (plc["Jog.AlarmGroup"], plc["Jog.AlarmCategory"]) == (0, 0)


def test_a_soft_limit_ends_the_jog_with_its_alarm() -> None:
    """Source: remote command guide 1.1: 2.334."""
    plc = _plc()
    _jogging(plc)
    plc.answer(0x4000, [0x0002, 0x014E])
    plc.scan()
    assert plc["Jog.ErrorID"] == 0x8020
    assert (plc["Jog.AlarmGroup"], plc["Jog.AlarmCategory"]) == (2, 334)
    assert "SI06" in plc.inputs


def test_a_jog_that_the_controller_ends_normally_stays_valid_until_enable_falls() -> None:
    """Source: remote command guide 4.2.6, normal end."""
    plc = _plc()
    _jogging(plc, PositionOutput="POSITION_PULSES")
    plc.answer(0x0200, [0, 0, 0, 0x3039, 0])
    plc.scan()
    plc.answer(0)
    plc.scan(5)
    assert plc["Jog.Valid"]
    assert plc.words[0] == 0
    assert plc["Jog.Pulses"][0] == 12345
    plc["Jog.Enable"] = False
    plc.scan()
    assert plc.inputs == ["SI00", "SI06"], "nothing is to be stopped"


@pytest.mark.parametrize(
    ("pins", "error"),
    [
        ({"RobotNumber": 5}, 0x8040),
        ({"RobotNumber": -1}, 0x8040),
        ({"Axis": 0}, 0x8041),
        ({"Axis": 7}, 0x8041),
    ],
)
def test_inputs_that_are_not_legal_are_refused_without_a_telegram(
    pins: dict[str, int], error: int
) -> None:
    """Source: remote command guide 4.2.6: robots 0 to 4, one of axes 1 to 6."""
    plc = _plc()
    for name, value in pins.items():
        plc[f"Jog.{name}"] = value
    plc["Jog.Enable"] = True
    plc.scan(2)
    assert plc["Jog.ErrorID"] == error
    plc.scan(5)
    assert plc.words == [0] * 16


def test_an_illegal_value_after_a_legal_jog_sends_nothing() -> None:
    plc = _plc()
    _jogging(plc)
    _stop(plc)
    plc.scan_until(lambda: not plc["Jog.Stopping"])
    plc["Jog.Axis"], plc["Jog.Enable"] = 7, True
    plc.scan(6)
    assert plc["Jog.ErrorID"] == 0x8041
    assert plc.words[0] == 0


def test_with_the_stop_input_off_or_in_emergency_stop_no_jog_goes_out() -> None:
    """Source: manual chapter 5, 2, SI(06) and SI(00)."""
    for pin, error in (("StopOk", 0x8007), ("EmergencyStopOk", 0x8003)):
        plc = _plc()
        plc[pin] = False
        plc.scan()
        plc["Jog.Enable"] = True
        plc.scan(3)
        assert plc["Jog.ErrorID"] == error
        assert plc.words[0] == 0


def test_a_stop_that_is_never_answered_lets_the_channel_go_after_timeout() -> None:
    """SI(06) stays OFF while the jog is out, and a new Enable says that the channel is blocked."""
    plc = _plc()
    _jogging(plc, Timeout="T#100ms")
    plc["Jog.Enable"] = False
    plc.scan(15)
    assert not plc["Jog.Stopping"]
    assert plc.inputs == ["SI00"]
    assert plc.words[0] == 0x0020
    plc["Jog.Enable"] = True
    plc.scan_until(lambda: bool(plc["Jog.Error"]), most=15)
    assert plc["Jog.ErrorID"] in (0x8007, 0x8012)


def test_a_lost_link_ends_the_jog_and_nothing_restarts() -> None:
    """Source: design of every block; manual chapter 1, 5."""
    plc = _plc()
    _jogging(plc)
    plc["Connected"] = False
    plc.scan()
    assert plc["Jog.ErrorID"] == 0x8001
    plc["Connected"] = True
    plc.answer(0)
    plc.scan(60)
    assert plc.words[0] == 0
    assert plc["Jog.Error"]


@pytest.mark.parametrize("moment", ["while SI(06) stops it", "until SI(06) is back"])
@pytest.mark.parametrize(
    ("lost", "error_id"), [("Connected", 0x8001), ("SO01_CpuOk", 0x8002)], ids=["link", "CPU_OK"]
)
def test_a_loss_also_ends_an_enable_that_waits_for_the_last_stop(
    moment: str, lost: str, error_id: int
) -> None:
    """Nothing restarts by itself: Enable was TRUE while nobody was there.

    Source: design of every block; manual chapter 1, 5.
    """
    plc = _plc()
    _jogging(plc)
    plc["Jog.Enable"] = False
    plc.scan()
    if moment == "until SI(06) is back":
        plc.answer(0x4000, STOPPED)
        plc.scan()
        plc.answer(0)
    plc["Jog.Enable"] = True
    plc.scan()
    assert plc["Jog.Busy"]
    _present(plc, lost, False)
    plc.scan()
    assert (plc["Jog.Error"], plc["Jog.Busy"], plc["Jog.ErrorID"]) == (True, False, error_id)
    _present(plc, lost, True)
    plc.answer(0)
    plc.scan(100)
    assert plc.words[0] == 0
    assert plc["Jog.ErrorID"] == error_id
    plc["Jog.Enable"] = False
    plc.scan()
    assert not plc["Jog.Error"]
    plc["Jog.Enable"] = True
    plc.scan_until(lambda: plc.words[0] == 0x0020)


def test_a_jog_waits_for_its_turn() -> None:
    plc = _plc()
    plc["First.Code"], plc["First.Execute"] = 0x0501, True
    plc.scan(3)
    plc["Jog.Enable"] = True
    plc.scan(5)
    assert plc["Jog.Busy"]
    assert plc.words[0] == 0x0501
    plc.answer(0x0200)
    plc.scan()
    plc.answer(0)
    plc.scan_until(lambda: plc.words[0] == 0x0020, most=4)


def test_a_command_that_waits_goes_out_only_when_si06_is_back() -> None:
    """While SI(06) is OFF a movement would end with 12.400."""
    plc = _plc()
    _jogging(plc)
    plc["First.Code"], plc["First.Execute"] = 0x0001, True
    _stop(plc)
    while plc.words[0] != 0x0001:
        assert plc.now_us < 5_000_000
        assert plc.words[0] == 0
        plc.scan()
    assert "SI06" in plc.inputs
    assert plc["Robot.Settled"]


def test_a_command_is_not_held_back_where_the_stop_stays() -> None:
    """StopOk FALSE is the user's own stop: what does not move goes on working."""
    plc = _plc()
    _jogging(plc)
    plc["StopOk"] = False
    _stop(plc)
    plc["First.Code"], plc["First.Execute"] = 0x0501, True
    plc.scan_until(lambda: plc.words[0] == 0x0501, most=5)


def test_while_a_program_stop_holds_si06_the_next_command_does_not_wait_for_it() -> None:
    """SI(06) is not going to come back by itself then."""
    plc = _plc()
    _jogging(plc)
    plc["Robot.HoldStop"] = True
    _stop(plc)
    assert plc.inputs == ["SI00"]
    plc["First.Code"], plc["First.Execute"] = 0x0501, True
    plc.scan_until(lambda: plc.words[0] == 0x0501, most=4)
    assert plc.inputs == ["SI00"]


def test_a_jog_that_ended_while_nothing_could_be_written_needs_no_stop() -> None:
    """The end is seen in the scan in which the area is legal again."""
    plc = _plc()
    _jogging(plc)
    plc["Jog.Enable"], plc["WriteArea.Size"] = False, 47
    plc.scan()
    assert plc.words[0] == 0x0020, "held, whatever happens"
    plc["WriteArea.Size"] = 48
    plc.answer(0x4000, STOPPED)
    plc.scan()
    assert plc.words[0] == 0
    assert plc.inputs == ["SI00", "SI06"]
    assert not plc["Jog.Error"]
