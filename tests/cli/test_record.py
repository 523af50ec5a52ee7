"""`rcx record` captures packets with Wireshark's tools, and reports missing tools."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from rcx_harness.cli.app import main

Captured = pytest.CaptureFixture[str]

#: A replacement for dumpcap. It records its arguments, and writes the file named after `-w`.
TOOL = """#!/bin/sh
printf '%s\\n' "$@" > "$(dirname "$0")/called"
[ "$1" = -D ] && { echo '1. eth0'; echo '2. lo (Loopback)'; exit 0; }
while [ "$1" != -i ]; do shift; done
[ "$2" = eth9 ] && { echo 'There is no device named "eth9"' >&2; exit 1; }
while [ "$1" != -w ]; do shift; done
file=$2
trap 'echo captured > "$file"; exit 0' TERM
[ -z "$SENDS" ] || { kill "-$SENDS" "$TO"; while :; do sleep 1; done; }
echo captured > "$file"
"""

pytestmark = pytest.mark.skipif(os.name != "posix", reason="the stand-in is a shell script")


@pytest.fixture
def tools(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "tools"
    folder.mkdir()
    tool = folder / "dumpcap"
    tool.write_text(TOOL)
    tool.chmod(0o755)
    monkeypatch.setenv("PATH", f"{folder}{os.pathsep}/usr/bin{os.pathsep}/bin")
    return folder


def test_both_ports_are_captured_with_vlan(tools: Path, tmp_path: Path, capsys: Captured) -> None:
    """The capture filter has both EtherNet/IP ports (volume 2, chapter 2), also with VLAN tags."""
    file = tmp_path / "cell.pcapng"
    assert main(["record", str(file), "--interface", "eth0", "--for", "1.5s"]) == 0
    wanted = "(tcp port 44818 or udp port 2222)"
    assert (tools / "called").read_text().splitlines() == [
        *("-q", "-i", "eth0", "-f", f"{wanted} or (vlan and {wanted})"),
        *("-w", str(file), "-a", "duration:1.5"),
    ]
    assert capsys.readouterr().out.endswith(f"written: {file}, 9 bytes; next: rcx judge {file}\n")


@pytest.mark.exhaustive(but=["INT"])
@pytest.mark.parametrize("number", ["INT", "TERM", "HUP"])
@pytest.mark.usefixtures("tools")
def test_a_signal_ends_the_capture_and_keeps_its_file(
    tmp_path: Path, capsys: Captured, monkeypatch: pytest.MonkeyPatch, number: str
) -> None:
    """A signal to the command ends dumpcap, and the capture stays. The test's dumpcap never ends.

    Before a correction, dumpcap continued after SIGTERM.
    """
    monkeypatch.setenv("SENDS", number)
    monkeypatch.setenv("TO", str(os.getpid()))
    file = tmp_path / "cell.pcapng"
    assert main(["record", str(file), "--interface", "eth0"]) == 0
    assert f"written: {file}, 9 bytes" in capsys.readouterr().out


def test_hosts_and_ports_can_be_chosen(tools: Path, tmp_path: Path) -> None:
    file = tmp_path / "cell.pcapng"
    given = ["--host", "10.0.0.1", "--host", "10.0.0.2", "--port", "1", "--io-port", "2"]
    assert main(["record", str(file), "--interface", "lo", *given]) == 0
    wanted = "((tcp port 1 or udp port 2) and (host 10.0.0.1 or host 10.0.0.2))"
    assert f"{wanted} or (vlan and {wanted})" in (tools / "called").read_text()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--interface", "eth9"], 'cannot capture at eth9: There is no device named "eth9"'),
        ([], "--interface is missing; the interfaces are: eth0, lo (Loopback)"),
        (["--interface", "eth0", "--host", "robot"], "--host 'robot' is not an IPv4 address"),
        (["--interface", "eth0", "--for", "long"], "--for: 'long' is not a duration"),
    ],
)
@pytest.mark.usefixtures("tools")
def test_a_failed_capture_is_reported_with_its_reason(
    tmp_path: Path, capsys: Captured, options: list[str], message: str
) -> None:
    assert main(["record", str(tmp_path / "cell.pcapng"), *options]) == 2
    assert message in capsys.readouterr().err


def test_missing_tools_are_reported_with_their_name(
    tmp_path: Path, capsys: Captured, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    assert main(["record", str(tmp_path / "cell.pcapng"), "--interface", "eth0"]) == 2
    assert "neither dumpcap nor tshark was found; install Wireshark" in capsys.readouterr().err


@pytest.mark.usefixtures("tools")
def test_an_existing_capture_is_not_overwritten(tmp_path: Path, capsys: Captured) -> None:
    file = tmp_path / "cell.pcapng"
    file.write_text("an hour of work")
    assert main(["record", str(file), "--interface", "eth0"]) == 2
    assert "already exists" in capsys.readouterr().err
    assert file.read_text() == "an hour of work"
    assert main(["record", str(tmp_path / "cell.txt"), "--interface", "eth0"]) == 2
    assert "must end with .pcapng" in capsys.readouterr().err
