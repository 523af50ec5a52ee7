"""`rcx scan` prints a controller's data, and writes only on request."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from rcx_harness.cli import scan as cli_scan
from rcx_harness.cli.app import main
from rcx_harness.enip.codec.forward_open import OpenRequest
from rcx_harness.enip.cyclic.connections import ConnectionKind, OwnerState
from rcx_harness.enip.errors import CipError, ProcessDiedError
from rcx_harness.enip.originator.client import Client
from rcx_harness.enip.originator.scanner import Assemblies, Received, Scanner
from rcx_harness.enip.target.adapter import Adapter
from rcx_harness.look.look import ScanOptions, output_image
from rcx_harness.look.look import scan as look
from rcx_harness.trace import Scan, read_trace
from structured_text.errors import InputError

Captured = pytest.CaptureFixture[str]
Run = Callable[..., int]

#: Bytes 32 and 33: CPU_OK, MP RDY, AUTO mode. Bit 0 of byte 34: SO(20). Word 2: 0x1234.
OUTPUTS = bytes([0, 0, 0, 0, 0x34, 0x12]) + bytes(26) + bytes([0x12, 0x01, 0x01]) + bytes(13)


@pytest.fixture(scope="module")
def running() -> Iterator[Adapter]:
    with Adapter(48, cyclic=0) as made:
        made.write_to_master(OUTPUTS)
        yield made


@pytest.fixture
def adapter(running: Adapter) -> Adapter:
    """Return the adapter of the test, with no connection and all bytes of assembly 150 set to 0."""
    waiting = threading.Event()
    while running.shared.status().connections:  # wait: the previous connection is still closing
        waiting.wait(0.001)
    running.shared.to_robot.write(bytes(48))
    return running


@pytest.fixture
def scan(adapter: Adapter) -> Run:
    """Return a function that runs `rcx scan` on the adapter, by default for a single scan."""

    def run(*options: str, duration: str = "0s") -> int:
        host, port = adapter.address
        return main(["scan", host, "--port", str(port), "--for", duration, *options])

    return run


def test_identity_comes_first_then_both_areas_and_the_telegram(
    scan: Run, adapter: Adapter, capsys: Captured
) -> None:
    adapter.shared.to_robot.write(output_image(["SI00=1", "SIW(0)=0x0505"], 48))
    assert scan() == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == (
        "RCX3 virtual controller: vendor 636, device type 43, product code 5, revision 1.1, "
        "serial number 16#00000001"
    )
    assert lines[2] == "input only connection, 48 bytes, packets every 10 ms"
    master = lines.index("robot to master (assembly 100, the area from m)")
    robot = lines.index("master to robot (assembly 150, the area from n)")
    command = lines.index("remote command")
    assert master < robot < command
    assert "  SO(01) ON   CPU_OK status output" in lines[master:robot]
    assert "  SO(02) off  Servo ON status output" in lines[master:robot]
    assert "  not 0: SOW(2) = 16#1234, SO(20) = 1" in lines[master:robot]
    assert "  SI(00) ON   Emergency stop input" in lines[robot:command]
    request = "  ReadPositionPulses (16#R505): Current position reference, pulse units"
    assert lines[command + 1] == request
    assert lines[command + 2] == "  not taken yet"
    assert lines[-1].split(" packets received, ")[0].isdigit()


def test_without_write_nothing_is_written(scan: Run, adapter: Adapter) -> None:
    """Without --write nothing is written: an Input Only connection leaves the owner in control."""
    before = bytes(range(48))
    adapter.shared.to_robot.write(before)
    version, generation = adapter.shared.to_robot.version, adapter.shared.status().generation
    assert scan(duration="50ms") == 0
    assert adapter.shared.to_robot.read() == before
    assert adapter.shared.to_robot.version == version
    assert adapter.shared.status().generation == generation, "the scanner has been an owner"


def test_a_master_is_not_disturbed(scan: Run, adapter: Adapter, capsys: Captured) -> None:
    host, port = adapter.address
    with Scanner(host, port=port, io_port=0, multiplier=7) as master:
        master.write(output_image(["SI00=1"], 48))
        master.open()
        assert scan() == 0
        assert master.read().connected
        assert adapter.shared.status().owner is OwnerState.RUN
        assert "owned by a master" in capsys.readouterr().out
        assert scan("--listen-only") == 0
        assert "listen only connection" in capsys.readouterr().out
        assert scan("--write", "SI06=1") == 2
        error = capsys.readouterr().err
        assert "0x0106, another master owns the outputs" in error
        assert error.endswith(
            "; another master owns the robot: disconnect that master first, or leave --write out\n"
        )
        assert adapter.read_to_robot() == output_image(["SI00=1"], 48)


def test_with_write_rcx_scan_is_the_master(scan: Run, adapter: Adapter, capsys: Captured) -> None:
    """With --write, `rcx scan` is the owner of the connection. Data that are not named are 0."""
    assert scan("--write", "SI00=1", "--write", "SIW(2)=5", duration="200ms") == 0
    out = capsys.readouterr().out
    assert "exclusive owner connection" in out
    assert "  SI(00) ON   Emergency stop input" in out
    assert "  not 0: SIW(2) = 16#0005" in out
    assert adapter.shared.status().owner is OwnerState.CLOSED
    assert adapter.read_to_robot() == output_image(["SI00=1", "SIW(2)=5"], 48)


@pytest.mark.exhaustive(but=["options0-0x0128, the size from the device does not fit the assembly",
                             "options2-0x0112, the packet interval is not acceptable",
                             "options11-an area of 64 bytes does not exist",
                             "options14-no connection to the EtherNet/IP adapter"])  # fmt: skip
@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--size", "256"], "0x0128, the size from the device does not fit the assembly"),
        (["--size", "256"], "; its areas have another size: try --size 48"),
        (["--rpi", "1ms"], "0x0112, the packet interval is not acceptable"),
        (
            ["--rpi", "1ms"],
            "; the shortest interval that the device accepts is 2 ms; try --rpi 2ms\n",
        ),
        (["--heartbeat", "77"], "0x012A, there is no such consuming connection point"),
        (
            ["--heartbeat", "77"],
            "it has a different heartbeat connection point; name it with --heartbeat",
        ),
        (["--config-instance", "77"], "0x0129, there is no such configuration instance"),
        (["--config-instance", "77"], "or none; name it with --config-instance"),
        (["--config-instance", "1", "--config-data", "0102"], "give its data with --config-data"),
        (["--input-size", "64"], "; its EDS file has the sizes; give them with --input-size"),
        (["--listen-only"], "no other connection is open; leave --listen-only out"),
        (["--size", "64"], "an area of 64 bytes does not exist"),
        (["--write", "SO00=1"], "SO00"),
        (["--listen-only", "--write", "SI00=1"], "exclude each other"),
        (["--from", "192.0.2.1"], "no connection to the EtherNet/IP adapter"),
    ],
)
def test_a_refusal_is_reported_in_words(
    scan: Run, capsys: Captured, options: list[str], message: str
) -> None:
    assert scan(*options) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1


_OTHER_SIZE = "its areas have another size: try --size "
_EDS = "its EDS file has the sizes; give them with --input-size and --output-size"


@pytest.mark.parametrize(
    ("extended", "size", "hint"),
    [
        ((0x112,), 48, "try --rpi 10ms"),
        ((0x111,), 48, "try --rpi 10ms"),
        ((0x112, 0x0000, 10_000, 0, 10_000, 0), 48, "try --rpi 10ms"),
        # 3.2 s is 0x0030D400
        ((0x112, 0x0303, 0xD400, 0x0030, 0xD400, 0x0030), 48,
         "the longest interval that the device accepts is 3200 ms; try --rpi 3200ms"),
        ((0x112, 0x0400, 5_000, 0, 20_000, 0), 48,
         "the only interval that the device accepts is 20 ms; try --rpi 20ms"),
        *(((code,), size, hint)
          for code in (0x109, 0x127, 0x128)
          for size, hint in ((48, f"{_OTHER_SIZE}256"), (256, f"{_OTHER_SIZE}48"), (64, _EDS))),
    ],
)  # fmt: skip
def test_a_refused_interval_or_size_is_reported_with_a_suggestion(
    running: Adapter,
    monkeypatch: pytest.MonkeyPatch,
    extended: tuple[int, ...],
    size: int,
    hint: str,
) -> None:
    """If an interval or a size is refused, the message suggests an acceptable value.

    The extended status has one byte for each direction, then the two intervals in words.

    Source: CIP volume 1, chapter 3, 5.6, extended status 0x112; the words are admission.py's;
    0x109, 0x127 and 0x128: a size
    """

    def refuse(scanner: Scanner) -> None:
        raise CipError("Forward Open", 0x01, extended)

    monkeypatch.setattr(Scanner, "open", refuse)
    host, port = running.address
    with pytest.raises(InputError) as refused:
        look(ScanOptions(host, Assemblies(size, size), port=port), lambda line: None)
    assert refused.value.hint == hint


def test_each_option_reaches_the_scan(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[ScanOptions] = []

    def note(options: ScanOptions, tell: Callable[[str], None]) -> bool:
        asked.append(options)
        return True

    monkeypatch.setattr(cli_scan, "look", note)
    sizes = ["--input-size", "64", "--output-size", "32"]
    points = ["--input-instance", "101", "--output-instance", "102", "--heartbeat", "103"]
    configuration = ["--config-instance", "104", "--config-data", "0a 0B"]
    where = ["--port", "105", "--from", "127.0.0.6"]
    times = ["--rpi", "7ms", "--for", "8s"]
    assert main(["scan", "name", *sizes, *points, *configuration, *where, *times]) == 0
    assert main(["scan", "name", "--size", "256", "--write", "SI00=1", "--write", "SI06=1"]) == 0
    assert main(["scan", "name", "--listen-only"]) == 0
    assert asked == [
        ScanOptions(
            "name",
            Assemblies(64, 32, 101, 102, 103, 104, b"\x0a\x0b"),
            rpi_us=7_000,
            duration_us=8_000_000,
            port=105,
            address="127.0.0.6",
        ),
        ScanOptions(
            "name",
            Assemblies(256, 256),
            kind=ConnectionKind.EXCLUSIVE_OWNER,
            writes=["SI00=1", "SI06=1"],
        ),
        ScanOptions("name", kind=ConnectionKind.LISTEN_ONLY, writes=()),
    ]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--port", "99999"], "--port 99999 is not a port; use 1 to 65535"),
        (["--port", "0"], "--port 0 is not a port; use 1 to 65535"),
        (["--rpi", "5s"], "--rpi 5s is not a packet interval; use 1ms to 3200ms"),
        (["--rpi", "10us"], "--rpi 10us is not a packet interval; use 1ms to 3200ms"),
        (["--heartbeat", "65536"], "--heartbeat 65536 is not a connection point; use 1 to"),
        (["--input-size", "0"], "an assembly of 0 bytes cannot be exchanged"),
        (["--output-size", "1401"], "an assembly of 1401 bytes cannot be exchanged"),
        (["--input-instance", "0"], "0 is not an instance of an assembly"),
        (["--config-instance", "x"],
         "--config-instance x is not an instance; write it as 151, or none"),
        (["--config-instance", "65536"], "65536 is not an instance of an assembly"),
        (["--config-instance", "9" * 5_000], f"--config-instance {'9' * 40} is not an instance;"),
        (["--config-data", "01"], "configuration data need a configuration instance"),
        (["--config-instance", "1", "--config-data", "01"],
         "configuration data must be an even number"),
        (["--config-instance", "1", "--config-data", "00" * 512],
         "configuration data must be an even number of bytes, at most 510"),
        (["--config-instance", "1", "--config-data", "xy"],
         "--config-data 'xy' is not hexadecimal; write it in hexadecimal, as 01000A00"),
        (["--from", "here"], "--from 'here' is not an IPv4 address; write it as 192.168.0.10"),
        (["--for", "nan"], "--for: 'nan' is not a duration; write it as 10ms, 1.5s or 1m30s"),
        (["--for", "400d"], "--for: '400d' is too long for a duration; use 0s to 365d"),
        (["--rpi", "-1ms"], "--rpi: '-1ms' is not a duration; write it as 10ms, 1.5s or 1m30s"),
        (["--config-instance", "\u0661"], "--config-instance \u0661 is not an instance; write it"),
        (["--size", "-5"], "an area of -5 bytes does not exist; use 48, or 256"),
    ],
)  # fmt: skip
def test_wrong_options_are_reported_before_anything_is_sent(
    capsys: Captured, monkeypatch: pytest.MonkeyPatch, options: list[str], message: str
) -> None:
    monkeypatch.setattr(cli_scan, "look", lambda options, tell: pytest.fail("the scan was started"))
    assert main(["scan", "127.0.0.1", *options]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"rcx: {message}")
    assert error.count("\n") == 1


def test_a_missing_controller_is_one_line(capsys: Captured) -> None:
    assert main(["scan", "127.0.0.1", "--port", "1"]) == 2
    assert "no connection to the EtherNet/IP adapter at 127.0.0.1:1" in capsys.readouterr().err


@pytest.mark.exhaustive
def test_both_sizes_can_be_scanned(capsys: Captured) -> None:
    with Adapter(256, cyclic=0) as adapter:
        image = bytearray(256)
        image[254:] = b"\xcd\xab"
        adapter.write_to_master(bytes(image))
        host, port = adapter.address
        options = ["--port", str(port), "--size", "256", "--for", "0s"]
        assert main(["scan", host, *options]) == 0
    assert "  not 0: SOW(127) = 16#ABCD" in capsys.readouterr().out


@pytest.fixture
def other(monkeypatch: pytest.MonkeyPatch) -> Iterator[Adapter]:
    """Return an adapter of another maker, with 600 bytes in each direction."""
    monkeypatch.setattr("rcx_harness.enip.target.adapter.check_size", lambda size: None)
    with Adapter(600, cyclic=0) as made:
        made.write_to_master(bytes([0x12, 0x34]) + bytes(597) + b"\xff")
        yield made


@pytest.mark.exhaustive
def test_an_adapter_of_another_size_is_shown_as_bytes(other: Adapter, capsys: Captured) -> None:
    """Areas of another size are shown as bytes. More than 511 bytes need a Large Forward Open."""
    host, port = other.address
    options = ["--port", str(port), "--input-size", "600", "--for", "0s"]
    assert main(["scan", host, *options]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[2] == "input only connection, 600 bytes, packets every 10 ms"
    at = lines.index("robot to master (assembly 100)")
    assert lines[at + 1] == "     0  12 34" + " 00" * 14
    assert lines[at + 38] == "   592  00 00 00 00 00 00 00 ff"
    assert lines[lines.index("master to robot (assembly 150)") + 1] == "     0 " + " 00" * 16
    assert "remote command" not in lines


@pytest.mark.exhaustive
def test_other_sizes_are_written_by_byte_number(other: Adapter, capsys: Captured) -> None:
    host, port = other.address
    sizes = ["--input-size", "600", "--output-size", "600"]
    writes = ["--write", "0=0x12", "--write", "599=255"]
    assert main(["scan", host, "--port", str(port), *sizes, *writes, "--for", "200ms"]) == 0
    assert other.read_to_robot() == b"\x12" + bytes(598) + b"\xff"
    assert main(["scan", host, "--port", str(port), *sizes, "--write", "600=1"]) == 2
    assert "600 is not one of the 600 bytes; write 3=0x12" in capsys.readouterr().err


@pytest.mark.exhaustive
def test_changes_of_other_sizes_are_shown_by_their_bytes(other: Adapter) -> None:
    told: list[str] = []

    def tell(line: str) -> None:
        told.append(line)
        if line.startswith("changes in the next"):
            other.write_to_master(bytes([0x12, 0x35]) + bytes(597) + b"\xfe")
        elif " s  " in line and line.endswith("0xFE"):
            raise KeyboardInterrupt  # enough seen
        elif " s  " in line:
            assert line.endswith("byte 1 = 0x35")

    host, port = other.address
    assert look(ScanOptions(host, Assemblies(600, 600), duration_us=60_000_000, port=port), tell)
    assert any(line.endswith(" s  byte 599 = 0xFE") for line in told)


def test_an_assembly_that_cannot_be_read_is_reported_with_its_number(
    running: Adapter, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An assembly that cannot be read is reported with its number.

    The options name 101 and 151, but the adapter of the test has 100 and 150.
    """
    forward_open = OpenRequest.forward_open
    monkeypatch.setattr(
        *(OpenRequest, "forward_open"),
        lambda request: forward_open(replace(request, producing=100)),
    )
    told: list[str] = []
    host, port = running.address
    asked = Assemblies(48, 48, 101, 151)
    assert look(ScanOptions(host, asked, duration_us=0, port=port), told.append)
    assert "robot to master (assembly 101, the area from m)" in told
    at = told.index("master to robot (assembly 151, the area from n)")
    assert told[at + 1] == "  cannot be read"


@pytest.mark.exhaustive(but=["5", "none"])
@pytest.mark.parametrize("instance", ["none", "None", "1", "5", "151"])
def test_a_configuration_instance_may_be_named(scan: Run, instance: str) -> None:
    assert scan("--config-instance", instance) == 0


@pytest.mark.exhaustive
def test_the_connection_points_can_be_named(scan: Run, adapter: Adapter, capsys: Captured) -> None:
    assert scan("--input-instance", "100", "--output-instance", "150", "--write", "SI00=1") == 0
    assert scan("--input-instance", "101") == 2
    error = capsys.readouterr().err
    assert "0x012B" in error
    assert "name it with --input-instance" in error
    assert scan("--output-instance", "151", "--write", "SI00=1") == 2
    assert "0x012A" in capsys.readouterr().err


@pytest.mark.parametrize("written", [b"", b"\1\2"])
def test_a_device_that_gives_less_of_an_assembly_is_shown_nevertheless(
    adapter: Adapter, scan: Run, capsys: Captured, monkeypatch: pytest.MonkeyPatch, written: bytes
) -> None:
    monkeypatch.setattr(Client, "get_assembly", lambda client, instance: written)
    assert scan() == 0
    lines = capsys.readouterr().out.splitlines()
    at = next(k for k, line in enumerate(lines) if line.startswith("master to robot"))
    assert lines[at + 1] == ("     0  01 02" if written else "  cannot be read")


def test_inputs_are_written_by_any_of_their_names() -> None:
    names = ["SI00=1", "SI(01)=1", "SI10_SequenceControl=1", "SI(20)=1", "SIW(1)=0xABCD"]
    image = output_image([*names, "SID(2)=65536"], 48)
    assert image[2:4] == b"\xcd\xab"
    assert image[4:8] == b"\x00\x00\x01\x00"
    assert image[32:35] == b"\x03\x01\x01"
    assert output_image(["SIW(127)=1"], 256)[254:] == b"\x01\x00"
    assert output_image([], 48) == bytes(48)


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ("SI00", "not a value to write: 'SI00'"),
        ("SI00=on", "not a value to write"),
        ("SI00=2", "2 does not fit SI00"),
        ("SIW(2)=65536", "65536 does not fit"),
        ("SIW(2)=-1", "not a value to write"),
        ("SO(20)=1", "SO(20) is not an input of the robot"),
        ("MO(20)=1", "MO(20) is not an input of the robot"),
        ("SIW(127)=1", "SIW(127) needs the extended area; add --size 256"),
        ("nonsense=1", "nonsense"),
        ("SI0=9", "SI0 is not an input of the robot that can be written; write SI00=1, SI(20)=1"),
        ("SIW(16)=9", "words are SIW(0) to SIW(15), with --size 256 also"),
        ("SIW(2)=65536", "use 0 to 65535"),
    ],
)
def test_a_wrong_value_to_write_is_bad_input(entry: str, message: str) -> None:
    with pytest.raises(InputError) as refused:
        output_image([entry], 48)
    assert message in str(refused.value)
    assert "SOW" not in str(refused.value), "the hint must not name an output word"


@pytest.mark.exhaustive
def test_a_lost_connection_is_reported() -> None:
    """If the adapter ends during `rcx scan`, the lost connection is reported."""
    told: list[str] = []
    with Adapter(48, cyclic=0) as adapter:
        host, port = adapter.address

        def tell(line: str) -> None:
            told.append(line)
            if line.startswith("changes in the next"):
                adapter.close()

        assert not look(ScanOptions(host, duration_us=60_000_000, port=port), tell)
    assert any("the connection is lost" in line for line in told)
    assert " packets received, " in told[-1]


@pytest.mark.exhaustive
def test_a_dead_process_is_reported(running: Adapter, monkeypatch: pytest.MonkeyPatch) -> None:
    """If the process of the cyclic I/O dies, the report of the lost connection names it.

    If it dies before the first packet, an error is raised.
    """
    told: list[str] = []
    made: list[Scanner] = []
    open_ = Scanner.open

    def opening(scanner: Scanner) -> None:
        open_(scanner)
        made.append(scanner)
        if len(made) == 2:
            os.kill(scanner.pid, signal.SIGKILL)

    def tell(line: str) -> None:
        told.append(line)
        if line.startswith("changes in the next"):
            os.kill(made[0].pid, signal.SIGKILL)

    monkeypatch.setattr(Scanner, "open", opening)
    host, port = running.address
    options = ScanOptions(host, duration_us=60_000_000, port=port, rpi_us=100_000)
    assert not look(options, tell)
    killed = "the process of the cyclic I/O has ended by itself (killed by SIGKILL)"
    assert any(line.endswith(f"the connection is lost: {killed}") for line in told)
    monkeypatch.setattr(Scanner, "read", lambda scanner: Received(bytes(48), None, False))
    with pytest.raises(ProcessDiedError) as died:
        look(options, tell)
    assert died.value.message == killed


def test_ctrl_c_ends_it_with_the_count_of_packets(running: Adapter) -> None:
    told: list[str] = []

    def tell(line: str) -> None:
        told.append(line)
        if line.startswith("changes in the next"):
            raise KeyboardInterrupt

    host, port = running.address
    assert look(ScanOptions(host, duration_us=60_000_000, port=port), tell)
    assert " packets received, " in told[-1]


@pytest.mark.parametrize(("held", "code"), [(True, 0), (False, 1)])
def test_a_lost_connection_ends_with_1(
    monkeypatch: pytest.MonkeyPatch, held: bool, code: int
) -> None:
    monkeypatch.setattr(cli_scan, "look", lambda options, tell: held)
    assert main(["scan", "127.0.0.1"]) == code


def test_the_trace_begins_and_ends_with_the_state_of_the_areas(
    scan: Run, adapter: Adapter, tmp_path: Path
) -> None:
    """The trace has one record at the start and one at the end of the scan.

    A reader does not receive the data that the master writes, so `si` is empty.
    """
    file = tmp_path / "scan.jsonl"
    assert scan("--trace", str(file), duration="30ms") == 0
    header, records = read_trace(file)
    assert (header["by"], header["of"], header["size"]) == ("rcx scan", adapter.address[0], 48)
    scans = [one for one in records if isinstance(one, Scan)]
    assert (scans[0].t_us, scans[0].so, scans[0].si) == (0, OUTPUTS, b"")
    assert scans[-1].t_us > 0
    assert scans[-1].scan > 0
    assert main(["judge", str(file)]) == 0


def test_the_trace_of_a_master_has_what_it_writes(scan: Run, tmp_path: Path) -> None:
    file = tmp_path / "scan.jsonl"
    assert scan("--trace", str(file), "--write", "SI00=1") == 0
    assert {one.si for one in read_trace(file)[1] if isinstance(one, Scan)} == {
        output_image(["SI00=1"], 48)
    }


def test_the_trace_replaces_no_other_file(scan: Run, tmp_path: Path, capsys: Captured) -> None:
    mine = tmp_path / "mine.txt"
    mine.write_text("keep this")
    assert scan("--trace", str(mine)) == 2
    assert "already exists and is not a trace" in capsys.readouterr().err
    assert mine.read_text() == "keep this"
