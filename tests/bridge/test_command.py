"""The command `rcx bridge` exchanges data between a PLC and a robot, and reports errors."""

from __future__ import annotations

import inspect
import os
import re
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from pymodbus.constants import ExcCodes

from modbus_plc import ModbusPlc
from rcx_harness.bridge.core import Limits, State
from rcx_harness.bridge.loop import Loop
from rcx_harness.bridge.run import BridgeOptions, Running
from rcx_harness.cli import bridge as cli_bridge
from rcx_harness.cli.app import main
from rcx_harness.enip.originator.opening import Opener
from rcx_harness.enip.originator.scanner import Scanner
from rcx_harness.enip.target.adapter import Adapter

Captured = pytest.CaptureFixture[str]
Start = Callable[..., int]

_ANSWERS = bytes([0, 2]) + bytes(46)


@pytest.fixture(scope="module")
def adapter() -> Iterator[Adapter]:
    with Adapter(48, cyclic=0) as made:
        made.write_to_master(_ANSWERS)
        yield made


@pytest.fixture(scope="module")
def server() -> Iterator[ModbusPlc]:
    with ModbusPlc() as made:
        yield made


@pytest.fixture
def plc(server: ModbusPlc) -> ModbusPlc:
    server.holds.clear()
    server.refuses = None
    return server


@pytest.fixture
def bridge(plc: ModbusPlc, adapter: Adapter) -> Start:
    """Return a function that runs `rcx bridge` between the test's PLC and robot.

    The time-outs are long.
    """

    def start(*options: str) -> int:
        host, port = adapter.address
        sides = ["--plc", f"127.0.0.1:{plc.port}", "--robot", f"{host}:{port}"]
        return main(["bridge", *sides, "--heartbeat", "0s", "--timeout", "1s", *options])

    return start


def press_ctrl_c(after: Callable[[], None]) -> threading.Thread:
    """Call `after` in a thread, then send SIGINT to this process if the bridge still runs."""
    before = signal.getsignal(signal.SIGINT)

    def press() -> None:
        try:
            after()
        finally:
            if signal.getsignal(signal.SIGINT) is not before:
                os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=press)
    thread.start()
    return thread


def test_bridge_exchanges_until_ctrl_c_and_then_writes_zeros(
    bridge: Start, plc: ModbusPlc, adapter: Adapter, capsys: Captured
) -> None:
    """One word passes in each direction. After Ctrl+C, the words in the PLC are zero."""
    plc.holds[2] = 0x1234
    seen: list[int] = []

    def until_it_runs() -> None:
        while not plc.holds.get(1048):
            plc.wait_exchanges()
        seen.append(plc.holds[1024])
        pause = threading.Event()
        while adapter.read_to_robot()[4:6] != b"\x34\x12":
            pause.wait(0.001)

    thread = press_ctrl_c(until_it_runs)
    before = signal.getsignal(signal.SIGINT)
    try:
        assert bridge("--hold", "0s") == 0
    finally:
        thread.join()
    assert seen == [0x0200], "SOW(0) must be little endian"
    assert [plc.holds[1024 + k] for k in range(25)] == [0] * 25
    assert signal.getsignal(signal.SIGINT) == before
    out = capsys.readouterr().out
    assert out.startswith(f"PLC 127.0.0.1:{plc.port}: reads holding registers 0 to 24, writes 1024")
    assert "the robot then loses its master" in out


def test_quiet_prints_nothing_if_there_is_no_error(
    bridge: Start, plc: ModbusPlc, capsys: Captured
) -> None:
    thread = press_ctrl_c(plc.wait_exchanges)
    try:
        assert bridge("--quiet", "--hold", "10s") == 0
    finally:
        thread.join()
    said = capsys.readouterr()
    assert (said.out, said.err) == ("", "")


def test_options_choose_the_first_registers(bridge: Start, plc: ModbusPlc) -> None:
    thread = press_ctrl_c(plc.wait_exchanges)
    plc.requests.clear()
    try:
        assert bridge("--read", "100", "--write", "0") == 0
    finally:
        thread.join()
    assert {(3, 100, 25), (16, 0, 25)} == set(plc.requests)


def test_a_missing_plc_is_reported_in_one_line(capsys: Captured) -> None:
    assert main(["bridge", "--plc", "127.0.0.1:1", "--robot", "127.0.0.1:1"]) == 2
    error = capsys.readouterr().err
    assert error.startswith("rcx: no Modbus TCP connection to 127.0.0.1:1: ")
    assert "; switch its Modbus server on, or start the bridge with --wait" in error
    assert error.count("\n") == 1


def test_a_missing_robot_is_reported_in_one_line(plc: ModbusPlc, capsys: Captured) -> None:
    assert main(["bridge", "--plc", f"127.0.0.1:{plc.port}", "--robot", "127.0.0.1:1"]) == 2
    error = capsys.readouterr().err
    assert "no connection to the EtherNet/IP adapter at 127.0.0.1:1" in error
    assert error.count("\n") == 1


def test_a_robot_with_another_master_is_refused(
    bridge: Start, adapter: Adapter, capsys: Captured
) -> None:
    host, port = adapter.address
    with Scanner(host, port=port, io_port=0, multiplier=7) as master:
        master.open()
        assert bridge() == 2
    assert "another master owns the robot: disconnect that master first" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--size", "64"], "an area of 64 bytes does not exist"),
        (["--size", "256"], "its areas have another size: try --size 48"),
        (["--read", "190"], "illegal data address; check that the PLC has these registers"),
        (["--read", "1020"], "the registers 1020 to 1044 and 1024 to 1048 overlap"),
        (["--unit", "256"], "--unit 256 is not a unit identifier"),
        (["--period", "0ms"], "--period 0ms cannot be served; use 1ms to 1s"),
        (["--period", "2s"], "--period 2s cannot be served"),
        (["--timeout", "15ms"], "--timeout 15ms is less than two periods of 10ms"),
        (["--timeout", "1h"], "a time-out of"),
        (["--rpi", "10us"], "--rpi 10us cannot be served; use 1ms to 1s"),
        (["--rpi", "soon"], "--rpi: 'soon' is not a duration"),
        (["--heartbeat", "-1s"], "--heartbeat: '-1s' is not a duration"),
        (["--hold", "nan"], "--hold: 'nan' is not a duration"),
        (["--timeout", "inf"], "--timeout: 'inf' is not a duration"),
        (["--period", "999999h"], "--period: '999999h' is too long for a duration"),
        (["--unit", "-1"], "--unit -1 is not a unit identifier"),
        (["--read", "-1"], "--read -1: there are no registers -1 to 23"),
        (["--from", "here"], "--from 'here' is not an IPv4 address"),
        (["--plc", "127.0.0.1:\u0661"], "is not an address; write it as"),
        (["--plc", "127.0.0.1:" + "9" * 5_000], "is not an address; write it as"),
        (["--plc", "plc:modbus"], "--plc 'plc:modbus' is not an address"),
        (["--robot", ":44818"], "--robot ':44818' is not an address"),
        (["--robot", "10.0.0.1:70000"], "--robot '10.0.0.1:70000' is not an address"),
    ],
)
def test_a_bad_option_is_reported_in_one_line(
    bridge: Start, capsys: Captured, options: list[str], message: str
) -> None:
    assert bridge(*options) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1


def test_a_missing_pymodbus_is_reported_with_the_install_command(
    bridge: Start, monkeypatch: pytest.MonkeyPatch, capsys: Captured
) -> None:
    for name in [name for name in sys.modules if name.startswith("rcx_harness.bridge.")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "pymodbus.client", None)
    assert bridge() == 2
    error = capsys.readouterr().err
    assert error.strip() == "rcx: rcx bridge needs the library pymodbus; pip install pymodbus"


@pytest.mark.exhaustive
def test_with_wait_the_bridge_starts_before_the_plc(adapter: Adapter) -> None:
    """The bridge starts without a PLC, and connects to the PLC later without a restart."""
    host, port = adapter.address
    plc = ModbusPlc()
    plc.stop()
    limits = Limits(gap_us=1_000_000, beat_us=0, hold_us=0)
    options = BridgeOptions("127.0.0.1", plc.port, host, port, limits=limits, wait=True)
    try:
        with Running(options) as running:
            _, _, reason = wait_for(running, State.NO_PLC)
            assert "refused" in reason
            plc.start()
            wait_for(running, State.RUN)
            plc.refuses = ExcCodes.DEVICE_BUSY
            _, _, reason = wait_for(running, State.NO_PLC)
            assert "device busy" in reason
            plc.refuses = None
            wait_for(running, State.RUN)
    finally:
        plc.close()


def test_the_page_names_every_option_with_its_default(repository: Path) -> None:
    """The table in docs/how-to/bridge.md is written by hand and must agree with the options."""
    page = (repository / "docs/how-to/bridge.md").read_text(encoding="utf-8")
    rows = dict(re.findall(r"^\| `(--[a-z]+)` \|.*\|([^|]*)\|$", page, re.MULTILINE))
    expected = {}
    for name, parameter in inspect.signature(cli_bridge.bridge).parameters.items():
        default = parameter.default
        shown = "" if default in (False, "", inspect.Parameter.empty) else str(default)
        expected[{"address": "--from"}.get(name, f"--{name}")] = shown
    expected |= {"--plc": "port 502", "--robot": "port 44818", "--read": "0"}
    assert {name: rows[name].strip() for name in rows} == expected


@pytest.mark.exhaustive(but=["Loop-turn"])
@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
@pytest.mark.parametrize(("part", "work"), [(Loop, "turn"), (Opener, "keep")])
def test_the_command_ends_with_1_if_one_of_its_threads_ends(
    bridge: Start, monkeypatch: pytest.MonkeyPatch, capsys: Captured, part: type, work: str
) -> None:
    """One thread exchanges data; another thread keeps the robot's connection open.

    If either thread ends, `rcx bridge` ends with exit code 1.
    """

    def fail(worker: object) -> None:
        raise SystemExit  # end a thread without a traceback

    monkeypatch.setattr(part, work, fail)
    assert bridge() == 1
    assert "the exchange has ended by itself" in capsys.readouterr().err


def wait_for(running: Running, wanted: State) -> tuple[float, State, str]:
    """Wait until the bridge reports the wanted state, and return this report."""
    while True:
        news = running.news.get(timeout=60)
        assert news is not None, "the bridge has ended before it reported the wanted state"
        if news[1] is wanted:
            return news
