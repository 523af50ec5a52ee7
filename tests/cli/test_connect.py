"""`rcx run --connect` asks for confirmation, ends at Ctrl-C, and works with `rcx serve`."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from rcx_harness.cell import Cell
from rcx_harness.cell.elsewhere import Elsewhere
from rcx_harness.cli.app import main
from rcx_harness.cli.connect import confirm
from rcx_harness.cli.run import RunOptions
from rcx_harness.enip.cyclic.connections import OwnerState
from rcx_harness.enip.originator.scanner import Received, ScannerStatistics
from rcx_harness.enip.target.adapter import Adapter
from rcx_harness.trace import Scan, read_trace
from serve_process import ServeProcess, own_addresses
from structured_text.errors import InputError

Captured = pytest.CaptureFixture[str]
DEMO = ("plc", "examples", "01_power_up")
#: An address that is reserved for documentation, so no device has it (RFC 5737).
NOBODY = "192.0.2.1"


class Terminal:
    """A replacement for standard input. `somebody` says whether it is a terminal."""

    def __init__(self, somebody: bool) -> None:
        self._somebody = somebody

    def isatty(self) -> bool:
        """Return whether standard input is a terminal."""
        return self._somebody


@pytest.fixture
def adapter() -> Iterator[Adapter]:
    with Adapter(48, cyclic=0) as made:
        yield made


def test_without_a_terminal_the_confirmation_must_be_an_option(
    repository: Path, capsys: Captured, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "stdin", Terminal(somebody=False))
    monkeypatch.setattr(
        Cell, "build", lambda *_, **__: pytest.fail("the run was started without a confirmation")
    )
    assert main(["run", str(repository.joinpath(*DEMO)), "--connect", NOBODY]) == 2
    error = capsys.readouterr().err
    assert error == (
        f"rcx: --connect {NOBODY} drives a controller that may be a real one; "
        "clear the cell, then add --yes\n"
    )


@pytest.mark.parametrize("answer", [True, False])
def test_only_the_answer_yes_starts_the_run(monkeypatch: pytest.MonkeyPatch, answer: bool) -> None:
    asked: list[str] = []

    def ask(text: str) -> bool:
        asked.append(text)
        return answer

    monkeypatch.setattr(sys, "stdin", Terminal(somebody=True))
    monkeypatch.setattr("rcx_harness.cli.connect.typer.confirm", ask)
    if answer:
        confirm(Elsewhere(NOBODY, 5000), yes=False)
    else:
        with pytest.raises(InputError, match="nothing was sent"):
            confirm(Elsewhere(NOBODY, 5000), yes=False)
    (text,) = asked
    assert f"the controller at {NOBODY}:5000" in text
    assert "its robot moves" in text


@pytest.mark.parametrize(
    ("host", "yes"),
    [("127.0.0.1", False), ("127.9.9.9", False), ("localhost", False), (NOBODY, True)],
)
def test_the_loopback_and_the_option_yes_need_no_confirmation(
    monkeypatch: pytest.MonkeyPatch, host: str, yes: bool
) -> None:
    monkeypatch.setattr(sys, "stdin", Terminal(somebody=False))
    confirm(Elsewhere(host), yes=yes)


def test_an_unknown_host_name_needs_a_confirmation(monkeypatch: pytest.MonkeyPatch) -> None:
    def unknown(host: str) -> str:
        raise OSError

    monkeypatch.setattr(sys, "stdin", Terminal(somebody=False))
    monkeypatch.setattr("rcx_harness.cli.connect.socket.gethostbyname", unknown)
    with pytest.raises(InputError, match="may be a real one"):
        confirm(Elsewhere("robot-7"), yes=False)


def test_each_option_reaches_the_connection() -> None:
    options = RunOptions([], connect="127.0.0.1:5000", input_instance=101, output_instance=102,
                         config_instance="104", config_data="0a 0B", address="127.0.0.6",
                         rpi="20ms")  # fmt: skip
    arguments = options.of_cell()
    where = arguments["connect"]
    assert (where.host, where.port, where.address) == ("127.0.0.1", 5000, "127.0.0.6")
    assert (where.input_instance, where.output_instance) == (101, 102)
    assert (where.configuration, where.configuration_data) == (104, b"\x0a\x0b")
    assert arguments["timeout"] == 640_000  # 32 packet intervals, as with --realtime
    assert RunOptions([]).of_cell().get("connect") is None


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--connect", ""], "--connect '' is not an address"),
        (["--connect", "here:x"], "--connect 'here:x' is not an address"),
        (["--connect", "127.0.0.1:99999"], "is not an address"),
        (["--connect", "127.0.0.1", "--robot", "r.toml"], "--robot is for a virtual controller"),
        (["--connect", "127.0.0.1", "--from", "here"], "--from 'here' is not an IPv4 address"),
        (
            ["--connect", "127.0.0.1", "--jitter", "2ms"],
            "--jitter is for virtual time: in real time the network has its own jitter",
        ),
        (
            ["--connect", "127.0.0.1", "--config-instance", "x"],
            "--config-instance x is not an instance",
        ),
        (["--connect", "127.0.0.1", "--config-data", "xy"], "'xy' is not hexadecimal"),
        (["--connect", "127.0.0.1", "--input-instance", "0"], "0 is not an instance of an"),
        (["--connect", "127.0.0.1", "--size", "64"], "an area of 64 bytes does not exist"),
        (["--connect", "127.0.0.1", "--timeout", "1m"], "cannot be requested"),
        (["--connect", "127.0.0.1", "--m", "0", "--m", "48"], "2 offsets m are given for 1 robot"),
    ],
)
def test_wrong_options_are_reported_in_one_line(
    repository: Path, capsys: Captured, options: list[str], message: str
) -> None:
    assert main(["run", str(repository.joinpath(*DEMO)), *options]) == 2
    error = capsys.readouterr().err
    assert message in error
    # "compiling" is only printed on a slow computer
    assert error.removeprefix("compiling ...\n").count("\n") == 1


@pytest.mark.exhaustive
@pytest.mark.skipif(
    not sys.platform.startswith("linux"),
    reason="it needs /proc and loopback addresses besides 127.0.0.1, as Linux has them",
)
def test_the_demo_drives_a_controller(repository: Path, tmp_path: Path, capsys: Captured) -> None:
    """With `rcx serve`, the demo performs power-up, servo ON and program reset.

    The order is the same as in a cell with the virtual controller.

    Source: manual chapter 5, 3.1 and 3.2
    """
    demo, trace = repository.joinpath(*DEMO), tmp_path / "trace.jsonl"
    (address,) = own_addresses(1)
    stimulus = tmp_path / "stimulus.toml"
    pressed = '[[at]]\ntime = "1s"\nset = { "Main.CellSafe" = true, "Main.Start" = true }\n'
    stimulus.write_text(pressed)
    with ServeProcess("--address", address, "--robot", str(demo / "robot.toml")) as served:
        served.wait_for("alarm 12.551 EtherNet/IP link error")
        options = ["--for", "6s", "--stimulus", str(stimulus), "--trace", str(trace)]
        options += ["--timeout", "5s", "--engine", "builtin", "--connect", address]
        assert main(["run", str(demo), *options]) == 0
        assert "every 10 ms" in served.wait_for("connected: 127.")
        served.wait_for("the master has closed the connection")
        served.interrupt()
        assert served.end()[0] == 0
    captured = capsys.readouterr()
    assert "600 scans, no controller cycles" in captured.out
    assert "no violations" in captured.out
    assert f"{address}: connected, 48 bytes, packets every 10 ms\n" in captured.err
    scans = [one for one in read_trace(trace)[1] if isinstance(one, Scan)]
    risen = [name for name, byte, bit in _SIGNALS if any(one.so[byte] >> bit & 1 for one in scans)]
    assert risen == [name for name, _, _ in _SIGNALS]


#: SO(00), SO(02) servo ON and SO(14) program reset are in bytes 32 and 33 (chapter 5, 2).
_SIGNALS = (("SO00", 32, 0), ("SO02", 32, 2), ("SO14", 33, 4))


class SilentScanner:
    """A replacement for Scanner. Its connection opens, but it receives no packets."""

    ended = None
    failure = ""
    why = ""

    def __init__(self, *_: object, **__: object) -> None:
        """Accept the arguments of Scanner, and ignore them."""

    def open(self) -> None:
        """Do nothing, as if the controller had accepted the connection."""

    def write(self, image: bytes, run: bool = True, valid_us: int | None = None) -> None:
        """Discard the image that should be sent."""

    def read(self) -> Received:
        """Return an image of zeros that says "not connected"."""
        return Received(bytes(48), None, connected=False)

    def drops(self) -> str:
        """Return the reasons why packets were dropped."""
        return self.why

    def statistics(self) -> ScannerStatistics:
        """Return statistics that are all 0."""
        return ScannerStatistics(0, 0, 0, 0, 0, 0, 0, 0)

    def close(self) -> None:
        """Do nothing."""


@pytest.mark.parametrize(
    ("drops", "message"),
    [
        ("", "rcx: there was no connection in the whole run: 127.0.0.1: "
         "no packets have arrived yet; check that no firewall blocks UDP port 2222\n"),
        ("of a wrong length (20 bytes instead of 50)",
         "rcx: there was no connection in the whole run: 127.0.0.1: "
         "packets arrive, but cannot be used: they are "
         "of a wrong length (20 bytes instead of 50)\n"),
    ],
)  # fmt: skip
def test_a_run_without_a_single_packet_of_the_controller_is_an_error(
    tmp_path: Path, capsys: Captured, monkeypatch: pytest.MonkeyPatch, drops: str, message: str
) -> None:
    monkeypatch.setattr("rcx_harness.cell.elsewhere.Scanner", SilentScanner)
    monkeypatch.setattr(SilentScanner, "why", drops)
    program, trace = tmp_path / "main.st", tmp_path / "trace.jsonl"
    program.write_text(
        "PROGRAM Main VAR InputArea : ARRAY [0..511] OF BYTE; OutputArea : ARRAY [0..511] OF BYTE; "
        "END_VAR OutputArea[45] := InputArea[45]; END_PROGRAM"
    )
    options = ["--connect", "127.0.0.1", "--engine", "builtin", "--trace", str(trace)]
    assert main(["run", str(program), "--for", "30ms", *options]) == 2
    captured = capsys.readouterr()
    assert captured.err.endswith(message)
    assert "3 scans" in captured.out
    assert trace.exists(), "the trace must be written"


def test_ctrl_c_ends_the_run_with_zeros_and_all_outputs(
    repository: Path,
    tmp_path: Path,
    adapter: Adapter,
    capsys: Captured,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    trace, run, slices = tmp_path / "trace.jsonl", Cell.run, iter(range(3))

    def interrupted(cell: Cell, duration: int) -> None:
        run(cell, duration)
        if next(slices, None) is None:
            raise KeyboardInterrupt

    monkeypatch.setattr(Cell, "run", interrupted)
    where = "{}:{}".format(*adapter.address)
    demo = str(repository.joinpath(*DEMO))
    options = ["--connect", where, "--engine", "builtin", "--trace", str(trace)]
    assert main(["run", demo, "--for", "40s", "--timeout", "5s", *options]) == 0
    assert adapter.shared.status().owner is OwnerState.CLOSED
    assert adapter.read_to_robot() == bytes(48)
    assert "0.4 s on the builtin engine: 40 scans" in capsys.readouterr().out
    assert len([one for one in read_trace(trace)[1] if isinstance(one, Scan)]) == 40
