"""FB_MoveTable: rows, arrivals, hold, abort and what ends it; the test plays the controller."""

from __future__ import annotations

from typing import Any

import pytest

from both_engines import ENGINES
from plc_bench import ROOT, PlcBench

Row = dict[str, Any]

_PTP = {"Kind": "MOVE_PTP"}


def _bench(*rows: Row, engine: str = "builtin", **pins: Any) -> PlcBench:
    """Servos on, inputs settled; the rows are the first of the table."""
    program = ROOT / "tests/data/library/MoveTable.st"
    plc = PlcBench(program=program, engine=engine)
    plc.power_up()
    plc.outputs(SO02=True)
    for number, row in enumerate(rows, 1):
        for field, value in row.items():
            plc[f"Moves[{number}].{field}"] = value
    for pin, value in pins.items():
        plc[f"Table.{pin}"] = value
    plc.scan()
    return plc


def _points(*points: int) -> list[Row]:
    return [{"Kind": "MOVE_PTP", "Point": point} for point in points]


def _start(plc: PlcBench) -> None:
    plc["Table.Execute"] = True
    plc.scan()


def _restart(plc: PlcBench) -> None:
    """Execute falls for one scan and rises again; the pins say from where."""
    plc["Table.Execute"] = False
    plc.scan()
    _start(plc)


def _shown(plc: PlcBench) -> str:
    names = ("Done", "Busy", "Error")
    return " ".join(name for name in names if plc[f"Table.{name}"])


def _sent(plc: PlcBench, most: int = 12) -> list[int]:
    """Scan until a code is on the wire; code and data."""
    plc.scan_until(lambda: plc.words[0] != 0, most=most)
    return plc.words


def _end(plc: PlcBench, status: int = 0x0200, response: tuple[int, ...] = ()) -> None:
    """The controller ends the command; after its reset it is ready."""
    plc.answer(status, response)
    plc.scan()
    assert plc.words[0] == 0
    plc.answer(0)


def _runs(plc: PlcBench) -> list[int]:
    """Let the controller end each command with 16#0200; the points in their order, to the end."""
    points: list[int] = []
    for _ in range(200):
        if plc["Table.Busy"] is False:
            return points
        if plc.words[0]:
            points.append(plc.words[4])
            assert plc["Table.Row"] == points[-1], "in these tables row k goes to point k"
            _end(plc)
        else:
            plc.scan()
    raise AssertionError("it does not come to its end")


# ---- what a row sends

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
def test_each_kind_of_row_is_its_telegram(row: Row, words: list[int], engine: str) -> None:
    """And each end is taken, normal or not.

    Source: guide 4.2.1, 4.2.2, 4.2.5, 4.5.1, the tables of the commands.
    """
    pins = {"RobotNumber": 2, "ArchAxis": 4, "WorkPosition": 7}
    plc = _bench(row, engine=engine, **pins)
    _start(plc)
    assert _sent(plc) == words
    assert plc["Table.Active"]
    _end(plc)
    plc.scan(2)
    assert (_shown(plc), plc["Table.Row"]) == ("Done", 0)
    _restart(plc)
    assert _sent(plc) == words
    _end(plc, 0x4000, (12, 600))
    assert (_shown(plc), plc["Table.Row"]) == ("Error", 1)
    assert plc["Table.ErrorID"] == 0x8020
    assert (plc["Table.AlarmGroup"], plc["Table.AlarmCategory"]) == (12, 600)
    plc.scan(3)
    assert (plc["Table.AlarmGroup"], plc["Table.AlarmCategory"]) == (12, 600)
    plc["Table.Execute"] = False
    plc.scan()
    assert (plc["Table.AlarmGroup"], plc["Table.AlarmCategory"]) == (0, 0)
    assert plc["Table.Row"] == 1, "it is kept until the next start"


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
def test_a_number_that_is_not_there_ends_the_row_without_a_telegram(row: Row) -> None:
    """Source: guide 4.2.1, 4.2.5, 4.5.1, the ranges; RCX_MOVE."""
    plc = _bench(*_points(1), row)
    _start(plc)
    _sent(plc)
    _end(plc)
    plc.scan_until(lambda: plc["Table.Busy"] is False, most=6)
    assert (plc["Table.ErrorID"], plc["Table.Row"]) == (0x8044, 2)
    assert plc.words == [0] * 16


# ---- which rows, in which order


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    ("pins", "points"),
    [
        ({}, [1, 2, 3, 4]),
        ({"StartRow": 1}, [1, 2, 3, 4]),
        ({"StartRow": 3}, [3, 4]),
        ({"Rows": 4}, [1, 2, 3, 4]),
        ({"Rows": 2}, [1, 2]),
        ({"Rows": 1}, [1]),
        ({"Backwards": True, "StartRow": 4}, [4, 3, 2, 1]),
        ({"Backwards": True, "StartRow": 2}, [2, 1]),
        ({"Backwards": True, "Rows": 3}, [3, 2, 1]),
        ({"Backwards": True, "Rows": 6}, [4, 3, 2, 1]),
        ({"StartRow": 5}, []),
    ],
)
def test_the_rows_run_one_after_the_other(
    pins: dict[str, Any], points: list[int], engine: str
) -> None:
    """From StartRow to MOVE_END or Rows, or back to row 1; row 5 is MOVE_END.

    Source: RCX_MOVE_KIND; the block's pins.
    """
    plc = _bench(*_points(1, 2, 3, 4), engine=engine, **pins)
    _start(plc)
    assert _runs(plc) == points
    assert (_shown(plc), plc["Table.Row"], plc["Table.Stage"]) == ("Done", 0, "TABLE_COMPLETE")
    plc["Table.Execute"] = False
    plc.scan()
    assert (_shown(plc), plc["Table.Stage"]) == ("", "TABLE_IDLE")


def test_the_last_row_of_the_array_is_the_end_of_the_table() -> None:
    """Source: RCX_MOVES: rows 1 to 50."""
    plc = _bench(*_points(*range(1, 51)), StartRow=49)
    _start(plc)
    assert _runs(plc) == [49, 50]
    assert _shown(plc) == "Done"


@pytest.mark.parametrize(
    "pins",
    [{"StartRow": -1}, {"StartRow": 51}, {"StartRow": 3, "Rows": 2}, {"Rows": 0},
     {"Rows": 0, "Backwards": True}, {"Rows": -1, "Backwards": True}],
)  # fmt: skip
def test_a_row_that_is_none_of_the_table_is_refused(pins: dict[str, Any]) -> None:
    plc = _bench(*_points(1, 2, 3), **pins)
    _start(plc)
    assert _shown(plc) == "Busy"
    plc.scan()
    assert (_shown(plc), plc["Table.ErrorID"]) == ("Error", 0x8051)
    plc.scan(5)
    assert plc.words == [0] * 16
    plc["Table.Rows"], plc["Table.StartRow"], plc["Table.Backwards"] = 3, 3, False
    _restart(plc)
    assert _runs(plc) == [3], "afterwards it works as ever"


def test_pins_are_those_of_the_rising_edge() -> None:
    plc = _bench(*_points(1, 2), RobotNumber=1, Rows=2)
    _start(plc)
    plc["Table.RobotNumber"], plc["Table.Rows"], plc["Table.StartRow"] = 3, 1, 2
    plc["Table.Backwards"], plc["Table.Timeout"] = True, "T#10ms"
    assert _sent(plc)[0] == 0x1001
    plc.scan(5)
    _end(plc)
    words = _sent(plc)
    assert (words[0], words[4]) == (0x1001, 2)
    plc.scan(5)
    _end(plc)
    plc.scan(2)
    assert _shown(plc) == "Done"


def test_a_row_is_read_when_it_begins() -> None:
    plc = _bench(*_points(1, 2))
    _start(plc)
    plc["Moves[1].Point"] = 11
    plc["Moves[2].Point"] = 12
    assert _sent(plc)[4] == 1
    _end(plc)
    assert _sent(plc)[4] == 12


@pytest.mark.parametrize("kind", ["CIRCULAR", "BY_PTP", "BY_LINEAR", "BY_MM"])
def test_an_arc_or_a_relative_row_is_refused_backwards(kind: str) -> None:
    """Its data do not lead back to the row before.

    Source: guide 4.2.1, circular interpolation: from where the robot is; 4.2.2: by a distance.
    """
    plc = _bench({"Kind": f"MOVE_{kind}", "Point": 1}, *_points(2), Backwards=True, Rows=2)
    _start(plc)
    assert _sent(plc)[4] == 2
    _end(plc)
    plc.scan_until(lambda: plc["Table.Busy"] is False, most=6)
    assert (plc["Table.ErrorID"], plc["Table.Row"]) == (0x8054, 1)
    plc.scan(5)
    assert plc.words == [0] * 16
    plc["Table.StartRow"], plc["Table.Hold"] = 2, True
    _restart(plc)
    plc.scan(10)
    assert (_shown(plc), plc["Table.Stage"]) == ("Busy", "TABLE_HELD")


def test_a_relative_row_that_has_arrived_is_passed_backwards() -> None:
    """Its movement is done: nothing is left of it."""
    plc = _bench(*_points(1), {"Kind": "MOVE_BY_PTP", "Point": 2}, StartRow=2, StartArrived=True,
                 Backwards=True)  # fmt: skip
    _start(plc)
    assert _runs(plc) == [1]
    assert _shown(plc) == "Done"


# ---- at arrival


def _arrived(arrival: str, engine: str = "builtin", **fields: Any) -> PlcBench:
    """Row 2 of three has moved, and does something at arrival."""
    row = {"Kind": "MOVE_PTP", "Point": 2, "AtArrival": f"ARRIVE_{arrival}"} | fields
    plc = _bench(*_points(1), row, *_points(3), engine=engine, Timeout="T#300ms")
    _start(plc)
    for point in (1, 2):
        assert not plc["Table.Arrived"]
        assert _sent(plc)[4] == point
        assert plc["Table.CallNumber"] == 0
        _end(plc)
    assert (plc["Table.Row"], plc["Table.Arrived"]) == (2, True)
    assert plc["Table.Stage"] == "TABLE_ARRIVAL"
    return plc


def _goes_on(plc: PlcBench) -> bool:
    """Row 3 is on the wire within a few scans."""
    for _ in range(6):
        if plc.words[0]:
            assert (plc.words[4], plc["Table.Row"], plc["Table.Arrived"]) == (3, 3, False)
            return True
        plc.scan()
    return False


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(("number", "bits"), [(0, 1), (15, 0x8000), (31, 0x80000000)])
@pytest.mark.parametrize("state", [True, False])
def test_a_row_waits_for_a_bit(number: int, bits: int, state: bool, engine: str) -> None:
    plc = _arrived("WAIT", engine, Number=number, State=state)
    there = bits if state else 0xFFFFFFFF & ~bits
    plc["Table.Bits"] = 0xFFFFFFFF & ~there
    plc.scan(20)
    assert (plc["Table.Row"], plc.words[0]) == (2, 0)
    plc["Table.Bits"] = there
    assert _goes_on(plc)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(("arrival", "error"), [("WAIT", 0x8052), ("CALL", 0x8053)])
@pytest.mark.parametrize(("duration", "scans"), [("T#0s", 30), ("T#500ms", 50), ("T#50ms", 5)])
def test_a_wait_is_limited(
    arrival: str, error: int, duration: str, scans: int, engine: str
) -> None:
    """By Duration, or by Timeout where the row gives none; it can be gone on with.

    Source: RCX_ARRIVAL.
    """
    plc = _arrived(arrival, engine, Number=3, State=True, Duration=duration)
    taken = plc.scan_until(lambda: plc["Table.Busy"] is False, most=60)
    assert scans <= taken <= scans + 2
    assert (_shown(plc), plc["Table.ErrorID"]) == ("Error", error)
    assert (plc["Table.Row"], plc["Table.Arrived"], plc["Table.CallNumber"]) == (2, True, 0)
    plc["Table.StartRow"], plc["Table.StartArrived"] = 2, True
    _restart(plc)
    plc.scan(4)
    assert (plc["Table.Stage"], plc.words[0]) == ("TABLE_ARRIVAL", 0)
    assert (plc["Table.Row"], plc["Table.Arrived"]) == (2, True)
    if arrival == "WAIT":
        plc["Table.Bits"] = 8
    else:
        plc["Table.Acknowledge"] = True
    assert _goes_on(plc)


@pytest.mark.parametrize("arrival", ["WAIT", "CALL"])
def test_without_a_limit_a_row_waits_for_ever(arrival: str) -> None:
    plc = _arrived(arrival, Number=3, State=True)
    plc["Table.Abort"] = True
    plc.scan(2)
    plc["Table.Abort"] = False
    plc["Table.StartRow"], plc["Table.StartArrived"], plc["Table.Timeout"] = 2, True, "T#0s"
    _restart(plc)
    plc.scan(500)
    assert _shown(plc) == "Busy"


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(("duration", "scans"), [("T#100ms", 10), ("T#0s", 0), ("T#-5ms", 0)])
def test_a_row_pauses(duration: str, scans: int, engine: str) -> None:
    plc = _arrived("PAUSE", engine, Duration=duration)
    taken = plc.scan_until(lambda: plc["Table.Row"] == 3, most=60)
    assert scans < taken <= scans + 2
    assert _goes_on(plc)


def test_a_port_bit_that_is_not_answered_is_limited_by_duration() -> None:
    plc = _arrived("SET", Number=20, State=True, Duration="T#100ms")
    assert _sent(plc)[2] == 0x1020
    plc.scan_until(lambda: plc["Table.Busy"] is False, most=12)
    assert (plc["Table.ErrorID"], plc["Table.Row"], plc["Table.Arrived"]) == (0x8011, 2, True)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_call_goes_on_with_the_edge_of_acknowledge_and_not_before(engine: str) -> None:
    plc = _arrived("CALL", engine, Number=7)
    plc["Table.Acknowledge"] = True
    plc.scan()
    assert _goes_on(plc)
    plc = _bench(
        {"Kind": "MOVE_STAY", "AtArrival": "ARRIVE_CALL", "Number": 1},
        {"Kind": "MOVE_STAY", "AtArrival": "ARRIVE_CALL", "Number": 8},
        engine=engine,
        Acknowledge=True,
    )
    _start(plc)
    plc.scan(5)
    assert (plc["Table.CallNumber"], plc["Table.Row"]) == (1, 1), "that was no edge"
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
    assert (plc["Table.CallNumber"], plc["Table.Row"]) == (8, 2), "an edge is for one call"
    plc["Table.Acknowledge"] = False
    plc.scan()
    plc["Table.Acknowledge"] = True
    plc.scan(2)
    assert (plc["Table.CallNumber"], _shown(plc)) == (0, "Done")


def test_backwards_nothing_is_done_at_arrival() -> None:
    rows = [
        {"Kind": "MOVE_STAY", "AtArrival": "ARRIVE_SET", "Number": 20},
        {"Kind": "MOVE_PTP", "Point": 2, "AtArrival": "ARRIVE_CALL", "Number": 1},
        {"Kind": "MOVE_PTP", "Point": 3, "AtArrival": "ARRIVE_SET", "Number": 20},
    ]
    plc = _bench(*rows, Backwards=True, Rows=3)
    _start(plc)
    assert _runs(plc) == [3, 2]
    plc.scan(10)
    assert plc.words == [0] * 16


def test_going_on_at_an_arrival_does_not_move() -> None:
    row = {"Kind": "MOVE_PTP", "Point": 1, "AtArrival": "ARRIVE_SET", "Number": 20}
    plc = _bench(row, StartRow=1, StartArrived=True)
    _start(plc)
    assert _sent(plc)[:3] == [0x0301, 0, 0x1020]
    _end(plc)
    plc.scan(2)
    assert _shown(plc) == "Done"


def test_row_0_is_begun_with_its_movement() -> None:
    row = {"Kind": "MOVE_PTP", "Point": 1, "AtArrival": "ARRIVE_SET", "Number": 20}
    plc = _bench(row, StartArrived=True)
    _start(plc)
    assert _sent(plc)[0] == 0x0001


# ---- hold, one row, abort


@pytest.mark.parametrize("engine", ENGINES)
def test_hold_lets_the_row_end_and_begins_no_other(engine: str) -> None:
    plc = _bench(*_points(1, 2, 3), engine=engine)
    _start(plc)
    _sent(plc)
    plc["Table.Hold"] = True
    plc.scan(5)
    _end(plc)
    plc.scan(50)
    assert (plc["Table.Stage"], plc["Table.Row"]) == ("TABLE_HELD", 2)
    assert (_shown(plc), plc.words[0]) == ("Busy", 0)
    plc["Table.OneRow"] = True
    assert _sent(plc)[4] == 2
    _end(plc)
    plc.scan(50)
    assert (plc["Table.Stage"], plc["Table.Row"]) == ("TABLE_HELD", 3), "one edge is one row"
    plc["Table.Hold"] = False
    assert _sent(plc)[4] == 3
    plc["Table.Hold"] = True
    _end(plc)
    plc.scan(2)
    assert _shown(plc) == "Done", "behind the last row there is nothing to hold"


def test_hold_before_the_start_holds_the_first_row() -> None:
    plc = _bench(*_points(1), Hold=True)
    _start(plc)
    plc.scan(20)
    assert (plc["Table.Stage"], plc["Table.Row"], plc.words[0]) == ("TABLE_HELD", 1, 0)


def test_abort_between_rows_ends_at_once() -> None:
    plc = _bench(*_points(1), Hold=True)
    _start(plc)
    plc.scan(3)
    plc["Table.Abort"] = True
    plc.scan()
    assert (_shown(plc), plc["Table.ErrorID"], plc["Table.Row"]) == ("Error", 0x8050, 1)


def test_abort_lets_the_command_end_and_counts_the_row() -> None:
    """Source: guide, 2: a command is held to its end."""
    plc = _bench(*_points(1, 2, 3))
    _start(plc)
    _sent(plc)
    plc["Table.Abort"] = True
    plc.scan()
    plc["Table.Abort"] = False
    plc.scan(20)
    assert (_shown(plc), plc.words[0]) == ("Busy", 0x0001)
    _end(plc)
    plc.scan()
    assert (_shown(plc), plc["Table.ErrorID"], plc["Table.Row"]) == ("Error", 0x8050, 2)
    plc.scan(20)
    assert plc.words == [0] * 16


def test_abort_in_the_last_row_comes_too_late() -> None:
    plc = _bench(*_points(1))
    _start(plc)
    _sent(plc)
    plc["Table.Abort"] = True
    plc.scan(3)
    _end(plc)
    plc.scan(2)
    assert (_shown(plc), plc["Table.Row"]) == ("Done", 0)


def test_abort_withdraws_a_row_that_waits_for_its_turn() -> None:
    plc = _bench(*_points(1))
    plc["Other.Execute"] = True
    plc.scan(2)
    other = plc.words[0]
    _start(plc)
    plc.scan(5)
    assert (plc["Table.Stage"], plc.words[0]) == ("TABLE_MOVE", other)
    plc["Table.Abort"] = True
    plc.scan()
    assert (_shown(plc), plc["Table.ErrorID"], plc["Table.Row"]) == ("Error", 0x8050, 1)
    plc["Table.Abort"] = False
    _end(plc)
    plc.scan(20)
    assert plc.words == [0] * 16
    assert plc["Robot.Inner.Command.Serving"] == plc["Robot.Inner.Command.NextTicket"]
    _restart(plc)
    assert _runs(plc) == [1]


# ---- what ends it

_FAULTS = [
    pytest.param({"outputs": {"SO01": False}}, 0x8002, id="CPU_OK off"),
    pytest.param({"outputs": {"SO00": True}}, 0x8003, id="emergency stop"),
    pytest.param({"EmergencyStopOk": False}, 0x8003, id="cell not safe"),
    pytest.param({"outputs": {"SO03": True}}, 0x8004, id="alarm"),
    pytest.param({"StopOk": False}, 0x8007, id="stop"),
    pytest.param({"outputs": {"SO02": False}}, 0x800C, id="servos off"),
    pytest.param({"Connected": False}, 0x8001, id="link"),
]


def _fault(plc: PlcBench, fault: dict[str, Any], *, there: bool) -> None:
    for name, value in fault.items():
        if name == "outputs":
            plc.outputs(**{one: on is there for one, on in value.items()})
        else:
            plc[name] = value is there
            if name != "Connected":
                plc.scan()  # FB_WriteArea shows it to the next scan


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(("fault", "error"), _FAULTS)
def test_a_fault_for_one_scan_ends_a_waiting_row_and_nothing_goes_on(
    fault: dict[str, Any], error: int, engine: str
) -> None:
    """In a wait nothing is on the wire that the controller could end.

    Source: manual chapter 1, 5.2; chapter 5, 3.1 and 3.3.
    """
    plc = _arrived("WAIT", engine, Number=0, State=True, Duration="T#10s")
    _fault(plc, fault, there=True)
    plc.scan()
    assert (_shown(plc), plc["Table.ErrorID"]) == ("Error", error)
    _fault(plc, fault, there=False)
    plc["Table.Bits"] = 1
    plc.scan(60)
    assert (_shown(plc), plc["Table.ErrorID"]) == ("Error", error)
    assert (plc["Table.Row"], plc["Table.Arrived"]) == (2, True)
    assert plc.words == [0] * 16
    plc["Table.StartRow"], plc["Table.StartArrived"] = 2, True
    _restart(plc)
    assert _goes_on(plc)


@pytest.mark.parametrize(("fault", "error"), _FAULTS)
def test_a_fault_for_one_scan_withdraws_a_row_that_waits_for_its_turn(
    fault: dict[str, Any], error: int
) -> None:
    plc = _bench(*_points(1, 2))
    _start(plc)
    _sent(plc)
    plc["Other.Execute"] = True
    plc.scan()
    _end(plc)
    plc.scan(4)
    assert plc.words[0] == 0x0511  # FB_ReadDate has the turn
    _fault(plc, fault, there=True)
    plc.scan()
    assert (_shown(plc), plc["Table.ErrorID"]) == ("Error", error)
    assert (plc["Table.Row"], plc["Table.Arrived"]) == (2, False)
    _fault(plc, fault, there=False)
    plc.answer(0x0200)
    plc.scan(2)
    plc.answer(0)
    plc.scan(60)
    assert plc.words == [0] * 16


@pytest.mark.parametrize(("fault", "error"), [one for one in _FAULTS if one.id not in (
    "CPU_OK off", "link")])  # fmt: skip
def test_a_fault_during_a_movement_waits_for_its_end_and_ends_it_then(
    fault: dict[str, Any], error: int
) -> None:
    """Source: guide, 2: a command is held to its end."""
    plc = _bench(*_points(1, 2))
    _start(plc)
    _sent(plc)
    _fault(plc, fault, there=True)
    plc.scan()
    _fault(plc, fault, there=False)
    plc.scan(20)
    assert (_shown(plc), plc.words[0], plc["Table.Row"]) == ("Busy", 1, 1)
    _end(plc)
    plc.scan()
    assert (_shown(plc), plc["Table.ErrorID"], plc["Table.Row"]) == ("Error", error, 2)
    plc.scan(60)
    assert plc.words == [0] * 16


@pytest.mark.parametrize(("fault", "error"), [_FAULTS[0], _FAULTS[-1]])
def test_without_link_or_controller_a_movement_ends_at_once(
    fault: dict[str, Any], error: int
) -> None:
    """Source: manual chapter 1, 5.2."""
    plc = _bench(*_points(1, 2))
    _start(plc)
    _sent(plc)
    _fault(plc, fault, there=True)
    plc.scan()
    assert (_shown(plc), plc["Table.ErrorID"], plc["Table.Row"]) == ("Error", error, 1)
    assert plc.words == [0] * 16


@pytest.mark.parametrize(("fault", "error"), _FAULTS)
def test_it_does_not_start_into_a_fault(fault: dict[str, Any], error: int) -> None:
    plc = _bench(*_points(1))
    _fault(plc, fault, there=True)
    _start(plc)
    assert _shown(plc) == "Busy"
    plc.scan()
    assert (_shown(plc), plc["Table.ErrorID"], plc["Table.Row"]) == ("Error", error, 1)
    _fault(plc, fault, there=False)
    plc.scan(60)
    assert plc.words == [0] * 16


def test_a_row_begins_once_the_stop_input_has_settled() -> None:
    """SI(06) that has just come ON has not been seen by the controller yet.

    Source: manual chapter 5, 3, caution: 100 ms.
    """
    plc = _bench(*_points(1))
    plc["StopOk"] = False
    plc.scan(40)
    plc["StopOk"] = True
    plc.scan()
    _start(plc)
    plc.scan_until(lambda: plc.words[0] != 0, most=60)
    assert plc["Robot.Settled"]
    assert plc["Robot.SI.SI06_Stop"]


def test_a_time_limit_leaves_the_row_shown_with_the_command_that_is_held() -> None:
    plc = _bench(*_points(1, 2), Timeout="T#100ms")
    _start(plc)
    _sent(plc)
    plc.scan_until(lambda: plc["Table.Busy"] is False, most=12)
    assert (plc["Table.ErrorID"], plc["Table.Row"], plc.words[0]) == (0x8011, 1, 1)


def test_a_second_call_in_the_scan_of_an_error_lets_no_command_go_out_later() -> None:
    """It ends while its command waits behind another one's; called again it does not take it up.

    Source: no section (this library's own).
    """
    plc = _bench(*_points(1, 2))
    plc["Other.Execute"] = True
    date = _sent(plc)[0]
    _start(plc)
    plc.scan(3)
    plc["Table.Abort"] = plc["CallTwice"] = True
    plc.scan()
    assert (_shown(plc), plc["Table.ErrorID"], plc.words[0]) == ("Error", 0x8050, date)
    plc["Table.Abort"] = plc["CallTwice"] = False
    _end(plc)
    for _ in range(8):
        plc.scan()
        assert plc.words[0] == 0


def test_a_start_in_the_scan_of_an_error_is_refused() -> None:
    """It would run with pins of the start before, beside the command that still waits.

    Source: no section (this library's own).
    """
    plc = _bench(*_points(1, 2))
    plc["Other.Execute"] = True
    _sent(plc)
    _start(plc)
    plc["Table.Execute"] = False
    plc.scan(3)
    plc["Table.Abort"] = plc["StartAgain"] = True
    plc.scan()
    plc["Table.Abort"] = plc["StartAgain"] = False
    plc.scan()
    assert (_shown(plc), plc["Table.ErrorID"]) == ("Error", 0x8013)
    _end(plc)
    for _ in range(8):
        plc.scan()
        assert plc.words[0] == 0
    _restart(plc)
    assert _runs(plc) == [1, 2]


def test_a_call_that_is_left_out_ends_it_and_the_row_is_kept() -> None:
    plc = _bench(*_points(1, 2))
    _start(plc)
    _sent(plc)
    plc["CallTable"] = False
    plc.scan()
    plc["CallTable"] = True
    plc.scan()
    assert (_shown(plc), plc["Table.ErrorID"], plc["Table.Row"]) == ("Error", 0x8013, 1)
    plc["CallTwice"] = True
    _end(plc)
    plc["CallTwice"] = False
    _restart(plc)
    plc["CallTwice"] = True
    plc.scan()
    assert (_shown(plc), plc["Table.ErrorID"], plc["Table.Row"]) == ("Error", 0x8016, 1)
    plc["CallTwice"] = False
    plc.scan(5)
    assert plc.words == [0] * 16
    _restart(plc)
    assert _runs(plc) == [1, 2]


def test_a_start_in_the_scan_after_an_error_runs() -> None:
    """The command that waited is withdrawn with it. Source: no section (this library's own)."""
    plc = _bench(*_points(1, 2))
    plc["Other.Execute"] = True
    _sent(plc)
    _start(plc)
    plc["Table.Execute"] = False
    plc.scan(3)
    plc["Table.Abort"] = True
    plc.scan()
    plc["Table.Abort"] = False
    assert (_shown(plc), plc["Table.ErrorID"]) == ("Error", 0x8050)
    _start(plc)
    assert _shown(plc) == "Busy"
    _end(plc)
    assert _runs(plc) == [1, 2]
    assert _shown(plc) == "Done"


def test_a_start_with_the_second_call_of_a_scan_runs() -> None:
    """The call before had nothing to do. Source: no section (this library's own)."""
    plc = _bench(*_points(1, 2))
    plc["StartAgain"] = True
    plc.scan()
    plc["StartAgain"] = False
    assert _runs(plc) == [1, 2]
    assert _shown(plc) == "Done"


@pytest.mark.parametrize("hold", [True, False])
def test_a_call_that_is_left_out_before_a_command_lets_none_out(hold: bool) -> None:
    """Nor does it go on by itself where Hold falls afterwards. Source: docs/scan-model.md."""
    plc = _bench(*_points(1, 2), Hold=hold)
    _start(plc)
    plc["CallTable"] = False
    plc.scan()
    plc["CallTable"] = True
    plc.scan()
    assert (_shown(plc), plc["Table.ErrorID"], plc["Table.Row"]) == ("Error", 0x8013, 1)
    plc["Table.Hold"] = False
    for _ in range(8):
        plc.scan()
        assert plc.words == [0] * 16


@pytest.mark.parametrize("active", [True, False])
def test_an_edge_of_execute_while_it_is_under_way_takes_nothing_over(active: bool) -> None:
    """Source: design of the library, 3."""
    plc = _bench(*_points(1, 2, 3), Hold=not active)
    _start(plc)
    if active:
        _sent(plc)
    plc["Table.Execute"] = False
    plc.scan()
    plc["Table.StartRow"], plc["Table.Rows"], plc["Table.Hold"] = 3, 1, False
    plc["Table.Execute"] = True
    plc.scan()
    assert _runs(plc) == [1, 2, 3]
    assert _shown(plc) == "Done"


def test_execute_may_fall_at_once_and_the_end_is_shown_for_one_scan() -> None:
    plc = _bench(*_points(1))
    _start(plc)
    plc["Table.Execute"] = False
    _sent(plc)
    assert _shown(plc) == "Busy"
    plc.answer(0x0200)
    plc.scan()
    plc.answer(0)
    assert _shown(plc) == "Done"
    plc.scan()
    assert _shown(plc) == ""
    plc.scan(5)
    _start(plc)
    assert _runs(plc) == [1]
