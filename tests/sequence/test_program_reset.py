"""FB_ProgramReset: chapter 5, 3.2, step by step; the test plays the controller."""

from __future__ import annotations

import pytest

from plc_bench import PlcBench


def _plc() -> PlcBench:
    plc = PlcBench()
    plc.power_up()
    return plc


def test_program_reset_process() -> None:
    """Program reset input, program reset status, then the input is taken back.

    Source: manual chapter 5, 3.2, program reset process.
    """
    plc = _plc()
    plc["ProgramReset.Execute"] = True
    plc.scan(30)
    assert plc.inputs == ["SI00", "SI06", "SI15"]
    assert plc["ProgramReset.Active"]
    assert plc["Robot.Inner.Sequence.Holder"] == 0x0015
    plc.outputs(SO14=True)
    plc.scan()
    assert plc["ProgramReset.Done"]
    assert plc.inputs == ["SI00", "SI06"]


@pytest.mark.parametrize(
    ("output", "error"), [({"SO01": False}, 0x8002), ({"SO10": False}, 0x8006)]
)
def test_it_is_necessary_that_the_controller_is_in_auto_mode(
    output: dict[str, bool], error: int
) -> None:
    """Source: manual chapter 5, 2, SI(15)."""
    plc = _plc()
    plc.outputs(**output)
    plc["ProgramReset.Execute"] = True
    plc.scan(2)
    assert plc["ProgramReset.ErrorID"] == error
    plc.scan(20)
    assert "SI15" not in plc.inputs


def test_when_auto_is_lost_on_the_way_it_ends_and_the_input_is_taken_back() -> None:
    """Source: manual chapter 5, 2, SI(15)."""
    plc = _plc()
    plc["ProgramReset.Execute"] = True
    plc.scan(3)
    plc.outputs(SO10=False)
    plc.scan()
    assert plc["ProgramReset.ErrorID"] == 0x8006
    plc.scan(12)
    assert "SI15" not in plc.inputs


def test_a_missing_answer_ends_at_the_time_limit() -> None:
    plc = _plc()
    plc["ProgramReset.Timeout"] = "T#300ms"
    plc["ProgramReset.Execute"] = True
    plc.scan(31)
    assert plc["ProgramReset.ErrorID"] == 0x8010
    assert plc.inputs == ["SI00", "SI06"]
