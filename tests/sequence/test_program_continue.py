"""FB_ProgramContinue follows chapter 5, 3.3, step by step.

The test plays the controller.
"""

from __future__ import annotations

import pytest

from sequence_bench import pins, program_stopped, servo_on


def test_program_execution_after_stopping_program_with_stop_input() -> None:
    """The stop input, the start input and running turn ON, then the start input turns OFF.

    Source: manual chapter 5, 3.3, program execution after stopping program with stop input.
    """
    plc = program_stopped()
    plc.change("Resume.Execute", to=True)
    assert plc.inputs == ["SI00", "SI06"]
    assert pins(plc, "Resume") == "Busy Active"
    assert plc.scan_until(lambda: plc.inputs != ["SI00", "SI06"]) == 12
    assert plc.inputs == ["SI00", "SI06", "SI12"]
    plc.scan(30)
    assert pins(plc, "Resume") == "Busy Active"
    plc.outputs(SO13=True, scans=1)
    assert pins(plc, "Resume") == "Done"
    assert plc.inputs == ["SI00", "SI06"]
    plc.change("Resume.Execute", to=False)
    assert pins(plc, "Resume") == ""


@pytest.mark.parametrize("cause", ["pin", "block"])
def test_a_continuation_is_refused_while_stopok_is_false_and_the_hold_stays(cause: str) -> None:
    """Source: manual chapter 5, 3.2, note: not with the stop input OFF."""
    plc = program_stopped()
    if cause == "pin":
        plc["StopOk"] = False
    else:
        plc["ProgramStop.Execute"] = True
    plc.scan(20)
    plc.change("Resume.Execute", to=True, scans=2)
    assert plc["Resume.ErrorID"] == 0x8007
    plc["StopOk"] = True
    plc.change("ProgramStop.Execute", to=False, scans=50)
    assert plc.inputs == ["SI00"]


def test_without_a_link_a_continuation_is_refused_and_the_hold_stays() -> None:
    """Source: manual chapter 1, 5.2."""
    plc = program_stopped()
    plc.change("Connected", to=False)
    plc.change("Resume.Execute", to=True, scans=2)
    assert plc["Resume.ErrorID"] == 0x8001
    plc.change("Connected", to=True, scans=60)
    assert plc.inputs == ["SI00"]


def test_without_a_hold_a_continuation_is_a_program_start() -> None:
    """Source: manual chapter 5, 3.3, program execution process."""
    plc = servo_on()
    plc.change("Resume.Execute", to=True)
    assert plc.inputs == ["SI00", "SI06", "SI12"]
