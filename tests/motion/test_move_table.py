"""FB_MoveTable sends the telegram of each row in order, and reports arrivals.

The test plays the controller.
"""

from __future__ import annotations

from typing import Any

import pytest

from both_engines import ENGINES
from table_bench import (
    Row,
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

# ---- the telegram of a row

_ARCH = {"ArchPosition": 1.0, "ArchDistance1": 2.0, "ArchDistance2": 70.0}
_DIRECT = {"Position[1]": 10.0, "Position[2]": -20.0, "Position[6]": 0.001}
_HALF = {"SpeedMode": "SPEED_PERCENT", "Speed": 50.0}
_RAMPS = {"Acceleration": 30, "Deceleration": 40}


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    ("row", "words"),
    [
        ({"Kind": "MOVE_PTP", "Point": 100, "Axes": 3} | _HALF | _RAMPS,
         [0x2001, 0x0065, 3, 50, 100, 0, 0, 0, 0, 0, 30, 40, 0, 0, 0, 0]),
        ({"Kind": "MOVE_LINEAR", "Point": 100, "Axes": 3, "SpeedMode": "SPEED_MM_S",
          "Speed": 200.0} | _RAMPS,
         [0x2003, 0x0067, 3, 200, 100, 0, 0, 0, 0, 0, 30, 40, 0, 0, 0, 0]),
        ({"Kind": "MOVE_ARCH", "Point": 100, "Axes": 3} | _HALF | _ARCH,
         [0x2002, 0x0015, 0x0803, 50, 100, 0, 0, 0, 1000, 0, 2000, 0, 0x1170, 1, 0, 0]),
        ({"Kind": "MOVE_CIRCULAR", "Point": 100, "Point2": 101} | _HALF | _RAMPS,
         [0x2004, 0x0064, 0, 50, 100, 101, 0, 0, 0, 0, 30, 40, 0, 0, 0, 0]),
        ({"Kind": "MOVE_MM", "Axes": 35, "HandSystem": "HAND_LEFT"} | _HALF | _DIRECT,
         [0x2006, 0x0015, 35, 50, 10000, 0, 0xB1E0, 0xFFFF, 0, 0, 0, 0, 0, 0, 1, 0]),
        ({"Kind": "MOVE_BY_PTP", "Point": 100, "Axes": 3} | _HALF | _RAMPS,
         [0x2009, 0x0065, 3, 50, 100, 0, 0, 0, 0, 0, 30, 40, 0, 0, 0, 0]),
        ({"Kind": "MOVE_BY_LINEAR", "Point": 100, "Axes": 3} | _HALF | _RAMPS,
         [0x200A, 0x0065, 3, 50, 100, 0, 0, 0, 0, 0, 30, 40, 0, 0, 0, 0]),
        ({"Kind": "MOVE_BY_MM", "Axes": 35, "HandSystem": "HAND_LEFT"} | _HALF | _DIRECT,
         [0x200E, 0x0015, 35, 50, 10000, 0, 0xB1E0, 0xFFFF, 0, 0, 0, 0, 0, 0, 1, 0]),
        ({"Kind": "MOVE_PALLET", "Pallet": 1, "WorkPosition": 21} | _HALF | _RAMPS,
         [0x2018, 0x0064, 0, 50, 1, 21, 0, 0, 0, 0, 30, 40, 0, 0, 0, 0]),
        ({"Kind": "MOVE_PALLET", "Pallet": 1} | _HALF | _RAMPS,
         [0x2018, 0x0064, 0, 50, 1, 7, 0, 0, 0, 0, 30, 40, 0, 0, 0, 0]),
        ({"Kind": "MOVE_PALLET_ARCH", "Pallet": 10, "WorkPosition": 32} | _HALF | _ARCH,
         [0x2019, 0x0014, 0x0800, 50, 10, 32, 0, 0, 1000, 0, 2000, 0, 0x1170, 1, 0, 0]),
        ({"Kind": "MOVE_PALLET_ARCH", "Pallet": 10} | _HALF | _ARCH,
         [0x2019, 0x0014, 0x0800, 50, 10, 7, 0, 0, 1000, 0, 2000, 0, 0x1170, 1, 0, 0]),
        ({"Kind": "MOVE_STAY", "AtArrival": "ARRIVE_SET", "Number": 25, "State": True},
         [0x0301, 0, 0x1025, 1, *[0] * 12]),
        ({"Kind": "MOVE_STAY", "AtArrival": "ARRIVE_SET", "Number": 277},
         [0x0301, 0, 0x1277, 0, *[0] * 12]),
    ],
)  # fmt: skip
def test_each_kind_of_row_sends_its_telegram(row: Row, words: list[int], engine: str) -> None:
    """Each kind of row sends its telegram, and accepts a normal and an abnormal end.

    Source: guide 4.2.1, 4.2.2, 4.2.5, 4.5.1, the tables of the commands.
    """
    pins = {"RobotNumber": 2, "ArchAxis": 4, "WorkPosition": 7}
    plc = started(row, engine=engine, **pins)
    assert sent(plc) == words
    assert plc["Table.Active"]
    end(plc)
    plc.scan(2)
    assert (shown(plc), plc["Table.Row"]) == ("Done", 0)
    restart(plc)
    assert sent(plc) == words
    end(plc, 0x4000, (12, 600))
    assert (shown(plc), plc["Table.Row"]) == ("Error", 1)
    assert plc["Table.ErrorID"] == 0x8020
    assert (plc["Table.AlarmGroup"], plc["Table.AlarmCategory"]) == (12, 600)
    plc.scan(3)
    assert (plc["Table.AlarmGroup"], plc["Table.AlarmCategory"]) == (12, 600)
    plc["Table.Execute"] = False
    plc.scan()
    assert (plc["Table.AlarmGroup"], plc["Table.AlarmCategory"]) == (0, 0)
    assert plc["Table.Row"] == 1, "the value stays until the next start"


@pytest.mark.parametrize(
    "row",
    [
        {"Kind": "MOVE_PTP", "Point": 30000},
        {"Kind": "MOVE_PALLET", "Pallet": 40},
        {"Kind": "MOVE_STAY", "AtArrival": "ARRIVE_SET", "Number": 280},
        {"Kind": "MOVE_STAY", "AtArrival": "ARRIVE_WAIT", "Number": -1},
        {"Kind": "MOVE_STAY", "AtArrival": "ARRIVE_WAIT", "Number": 32},
        {"Kind": "MOVE_STAY", "AtArrival": "ARRIVE_CALL", "Number": 0},
    ],
)
def test_a_number_out_of_range_ends_the_row_without_a_telegram(row: Row) -> None:
    """Source: guide 4.2.1, 4.2.5, 4.5.1, the ranges; RCX_MOVE."""
    plc = moving(*rows_to(1), row)
    end(plc)
    plc.scan_until(lambda: plc["Table.Busy"] is False, most=6)
    assert (plc["Table.ErrorID"], plc["Table.Row"]) == (0x8044, 2)
    assert plc.words == [0] * 16


# ---- the order of rows


#: Tables: four rows; four rows with old rows after MOVE_END; an empty table; a full array.
_FOUR, _LEFT = rows_to(1, 2, 3, 4), [*rows_to(1, 2), {}, *rows_to(4, 5)]
_NONE, _ALL = [{}, *rows_to(2)], rows_to(*range(1, 51))


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    ("rows", "pins", "points"),
    [
        (_FOUR, {}, [1, 2, 3, 4]),
        (_FOUR, {"StartRow": 1}, [1, 2, 3, 4]),
        (_FOUR, {"StartRow": 3}, [3, 4]),
        (_FOUR, {"Rows": 4}, [1, 2, 3, 4]),
        (_FOUR, {"Rows": 2}, [1, 2]),
        (_FOUR, {"Rows": 1}, [1]),
        (_FOUR, {"Backwards": True, "StartRow": 4}, [4, 3, 2, 1]),
        (_FOUR, {"Backwards": True, "StartRow": 2}, [2, 1]),
        (_FOUR, {"Backwards": True, "Rows": 3}, [3, 2, 1]),
        (_FOUR, {"Backwards": True, "Rows": 6}, [4, 3, 2, 1]),
        (_FOUR, {"StartRow": 5}, []),
        (_LEFT, {"Backwards": True}, [2, 1]),
        (_LEFT, {"Backwards": True, "Rows": 5}, [2, 1]),
        (_LEFT, {"Backwards": True, "Rows": 3}, [2, 1]),
        (_LEFT, {"Backwards": True, "Rows": 2}, [2, 1]),
        (_LEFT, {"Backwards": True, "StartRow": 3}, [2, 1]),
        (_LEFT, {}, [1, 2]),
        (_LEFT, {"StartRow": 3}, []),
        (_NONE, {}, []),
        (_NONE, {"Backwards": True}, []),
        (_ALL, {"StartRow": 49}, [49, 50]),
    ],
)
def test_the_rows_run_one_after_the_other(
    rows: list[Row], pins: dict[str, Any], points: list[int], engine: str
) -> None:
    """The table runs from StartRow to MOVE_END, to Rows or to the end of the array, or repeats.

    Source: RCX_MOVE_KIND; RCX_MOVES: rows 1 to 50; the block's pins.
    """
    plc = started(*rows, engine=engine, **pins)
    assert runs(plc) == points
    assert (shown(plc), plc["Table.Row"], plc["Table.Stage"]) == ("Done", 0, "TABLE_COMPLETE")
    plc["Table.Execute"] = False
    plc.scan()
    assert (shown(plc), plc["Table.Stage"]) == ("", "TABLE_IDLE")


def test_backwards_the_first_row_that_is_held_is_the_last_of_the_table() -> None:
    plc = started(*rows_to(1, 2), {}, *rows_to(4), Backwards=True, Hold=True)
    plc.scan(3)
    assert (plc["Table.Stage"], plc["Table.Row"]) == ("TABLE_HELD", 2)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("back", [False, True])
@pytest.mark.parametrize("row", [4, 5, 50])
def test_a_start_behind_the_end_of_the_table_is_refused(row: int, back: bool, engine: str) -> None:
    """A StartRow behind the end of the table is refused. Here row 3 is MOVE_END.

    Source: RCX_MOVE_KIND.
    """
    plc = started(*rows_to(1, 2), {}, *rows_to(4, 5), engine=engine, StartRow=row, Backwards=back)
    plc.scan()
    assert (shown(plc), plc["Table.ErrorID"]) == ("Error", 0x8051)
    plc.scan(5)
    assert plc.words == [0] * 16


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("row", [0, 3])
@pytest.mark.parametrize(
    ("pin", "value", "error"),
    [
        *(("Connected", False, 0x8001), ("EmergencyStopOk", False, 0x8003)),
        *(("StopOk", False, 0x8007), ("Table.Abort", True, 0x8050)),
    ],
)
def test_a_start_during_a_fault_ends_in_it_even_if_no_row_would_run(
    pin: str, value: bool, error: int, row: int, engine: str
) -> None:
    """A start during a fault ends in the error of the fault, even if no row would run.

    The table is empty, or StartRow is MOVE_END. The cause of the fault may be gone in the next
    scan.

    Source: pin Error: refused, broken off
    """
    rows = rows_to(1, 2) if row else []
    plc = bench(*rows, engine=engine, StartRow=row)
    plc[pin] = value
    plc.scan(2)
    start(plc)
    plc[pin] = not value
    plc.scan()
    assert (shown(plc), plc["Table.ErrorID"]) == ("Error", error)
    assert (plc["Table.Row"], plc["Table.Stage"]) == (row or 1, "TABLE_HELD")
    plc.scan(40)
    restart(plc)
    plc.scan(2)
    assert (shown(plc), plc["Table.ErrorID"]) == ("Done", 0)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_fault_during_the_last_row_leaves_the_table_done(engine: str) -> None:
    """If a fault comes during the last row and the row ends normally, the table is Done.

    Source: pin Done: all rows are done.
    """
    plc = moving(*rows_to(1), engine=engine)
    plc["Table.Abort"] = True
    plc.scan(5)
    end(plc)
    assert (shown(plc), plc["Table.ErrorID"], plc["Table.Row"]) == ("Done", 0, 0)


def test_rows_added_while_the_table_runs_are_executed() -> None:
    """Rows that are added while the table runs are executed.

    The table ends at the first row with MOVE_END. Source: pin Moves.
    """
    plc = started(*rows_to(1))
    plc["Moves[2].Kind"], plc["Moves[2].Point"] = "MOVE_PTP", 2
    assert runs(plc) == [1, 2]


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    "pins",
    [{"StartRow": -1}, {"StartRow": 51}, {"StartRow": 3, "Rows": 2}, {"Rows": 0},
     {"Rows": 0, "Backwards": True}, {"Rows": -1, "Backwards": True},
     {"Rows": 51}, {"Rows": 51, "Backwards": True}, {"Rows": 51, "StartRow": 51},
     {"Rows": 32767, "StartRow": 2}, {"MovesSize": 3, "Rows": 4}, {"MovesSize": 0, "Rows": 1},
     {"MovesSize": 49}],
)  # fmt: skip
def test_a_row_number_outside_of_the_table_is_refused(pins: dict[str, Any], engine: str) -> None:
    """A row number outside of the table is refused.

    MovesSize must not exceed the rows of RCX_MOVES.

    Source: a rule of this library.
    """
    plc = started(*rows_to(1, 2, 3), engine=engine, **pins)
    assert shown(plc) == "Busy"
    plc.scan()
    assert (shown(plc), plc["Table.ErrorID"]) == ("Error", 0x8051)
    plc.scan(5)
    assert plc.words == [0] * 16
    plc["Table.Rows"], plc["Table.StartRow"], plc["Table.Backwards"] = 3, 3, False
    restart(plc, MovesSize=3)
    assert runs(plc) == [3], "afterwards the table works as before"


def test_pins_are_those_of_the_rising_edge() -> None:
    plc = started(*rows_to(1, 2), RobotNumber=1, Rows=2)
    plc["Table.RobotNumber"], plc["Table.Rows"], plc["Table.StartRow"] = 3, 1, 2
    plc["Table.Backwards"], plc["Table.Timeout"] = True, "T#10ms"
    assert sent(plc)[0] == 0x1001
    plc.scan(5)
    end(plc)
    words = sent(plc)
    assert (words[0], words[4]) == (0x1001, 2)
    plc.scan(5)
    end(plc)
    plc.scan(2)
    assert shown(plc) == "Done"


def test_a_row_is_read_when_it_begins() -> None:
    plc = started(*rows_to(1, 2))
    plc["Moves[1].Point"] = 11
    plc["Moves[2].Point"] = 12
    assert sent(plc)[4] == 1
    end(plc)
    assert sent(plc)[4] == 12


@pytest.mark.parametrize("kind", ["CIRCULAR", "BY_PTP", "BY_LINEAR", "BY_MM"])
def test_backwards_a_circular_or_relative_row_is_refused(kind: str) -> None:
    """With Backwards, a circular or relative row is refused: it would not lead to the previous row.

    Source: guide 4.2.1, circular interpolation: from where the robot is; 4.2.2: by a distance.
    """
    plc = started({"Kind": f"MOVE_{kind}", "Point": 1}, *rows_to(2), Backwards=True, Rows=2)
    assert sent(plc)[4] == 2
    end(plc)
    plc.scan_until(lambda: plc["Table.Busy"] is False, most=6)
    assert (plc["Table.ErrorID"], plc["Table.Row"]) == (0x8054, 1)
    plc.scan(5)
    assert plc.words == [0] * 16
    restart(plc, StartRow=2, Hold=True)
    plc.scan(10)
    assert (shown(plc), plc["Table.Stage"]) == ("Busy", "TABLE_HELD")


def test_backwards_a_completed_relative_row_is_passed() -> None:
    """With Backwards, a relative row that has already been executed (StartArrived) is passed."""
    plc = started(*rows_to(1), {"Kind": "MOVE_BY_PTP", "Point": 2}, StartRow=2, StartArrived=True,
                 Backwards=True)  # fmt: skip
    assert runs(plc) == [1]
    assert shown(plc) == "Done"


# ---- at arrival


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(("number", "bits"), [(0, 1), (15, 0x8000), (31, 0x80000000)])
@pytest.mark.parametrize("state", [True, False])
def test_a_row_waits_for_a_bit(number: int, bits: int, state: bool, engine: str) -> None:
    plc = arrived("WAIT", engine, Number=number, State=state)
    there = bits if state else 0xFFFFFFFF & ~bits
    plc["Table.Bits"] = 0xFFFFFFFF & ~there
    plc.scan(20)
    assert (plc["Table.Row"], plc.words[0]) == (2, 0)
    plc["Table.Bits"] = there
    assert goes_on(plc)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(("arrival", "error"), [("WAIT", 0x8052), ("CALL", 0x8053)])
@pytest.mark.parametrize(("duration", "scans"), [("T#0s", 30), ("T#500ms", 50), ("T#50ms", 5)])
def test_a_wait_of_a_row_ends_after_duration_or_timeout(
    arrival: str, error: int, duration: str, scans: int, engine: str
) -> None:
    """A wait ends after Duration, or after Timeout if the row has no Duration.

    The table can be continued afterwards.

    Source: RCX_ARRIVAL.
    """
    plc = arrived(arrival, engine, Number=3, State=True, Duration=duration)
    taken = plc.scan_until(lambda: plc["Table.Busy"] is False, most=60)
    assert scans <= taken <= scans + 2
    assert (shown(plc), plc["Table.ErrorID"]) == ("Error", error)
    assert (plc["Table.Row"], plc["Table.Arrived"], plc["Table.CallNumber"]) == (2, True, 0)
    restart(plc, StartRow=2, StartArrived=True)
    plc.scan(4)
    assert (plc["Table.Stage"], plc.words[0]) == ("TABLE_ARRIVAL", 0)
    assert (plc["Table.Row"], plc["Table.Arrived"]) == (2, True)
    if arrival == "WAIT":
        plc["Table.Bits"] = 8
    else:
        plc["Table.Acknowledge"] = True
    assert goes_on(plc)


@pytest.mark.parametrize("arrival", ["WAIT", "CALL"])
def test_without_a_limit_a_row_waits_for_ever(arrival: str) -> None:
    plc = arrived(arrival, Number=3, State=True)
    plc["Table.Abort"] = True
    plc.scan(2)
    plc["Table.Abort"] = False
    restart(plc, StartRow=2, StartArrived=True, Timeout="T#0s")
    plc.scan(500)
    assert shown(plc) == "Busy"


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(("duration", "scans"), [("T#100ms", 10), ("T#0s", 0), ("T#-5ms", 0)])
def test_a_row_pauses(duration: str, scans: int, engine: str) -> None:
    plc = arrived("PAUSE", engine, Duration=duration)
    taken = plc.scan_until(lambda: plc["Table.Row"] == 3, most=60)
    assert scans < taken <= scans + 2
    assert goes_on(plc)


def test_a_port_bit_that_is_not_answered_is_limited_by_duration() -> None:
    plc = arrived("SET", Number=20, State=True, Duration="T#100ms")
    assert sent(plc)[2] == 0x1020
    plc.scan_until(lambda: plc["Table.Busy"] is False, most=12)
    assert (plc["Table.ErrorID"], plc["Table.Row"], plc["Table.Arrived"]) == (0x8011, 2, True)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_call_goes_on_with_the_edge_of_acknowledge_and_not_before(engine: str) -> None:
    plc = arrived("CALL", engine, Number=7)
    plc["Table.Acknowledge"] = True
    plc.scan()
    assert goes_on(plc)
    plc = started(
        {"Kind": "MOVE_STAY", "AtArrival": "ARRIVE_CALL", "Number": 1},
        {"Kind": "MOVE_STAY", "AtArrival": "ARRIVE_CALL", "Number": 8},
        engine=engine,
        Acknowledge=True,
    )
    plc.scan(5)
    assert (plc["Table.CallNumber"], plc["Table.Row"]) == (1, 1), "there was no new edge"
    plc["Table.Acknowledge"] = False
    plc.scan(3)
    plc["Table.Acknowledge"] = True
    plc.scan()
    assert (plc["Table.CallNumber"], plc["Table.Row"]) == (0, 2)
    plc["Table.Hold"] = True
    plc.scan(5)
    assert plc["Table.CallNumber"] == 0
    plc["Table.Hold"] = False
    plc.scan(5)
    assert (plc["Table.CallNumber"], plc["Table.Row"]) == (8, 2), "an edge answers a single call"
    plc["Table.Acknowledge"] = False
    plc.scan()
    plc["Table.Acknowledge"] = True
    plc.scan(2)
    assert (plc["Table.CallNumber"], shown(plc)) == (0, "Done")


@pytest.mark.parametrize("engine", ENGINES)
def test_an_edge_before_callnumber_is_shown_does_not_acknowledge_it(engine: str) -> None:
    """An edge of Acknowledge before CallNumber is shown does not acknowledge the call.

    Source: RCX_ARRIVAL, ARRIVE_CALL.
    """
    rows = [
        {"Kind": "MOVE_STAY", "AtArrival": "ARRIVE_CALL", "Number": 7},
        {"Kind": "MOVE_STAY", "AtArrival": "ARRIVE_CALL", "Number": 8},
        {"Kind": "MOVE_PTP", "Point": 3},
    ]
    plc = bench(*rows, engine=engine)
    plc["Table.Acknowledge"] = True
    start(plc)
    plc.scan(5)
    assert (plc["Table.CallNumber"], plc["Table.Row"]) == (7, 1)
    for acknowledge in (False, True, False, True):  # edges of a bouncing contact
        plc["Table.Acknowledge"] = acknowledge
        plc.scan()
    plc.scan(5)
    assert (plc["Table.CallNumber"], plc["Table.Row"]) == (8, 2)
    for acknowledge in (False, True):
        plc["Table.Acknowledge"] = acknowledge
        plc.scan()
    assert runs(plc) == [3]


def test_backwards_nothing_is_done_at_arrival() -> None:
    rows = [
        {"Kind": "MOVE_STAY", "AtArrival": "ARRIVE_SET", "Number": 20},
        {"Kind": "MOVE_PTP", "Point": 2, "AtArrival": "ARRIVE_CALL", "Number": 1},
        {"Kind": "MOVE_PTP", "Point": 3, "AtArrival": "ARRIVE_SET", "Number": 20},
    ]
    plc = started(*rows, Backwards=True, Rows=3)
    assert runs(plc) == [3, 2]
    plc.scan(10)
    assert plc.words == [0] * 16


def test_going_on_at_an_arrival_does_not_move() -> None:
    row = {"Kind": "MOVE_PTP", "Point": 1, "AtArrival": "ARRIVE_SET", "Number": 20}
    plc = started(row, StartRow=1, StartArrived=True)
    assert sent(plc)[:3] == [0x0301, 0, 0x1020]
    end(plc)
    plc.scan(2)
    assert shown(plc) == "Done"


def test_row_0_is_begun_with_its_movement() -> None:
    row = {"Kind": "MOVE_PTP", "Point": 1, "AtArrival": "ARRIVE_SET", "Number": 20}
    plc = started(row, StartArrived=True)
    assert sent(plc)[0] == 0x0001


@pytest.mark.parametrize("kind", ["MOVE_BY_PTP", "MOVE_BY_LINEAR", "MOVE_BY_MM"])
@pytest.mark.parametrize("lost", ["no call", "time-out", "link"])
def test_a_relative_row_that_may_be_done_is_not_repeated_without_a_decision(
    kind: str, lost: str
) -> None:
    """A relative row that may have been executed is not repeated until a person has decided.

    Source: guide 4.2.2: a relative movement adds to where the robot stands
    """
    for known in ({"StartArrived": True}, {"Acknowledge": True}):
        plc = bench(*rows_to(1), {"Kind": kind, "Axes": 1}, *rows_to(3), Timeout="T#100ms")
        plc["Table.StartRow"] = 2
        start(plc)
        sent(plc)
        if lost == "link":
            plc["Connected"] = False
        elif lost == "no call":
            plc["CallTable"] = False
        plc.scan(20)
        plc["Connected"] = plc["CallTable"] = True
        plc.scan()
        assert (shown(plc), plc["Table.Row"], plc["Table.Arrived"]) == ("Error", 2, False)
        plc.answer(0x0200)
        plc.scan(2)
        plc.answer(0)
        plc.scan(40)
        for _ in range(2):
            restart(plc)
            plc.scan(4)
            assert (shown(plc), plc["Table.ErrorID"]) == ("Error", 0x8055)
        for pin, value in known.items():
            plc[f"Table.{pin}"] = value
        restart(plc)
        assert (sent(plc)[4] == 3) is ("StartArrived" in known)


def test_an_absolute_row_and_an_ended_relative_row_are_not_doubtful() -> None:
    """Source: guide 4.2.1, 4.2.2."""
    plc = moving(*rows_to(1), {"Kind": "MOVE_BY_PTP", "Axes": 1}, Timeout="T#100ms")
    plc.scan(20)
    assert plc["Table.ErrorID"] == 0x8011
    end(plc)
    restart(plc, StartRow=1)
    assert sent(plc)[4] == 1
    end(plc)
    sent(plc)
    end(plc, 0x4000, (12, 400))
    restart(plc, StartRow=2)
    assert sent(plc)[0] == 0x0009
