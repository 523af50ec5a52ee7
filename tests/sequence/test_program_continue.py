"""FB_ProgramContinue: chapter 5, 3.3, step by step; the test plays the controller."""

from __future__ import annotations

import pytest

from plc_bench import PlcBench
from sequence_bench import pins, servo_on


def _stopped() -> PlcBench:
    """FB_ProgramStop holds SI(06) OFF, its Execute has fallen."""
    plc = servo_on()
    plc.outputs(SO14=False)
    plc["ProgramStop.Execute"] = True
    plc.scan(20)
    plc["ProgramStop.Execute"] = False
    plc.scan(20)
    assert plc.inputs == ["SI00"]
    return plc


def test_program_execution_after_stopping_program_with_stop_input() -> None:
    """Stop input ON, start input ON, running ON, start input OFF.

    Source: manual chapter 5, 3.3, program execution after stopping program with stop input.
    """
    plc = _stopped()
    plc["Resume.Execute"] = True
    plc.scan()
    assert plc.inputs == ["SI00", "SI06"]
    assert pins(plc, "Resume") == "Busy Active"
    assert plc.scan_until(lambda: plc.inputs != ["SI00", "SI06"]) == 12
    assert plc.inputs == ["SI00", "SI06", "SI12"]
    plc.scan(30)
    assert pins(plc, "Resume") == "Busy Active"
    plc.outputs(SO13=True)
    plc.scan()
    assert pins(plc, "Resume") == "Done"
    assert plc.inputs == ["SI00", "SI06"]
    plc["Resume.Execute"] = False
    plc.scan()
    assert pins(plc, "Resume") == ""


@pytest.mark.parametrize("cause", ["pin", "block"])
def test_refused_while_the_stop_is_kept_on_and_the_hold_stays(cause: str) -> None:
    """Source: manual chapter 5, 3.2, note: not with the stop input OFF."""
    plc = _stopped()
    if cause == "pin":
        plc["StopOk"] = False
    else:
        plc["ProgramStop.Execute"] = True
    plc.scan(20)
    plc["Resume.Execute"] = True
    plc.scan(2)
    assert pins(plc, "Resume") == "Error"
    assert plc["Resume.ErrorID"] == 0x8007
    plc["StopOk"] = True
    plc["ProgramStop.Execute"] = False
    plc.scan(50)
    assert plc.inputs == ["SI00"]


@pytest.mark.parametrize(
    ("output", "error"),
    [
        ({"SO01": False}, 0x8002),
        ({"SO00": True}, 0x8003),
        ({"SO03": True}, 0x8004),
        ({"SO10": False}, 0x8006),
    ],
)
def test_refused_as_a_program_start_is(output: dict[str, bool], error: int) -> None:
    """Source: manual chapter 5, 3.3, note: alarm reset and servo ON are required."""
    plc = _stopped()
    plc.outputs(**output)
    plc["Resume.Execute"] = True
    plc.scan(20)
    assert plc["Resume.ErrorID"] == error
    assert "SI12" not in plc.inputs


def test_without_a_link_it_is_refused_and_the_hold_stays() -> None:
    """Source: manual chapter 1, 5.2."""
    plc = _stopped()
    plc["Connected"] = False
    plc.scan()
    plc["Resume.Execute"] = True
    plc.scan(2)
    assert plc["Resume.ErrorID"] == 0x8001
    plc["Connected"] = True
    plc.scan(60)
    assert plc.inputs == ["SI00"]


def test_a_missing_answer_ends_at_the_time_limit_and_the_stop_stays_released() -> None:
    plc = _stopped()
    plc["Resume.Timeout"] = "T#300ms"
    plc["Resume.Execute"] = True
    plc.scan(31)
    assert plc["Resume.ErrorID"] == 0x8010
    plc.scan(12)
    assert plc.inputs == ["SI00", "SI06"]


def test_without_a_hold_it_is_a_program_start() -> None:
    """Source: manual chapter 5, 3.3, program execution process."""
    plc = servo_on()
    plc["Resume.Execute"] = True
    plc.scan()
    assert plc.inputs == ["SI00", "SI06", "SI12"]
