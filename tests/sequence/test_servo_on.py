"""FB_ServoOn follows chapter 5, 3.1, step by step.

The test plays the controller.
"""

from __future__ import annotations

from plc_bench import PlcBench


def _plc() -> PlcBench:
    plc = PlcBench()
    plc.power_up()
    return plc


def test_initial_servo_on_process_after_power_on() -> None:
    """The servo ON input and the servo ON status turn ON, then the input turns OFF.

    Source: manual chapter 5, 3.1, initial servo ON process after power ON.
    """
    plc = _plc()
    plc.change("ServoOn.Execute", to=True)
    assert plc.inputs == ["SI00", "SI01", "SI06"]
    plc.scan(30)
    assert plc.inputs == ["SI00", "SI01", "SI06"], "SI(01) stays ON until the status is confirmed"
    assert plc["ServoOn.Active"]
    assert plc["Robot.Inner.Sequence.Holder"] == 0x0001
    plc.outputs(SO02=True, scans=1)
    assert plc["ServoOn.Done"]
    assert plc.inputs == ["SI00", "SI06"]


def test_an_early_answer_ends_the_block_and_the_input_stays_on_for_100_ms() -> None:
    """Source: manual chapter 5, 3.1, caution."""
    plc = _plc()
    plc.change("ServoOn.Execute", to=True)
    plc.outputs(SO02=True, scans=1)
    assert plc["ServoOn.Done"]
    assert plc.scan_until(lambda: "SI01" not in plc.inputs) == 11


def test_servo_on_waits_for_an_emergency_stop_that_is_just_being_released() -> None:
    """The block waits for an emergency stop that is just being released.

    SI(00) turns ON only after the interval, and the controller answers even later.

    Source: manual chapter 5, 3.1, servo ON process from emergency stop status.
    """
    plc = PlcBench()
    plc.outputs(SO00=True, SO01=True, SO04=True)
    plc.scan_until(lambda: "SI00" in plc.inputs, execute="ServoOn")
    plc.scan(3)
    assert plc["ServoOn.Busy"]
    plc.outputs(SO00=False)
    plc.scan_until(lambda: "SI01" in plc.inputs)
    assert plc["ServoOn.Active"]


def test_a_second_servo_on_sends_a_new_edge() -> None:
    """Source: manual chapter 5, 2, SI(01): from OFF to ON."""
    plc = _plc()
    plc.change("ServoOn.Execute", "ServoAgain.Execute", to=True)
    plc.outputs(SO02=True, scans=1)
    assert plc["ServoOn.Done"]
    assert plc["ServoAgain.Active"]
    assert plc.scan_until(lambda: "SI01" not in plc.inputs) == 11
    assert plc.scan_until(lambda: "SI01" in plc.inputs) == 12
    plc.scan()
    assert plc["ServoAgain.Done"]
