"""A bench for FB_MoveTable beside another command.

The test writes rows and plays the controller.
"""

from __future__ import annotations

from typing import Any

from plc_bench import ROOT, PlcBench

Row = dict[str, Any]


def bench(*rows: Row, engine: str = "builtin", **pins: Any) -> PlcBench:
    """Return a bench with servos on and settled inputs.

    The given rows are the first of the table.
    """
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


def rows_to(*points: int) -> list[Row]:
    return [{"Kind": "MOVE_PTP", "Point": point} for point in points]


def start(plc: PlcBench) -> None:
    plc["Table.Execute"] = True
    plc.scan()


def started(*rows: Row, engine: str = "builtin", **pins: Any) -> PlcBench:
    """Return the bench after a rising edge of Execute."""
    plc = bench(*rows, engine=engine, **pins)
    start(plc)
    return plc


def moving(*rows: Row, engine: str = "builtin", **pins: Any) -> PlcBench:
    """Return the bench with the command of the first row on the wire."""
    plc = started(*rows, engine=engine, **pins)
    sent(plc)
    return plc


def restart(plc: PlcBench, **pins: Any) -> None:
    """Set pins, then set Execute to FALSE for one scan and to TRUE again."""
    for pin, value in pins.items():
        plc[f"Table.{pin}"] = value
    plc["Table.Execute"] = False
    plc.scan()
    start(plc)


def shown(plc: PlcBench) -> str:
    names = ("Done", "Busy", "Error")
    return " ".join(name for name in names if plc[f"Table.{name}"])


def sent(plc: PlcBench, most: int = 12) -> list[int]:
    """Scan until a code is on the wire, and return code and data."""
    plc.scan_until(lambda: plc.words[0] != 0, most=most)
    return plc.words


def end(plc: PlcBench, status: int = 0x0200, response: tuple[int, ...] = ()) -> None:
    """End the command with a status; after its reset the controller is ready."""
    plc.answer(status, response)
    plc.scan()
    assert plc.words[0] == 0
    plc.answer(0)


def runs(plc: PlcBench) -> list[int]:
    """Let the controller end each command with 16#0200.

    Return the commanded points in their order.
    """
    points: list[int] = []
    for _ in range(200):
        if plc["Table.Busy"] is False:
            return points
        if plc.words[0]:
            points.append(plc.words[4])
            assert plc["Table.Row"] == points[-1], "in these tables row k goes to point k"
            end(plc)
        else:
            plc.scan()
    raise AssertionError("the table is still Busy after 200 scans")


def arrived(arrival: str, engine: str = "builtin", **fields: Any) -> PlcBench:
    """Return a bench in which row 2 of three has ended, with an action at its arrival."""
    row = {"Kind": "MOVE_PTP", "Point": 2, "AtArrival": f"ARRIVE_{arrival}"} | fields
    plc = bench(*rows_to(1), row, *rows_to(3), engine=engine, Timeout="T#300ms")
    start(plc)
    for point in (1, 2):
        assert not plc["Table.Arrived"]
        assert sent(plc)[4] == point
        assert plc["Table.CallNumber"] == 0
        end(plc)
    assert (plc["Table.Row"], plc["Table.Arrived"]) == (2, True)
    assert plc["Table.Stage"] == "TABLE_ARRIVAL"
    return plc


def goes_on(plc: PlcBench) -> bool:
    """Check that row 3 is sent within a few scans."""
    for _ in range(6):
        if plc.words[0]:
            assert (plc.words[4], plc["Table.Row"], plc["Table.Arrived"]) == (3, 3, False)
            return True
        plc.scan()
    return False
