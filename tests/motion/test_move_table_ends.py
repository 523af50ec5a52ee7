"""FB_MoveTable: hold, single rows, abort, and events that end it.

The test plays the controller.
"""

from __future__ import annotations

from typing import Any

import pytest

from both_engines import ENGINES
from plc_bench import PlcBench
from table_bench import (
    arrived,
    bench,
    end,
    goes_on,
    moving,
    restart,
    rows_to,
    runs,
    sent,
    shown,
    start,
    started,
)

# ---- hold, one row, abort


@pytest.mark.parametrize("engine", ENGINES)
def test_hold_lets_the_row_end_and_begins_no_other(engine: str) -> None:
    plc = moving(*rows_to(1, 2, 3), engine=engine)
    plc["Table.Hold"] = True
    plc.scan(5)
    end(plc)
    plc.scan(50)
    assert (plc["Table.Stage"], plc["Table.Row"]) == ("TABLE_HELD", 2)
    assert (shown(plc), plc.words[0]) == ("Busy", 0)
    plc["Table.OneRow"] = True
    assert sent(plc)[4] == 2
    end(plc)
    plc.scan(50)
    assert (plc["Table.Stage"], plc["Table.Row"]) == ("TABLE_HELD", 3), "an edge moves one row"
    plc["Table.Hold"] = False
    assert sent(plc)[4] == 3
    plc["Table.Hold"] = True
    end(plc)
    plc.scan(2)
    assert shown(plc) == "Done", "after the last row, Hold has no effect"


def test_abort_before_a_row_that_is_held_ends_at_once() -> None:
    plc = started(*rows_to(1), Hold=True)
    plc.scan(20)
    assert (plc["Table.Stage"], plc["Table.Row"], plc.words[0]) == ("TABLE_HELD", 1, 0)
    plc["Table.Abort"] = True
    plc.scan()
    assert (shown(plc), plc["Table.ErrorID"], plc["Table.Row"]) == ("Error", 0x8050, 1)


def test_abort_lets_the_command_end_and_counts_the_row() -> None:
    """Source: guide, 2: a command is held to its end."""
    plc = moving(*rows_to(1, 2, 3))
    plc["Table.Abort"] = True
    plc.scan()
    plc["Table.Abort"] = False
    plc.scan(20)
    assert (shown(plc), plc.words[0]) == ("Busy", 0x0001)
    end(plc)
    plc.scan()
    assert (shown(plc), plc["Table.ErrorID"], plc["Table.Row"]) == ("Error", 0x8050, 2)
    plc.scan(20)
    assert plc.words == [0] * 16


def test_abort_withdraws_a_row_that_waits_for_its_turn() -> None:
    plc = bench(*rows_to(1))
    plc["Other.Execute"] = True
    plc.scan(2)
    other = plc.words[0]
    start(plc)
    plc.scan(5)
    assert (plc["Table.Stage"], plc.words[0]) == ("TABLE_MOVE", other)
    plc["Table.Abort"] = True
    plc.scan()
    assert (shown(plc), plc["Table.ErrorID"], plc["Table.Row"]) == ("Error", 0x8050, 1)
    plc["Table.Abort"] = False
    end(plc)
    plc.scan(20)
    assert plc.words == [0] * 16
    assert plc["Robot.Inner.Command.Serving"] == plc["Robot.Inner.Command.NextTicket"]
    restart(plc)
    assert runs(plc) == [1]


# ---- events that end the table

_FAULTS = [
    pytest.param({"outputs": {"SO01": False}}, 0x8002, id="CPU_OK off"),
    pytest.param({"outputs": {"SO00": True}}, 0x8003, id="emergency stop"),
    pytest.param({"EmergencyStopOk": False}, 0x8003, id="cell not safe"),
    pytest.param({"outputs": {"SO03": True}}, 0x8004, id="alarm"),
    pytest.param({"StopOk": False}, 0x8007, id="stop"),
    pytest.param({"outputs": {"SO02": False}}, 0x800C, id="servos off"),
    pytest.param({"Connected": False}, 0x8001, id="link"),
]
#: Events that end a table started in AUTO mode. A table may also start in MANUAL mode.
_ENDS = [*_FAULTS, pytest.param({"outputs": {"SO10": False}}, 0x8006, id="AUTO mode off")]


def _fault(plc: PlcBench, fault: dict[str, Any], *, there: bool) -> None:
    for name, value in fault.items():
        if name == "outputs":
            plc.outputs(**{one: on is there for one, on in value.items()})
        else:
            plc[name] = value is there
            if name != "Connected":
                plc.scan()  # FB_WriteArea reports the change in the next scan


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(("fault", "error"), _ENDS)
def test_a_fault_of_one_scan_ends_a_waiting_row_and_nothing_continues(
    fault: dict[str, Any], error: int, engine: str
) -> None:
    """If a fault of one scan comes during a wait, the table ends and does not continue.

    During a wait no command is running, so the controller reports no abnormal end.

    Source: manual chapter 1, 5.2; chapter 5, 3.1 and 3.3.
    """
    plc = arrived("WAIT", engine, Number=0, State=True, Duration="T#10s")
    _fault(plc, fault, there=True)
    plc.scan()
    assert (shown(plc), plc["Table.ErrorID"]) == ("Error", error)
    _fault(plc, fault, there=False)
    plc["Table.Bits"] = 1
    plc.scan(60)
    assert (shown(plc), plc["Table.ErrorID"]) == ("Error", error)
    assert (plc["Table.Row"], plc["Table.Arrived"]) == (2, True)
    assert plc.words == [0] * 16
    restart(plc, StartRow=2, StartArrived=True)
    assert goes_on(plc)


@pytest.mark.parametrize(("fault", "error"), _ENDS)
def test_a_short_fault_withdraws_a_waiting_row(fault: dict[str, Any], error: int) -> None:
    plc = moving(*rows_to(1, 2))
    plc["Other.Execute"] = True
    plc.scan()
    end(plc)
    plc.scan(4)
    assert plc.words[0] == 0x0511  # FB_ReadDate uses the channel of the commands
    _fault(plc, fault, there=True)
    plc.scan()
    assert (shown(plc), plc["Table.ErrorID"]) == ("Error", error)
    assert (plc["Table.Row"], plc["Table.Arrived"]) == (2, False)
    _fault(plc, fault, there=False)
    plc.answer(0x0200)
    plc.scan(2)
    plc.answer(0)
    plc.scan(60)
    assert plc.words == [0] * 16


@pytest.mark.parametrize(("fault", "error"), [one for one in _ENDS if one.id not in (
    "CPU_OK off", "link")])  # fmt: skip
def test_a_fault_in_a_movement_waits_for_its_end(fault: dict[str, Any], error: int) -> None:
    """Source: guide, 2: a command is held to its end."""
    plc = moving(*rows_to(1, 2))
    _fault(plc, fault, there=True)
    plc.scan()
    _fault(plc, fault, there=False)
    plc.scan(20)
    assert (shown(plc), plc.words[0], plc["Table.Row"]) == ("Busy", 1, 1)
    end(plc)
    plc.scan()
    assert (shown(plc), plc["Table.ErrorID"], plc["Table.Row"]) == ("Error", error, 2)
    plc.scan(60)
    assert plc.words == [0] * 16


@pytest.mark.parametrize(("fault", "error"), [_FAULTS[0], _FAULTS[-1]])
def test_a_movement_without_controller_ends_at_once(fault: dict[str, Any], error: int) -> None:
    """Source: manual chapter 1, 5.2."""
    plc = moving(*rows_to(1, 2))
    _fault(plc, fault, there=True)
    plc.scan()
    assert (shown(plc), plc["Table.ErrorID"], plc["Table.Row"]) == ("Error", error, 1)
    assert plc.words == [0] * 16


@pytest.mark.parametrize(("fault", "error"), _FAULTS)
def test_it_does_not_start_into_a_fault(fault: dict[str, Any], error: int) -> None:
    plc = bench(*rows_to(1))
    _fault(plc, fault, there=True)
    start(plc)
    assert shown(plc) == "Busy"
    plc.scan()
    assert (shown(plc), plc["Table.ErrorID"], plc["Table.Row"]) == ("Error", error, 1)
    _fault(plc, fault, there=False)
    plc.scan(60)
    assert plc.words == [0] * 16


def test_a_row_begins_once_the_stop_input_has_settled() -> None:
    """A row begins only after SI(06) has been ON for the interval.

    If SI(06) has just turned ON, the controller may not have read it yet.

    Source: manual chapter 5, 3, caution: 100 ms.
    """
    plc = bench(*rows_to(1))
    plc["StopOk"] = False
    plc.scan(40)
    plc["StopOk"] = True
    plc.scan()
    start(plc)
    plc.scan_until(lambda: plc.words[0] != 0, most=60)
    assert plc["Robot.Settled"]
    assert plc["Robot.SI.SI06_Stop"]


def test_a_time_limit_leaves_the_row_shown_with_the_command_that_is_held() -> None:
    plc = moving(*rows_to(1, 2), Timeout="T#100ms")
    plc.scan_until(lambda: plc["Table.Busy"] is False, most=12)
    assert (plc["Table.ErrorID"], plc["Table.Row"], plc.words[0]) == (0x8011, 1, 1)


def test_a_second_call_in_the_scan_of_an_error_sends_no_later_command() -> None:
    """A second call in the scan of an error sends no command later.

    The table has ended while its command waited for a command of another block.

    Source: a rule of this library.
    """
    plc = bench(*rows_to(1, 2))
    plc["Other.Execute"] = True
    date = sent(plc)[0]
    start(plc)
    plc.scan(3)
    plc["Table.Abort"] = plc["CallTwice"] = True
    plc.scan()
    assert (shown(plc), plc["Table.ErrorID"], plc.words[0]) == ("Error", 0x8050, date)
    plc["Table.Abort"] = plc["CallTwice"] = False
    end(plc)
    for _ in range(8):
        plc.scan()
        assert plc.words[0] == 0


def test_a_start_in_the_scan_of_an_error_is_refused() -> None:
    """A start in the scan of an error is refused while the command of the ended table still waits.

    Its pins are the pins of the ended table.

    Source: a rule of this library.
    """
    plc = bench(*rows_to(1, 2))
    plc["Other.Execute"] = True
    sent(plc)
    start(plc)
    plc["Table.Execute"] = False
    plc.scan(3)
    plc["Table.Abort"] = plc["StartAgain"] = True
    plc.scan()
    plc["Table.Abort"] = plc["StartAgain"] = False
    plc.scan()
    assert (shown(plc), plc["Table.ErrorID"]) == ("Error", 0x8013)
    end(plc)
    for _ in range(8):
        plc.scan()
        assert plc.words[0] == 0
    restart(plc)
    assert runs(plc) == [1, 2]


def test_a_missing_call_ends_the_table_and_the_row_stays_shown() -> None:
    plc = moving(*rows_to(1, 2))
    plc["CallTable"] = False
    plc.scan()
    plc["CallTable"] = True
    plc.scan()
    assert (shown(plc), plc["Table.ErrorID"], plc["Table.Row"]) == ("Error", 0x8013, 1)
    plc["CallTwice"] = True
    end(plc)
    plc["CallTwice"] = False
    restart(plc)
    plc["CallTwice"] = True
    plc.scan()
    assert (shown(plc), plc["Table.ErrorID"], plc["Table.Row"]) == ("Error", 0x8016, 1)
    plc["CallTwice"] = False
    plc.scan(5)
    assert plc.words == [0] * 16
    restart(plc)
    assert runs(plc) == [1, 2]


def test_a_start_in_the_scan_after_an_error_runs() -> None:
    """A start in the scan after an error runs, because the error has withdrawn the waiting command.

    Source: a rule of this library.
    """
    plc = bench(*rows_to(1, 2))
    plc["Other.Execute"] = True
    sent(plc)
    start(plc)
    plc["Table.Execute"] = False
    plc.scan(3)
    plc["Table.Abort"] = True
    plc.scan()
    plc["Table.Abort"] = False
    assert (shown(plc), plc["Table.ErrorID"]) == ("Error", 0x8050)
    start(plc)
    assert shown(plc) == "Busy"
    end(plc)
    assert runs(plc) == [1, 2]
    assert shown(plc) == "Done"


def test_a_start_with_the_second_call_of_a_scan_runs() -> None:
    """If the second call of a scan starts the table, the table runs.

    The first call was without work.

    Source: a rule of this library.
    """
    plc = bench(*rows_to(1, 2))
    plc["StartAgain"] = True
    plc.scan()
    plc["StartAgain"] = False
    assert runs(plc) == [1, 2]
    assert shown(plc) == "Done"


@pytest.mark.parametrize("hold", [True, False])
def test_after_a_missing_call_no_command_is_sent(hold: bool) -> None:
    """After a scan without a call, no command is sent, even if Hold is reset afterwards.

    Source: scan-model.md.
    """
    plc = started(*rows_to(1, 2), Hold=hold)
    plc["CallTable"] = False
    plc.scan()
    plc["CallTable"] = True
    plc.scan()
    assert (shown(plc), plc["Table.ErrorID"], plc["Table.Row"]) == ("Error", 0x8013, 1)
    plc["Table.Hold"] = False
    for _ in range(8):
        plc.scan()
        assert plc.words == [0] * 16


@pytest.mark.parametrize("active", [True, False])
def test_an_edge_of_execute_while_the_table_runs_samples_no_input(active: bool) -> None:
    """Source: design of the library, 3."""
    plc = started(*rows_to(1, 2, 3), Hold=not active)
    if active:
        sent(plc)
    plc["Table.Execute"] = False
    plc.scan()
    plc["Table.StartRow"], plc["Table.Rows"], plc["Table.Hold"] = 3, 1, False
    plc["Table.Execute"] = True
    plc.scan()
    assert runs(plc) == [1, 2, 3]
    assert shown(plc) == "Done"


def test_if_execute_falls_at_once_the_end_is_shown_for_one_scan() -> None:
    plc = started(*rows_to(1))
    plc["Table.Execute"] = False
    sent(plc)
    assert shown(plc) == "Busy"
    plc.answer(0x0200)
    plc.scan()
    plc.answer(0)
    assert shown(plc) == "Done"
    plc.scan()
    assert shown(plc) == ""
    plc.scan(5)
    start(plc)
    assert runs(plc) == [1]


def test_a_table_can_start_in_manual_mode_and_ignores_the_mode() -> None:
    """Source: docs/explanation/fidelity.md, program-mode: remote commands work in both modes."""
    plc = bench(*rows_to(1, 2, 3))
    plc.outputs(SO10=False)
    plc.scan()
    start(plc)
    end_of_first = sent(plc)
    assert end_of_first[4] == 1
    plc.outputs(SO10=True)
    end(plc)
    sent(plc)
    plc.outputs(SO10=False)
    end(plc)
    assert runs(plc) == [3]
    assert shown(plc) == "Done"


def _doubtful() -> PlcBench:
    """Return a bench that has sent relative row 2 of 3, but has missed its end status."""
    relative = {"Kind": "MOVE_BY_PTP", "Axes": 1}
    plc = moving(*rows_to(1), relative, *rows_to(3), Rows=3, StartRow=2)
    plc["CallTable"] = False
    plc.scan()
    plc["CallTable"] = True
    plc.answer(0x0200)
    plc.scan(2)
    plc.answer(0)
    plc.scan(40)
    assert (shown(plc), plc["Table.ErrorID"], plc["Table.Row"]) == ("Error", 0x8013, 2)
    return plc


@pytest.mark.parametrize(
    ("pins", "error"),
    [({"StartRow": 9}, 0x8051), ({"StartRow": 2, "Rows": 1}, 0x8051), ({}, 0x8007)],
)
def test_after_a_refused_start_a_relative_row_stays_doubtful(
    pins: dict[str, Any], error: int
) -> None:
    """After a refused start the block still reports that a relative row may have been executed.

    The start is refused because of an illegal row or a stop.

    Source: docs/reference/errors.md, 16#8055; guide 4.2.2: a relative movement adds to where the
    robot stands
    """
    plc = _doubtful()
    plc["StopOk"] = bool(pins)
    plc.scan()
    for pin, value in ({"StartRow": 1} | pins).items():
        plc[f"Table.{pin}"] = value
    restart(plc)
    plc.scan(2)
    assert plc["Table.ErrorID"] == error
    plc["StopOk"] = True
    plc.scan(40)
    restart(plc, StartRow=2, Rows=3)
    plc.scan(4)
    assert (shown(plc), plc["Table.ErrorID"], plc.words[0]) == ("Error", 0x8055, 0)


def test_an_absolute_row_may_begin_after_an_interrupted_row() -> None:
    """After an interrupted relative row, an absolute row may begin: its target is fixed.

    Source: guide 4.2.1, absolute movement.
    """
    plc = _doubtful()
    restart(plc, StartRow=3)
    assert runs(plc) == [3]
    assert shown(plc) == "Done"
