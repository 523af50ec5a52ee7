"""A record has the CRC-32 of zlib, and loses no data if a virtual controller stores it."""

from __future__ import annotations

import random
import struct
import zlib
from collections.abc import Mapping

import pytest

from both_engines import ENGINES
from plc_bench import ROOT, compiled
from points_bench import PointsBench, points_bench
from rcx_harness import Cell
from rcx_harness.cell.clock import Timing
from rcx_harness.cell.link import DirectLink
from rcx_harness.robot import Controller, RobotConfig
from rcx_harness.robot.controller_memory import Memory
from rcx_harness.robot.stored import Hand, Pallet, Point

_PROGRAM = ROOT / "tests/data/library/Points.st"
_CODES = {
    "DATA_POINTS": 0x100,
    "DATA_COMMENTS": 0x104,
    "DATA_SHIFTS": 0x10C,
    "DATA_HANDS": 0x110,
    "DATA_PALLETS": 0x108,
}
_STORED = RobotConfig(
    points={
        3: Point((1, -2, 3, -4, 5, -6)),
        4: Point((8_191_999, -8_191_999, 2_000_001, 0, 0, 0), mm=True, hand=2, arm1=-1, arm2=1),
        6: Point((2**31 - 1, -(2**31), 0, 0, 0, 0)),
    },
    comments={4: "WAIT ORG", 5: "0123456789abcdef"},
    shifts={1: (1, -2, 3, -4)},
    hands={(1, 2): Hand((100, -1, 2, 0)), (1, 3): Hand((7, 8, 9, 1))},
    pallets={2: Pallet(10, 15, 1, 100)},
)


@pytest.fixture(params=ENGINES)
def plc(request: pytest.FixtureRequest) -> PointsBench:
    return points_bench(request.param)


@pytest.mark.parametrize(("kind", "robot"), [*((one, 0) for one in _CODES), ("DATA_HANDS", 4)])
def test_the_checksum_is_the_crc_32_of_head_and_rows(
    plc: PointsBench, kind: str, robot: int
) -> None:
    """The checksum is the CRC-32 of head and rows, in little endian.

    The bytes are code and robot of the definition, First, then each row.

    Source: IEEE 802.3, as zlib has it; all bits inverted
    """
    chance = random.Random(11)
    code = _CODES[kind] | robot << 12
    for number in range(8):
        words = [chance.choice((0, 0x0207)), *(chance.getrandbits(16) | 1 for _ in range(13))]
        if number != 5:
            plc.stored[code, number] = words
    if kind in ("DATA_SHIFTS", "DATA_HANDS"):
        plc.stored[code, 5] = [0] * 14
    assert plc.run("Backup", Kind=kind, RobotNumber=robot, First=0, Count=8) == 0
    bytes_ = struct.pack("<HH", 0, code)
    for row in range(1, 9):
        defined, flag, values = plc.row(row)
        bytes_ += struct.pack("<HH6i", flag, defined, *values)
    head = plc["Head"]
    assert isinstance(head, Mapping)
    assert head["Checksum"] == zlib.crc32(bytes_) ^ 0xFFFFFFFF
    assert any(plc.row(row)[2] for row in range(1, 9))


def _cell(config: RobotConfig) -> Cell:
    program = compiled(_PROGRAM)
    timing = Timing.make(scan="10ms", rpi="10ms")
    return Cell(program, Controller(config), DirectLink(48), timing)


def _run(cell: Cell, block: str, **inputs: object) -> object:
    for name, value in inputs.items():
        cell[f"Main.{block}.{name}"] = value
    cell[f"Main.{block}.Execute"] = True
    cell.scan(2)
    cell.run_until(lambda: not cell[f"Main.{block}.Busy"], within="60s")
    error = cell[f"Main.{block}.ErrorID"]
    cell[f"Main.{block}.Execute"] = False
    cell.scan(2)
    return error


@pytest.mark.parametrize("kind", list(_CODES))
def test_a_record_is_copied_to_another_controller_without_loss(kind: str) -> None:
    """A record that is written to another controller arrives there without a difference.

    The record has the largest numbers and all flags. Nothing is rounded.

    Source: guide 4.3.1 to 4.3.5.
    """
    old, new = _cell(_STORED), _cell(RobotConfig(points={}))
    assert _run(old, "Backup", Kind=kind, First=0, Count=8) == 0
    for name in ("Rows", "Head"):
        new[f"Main.{name}"] = old[f"Main.{name}"]
    assert _run(new, "Restore", CompareOnly=True) == 0
    before = new["Main.Restore.Differences"]
    assert isinstance(before, int)
    assert before > 0
    assert _run(new, "Restore", CompareOnly=False) == 0
    assert _run(new, "Restore", CompareOnly=True) == 0
    assert new["Main.Restore.Differences"] == 0
    there, wanted = new.robot.machine.memory, old.robot.machine.memory
    for number in range(8):
        assert _shown(there, kind, number) == _shown(wanted, kind, number)


def _shown(memory: Memory, kind: str, number: int) -> object:
    """Return the data that the controller has stored under this number."""
    if kind == "DATA_POINTS":
        return memory.points.get(number)
    if kind == "DATA_COMMENTS":
        return memory.comment(number)
    if kind == "DATA_SHIFTS":
        return memory.shift(number)
    if kind == "DATA_HANDS":
        return memory.hand(1, number)
    return memory.pallets.get(number)
