"""The process of the adapter answers requests, and leaves no process and no memory at its end."""

from __future__ import annotations

import signal
import socket
import subprocess
import sys
from typing import Any

import pytest

from rcx_harness.enip.errors import CipError, EnipError
from rcx_harness.enip.options import Identity
from rcx_harness.enip.originator.client import Client
from rcx_harness.enip.target.adapter import Adapter
from structured_text.errors import InputError
from structured_text.output.system import SharedMemory


@pytest.fixture
def memories(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return a list that collects the names of all shared memory that the test creates."""
    names: list[str] = []

    class Recording(SharedMemory):
        def __init__(self, *args: Any, **kwargs: Any) -> None:
            super().__init__(*args, **kwargs)
            names.append(self.name)

    monkeypatch.setattr("rcx_harness.enip.cyclic.shared.SharedMemory", Recording)
    return names


def is_gone(name: str) -> bool:
    """Return whether the shared memory with this name was removed."""
    try:
        SharedMemory(name).close()
    except FileNotFoundError:
        return True
    return False


@pytest.mark.parametrize("size", [48, 256])
def test_both_images_have_the_size_of_the_areas(size: int) -> None:
    """Each area has 48 bytes, or 256 bytes with the word extension.

    Source: manual chapter 1, 4.1 and 4.2
    """
    image = bytes((7 * k + 1) % 256 for k in range(size))
    with Adapter(size) as adapter, Client(*adapter.address) as master:
        assert master.get_attribute(4, 100, 4) == size.to_bytes(2, "little")
        assert master.get_attribute(4, 150, 4) == size.to_bytes(2, "little")
        assert master.get_assembly(100) == adapter.read_to_robot() == bytes(size)

        adapter.write_to_master(image)
        assert master.get_assembly(100) == image
        assert adapter.read_to_robot() == bytes(size)

        master.set_assembly(150, image[::-1])
        assert adapter.read_to_robot() == image[::-1]
        assert master.get_assembly(100) == image


@pytest.mark.parametrize("size", [0, 47, 49, 255, 512])
def test_another_size_is_bad_input(size: int) -> None:
    with pytest.raises(InputError, match=f"{size} bytes"):
        Adapter(size)


def test_the_identity_can_be_chosen() -> None:
    identity = Identity(1, 12, 3, 4, 5, 0x06070809, "another device")
    with Adapter(48, identity) as adapter, Client(*adapter.address) as master:
        values = master.request(0x01, bytes.fromhex("2001 2401"))
    assert values == bytes.fromhex("0100 0C00 0300 0405 3000 09080706 0E") + b"another device"


def test_after_a_refused_request_the_session_continues() -> None:
    with Adapter() as adapter, Client(*adapter.address) as master:
        for image, status in ((bytes(47), 0x13), (bytes(49), 0x15)):
            with pytest.raises(CipError) as refusal:
                master.set_assembly(150, image)
            assert refusal.value.status == status
        with pytest.raises(CipError, match="attribute not settable"):
            master.set_assembly(100, bytes(48))
        with pytest.raises(CipError, match="service not supported"):
            master.request(0x4C, bytes.fromhex("2004 2464"))
        assert master.get_assembly(100) == bytes(48)


def test_stopping_leaves_no_process_and_no_memory(
    processes: list[subprocess.Popen[str]], memories: list[str]
) -> None:
    adapter = Adapter()
    assert processes[0].poll() is None
    assert all(is_gone(name) for name in memories), (
        "the name is removed when both processes have the memory"
    )
    adapter.close()
    adapter.close()
    assert len(memories) == 1
    assert [process.returncode for process in processes] == [0]
    with pytest.raises(EnipError, match="no connection"):
        Client(*adapter.address)


def test_a_port_in_use_is_reported_and_leaves_nothing(
    processes: list[subprocess.Popen[str]], memories: list[str]
) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(EnipError, match=rf"cannot listen on 127\.0\.0\.1:{port}.*free port"):
            Adapter(port=port)
    assert len(processes) == len(memories) == 1
    assert processes[0].returncode == 0
    assert is_gone(memories[0])


@pytest.mark.parametrize(("host", "port"), [("127.0.0.1", 70000), ("not..a.name", 0)])
def test_an_invalid_address_is_reported(host: str, port: int) -> None:
    with pytest.raises(EnipError, match=rf"cannot listen on {host}:{port}"):
        Adapter(host=host, port=port)


def test_a_process_that_cannot_start_is_reported(
    monkeypatch: pytest.MonkeyPatch, memories: list[str]
) -> None:
    monkeypatch.setattr("rcx_harness.enip.target.adapter.MODULE", "rcx_harness.enip.no_such_module")
    with pytest.raises(EnipError, match="ended at once, exit code 1"):
        Adapter()
    assert is_gone(memories[0])


@pytest.mark.exhaustive(but=["9-SIGKILL"])
@pytest.mark.skipif(sys.platform == "win32", reason="signals are POSIX")
@pytest.mark.parametrize(
    ("number", "how"), [(signal.SIGKILL, "SIGKILL"), (signal.SIGTERM, "SIGTERM")]
)
def test_a_dead_process_is_reported_with_its_signal(
    processes: list[subprocess.Popen[str]], number: signal.Signals, how: str
) -> None:
    with Adapter() as adapter:
        assert adapter.failure == ""
        processes[0].send_signal(number)
        told = f"the process of the EtherNet/IP adapter has ended by itself (killed by {how})"
        assert adapter.wait_for_failure() == adapter.failure == told
    with Adapter() as closed:
        pass
    assert closed.failure == ""


@pytest.mark.exhaustive
@pytest.mark.skipif(sys.platform == "win32", reason="signals are POSIX")
def test_the_adapter_ignores_ctrl_c(processes: list[subprocess.Popen[str]]) -> None:
    with Adapter() as adapter, Client(*adapter.address) as master:
        processes[0].send_signal(signal.SIGINT)
        assert master.get_assembly(100) == bytes(48)
    assert processes[0].returncode == 0


@pytest.mark.skipif(sys.platform == "win32", reason="signals are POSIX")
def test_the_adapter_ends_when_its_parent_is_killed() -> None:
    """If the parent process is killed, its adapter ends as well.

    The test waits until standard error is closed, which both processes hold open.
    """
    program = (
        "from rcx_harness.enip.target.adapter import Adapter\n"
        "adapter = Adapter()\n"
        "print(adapter.address[1], flush=True)\n"
        "input()\n"
    )
    pipe = subprocess.PIPE
    command = [sys.executable, "-c", program]
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe, text=True) as parent:
        assert parent.stdout is not None
        port = int(parent.stdout.readline())
        with Client("127.0.0.1", port) as master:
            assert master.get_assembly(100) == bytes(48)
            parent.kill()
            _, complaints = parent.communicate(timeout=30)
    assert complaints == ""
    with pytest.raises(EnipError, match="no connection"):
        Client("127.0.0.1", port)
