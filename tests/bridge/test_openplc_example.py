"""The OpenPLC example controls the virtual controller through the bridge."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest

from bridge_bench import BridgeBench
from plc_bench import ROOT
from rcx_harness.bridge.core import Registers, State
from rcx_harness.cell import Cell
from rcx_harness.cell.sources import source_files
from rcx_harness.cell.stimulus import Stimulus
from rcx_harness.robot.area import INPUTS
from structured_text.engines.base import Program
from structured_text.engines.load import build

_EXAMPLE = ROOT / "plc/examples/09_openplc"
_FIRST_MEMORY = 1024


class OpenPlc:
    """The OpenPLC example on the built-in engine, with its located words in Modbus registers.

    %QWk is holding register k, and %MWk is holding register 1024 + k.
    """

    def __init__(self, program: Program) -> None:
        self.program = program
        words = {one.address.upper(): one.path for one in program.located()}
        self._from = {k: words[f"%MW{k}"] for k in range(25)}
        self._to = {k: words[f"%QW{k}"] for k in range(25)}

    def scan(self, now_us: int, holds: dict[int, int]) -> None:
        """Copy the registers into the program, run one scan, and copy its outputs back."""
        for k, path in self._from.items():
            self.program.write(path, holds.get(_FIRST_MEMORY + k, 0))
        self.program.scan(now_us)
        holds.update({k: int(self.program.read(path)) for k, path in self._to.items()})


@pytest.fixture(scope="module")
def compiled() -> Iterator[tuple[Program, object]]:
    """Return the compiled example program and its state before the first scan."""
    program = build(source_files(sorted(_EXAMPLE.glob("*.st")), None).all, "builtin").program
    yield program, program.snapshot()
    program.close()


@pytest.fixture
def plc(compiled: tuple[Program, object]) -> OpenPlc:
    program, fresh = compiled
    program.restore(fresh)
    program.write("Main.CellSafe", True)
    return OpenPlc(program)


@pytest.fixture
def bench(plc: OpenPlc) -> Iterator[BridgeBench]:
    with BridgeBench(plc.scan) as made:
        made.step(10)
        made.robot.opener.open()
        yield made


def power_up(bench: BridgeBench, plc: OpenPlc) -> None:
    """Press the Start button, and wait until the servos are on and SI(01) is OFF again."""
    plc.program.write("Main.Start", True)
    bench.step(5)
    plc.program.write("Main.Start", False)
    bench.until(lambda: bool(plc.program.read("Main.Complete")))
    bench.until(lambda: dedicated(bench) == INPUTS["SI00"] | INPUTS["SI06"])


def dedicated(bench: BridgeBench) -> int:
    area = bench.adapter.shared.to_robot.read()
    return area[32] | area[33] << 8


@pytest.mark.exhaustive
def test_the_button_switches_the_servos_on_and_no_rule_is_broken(
    bench: BridgeBench, plc: OpenPlc
) -> None:
    """The button turns the servos on, and the controller sees 100 ms between two changes.

    Source: manual chapter 5, 3.1 and caution.
    """
    bench.until(lambda: plc.program.read("Main.Connected"))
    assert not plc.program.read("Main.Complete")
    power_up(bench, plc)
    assert bench.controller.machine.servo_on
    assert plc.program.read("Main.Fault") == 0
    assert not bench.controller.violations


@pytest.mark.exhaustive
def test_a_loss_of_the_plc_stops_the_robot_and_its_servos_stay_off(
    bench: BridgeBench, plc: OpenPlc
) -> None:
    """After a loss of the PLC, SI(00) and SI(06) are OFF. The servos stay off when the PLC is back.

    Source: manual chapter 1, 5.2.
    """
    power_up(bench, plc)
    bench.plc.stop()
    bench.step(2)
    assert bench.loop.state is State.NO_PLC
    assert bench.adapter.shared.to_robot.read() == bytes(48)
    assert not bench.controller.machine.si00
    assert not bench.controller.machine.si06
    bench.step(30)
    assert not plc.program.read("Main.Connected"), "the life word has stopped"

    bench.plc.start()
    bench.until(lambda: bench.loop.state is State.RUN)
    bench.step(50)
    assert plc.program.read("Main.Connected")
    assert not bench.controller.machine.servo_on
    power_up(bench, plc)
    assert not bench.controller.violations


@pytest.mark.exhaustive
def test_the_program_detects_a_loss_of_the_robot_and_then_its_alarm(
    bench: BridgeBench, plc: OpenPlc
) -> None:
    """When the robot is back, alarm 12.552 is active. It needs an alarm reset and then servo on.

    Source: manual chapter 1, 5.2; chapter 4, 4.
    """
    power_up(bench, plc)
    bench.station.happen("link_down", {})
    bench.until(lambda: bench.loop.state is State.NO_ROBOT, most=20_000)
    bench.step(2)
    with bench.plc.between_scans() as holds:
        assert [holds[_FIRST_MEMORY + k] for k in range(25)] == [0] * 25
    assert not plc.program.read("Main.Connected")

    bench.station.happen("link_up", {})

    def runs() -> bool:
        bench.robot.opener.keep()
        return bench.loop.state is State.RUN

    bench.until(runs, most=20_000)
    bench.step(5)
    assert plc.program.read("Main.Robot.SO.SO03_Alarm")
    assert "12.552" in [alarm.number for alarm in bench.controller.alarms.active]
    power_up(bench, plc)
    assert bench.controller.machine.servo_on


@pytest.mark.exhaustive
def test_if_the_program_stops_the_bridge_stops_the_robot(bench: BridgeBench, plc: OpenPlc) -> None:
    """If the program stops, the bridge stops the robot although the Modbus server still answers."""
    power_up(bench, plc)
    program = plc.program
    plc.scan = lambda now_us, holds: None  # type: ignore[method-assign]
    bench.scan = plc.scan
    bench.until(lambda: bench.loop.state is State.STANDING, most=30)
    bench.step()
    assert dedicated(bench) == 0
    assert program.read("Main.Q16") == INPUTS["SI00"] | INPUTS["SI06"], (
        "the last words still request the servos"
    )


def test_the_example_runs_in_a_virtual_cell(build_cell: Callable[..., Cell]) -> None:
    """In a virtual cell, %MW contains the inputs and the life word.

    A loss of the link sets them to 0.
    """
    cell = build_cell(sorted(_EXAMPLE.glob("*.st")), engine="builtin")
    Stimulus.load(_EXAMPLE / "stimulus.toml").schedule(cell)
    cell.run_until(lambda: cell["Main.Complete"], within="3s")
    first = cell["Main.Life"]
    cell.scan()
    assert cell["Main.Life"] == first + 1
    cell.inject("link_down")
    cell.run_until(lambda: cell["Main.Life"] == 0, within="1s")
    assert not cell["Main.Connected"]
    assert [cell[f"Main.M{k}"] for k in range(24)] == [0] * 24
    assert not cell.violations


@pytest.mark.exhaustive
def test_areas_of_256_bytes_pass_completely() -> None:
    """In areas of 256 bytes, the first and the last words reach the other side.

    Source: manual chapter 1, 4.2.
    """

    def scan(now_us: int, holds: dict[int, int]) -> None:
        holds.update({k: 0x100 + k for k in range(128) if k not in (0, 16)})
        holds[128] = holds.get(128, 0) + 1

    with BridgeBench(scan, Registers(size=256)) as bench:
        bench.robot.opener.open()
        bench.until(lambda: bench.loop.state is State.RUN)
        bench.step(2)
        received = bench.adapter.shared.to_robot.read()
        assert (received[2:4], received[254:]) == (b"\x01\x01", b"\x7f\x01")
        bench.controller.force("SOW(127)", 0xABCD)
        bench.step(2)
        with bench.plc.between_scans() as holds:
            assert holds[1024 + 127] == 0xABCD
            assert holds[1024 + 128] != 0
