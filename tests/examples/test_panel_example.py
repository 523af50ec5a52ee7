"""Example 15: a user moves the robot with the keys of a panel."""

from __future__ import annotations

from example_runs import finished
from rcx_harness.robot.ports import port
from rcx_tools.docs.examples import examples


def test_the_keys_jog_step_teach_and_run_the_program() -> None:
    """The keys jog, step and teach the robot, and run its program to the end.

    Source: guide 4.2.6, 4.2.7, 4.2.9; manual chapter 5, 3.3.
    """
    cell = finished("15_panel").cell
    axis1, axis2 = cell.robot.positions[:2]
    assert axis1 > 10_000
    assert axis2 == -500, "one step"
    assert cell.robot.points[101].data[:2] == (axis1, -500)
    assert cell.robot.machine.ports.read(port("SO2()")) == 4, "the program must run all lines"
    assert (cell["Main.Panel.MessageID"], cell["Main.Operator.Error"]) == (0, False)
    assert cell["Main.Panel.Position"][:2] == [axis1 / 1000, -0.5]


def test_a_key_that_is_held_when_the_link_is_back_starts_nothing() -> None:
    """A jog key that is held when the link is back does not move the robot. Source: FB_Operator."""
    with examples()["15_panel"].build("builtin") as cell:
        cell.run_until(lambda: cell["Main.Panel.Lamp.Moving"], within="2s")
        cell.inject("link_down")
        cell.run("300ms")
        assert cell["Main.Panel.MessageID"] == 0x8001
        stood = cell.robot.positions[0]
        cell["Main.Panel.Key.JogPlus"] = True
        cell.inject("link_up")
        cell.run("800ms")
        assert cell["Main.Panel.Lamp.Connected"]
        assert cell.robot.positions[0] == stood
