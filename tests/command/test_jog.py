"""FB_Jog moves the robot while Enable is TRUE, and stops it with SI(06)."""

from __future__ import annotations

import pytest

from jog_bench import STOPPED, end_by_stop, jog_plc, jogging, present


@pytest.mark.parametrize(
    ("frame", "code"), [("JOG_PULSES", 0x20), ("JOG_CARTESIAN", 0x21), ("JOG_TOOL", 0x22)]
)
def test_the_telegram_of_a_jog(frame: str, code: int) -> None:
    """A jog of axis 1 in the minus direction with the position in pulses sends 0x4000 and 0x0081.

    Source: remote command guide 4.2.6, examples
    """
    plc = jog_plc()
    jogging(plc, Frame=frame, Direction="DIRECTION_MINUS", PositionOutput="POSITION_PULSES")
    assert plc.words == [code, 0x4000, 0x0081, *[0] * 13]
    assert plc["Jog.Valid"]
    assert not plc["Jog.Busy"]


def test_robot_axis_and_millimetres() -> None:
    """The telegram has the robot in bits 15 to 12 and the axis in bits 0 to 5.

    Source: guide 4.2.6.
    """
    plc = jog_plc()
    jogging(plc, RobotNumber=2, Axis=6, PositionOutput="POSITION_MM")
    assert plc.words[:3] == [0x2020, 0x8000, 0x0020]


def test_the_jog_is_stopped_by_the_stop_input_si06() -> None:
    """When Enable falls, SI(06) turns OFF while the code stays.

    Source: remote command guide 4.2.6.
    """
    plc = jog_plc()
    jogging(plc)
    plc.change("Jog.Enable", to=False)
    assert plc.inputs == ["SI00"]
    assert plc.words[0] == 0x0020
    assert plc["Jog.Stopping"]
    assert not plc["Jog.Busy"]


def test_the_alarm_12_400_is_the_normal_end_of_a_jog_with_the_position() -> None:
    """A jog that was stopped by SI(06) ends with alarm 12.400, which is not an error of the block.

    Source: remote command guide 4.2.6, abnormal end by the stop input, and its example.
    """
    plc = jog_plc()
    jogging(plc, PositionOutput="POSITION_PULSES")
    end_by_stop(plc)
    assert not plc["Jog.Error"]
    assert (plc["Jog.AlarmGroup"], plc["Jog.AlarmCategory"]) == (0, 0)
    assert plc["Jog.Pulses"] == [12345, -123, 2000, 0, 0, 0]
    assert plc["Jog.PositionMm"] == [0.0] * 6


def test_the_position_in_millimetres_has_three_decimals() -> None:
    """A position in mm is the answer divided by 1000. Source: remote command guide 4.2.6."""
    plc = jog_plc()
    jogging(plc, PositionOutput="POSITION_MM")
    end_by_stop(plc)
    assert plc["Jog.PositionMm"] == pytest.approx([12.345, -0.123, 2.0, 0.0, 0.0, 0.0])
    assert plc["Jog.Pulses"] == [0] * 6


def test_after_the_stop_the_interlock_signal_is_set_on_again_by_itself() -> None:
    """After a stop, SI(06) turns ON again after 100 ms and the margin. Then Stopping is FALSE.

    Source: remote command guide 4.2.6; manual chapter 5, 3, caution
    """
    plc = jog_plc()
    jogging(plc)
    end_by_stop(plc)
    assert plc["Jog.Stopping"]
    assert 8 <= plc.scan_until(lambda: "SI06" in plc.inputs) <= 10, (
        "SI(06) must be OFF for 12 scans"
    )
    plc.scan_until(lambda: not plc["Jog.Stopping"])
    assert plc["Robot.Settled"]


def test_an_enable_during_the_stop_jogs_again_after_the_stop() -> None:
    plc = jog_plc()
    jogging(plc)
    plc.change("Jog.Enable", to=False)
    plc["Jog.Enable"], plc["Jog.Axis"] = True, 2
    plc.scan()
    assert plc["Jog.Busy"]
    assert plc.words[:3] == [0x0020, 0, 1], "the first jog must stay until its end"
    plc.complete(0x4000, STOPPED)
    plc.scan_until(lambda: plc.words[0] == 0x0020)
    assert plc["Robot.Settled"]
    assert "SI06" in plc.inputs
    assert plc.words[2] == 2


def test_if_enable_falls_before_the_code_is_sent_no_jog_is_sent() -> None:
    plc = jog_plc()
    plc.change("Jog.Enable", to=True)
    plc.change("Jog.Enable", to=False, scans=10)
    assert plc.words[0] == 0
    assert plc.inputs == ["SI00", "SI06"]
    assert not plc["Jog.Stopping"]
    plc.give("First", 0x0501, most=4)


def test_an_enable_of_one_scan_stops_in_the_scan_after_the_code() -> None:
    """If Enable is TRUE for a few scans only, SI(06) turns OFF one scan after the code."""
    for scans in range(1, 6):
        plc = jog_plc()
        plc.change("Jog.Enable", to=True, scans=scans)
        plc.change("Jog.Enable", to=False)
        assert plc.words[0] == 0 or "SI06" not in plc.inputs, scans


def test_a_jog_whose_block_is_not_called_any_more_is_stopped() -> None:
    """If the program stops calling the block, SI(06) turns OFF in the same scan."""
    plc = jog_plc()
    jogging(plc)
    plc.change("CallJog", to=False)
    assert plc.inputs == ["SI00"]
    plc.scan(20)
    assert plc.inputs == ["SI00"], "SI(06) stays OFF until the jog has ended"
    plc.complete(0x4000, STOPPED)
    plc.scan_until(lambda: "SI06" in plc.inputs)


def test_a_jog_of_fb_remote_command_is_stopped_at_its_timeout() -> None:
    plc = jog_plc()
    plc["First.Code"], plc["First.Data[2]"], plc["First.Timeout"] = 0x0020, 1, "T#100ms"
    plc.scan_until(lambda: plc.words[0] == 0x0020, execute="First")
    plc.answer(0x0100, scans=5)
    assert "SI06" in plc.inputs
    plc.scan_until(lambda: bool(plc["First.Error"]))
    assert "SI06" not in plc.inputs


def test_another_stop_ends_the_jog_with_an_error() -> None:
    """Alarm 12.400 while Enable is TRUE is an error: something else has stopped the jog."""
    plc = jog_plc()
    jogging(plc)
    plc.complete(0x4000, STOPPED)
    assert plc["Jog.ErrorID"] == 0x8020
    assert (plc["Jog.AlarmGroup"], plc["Jog.AlarmCategory"]) == (12, 400)
    plc.scan(20)
    assert plc.words[0] == 0, "the jog does not start again by itself"
    assert (plc["Jog.AlarmGroup"], plc["Jog.AlarmCategory"]) == (12, 400), (
        "the error stays until Enable falls"
    )
    plc.change("Jog.Enable", to=False)
    assert not plc["Jog.Error"]
    assert (plc["Jog.AlarmGroup"], plc["Jog.AlarmCategory"]) == (0, 0)


def test_a_soft_limit_ends_the_jog_with_its_alarm() -> None:
    """Alarm 2.334 ends the jog with an error. Source: remote command guide 1.1."""
    plc = jog_plc()
    jogging(plc)
    plc.answer(0x4000, [0x0002, 0x014E], scans=1)
    assert plc["Jog.ErrorID"] == 0x8020
    assert (plc["Jog.AlarmGroup"], plc["Jog.AlarmCategory"]) == (2, 334)
    assert "SI06" in plc.inputs


def test_a_jog_that_the_controller_ends_normally_stays_valid_until_enable_falls() -> None:
    """After a normal end, Valid stays TRUE until Enable falls. Source: guide 4.2.6, normal end."""
    plc = jog_plc()
    jogging(plc, PositionOutput="POSITION_PULSES")
    plc.answer(0x0200, [0, 0, 0, 0x3039, 0], scans=1)
    plc.answer(0, scans=5)
    assert plc["Jog.Valid"]
    assert plc.words[0] == 0
    assert plc["Jog.Pulses"][0] == 12345
    plc.change("Jog.Enable", to=False)
    assert plc.inputs == ["SI00", "SI06"], "without a jog SI(06) must stay ON"


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
    """An illegal robot or axis gives an error. Source: guide 4.2.6: robots 0 to 4, axes 1 to 6."""
    plc = jog_plc()
    for name, value in pins.items():
        plc[f"Jog.{name}"] = value
    plc.change("Jog.Enable", to=True, scans=2)
    assert plc["Jog.ErrorID"] == error
    plc.scan(5)
    assert plc.words == [0] * 16


def test_an_illegal_value_after_a_legal_jog_sends_nothing() -> None:
    plc = jog_plc()
    jogging(plc)
    end_by_stop(plc)
    plc.scan_until(lambda: not plc["Jog.Stopping"])
    plc["Jog.Axis"], plc["Jog.Enable"] = 7, True
    plc.scan(6)
    assert plc["Jog.ErrorID"] == 0x8041
    assert plc.words[0] == 0


def test_with_the_stop_input_off_or_in_emergency_stop_no_jog_is_sent() -> None:
    """While SI(06) or SI(00) is OFF, no jog is sent.

    Source: manual chapter 5, 2, SI(06) and SI(00).
    """
    for pin, error in (("StopOk", 0x8007), ("EmergencyStopOk", 0x8003)):
        plc = jog_plc()
        plc[pin] = False
        plc.scan()
        plc.change("Jog.Enable", to=True, scans=3)
        assert plc["Jog.ErrorID"] == error
        assert plc.words[0] == 0


def test_a_stop_without_an_answer_ends_at_timeout() -> None:
    """If the controller never ends the jog, SI(06) stays OFF, and a new Enable gives an error."""
    plc = jog_plc()
    jogging(plc, Timeout="T#100ms")
    plc.change("Jog.Enable", to=False, scans=15)
    assert not plc["Jog.Stopping"]
    assert plc.inputs == ["SI00"]
    assert plc.words[0] == 0x0020
    plc["Jog.Enable"] = True
    plc.scan_until(lambda: bool(plc["Jog.Error"]), most=15)
    assert plc["Jog.ErrorID"] in (0x8007, 0x8012)


def test_a_lost_link_ends_the_jog_and_nothing_restarts() -> None:
    """After a loss of the link, the jog does not start again by itself.

    Source: manual chapter 1, 5.
    """
    plc = jog_plc()
    jogging(plc)
    plc.change("Connected", to=False)
    assert plc["Jog.ErrorID"] == 0x8001
    plc["Connected"] = True
    plc.answer(0, scans=60)
    assert plc.words[0] == 0
    assert plc["Jog.Error"]


@pytest.mark.parametrize("moment", ["while SI(06) stops it", "until SI(06) is back"])
@pytest.mark.parametrize(
    ("lost", "error_id"), [("Connected", 0x8001), ("SO01_CpuOk", 0x8002)], ids=["link", "CPU_OK"]
)
def test_a_loss_also_ends_an_enable_that_waits_for_the_last_stop(
    moment: str, lost: str, error_id: int
) -> None:
    """A loss of the link also ends a waiting jog with an error. Source: manual chapter 1, 5."""
    plc = jog_plc()
    jogging(plc)
    plc.change("Jog.Enable", to=False)
    if moment == "until SI(06) is back":
        plc.complete(0x4000, STOPPED)
    plc.change("Jog.Enable", to=True)
    assert plc["Jog.Busy"]
    present(plc, lost, False)
    plc.scan()
    assert (plc["Jog.Error"], plc["Jog.Busy"], plc["Jog.ErrorID"]) == (True, False, error_id)
    present(plc, lost, True)
    plc.answer(0, scans=100)
    assert plc.words[0] == 0
    assert plc["Jog.ErrorID"] == error_id
    plc.change("Jog.Enable", to=False)
    assert not plc["Jog.Error"]
    plc["Jog.Enable"] = True
    plc.scan_until(lambda: plc.words[0] == 0x0020)
