"""FB_AutoStart: chapter 5, 3.2 and 3.3, step by step; the test plays the controller."""

from __future__ import annotations

import pytest

from plc_bench import PlcBench


def _plc() -> PlcBench:
    plc = PlcBench()
    plc.power_up()
    plc.outputs(SO02=True, SO14=True)
    return plc


def test_program_execution_process() -> None:
    """Start input, reset status OFF and running ON, then the input is taken back.

    Source: manual chapter 5, 3.2, program execution process.
    """
    plc = _plc()
    plc["AutoStart.Execute"] = True
    plc.scan(30)
    assert plc.inputs == ["SI00", "SI06", "SI12"]
    assert plc["AutoStart.Active"]
    assert plc["Robot.Inner.Sequence.Holder"] == 0x0012
    plc.outputs(SO14=False, SO13=True)
    plc.scan()
    assert plc["AutoStart.Done"]
    assert plc.inputs == ["SI00", "SI06"]


def test_the_reset_status_alone_is_no_confirmation() -> None:
    """Source: manual chapter 5, 3.2, program execution process, step 3: SO(13) confirms."""
    plc = _plc()
    plc["AutoStart.Execute"] = True
    plc.scan(3)
    plc.outputs(SO14=False)
    plc.scan(20)
    assert plc["AutoStart.Busy"]


@pytest.mark.parametrize(
    ("output", "error"),
    [
        ({"SO01": False}, 0x8002),
        ({"SO00": True}, 0x8003),
        ({"SO03": True}, 0x8004),
        ({"SO10": False}, 0x8006),
        ({"SO13": True}, 0x8008),
    ],
)
def test_refused_without_its_conditions_and_nothing_goes_out(
    output: dict[str, bool], error: int
) -> None:
    """Source: manual chapter 5, 3.2, AUTO mode and the note on emergency stop and stop input."""
    plc = _plc()
    plc.outputs(**output)
    plc["AutoStart.Execute"] = True
    plc.scan(2)
    assert plc["AutoStart.ErrorID"] == error
    plc.scan(20)
    assert "SI12" not in plc.inputs


@pytest.mark.parametrize(("pin", "error"), [("EmergencyStopOk", 0x8003), ("StopOk", 0x8007)])
def test_refused_while_the_application_keeps_a_safety_input_off(pin: str, error: int) -> None:
    """Source: manual chapter 5, 3.2, note: not with emergency stop or stop input OFF."""
    plc = _plc()
    plc[pin] = False
    plc.scan(20)
    plc["AutoStart.Execute"] = True
    plc.scan(2)
    assert plc["AutoStart.ErrorID"] == error
    assert "SI12" not in plc.inputs


def test_the_stop_input_comes_back_on_before_the_start() -> None:
    """Source: manual chapter 5, 3.3, program execution after stopping program with stop input."""
    plc = _plc()
    plc["StopOk"] = False
    plc.scan(20)
    plc["StopOk"] = plc["AutoStart.Execute"] = True
    plc.scan()
    assert plc.inputs == ["SI00", "SI06"]
    assert plc.scan_until(lambda: "SI12" in plc.inputs) == 12


@pytest.mark.parametrize(
    ("output", "error"),
    [({"SO00": True}, 0x8003), ({"SO03": True}, 0x8004), ({"SO10": False}, 0x8006)],
)
def test_a_condition_that_is_lost_on_the_way_ends_it(output: dict[str, bool], error: int) -> None:
    """Source: manual chapter 5, 3.3, note on the transition to emergency stop."""
    plc = _plc()
    plc["AutoStart.Execute"] = True
    plc.scan(3)
    plc.outputs(**output)
    plc.scan()
    assert plc["AutoStart.ErrorID"] == error
    plc.scan(12)
    assert "SI12" not in plc.inputs


def test_a_missing_answer_ends_at_the_time_limit() -> None:
    plc = _plc()
    plc["AutoStart.Timeout"] = "T#300ms"
    plc["AutoStart.Execute"] = True
    plc.scan(31)
    assert plc["AutoStart.ErrorID"] == 0x8010
    assert plc.inputs == ["SI00", "SI06"]
