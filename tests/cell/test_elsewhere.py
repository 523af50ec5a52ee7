"""A cell can connect its PLC program to an external controller over a real connection.

The controller is an adapter in a separate process on the loopback interface. The tests write and
read the adapter's areas.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from rcx_harness import Cell, RobotConfig
from rcx_harness.cell.clock import Timing
from rcx_harness.cell.elsewhere import Elsewhere, FarLink
from rcx_harness.cell.stimulus import Stimulus
from rcx_harness.enip.cyclic.connections import OwnerState
from rcx_harness.enip.cyclic.shared import LinkState
from rcx_harness.enip.originator.scanner import Scanner
from rcx_harness.enip.target.adapter import Adapter
from rcx_harness.trace import Cycle, Scan, read_trace
from structured_text.errors import InputError

Build = Callable[..., Cell]

#: A PLC program that copies SO(150) to SO(157) to SI(150) to SI(157).
_PROGRAM = """\
PROGRAM Echo
VAR
  Connected : BOOL;
  InputArea : ARRAY [0..511] OF BYTE;
  OutputArea : ARRAY [0..511] OF BYTE;
END_VAR
OutputArea[45] := InputArea[45];
END_PROGRAM
"""
#: Long time-outs, so that a busy computer cannot cause a loss of the link.
_LONG_TIMEOUT = "5s"
_WITHIN = "60s"


@pytest.fixture
def adapter() -> Iterator[Adapter]:
    with Adapter(48, cyclic=0) as made:
        yield made


@pytest.fixture
def program(tmp_path: Path) -> Path:
    file = tmp_path / "echo.st"
    file.write_text(_PROGRAM)
    return file


class Messages:
    """A recorder of the messages about the connection."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def __call__(self, now_us: int, text: str) -> None:
        """Record a message of the connection."""
        assert now_us >= 0
        self.lines.append(text)


@pytest.fixture
def messages() -> Messages:
    return Messages()


@pytest.fixture
def far(build_cell: Build, adapter: Adapter, program: Path, messages: Messages) -> Build:
    """Return a function that builds a cell whose PLC is connected to the adapter."""
    host, port = adapter.address

    def build(**options: object) -> Cell:
        given = {"rpi": "10ms", "timeout": _LONG_TIMEOUT} | options
        return build_cell(program, connect=Elsewhere(host, port, tell=messages), **given)

    return build


def _echoes(cell: Cell, adapter: Adapter, value: int) -> None:
    """Check that a byte from the controller reaches the program and comes back."""
    adapter.write_to_master(bytes(45) + bytes([value]) + bytes(2))
    cell.run_until(lambda: cell["Main.InputArea"][45] == value, within=_WITHIN)
    cell.run_until(lambda: adapter.read_to_robot()[45] == value, within=_WITHIN)


def test_the_program_reads_and_writes_the_controllers_areas(
    far: Build, adapter: Adapter, messages: Messages, tmp_path: Path
) -> None:
    """The trace contains only the PLC's scans, because the controller is not simulated.

    The monitors check these scans as in every run.
    """
    trace = tmp_path / "trace.jsonl"
    cell = far(trace=trace)
    assert not cell["Main.Connected"]
    cell.run_until(lambda: bool(cell["Main.Connected"]), within=_WITHIN)
    assert cell.connected
    _echoes(cell, adapter, 0x5A)
    assert (cell.cycles, cell.violations) == (0, [])
    host, port = adapter.address
    assert messages.lines[-1] == f"{host}:{port}: connected, 48 bytes, packets every 10 ms"
    cell.close()
    header, records = read_trace(trace)
    assert header["link"] == "enip-connect"
    entries = list(records)
    assert not any(isinstance(one, Cycle) for one in entries)
    scans = [one for one in entries if isinstance(one, Scan)]
    assert scans[-1].so[45] == 0x5A


@pytest.mark.exhaustive
def test_a_broken_rule_is_reported_with_an_external_controller(far: Build, program: Path) -> None:
    """The monitor reports that SI(00) and SI(06) change together. Changes must be 100 ms apart.

    Source: manual chapter 5, 3.1
    """
    text = _PROGRAM.replace("  OutputArea :", "  Word : BYTE;\n  OutputArea :")
    text = text.replace("OutputArea[45] :=", "OutputArea[32] := Word;\nOutputArea[45] :=")
    program.write_text(text)
    cell = far()
    cell.run_until(lambda: cell.connected, within=_WITHIN)
    cell["Main.Word"] = 0x41
    cell.scan(2)
    assert [one.rule for one in cell.violations] == ["interval"]


@pytest.mark.exhaustive
def test_zeros_are_sent_before_the_connection_is_closed(far: Build, adapter: Adapter) -> None:
    """The cell sends zeros, with SI(00) and SI(06) OFF, before it closes the connection.

    Source: manual chapter 1, 5.2
    """
    cell = far()
    _echoes(cell, adapter, 0xFF)
    cell.close()
    assert adapter.shared.status().owner is OwnerState.CLOSED
    assert adapter.read_to_robot() == bytes(48)


@pytest.mark.exhaustive
def test_after_a_loss_the_program_is_connected_again(
    far: Build, adapter: Adapter, messages: Messages
) -> None:
    cell = far(timeout="200ms")
    cell.run_until(lambda: bool(cell["Main.Connected"]), within=_WITHIN)
    adapter.shared.link = LinkState.CUT
    cell.run_until(lambda: not cell["Main.Connected"], within=_WITHIN)
    cell.run_until(lambda: "connected, 48" not in messages.lines[-1], within=_WITHIN)
    adapter.shared.link = LinkState.UP
    cell.run_until(lambda: bool(cell["Main.Connected"]), within=_WITHIN)
    _echoes(cell, adapter, 0x17)


@pytest.mark.exhaustive
def test_inputs_are_cleared_at_a_loss_on_request(far: Build, adapter: Adapter) -> None:
    cell = far(timeout="200ms", on_loss="clear")
    _echoes(cell, adapter, 0x33)
    adapter.shared.link = LinkState.CUT
    cell.run_until(lambda: not cell["Main.Connected"], within=_WITHIN)
    assert cell["Main.InputArea"][45] == 0
    adapter.shared.link = LinkState.UP


@pytest.mark.exhaustive
def test_another_size_is_refused_and_the_right_size_is_named(
    build_cell: Build, program: Path, adapter: Adapter
) -> None:
    """The message names the size that the controller has. Source: manual chapter 3, 1."""
    with pytest.raises(InputError) as refused:
        build_cell(program, size=256, connect=Elsewhere(*adapter.address))
    assert "0x0127" in refused.value.message or "0x0128" in refused.value.message
    assert refused.value.hint == "its areas have another size: try --size 48"


@pytest.mark.exhaustive
def test_other_assemblies_are_requested(build_cell: Build, program: Path, adapter: Adapter) -> None:
    host, port = adapter.address
    for where, word in (
        (Elsewhere(host, port, input_instance=101), "producing"),
        (Elsewhere(host, port, configuration=77), "configuration"),
    ):
        with pytest.raises(InputError, match=f"there is no such {word}"):
            build_cell(program, connect=where)
    cell = build_cell(program, connect=Elsewhere(host, port, configuration=151))
    cell.run_until(lambda: cell.connected, within=_WITHIN)


@pytest.mark.exhaustive
def test_a_controller_with_another_master_is_refused(
    build_cell: Build, program: Path, adapter: Adapter
) -> None:
    host, port = adapter.address
    with Scanner(host, port=port, io_port=0, multiplier=7) as master:
        master.write(bytes(40) + b"\x01" + bytes(7))
        master.open()
        with pytest.raises(InputError) as refused:
            build_cell(program, connect=Elsewhere(host, port))
        assert refused.value.hint == "another master owns the robot: disconnect that master first"
        assert master.read().connected


def test_a_missing_controller_is_reported(build_cell: Build, program: Path) -> None:
    with Adapter(48, cyclic=0) as gone:
        where = Elsewhere(*gone.address)
    with pytest.raises(InputError, match="no connection to the EtherNet/IP adapter"):
        build_cell(program, connect=where)


@pytest.mark.exhaustive
def test_events_need_a_virtual_controller(far: Build, tmp_path: Path) -> None:
    cell = far()
    for event in ("emergency_stop", "link_down"):
        with pytest.raises(
            InputError, match="an external controller accepts neither events nor hold and release"
        ):
            cell.inject(event)
    with pytest.raises(InputError, match="no snapshot"):
        cell.snapshot()
    for entry in ('robot = "alarm"', 'hold = "SO02"'):
        file = tmp_path / "stimulus.toml"
        file.write_text(f'[[at]]\ntime = "1s"\n{entry}\n')
        with pytest.raises(InputError, match="an external controller accepts") as refused:
            Stimulus.load(file).schedule(cell)
        assert (refused.value.file, refused.value.line) == (str(file), 1)


@pytest.mark.exhaustive
def test_an_external_controller_cannot_be_configured(far: Build) -> None:
    with pytest.raises(InputError, match="an external controller cannot be configured"):
        far(robot=RobotConfig())


def test_images_of_a_stopped_program_expire(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each image expires after the link's time-out or four scans, whichever is longer."""
    for scan, valid_us in (("10ms", 300_000), ("100ms", 400_000)):
        link = FarLink(48, Timing.make(scan=scan, timeout="300ms"), Elsewhere("127.0.0.1"))
        written: list[tuple[bytes, int | None]] = []
        monkeypatch.setattr(link.connection, "write", lambda *one, to=written: to.append(one))
        link.scanner_write(bytes(48))
        assert written == [(bytes(48), valid_us)]
        link.close()
