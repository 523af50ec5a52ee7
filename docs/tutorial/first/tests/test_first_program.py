"""The first program moves the robot, but only while the cell is safe."""

from rcx_harness import Cell


def test_start_moves_the_robot_to_point_1(cell: Cell) -> None:
    cell["Main.CellSafe"] = True
    cell.run("500ms")
    cell["Main.Start"] = True
    cell.run_until(lambda: cell["Main.MovePtp.Done"], within="5s")
    assert list(cell.robot.positions) == [120000, -45000, 30000, 0]


def test_nothing_moves_while_the_cell_is_not_safe(cell: Cell) -> None:
    cell["Main.Start"] = True
    cell.run("3s")
    assert not cell["Main.Robot.SO.SO02_ServoOn"]
    assert list(cell.robot.positions) == [0, 0, 0, 0]
