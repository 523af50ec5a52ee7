"""The area must have the same size in the master and in the controller."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from plc_bench import ROOT
from rcx_harness import Cell, RobotConfig

Build = Callable[..., Cell]

PROGRAM = ROOT / "tests/data/library/Areas.st"


def _cell(build: Build, plc: int, robot: int, **options: object) -> Cell:
    """Return a cell whose PLC and area blocks use areas of `plc` bytes."""
    cell = build(PROGRAM, scan="10ms", size=plc, robot=RobotConfig(size=robot), **options)
    for block in ("ReadArea", "WriteArea", "ReadBit", "WriteBit", "ReadWord", "WriteWord"):
        cell[f"Main.{block}.Size"] = plc
    return cell


@pytest.mark.parametrize("link", ["direct", "enip"])
@pytest.mark.parametrize(("plc", "robot"), [(48, 256), (256, 48)])
def test_without_the_same_size_there_is_no_connection(
    build_cell: Build, plc: int, robot: int, link: str
) -> None:
    """Source: manual chapter 3, 1, conditions and incorrect connection."""
    cell = _cell(build_cell, plc, robot, link=link)
    cell.run("1s")
    assert not cell.connected
    assert cell["Main.Robot.Connected"] is False
    assert not any(cell["Main.Robot.SO"].values())
    assert not any(one.rcx_si.strip(b"\0") for one in cell.trace.cycles())
    assert not any(cell["Main.Robot.SI"].values())
    assert [alarm.number for alarm in cell.robot.alarms.active] == ["12.551"]
    assert not cell.violations


@pytest.mark.parametrize("size", [48, 256])
def test_with_the_same_size_there_is_a_connection(build_cell: Build, size: int) -> None:
    """Source: manual chapter 3, 1, conditions."""
    cell = _cell(build_cell, size, size)
    cell.run("1s")
    assert cell.connected
    assert cell["Main.Robot.SI.SI00_EmergencyStop"] is True
    assert cell["Main.Robot.SO.SO00_EmergencyStop"] is False


@pytest.mark.parametrize(("plc", "robot"), [(48, 256), (256, 48)])
def test_with_different_sizes_every_block_ends_in_error(
    build_cell: Build, plc: int, robot: int
) -> None:
    """Source: manual chapter 3, 1; chapter 1, 5.3, communication is disabled."""
    cell = _cell(build_cell, plc, robot)
    cell["Main.ServoOn.Execute"] = cell["Main.First.Execute"] = True
    cell["Main.First.Code"] = 0x0505
    cell.run("500ms")
    for block in ("ServoOn", "First", "ReadBit", "ReadWord"):
        assert cell[f"Main.{block}.ErrorID"] == 0x8001, block
    assert cell["Main.ReadArea.ErrorID"] == 0, "the size itself is legal"
