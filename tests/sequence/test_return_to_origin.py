"""FB_ReturnToOrigin follows chapter 5, 2, SI(14), SI(17) and SO(11).

The test plays the controller.
"""

from __future__ import annotations

import pytest

from plc_bench import PlcBench
from sequence_bench import pins, servo_on

_KINDS = pytest.mark.parametrize(
    ("axes", "signal", "holder"),
    [("ORIGIN_INCREMENTAL", "SI14", 0x0014), ("ORIGIN_ABSOLUTE", "SI17", 0x0017)],
)


@_KINDS
def test_the_return_to_origin_input_stays_on_until_the_return_is_complete(
    axes: str, signal: str, holder: int
) -> None:
    """The input is ON until SO(11) is ON.

    Source: manual chapter 5, 2, SI(14), SI(17) and SO(11).
    """
    plc = servo_on()
    plc["Origin.Axes"] = axes
    plc.change("Origin.Execute", to=True)
    assert plc.inputs == ["SI00", "SI06", signal]
    assert pins(plc, "Origin") == "Busy Active"
    assert plc["Robot.Inner.Sequence.Holder"] == holder
    plc.scan(200)
    assert plc.inputs == ["SI00", "SI06", signal]
    assert pins(plc, "Origin") == "Busy Active"
    plc.outputs(SO11=True, scans=1)
    assert pins(plc, "Origin") == "Done"
    assert plc.inputs == ["SI00", "SI06"]


def test_a_waiting_return_is_executed_although_execute_has_fallen() -> None:
    """Source: design of every block: letting Execute fall never cancels the work."""
    plc = servo_on()
    plc.outputs(SO02=True)
    plc.change("ProgramReset.Execute", "Origin.Execute", to=True)
    assert pins(plc, "Origin") == "Busy"
    assert plc.inputs == ["SI00", "SI06", "SI15"]
    plc.change("ProgramReset.Execute", "Origin.Execute", to=False)
    plc.outputs(SO02=True, SO14=True)
    plc.scan_until(lambda: "SI14" in plc.inputs)
    assert pins(plc, "Origin") == "Busy Active"
    plc.outputs(SO02=True, SO14=True, SO11=True, scans=1)
    assert pins(plc, "Origin") == "Done"


def test_incremental_axes_are_the_default() -> None:
    """By default the block uses SI(14), for incremental axes, which every robot accepts.

    SI(17) depends on a parameter of the controller.
    """
    plc = servo_on()
    plc.change("Origin.Execute", to=True)
    assert plc.inputs == ["SI00", "SI06", "SI14"]


def test_the_axes_are_sampled_on_the_rising_edge() -> None:
    plc = servo_on()
    plc.change("Origin.Execute", to=True)
    plc.change("Origin.Axes", to="ORIGIN_ABSOLUTE", scans=30)
    assert plc.inputs == ["SI00", "SI06", "SI14"]


def test_an_earlier_completion_must_turn_off_first() -> None:
    """Source: assumed; the manual has no chart of SI(14) and SO(11)."""
    plc = servo_on()
    plc.outputs(SO11=True)
    plc.change("Origin.Execute", to=True, scans=10)
    assert pins(plc, "Origin") == "Busy Active"
    plc.outputs(SO11=False, scans=100)
    assert pins(plc, "Origin") == "Busy Active"
    plc.outputs(SO11=True, scans=1)
    assert pins(plc, "Origin") == "Done"


def test_an_earlier_completion_that_stays_on_is_accepted_after_confirm() -> None:
    """If SO(11) was ON before and stays ON, the block is done after Confirm (300 ms).

    The input is sent in scan 1 and counts as ON from scan 2 on. 300 ms later is scan 32.

    Source: assumed; the manual has no chart of SI(14) and SO(11).
    """
    plc = servo_on()
    plc.outputs(SO11=True)
    plc["Origin.Confirm"] = "T#300ms"
    plc["Origin.Execute"] = True
    assert plc.scan_until(lambda: plc["Origin.Done"] is True) == 32


def _moving() -> PlcBench:
    plc = servo_on()
    plc.change("Origin.Execute", to=True, scans=5)
    return plc


def test_a_program_stop_ends_it() -> None:
    plc = _moving()
    plc.change("ProgramStop.Execute", to=True, scans=2)
    assert plc["Origin.ErrorID"] == 0x8007
    plc.scan(12)
    assert plc.inputs == ["SI00"]


def test_a_program_that_starts_after_the_input_was_sent_does_not_refuse_the_return() -> None:
    """Source: assumed; the manual has no chart of SI(14) and SO(13)."""
    plc = servo_on()
    plc.change("Origin.Execute", to=True)
    assert plc.inputs == ["SI00", "SI06", "SI14"]
    plc.outputs(SO13=True, scans=5)
    assert pins(plc, "Origin") == "Busy Active"
    plc.outputs(SO11=True, scans=1)
    assert pins(plc, "Origin") == "Done"
