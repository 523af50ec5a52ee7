"""FB_AlarmReset follows chapter 5, 3.1, step by step.

The test plays the controller.
"""

from __future__ import annotations

from plc_bench import PlcBench


def _plc() -> PlcBench:
    plc = PlcBench()
    plc.power_up()
    plc.outputs(SO03=True)
    return plc


def test_the_alarm_reset_input_is_reset_after_the_alarm_is_off() -> None:
    """Source: manual chapter 5, 3.1, servo ON process from emergency stop status, steps 3 to 5."""
    plc = _plc()
    plc.change("AlarmReset.Execute", to=True, scans=30)
    assert plc.inputs == ["SI00", "SI06", "SI16"]
    assert plc["AlarmReset.Active"]
    assert plc["Robot.Inner.Sequence.Holder"] == 0x0016
    plc.outputs(SO03=False, scans=1)
    assert plc["AlarmReset.Done"]
    assert plc.inputs == ["SI00", "SI06"]


def test_without_an_alarm_the_reset_input_is_also_sent() -> None:
    """Without an alarm, the reset input is sent as well.

    It also resets a warning, or an alarm that begins at this moment.
    """
    plc = _plc()
    plc.outputs(SO03=False)
    plc.change("AlarmReset.Execute", to=True)
    assert "SI16" in plc.inputs
    plc.scan()
    assert plc["AlarmReset.Done"]


def test_an_alarm_may_be_reset_while_the_controller_is_not_in_its_normal_state() -> None:
    plc = _plc()
    plc.outputs(SO01=False)
    plc.change("AlarmReset.Execute", to=True)
    assert "SI16" in plc.inputs
