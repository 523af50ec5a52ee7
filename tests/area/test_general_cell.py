"""The library exchanges general-purpose I/O with a robot program of the virtual controller."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from plc_bench import ROOT
from rcx_harness import Cell, RobotConfig
from rcx_harness.cell.stimulus import Stimulus

Build = Callable[..., Cell]

AREAS = ROOT / "tests/data/library/Areas.st"
EXAMPLE = ROOT / "plc/examples/03_general_io"


@pytest.fixture
def example(build_cell: Build) -> Cell:
    """Return example 03 with its cell closed and its button not yet pressed."""
    cell = build_cell(
        [EXAMPLE / "Config.st", EXAMPLE / "GeneralIo.st"], robot=EXAMPLE / "robot.toml", m=20, n=40
    )
    cell["Main.CellSafe"] = True
    return cell


def test_words_and_bits_are_exchanged_with_the_robot_program(example: Cell) -> None:
    """Words and bits reach the robot program, and its outputs reach the PLC.

    The program has WAIT SI(20)=1, A%=SIW(2), SOW(2)=A% and SO(20)=1.

    All images are images of words.

    Source: manual chapter 1, 2, mechanism of communication; chapter 3, 2.1 and 2.2.
    """
    example.run("500ms")
    example["Main.Start"] = True
    example.run_until(lambda: bool(example["Main.Complete"]), within="1s")
    assert example.robot.program.variables == {"A%": 512, "B%": -20_000}
    assert example["Main.PartBack"] == 0x0200
    assert example["Main.HeightBack"] == -20_000
    assert not example.violations
    assert example["Main.OutputArea"][:20] == [0] * 20, "words before n = 40"
    assert example["Main.OutputArea"][22:24] == [0x0200, 0], "SIW(2) is word 40 / 2 + 2"
    assert example["Main.OutputArea"][44:] == [0] * 212, "words from n = 40 + 48 on"


def test_the_robot_program_waits_for_the_bit(example: Cell) -> None:
    """Source: manual chapter 1, 2: WAIT SI(20)=1."""
    stimulus = Stimulus.load(EXAMPLE / "stimulus.toml")
    stimulus.schedule(example)
    example.run_until(lambda: bool(example["Main.Robot.SO.SO13_ProgramRunning"]), within="1s")
    assert example.robot.read_port("SI(20)") == 0
    assert example.robot.program.variables == {}
    example.run_until(lambda: bool(example["Main.Complete"]), within="1s")
    assert example.robot.read_port("SO(20)") == 0


@pytest.mark.parametrize("jitter", ["0ms", "12ms"])
def test_remote_commands_and_shared_words_are_never_mixed_on_the_wire(
    build_cell: Build, jitter: str
) -> None:
    """Source: guide chapter 1, 1.1, note; manual chapter 1, 4.1."""
    cell = build_cell(AREAS, scan="10ms", jitter=jitter, phases="random", seed=3)
    cell["Main.WriteArea.Margin"] = "T#30ms"
    cell["Main.First.Code"] = 0x0505
    cell["Main.ReadWord.Number"], cell["Main.WriteWord.Number"] = 5, 9
    cell["Main.ReadDoubleWord.Number"] = 10
    cell["Main.Writing"] = True
    cell.run("400ms")
    cell.robot.write_port("SOW(5)", 0x0777)
    cell.robot.write_port("SOD(10)", -5)
    cell.run("50ms")
    seen = set()
    for scan in range(400):
        cell["Main.WriteWord.Value"] = scan
        cell["Main.First.Execute"] = scan % 40 < 30
        cell.scan()
        state = [
            cell[f"Main.Read{kind}.{pin}"]
            for kind in ("Word", "DoubleWord")
            for pin in ("Valid", "Value")
        ]
        seen.add(tuple(state))
    assert seen == {(True, 0x0777, True, -5), (False, 0, False, 0)}
    assert cell.commands == 10
    assert cell["Main.First.Done"] is False
    assert not cell.violations


@pytest.mark.parametrize("port", ["20", "77", "100", "157"])
def test_plc_and_robot_program_use_the_same_bit_numbers(build_cell: Build, port: str) -> None:
    """Source: manual chapter 1, 4.1; chapter 3, 2.1 and 2.2."""
    cell = build_cell(AREAS, scan="10ms")
    cell["Main.WriteBit.Port"] = cell["Main.ReadBit.Port"] = int(port)
    cell["Main.WritePort.Port"] = 3
    cell["Main.WriteBit.Value"] = cell["Main.Writing"] = True
    cell.robot.write_port(f"SO({port})", 1)
    cell.run("400ms")
    assert cell.robot.read_port(f"SI({port})") == 1
    assert cell["Main.ReadBit.Value"] is True
    cell["Main.WriteBit.Value"] = False
    cell.run("50ms")
    assert cell.robot.read_port(f"SI({port})") == 0


def test_plc_and_robot_program_use_the_same_numbers_for_extended_words(build_cell: Build) -> None:
    """Source: manual chapter 1, 4.2; chapter 3, 2.1 and 2.2."""
    cell = build_cell(AREAS, scan="10ms", m=100, n=200, robot=RobotConfig(size=256))
    blocks = ("ReadWord", "WriteWord", "ReadDoubleWord", "WriteDoubleWord", "ReadArea", "WriteArea")
    for block in blocks:
        cell[f"Main.{block}.Size"] = 256
        pin, offset = ("m", 100) if block.startswith("Read") else ("n", 200)
        cell[f"Main.{block}.{pin}"] = offset
    for block in blocks[:4]:
        cell[f"Main.{block}.Number"] = 127 if "Double" not in block else 24
    cell["Main.WriteWord.Value"], cell["Main.WriteDoubleWord.Value"] = 511, -65_552
    cell["Main.Writing"] = True
    cell.robot.write_port("SOW(127)", 512)
    cell.robot.write_port("SOD(24)", 69905)
    cell.run("400ms")
    assert cell.robot.read_port("SIW(127)") == 511
    assert cell.robot.read_port("SID(24)") == -65_552
    assert cell["Main.ReadWord.Value"] == 512
    assert cell["Main.ReadDoubleWord.Value"] == 69905
    assert not cell.violations
