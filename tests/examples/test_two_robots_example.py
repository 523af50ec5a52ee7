"""Example 12: two controllers on one PLC, independent but for the tray that they share."""

from __future__ import annotations

from example_runs import finished
from rcx_harness.cell import Cell
from rcx_tools.docs.examples import examples

_PART = (150_000, 0), (-120_000, 30_000)
_TRAY = (-50_000, 100_000), (60_000, 90_000)


def _build() -> Cell:
    return examples()["12_two_robots"].build("builtin")


def _placed(cell: Cell) -> tuple[int, int]:
    return cell["Main.Carry1.Placed"], cell["Main.Carry2.Placed"]


def test_never_are_both_robots_on_the_way_to_the_tray_or_at_it() -> None:
    """A robot without its parts' point is at the tray, or somewhere between.

    Source: points 10 and 20 of robot1.toml and robot2.toml.
    """
    with _build() as cell:
        cell.run_until(lambda: cell["Main.Carry1.Stage"] == "DUO_WAIT", within="2s")
        visits: list[int] = []
        while cell.now_us < 8_500_000:
            cell.scan()
            away = [tuple(one.positions[:2]) for one in cell.robots]
            out = [k for k in (0, 1) if away[k] != _PART[k]]
            assert len(out) < 2, f"both robots are at the tray: {away}"
            visits += [k for k in (0, 1) if away[k] == _TRAY[k] and visits[-1:] != [k]]
        assert visits == [1, 0, 1, 0], "the second robot is faster at first, and lost its link"
        assert _placed(cell) == (4, 2)
        assert not cell.violations


def test_the_first_robot_works_on_while_the_second_has_lost_its_link() -> None:
    """Source: manual chapter 1, 5.2 (link loss), for each controller by itself."""
    with _build() as cell:
        cell.run("3950ms")
        assert cell["Main.Connected"] is cell["Main.Connected2"] is True, "plugged in again"
        assert cell["Main.Carry2.Stage"] == "DUO_FAULT"
        assert cell["Main.Carry2.Fault"] == 0x800C
        assert (cell["Main.Carry1.Fault"], _placed(cell)) == (0, (2, 1))
        servo = [cell[f"Main.Robot{k}.SO.SO02_ServoOn"] for k in (1, 2)]
        assert servo == [True, False]


def test_an_emergency_stop_of_one_controller_leaves_the_other_running() -> None:
    """Source: manual chapter 5, 3.1; the shared circuit, CellSafe, stops both."""
    with _build() as cell:
        cell.run("1500ms")
        cell.inject("emergency_stop", controller=2)
        cell.run("100ms")
        assert cell["Main.Carry2.Fault"] == 0x8020, "it was on its way to the tray"
        assert not cell["Main.Robot1.SO.SO00_EmergencyStop"]
        assert cell["Main.Carry2.AtTray"] is True
        cell.run("2s")
        assert cell["Main.Carry1.Stage"] == "DUO_WAIT", "the other robot may be in the way"
        cell["Main.CellSafe"] = False
        cell.run("100ms")
        emergency = [cell[f"Main.Robot{k}.SO.SO00_EmergencyStop"] for k in (1, 2)]
        assert emergency == [True, True]


def test_the_areas_of_both_lie_one_behind_the_other() -> None:
    """Source: manual chapter 1, 4.1: 48 bytes each."""
    cell = finished("12_two_robots").cell
    one, two = cell.trace.scans()[-2:]
    assert (one.controller, two.controller) == (1, 2)
    image = bytes(cell["Main.OutputArea"])
    assert image[:96] == one.si + two.si
    assert image[96:] == bytes(len(image) - 96)
    assert bytes(cell["Main.InputArea"])[:96] == one.so + two.so
