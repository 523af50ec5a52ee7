"""`rcx serve` is tested as a whole, with real processes and sockets on loopback addresses."""

from __future__ import annotations

import asyncio
import errno
import os
import signal
import socket
import sys
from pathlib import Path

import pytest

from rcx_harness.cli.app import main
from rcx_harness.enip.originator.client import Client
from rcx_harness.enip.originator.scanner import Scanner
from rcx_harness.serve.host import Host, Settings
from rcx_harness.serve.lines import Lines
from rcx_harness.serve.run import serve, warnings
from rcx_harness.trace import read_trace
from serve_process import ServeProcess, own_addresses, watching

pytestmark = pytest.mark.skipif(
    not sys.platform.startswith("linux"),
    reason="it needs /proc and loopback addresses besides 127.0.0.1, as Linux has them",
)

_MULTIPLIER = 5  # 128 packet intervals, because a busy machine must not lose the link
_IDENTITY = (1, 1)
#: Longest wait for the end of the process [s].
_PATIENCE_S = 60


@pytest.mark.exhaustive
def test_two_controllers_are_devices_of_their_own_and_end_with_ctrl_c() -> None:
    first, second = own_addresses(2)
    with ServeProcess("--address", first, "--address", second, "--product-code", "7") as served:
        served.wait_for("Ctrl-C ends it")
        assert served.lines[:2] == [
            f"serving {first}: TCP and UDP 44818, cyclic UDP 2222, 48 bytes",
            f"serving {second}: TCP and UDP 44818, cyclic UDP 2222, 48 bytes",
        ]
        for number, address in enumerate((first, second), 1):
            with Client(address) as client:
                assert client.get_attribute(*_IDENTITY, 1) == bytes.fromhex("7C02")  # vendor 636
                assert client.get_attribute(*_IDENTITY, 3) == bytes.fromhex("0700")
                assert client.get_attribute(*_IDENTITY, 6) == number.to_bytes(4, "little")
                client.get_assembly(100)
        processes = served.processes()
        # 7 processes: rcx serve, and for each of two controllers: controller, adapter, cyclic I/O.
        assert len(processes) >= 7
        with watching(processes):
            served.interrupt()
            assert served.end() == (0, "")


def test_a_master_connects_is_served_and_leaves() -> None:
    (address,) = own_addresses(1)
    with ServeProcess("--address", address) as served:
        served.wait_for("alarm 12.551 EtherNet/IP link error")
        with Scanner(address, rpi_us=10_000, multiplier=_MULTIPLIER, io_port=0) as scanner:
            scanner.write(bytes(32) + b"\x41" + bytes(15))
            scanner.open()
            assert "every 10 ms" in served.wait_for("connected: 127.")
            served.wait_for("Module Status green, Network Status green")
            served.wait_for("no longer: alarm 12.551")
            # Command 0x0505 requests the positions and gets an answer.
            scanner.write(b"\x05\x05" + bytes(30) + b"\x41" + bytes(15))
            assert served.wait_for("command: ReadPositionPulses").endswith("normal end")
            assert scanner.read().image[:2] == b"\x00\x02"
            assert scanner.read().image[32] == 0x12  # bytes with SO(01) CPU_OK and SO(04) MP RDY ON
            scanner.close_connection()
            served.wait_for("the master has closed the connection")
            served.wait_for("Module Status green, flashing, Network Status red, flashing")
            served.wait_for("alarm 12.552 EtherNet/IP overtime error")
        served.interrupt()
        assert served.end()[0] == 0


@pytest.mark.exhaustive
def test_a_port_that_is_taken_is_one_clear_message_and_nothing_stays() -> None:
    first, second = own_addresses(2)
    with socket.create_server((second, 44818)):
        with ServeProcess("--address", first, "--address", second) as served:
            code, said = served.end()
        assert code == 2
        assert len(said.splitlines()) == 1
        assert said.startswith(f"rcx: the EtherNet/IP adapter cannot listen on {second}:44818: ")
        with socket.create_server((first, 44818)):
            pass  # the other controller has also ended


@pytest.mark.exhaustive
def test_an_address_of_another_machine_is_one_clear_message() -> None:
    with ServeProcess("--address", "192.0.2.1") as served:
        code, said = served.end()
    assert code == 2
    assert said.startswith("rcx: ")
    assert "192.0.2.1" in said
    assert len(said.splitlines()) == 1


@pytest.mark.exhaustive
def test_quiet_says_nothing_and_sigint_still_ends_it() -> None:
    (address,) = own_addresses(1)
    with ServeProcess("--address", address, "--quiet", "--web", "0") as served:
        served.wait_for_port(address, 44818)
        served.interrupt()
        assert served.end() == (0, "")
    assert served.lines == []


@pytest.mark.exhaustive
def test_the_traces_of_two_controllers_are_written_and_can_be_judged(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    addresses, files = own_addresses(2), [tmp_path / "a.jsonl", tmp_path / "b.jsonl"]
    options = [word for one in addresses for word in ("--address", one)]
    options += [word for one in files for word in ("--trace", str(one))]
    with ServeProcess(*options) as served:
        served.wait_for("Ctrl-C ends it")
        with Scanner(addresses[1], multiplier=_MULTIPLIER, io_port=0) as master:
            master.write(bytes(32) + b"\x01" + bytes(15))
            master.open()
            served.wait_for("connected: 127.")
            master.close_connection()
        served.wait_for("the master has closed the connection")
        served.interrupt()
        assert served.end() == (0, "")
    headers = [read_trace(file)[0] for file in files]
    assert [(one["by"], one["of"]) for one in headers] == [("rcx serve", one) for one in addresses]
    assert main(["judge", str(files[1])]) == 0
    assert "SI(00) ON   Emergency stop input" in capsys.readouterr().out


@pytest.mark.exhaustive
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full")
def test_a_trace_that_cannot_be_written_ends_it_with_a_reason() -> None:
    (address,) = own_addresses(1)
    with ServeProcess("--address", address, "--trace", "/dev/full") as served:
        code, said = served.end()
    assert code == 1
    text = "/dev/full: cannot be written: No space left on device"
    assert said == f"rcx: controller {address} is gone: {text}\n"


@pytest.mark.exhaustive
def test_a_disk_that_fills_up_later_ends_rcx_serve(monkeypatch: pytest.MonkeyPatch) -> None:
    """If the disk fills up later, `rcx serve > log` ends with one line and exit code 2."""

    def full(lines: Lines) -> list[str]:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Lines, "new", full)
    (address,) = own_addresses(1)
    serving = serve([Settings(host=address)], None, quiet=False)
    with pytest.raises(OSError, match="No space left"):
        asyncio.run(asyncio.wait_for(serving, _PATIENCE_S))


@pytest.mark.exhaustive
def test_children_end_with_a_parent_that_is_killed() -> None:
    (address,) = own_addresses(1)
    with ServeProcess("--address", address) as served:
        served.wait_for("Ctrl-C ends it")
        with watching(served.processes()):
            served.kill()


@pytest.mark.exhaustive
def test_an_address_reachable_from_the_network_gives_a_warning_and_loopback_does_not() -> None:
    """An address that other machines can reach gives a warning, a loopback address does not.

    The warning appears even in quiet mode. The web page is always on the loopback address.
    """
    settings = [
        Settings(host=host) for host in ("127.0.0.1", "192.168.0.21", "127.9.9.9", "0.0.0.0")
    ]
    assert [
        line.partition(" can be reached from the network: ")[0] for line in warnings(settings)
    ] == ["warning: 192.168.0.21", "warning: 0.0.0.0"]
    # The port is below the range that the system assigns, because it must be free on all addresses
    # of the machine.
    port = 20_000 + 2 * (os.getpid() % 5_000)
    ports = ["--port", str(port), "--io-port", str(port + 1)]
    with ServeProcess("--address", "0.0.0.0", *ports, "--quiet") as served:
        served.wait_for_port("127.0.0.1", port)
        served.interrupt()
        code, said = served.end()
    assert code == 0
    assert said.startswith("rcx: warning: 0.0.0.0 can be reached from the network: ")
    assert said.count("\n") == 1


def test_the_warning_comes_even_if_ctrl_c_follows_at_once(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The warning is printed even if Ctrl-C follows at once: the first port was already open."""

    async def starting(host: Host) -> None:
        signal.raise_signal(signal.SIGINT)
        await asyncio.Event().wait()

    monkeypatch.setattr(Host, "start", starting)
    assert asyncio.run(serve([Settings(host="0.0.0.0")], None, quiet=False)) == 0
    said = capsys.readouterr()
    assert said.err.startswith("rcx: warning: 0.0.0.0 can be reached from the network: ")
    assert said.out == ""


@pytest.mark.exhaustive(
    but=["serve.station_process-its process has ended by itself (killed by SIGKILL)-True"]
)
@pytest.mark.parametrize("quiet", [False, True])
@pytest.mark.parametrize(
    ("part", "said"),
    [
        ("serve.station_process", "its process has ended by itself (killed by SIGKILL)"),
        (
            "enip.target.adapter_process",
            "the process of the EtherNet/IP adapter has ended by itself (killed by SIGKILL)",
        ),
        (
            "enip.cyclic.process",
            "the EtherNet/IP adapter has ended: the process of the cyclic I/O has ended by itself "
            "(killed by SIGKILL)",
        ),
    ],
)
def test_a_part_that_dies_ends_it_with_1_and_is_named(part: str, said: str, quiet: bool) -> None:
    first, second = own_addresses(2)
    options = ["--quiet"] if quiet else []
    with ServeProcess("--address", first, "--address", second, *options) as served:
        served.wait_for_port(first, 44818)
        served.wait_for_port(second, 44818)
        with watching(served.processes()):
            os.kill(served.process_of(f"rcx_harness.{part}"), signal.SIGKILL)
            code, complaint = served.end()
    assert code == 1
    assert complaint in {f"rcx: controller {one} is gone: {said}\n" for one in (first, second)}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--address", "here"], "'here' is not an IPv4 address; write it as 127.0.0.1"),
        (
            ["--address", "127.0.0.1", "--address", "127.0.0.1"],
            "each controller needs its own address, not 127.0.0.1 twice; "
            "use 127.0.0.2, 127.0.0.3 ...: they also belong to this computer",
        ),
        (
            ["--size", "64"],
            "an area of 64 bytes does not exist; use 48, or 256 with SIOW extension valid",
        ),
        (["--web", "70000"], "--web 70000 is not a port; use 1 to 65535"),
        (["--port", "0"], "--port 0 is not a port; use 1 to 65535"),
        (["--revision", "1"], "'1' is not a revision; write it as 1.1"),
        (
            ["--rpi-min", "fast"],
            "--rpi-min: 'fast' is not a duration; write it as 10ms, 1.5s or 1m30s",
        ),
        (["--rpi-min", "0ms"], "--rpi-min 0ms is not a packet interval; use 1ms to 3200ms"),
        (["--rpi-min", "4s"], "--rpi-min 4s is not a packet interval; use 1ms to 3200ms"),
        (
            ["--first-packet", "9s"],
            "the time to wait for the first packet cannot be 9000 ms; use 10s to 610h",
        ),
        (
            ["--port", "2222"],
            "--port and --io-port are both 2222; "
            "use different ports for explicit and cyclic messages",
        ),
        (
            ["--web", "44818"],
            "--web and --port are both 44818 of 127.0.0.1; give the page another port",
        ),
        (
            ["--robot", "a.toml", "--robot", "b.toml"],
            "2 robot files are given for 1 addresses; "
            "give one for all, or one per address in their order",
        ),
        (
            ["--trace", "a.jsonl", "--trace", "b.jsonl"],
            "2 traces are given for 1 addresses; give one per address, in their order",
        ),
        (
            ["--trace", "robot.toml", "--robot", "robot.toml"],
            "robot.toml: would be overwritten, but it is an input",
        ),
        (["--robot", "missing.toml"], "missing.toml: cannot be read: No such file or directory"),
    ],
)
def test_bad_input_is_one_message_and_exit_code_2(
    arguments: list[str],
    message: str,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["serve", *arguments]) == 2
    assert capsys.readouterr().err == f"rcx: {message}\n"
