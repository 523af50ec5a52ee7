"""FB_EmergencyStop follows chapter 5, 3.1, step by step.

The test plays the controller.
"""

from __future__ import annotations

from sequence_bench import pins, sequences, servo_on


def test_shift_to_emergency_stop() -> None:
    """The emergency stop input turns OFF, then SO(00) and SO(03) turn ON and SO(02) OFF.

    Source: manual chapter 5, 3.1, shift to emergency stop.
    """
    plc = servo_on()
    plc.change("EmergencyStop.Execute", to=True)
    assert plc.inputs == ["SI06"]
    assert pins(plc, "EmergencyStop") == "Busy Active"
    plc.scan(30)
    assert pins(plc, "EmergencyStop") == "Busy Active"
    plc.outputs(SO00=True, SO03=True, SO02=False, scans=1)
    assert pins(plc, "EmergencyStop") == "Done"
    plc.scan(50)
    assert plc.inputs == ["SI06"]


def test_emergency_stop_status_with_the_servos_on_is_not_the_end() -> None:
    """Source: manual chapter 5, 3.1, shift to emergency stop, step 2."""
    plc = servo_on()
    plc.change("EmergencyStop.Execute", to=True)
    plc.outputs(SO00=True, SO03=True, scans=5)
    assert pins(plc, "EmergencyStop") == "Busy Active"
    plc.outputs(SO02=False, scans=1)
    assert pins(plc, "EmergencyStop") == "Done"


def test_an_emergency_stop_does_not_wait_for_a_turn_or_the_interval() -> None:
    """An emergency stop is sent at once, without waiting for a turn or for the interval.

    The servo ON input has just been sent. The block that sent it ends by itself.

    Source: manual chapter 5, 2, SI(00).
    """
    plc = sequences()
    plc.change("ServoOn.Execute", to=True)
    assert plc.inputs == ["SI00", "SI01", "SI06"]
    plc.change("EmergencyStop.Execute", to=True)
    assert plc.inputs == ["SI01", "SI06"]
    plc.scan()
    assert plc["ServoOn.ErrorID"] == 0x8003
    assert plc.scan_until(lambda: plc.inputs == ["SI06"]) == 11, "SI(01) keeps its interval"


def test_a_running_remote_command_is_held_to_its_end() -> None:
    """Source: remote command guide, chapter 1, 1.1."""
    plc = servo_on()
    plc["Command.Code"] = 0x0001
    plc.change("Command.Execute", to=True, scans=2)
    plc.change("EmergencyStop.Execute", to=True, scans=3)
    assert plc.words[0] == 0x0001
    assert plc["Command.Active"]
    plc.outputs(SO00=True, SO03=True, SO02=False)
    plc.answer(0x4000, [12, 600], scans=1)
    assert (plc["Command.AlarmGroup"], plc["Command.AlarmCategory"]) == (12, 600)
    assert plc.words[0] == 0


def test_in_emergency_stop_already_it_is_done_in_the_next_call() -> None:
    plc = sequences()
    plc["EmergencyStopOk"] = False
    plc.outputs(SO00=True, scans=20)
    plc.change("EmergencyStop.Execute", to=True)
    assert pins(plc, "EmergencyStop") == "Busy Active"
    plc.scan()
    assert pins(plc, "EmergencyStop") == "Done"
    plc.change("EmergencyStopOk", to=True, scans=50)
    assert plc.inputs == ["SI06"], "held by the block, whatever the pin says"


def test_emergency_stop_status_confirms_with_and_without_cpu_ok() -> None:
    """SO(00) ON confirms the emergency stop, whether CPU_OK is ON or OFF.

    Source: manual chapter 5, 2, SO(00) and SO(01); assumed that SO(00) holds without SO(01).
    """
    plc = servo_on()
    plc.change("EmergencyStop.Execute", to=True)
    plc.outputs(SO00=True, SO01=False, SO02=False, scans=1)
    assert pins(plc, "EmergencyStop") == "Done"


def test_a_new_edge_while_it_is_done_stops_again() -> None:
    plc = servo_on()
    for _ in range(2):
        plc.change("EmergencyStop.Execute", to=True)
        plc.outputs(SO00=True, SO02=False, scans=1)
        assert pins(plc, "EmergencyStop") == "Done"
        plc.change("EmergencyStop.Execute", to=False)
        assert pins(plc, "EmergencyStop") == ""
