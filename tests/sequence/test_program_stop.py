"""FB_ProgramStop follows chapter 5, 3.3, step by step.

The test plays the controller.
"""

from __future__ import annotations

from plc_bench import PlcBench
from sequence_bench import pins, servo_on


def _running() -> PlcBench:
    plc = servo_on()
    plc.outputs(SO13=True, SO14=False, scans=1)
    return plc


def test_program_stop_process_using_stop_input() -> None:
    """The stop input turns OFF, then running turns OFF. The stop input stays OFF.

    Source: manual chapter 5, 3.3, program stop process using stop input.
    """
    plc = _running()
    plc.change("ProgramStop.Execute", to=True)
    assert plc.inputs == ["SI00"]
    assert pins(plc, "ProgramStop") == "Busy Active"
    plc.scan(30)
    assert pins(plc, "ProgramStop") == "Busy Active"
    plc.outputs(SO13=False, scans=1)
    assert pins(plc, "ProgramStop") == "Done"
    plc.change("ProgramStop.Execute", to=False, scans=50)
    assert pins(plc, "ProgramStop") == ""
    assert plc.inputs == ["SI00"]


def test_a_stop_does_not_wait_for_a_turn_and_a_running_start_ends_by_itself() -> None:
    """Source: manual chapter 5, 3.2, note: not with the stop input OFF."""
    plc = servo_on()
    plc.change("AutoStart.Execute", to=True)
    assert plc.inputs == ["SI00", "SI06", "SI12"]
    plc.change("ProgramStop.Execute", to=True)
    assert plc.inputs == ["SI00", "SI12"]
    plc.scan()
    assert plc["AutoStart.ErrorID"] == 0x8007
    plc.scan(12)
    assert plc.inputs == ["SI00"]


def test_the_stop_waits_for_a_program_that_is_just_starting() -> None:
    """The block waits for a program that is just starting.

    SO(13) OFF is accepted only after the stop input has been OFF for 140 ms.
    """
    plc = servo_on()
    plc.change("ProgramStop.Execute", to=True, scans=14)
    assert pins(plc, "ProgramStop") == "Busy Active"
    plc.outputs(SO13=True, scans=10)
    assert pins(plc, "ProgramStop") == "Busy Active"
    plc.outputs(SO13=False, scans=1)
    assert pins(plc, "ProgramStop") == "Done"


def test_without_a_program_it_is_done_when_the_stop_input_has_stood_long_enough() -> None:
    plc = servo_on()
    plc["ProgramStop.Execute"] = True
    assert plc.scan_until(lambda: plc["ProgramStop.Done"] is True) == 16


def test_the_stop_is_done_at_once_if_a_running_program_has_stopped() -> None:
    """Source: manual chapter 5, 3.3, program stop process using stop input, step 2."""
    plc = _running()
    plc.change("ProgramStop.Execute", to=True)
    plc.outputs(SO13=False, scans=1)
    assert pins(plc, "ProgramStop") == "Done"


def test_a_stop_that_cannot_be_written_is_not_done() -> None:
    """If the area cannot be written, the stop is not done: SI(06) is still ON in the controller.

    The area is illegal for some scans.
    """
    plc = servo_on()
    plc["ProgramStop.Execute"], plc["WriteArea.Size"] = True, 47
    plc.scan(20)
    assert plc.inputs == ["SI00", "SI06"]
    assert pins(plc, "ProgramStop") == "Busy Active"
    plc.change("WriteArea.Size", to=48)
    assert plc.inputs == ["SI00"]
    plc.scan_until(lambda: pins(plc, "ProgramStop") == "Done", most=20)
