"""If the process of a served controller ends or prints invalid output, its parent reports this."""

from __future__ import annotations

import asyncio
import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from rcx_harness.enip.errors import ProcessDiedError
from rcx_harness.serve.host import Host, Settings
from rcx_harness.serve.status import Status
from serve_process import own_addresses, watching
from structured_text.errors import InputError

pytestmark = pytest.mark.skipif(
    not sys.platform.startswith("linux"),
    reason="it needs signals, and loopback addresses besides 127.0.0.1",
)

#: Longest wait for the end of the process [s].
_PATIENCE_S = 60
#: Child process that raises an exception in its first step.
_FAILS_AT_START = """
import sys
from rcx_harness.serve import station_process

def step(station, now_us, skipped=0):
    raise RuntimeError("a mistake")

station_process.Station.step = step
station_process.main(sys.argv[1])
"""
#: Child process that prints invalid output, at once or after its status, and then waits.
_GARBAGE = """
import sys
from rcx_harness.serve.status import Status

first, *more = sys.argv[0].rpartition("/")[2].removesuffix(".py").split("_")
print('{"size": 48}')
if more:
    print(Status().to_json())
print("[]" if first == "listing" else "nonsense", flush=True)
sys.stdin.read()
"""
#: Child process that does not end when its standard input is closed.
_IGNORES_STDIN = """
import os
import time
from rcx_harness.serve.status import Status

print('{"size": 48}')
print(Status().to_json(), flush=True)
parent = os.getppid()
while os.getppid() == parent:  # it must not stay for ever where this test fails
    time.sleep(0.1)
"""

Use = Callable[[str, str], None]


@pytest.fixture
def use(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Use:
    """Replace the program of the controller's process by another program."""

    def write(name: str, program: str) -> None:
        (tmp_path / f"{name}.py").write_text(program)
        monkeypatch.setenv("PYTHONPATH", str(tmp_path))
        monkeypatch.setattr("rcx_harness.serve.host.MODULE", name)

    return write


def _host() -> Host:
    (address,) = own_addresses(1)
    return Host(Settings(host=address))


async def _ended(host: Host) -> str:
    """Wait for the end of the host, and return its failure."""
    try:
        await asyncio.wait_for(host.start(), _PATIENCE_S)
        await asyncio.wait_for(host.ended.wait(), _PATIENCE_S)
        return host.failure
    finally:
        await host.close()


def test_a_process_that_ends_before_it_listens_is_named_with_how(use: Use) -> None:
    use("ending", "raise SystemExit(7)")
    host = _host()
    with pytest.raises(ProcessDiedError) as died:
        asyncio.run(_ended(host))
    told = f"the process of controller {host.name} ended at once, exit code 7"
    assert died.value.message == told


@pytest.mark.exhaustive
def test_a_killed_controller_takes_no_event() -> None:
    async def kill_and_ask() -> None:
        host = _host()
        await host.start()
        assert host.status != Status(), "the process has sent its status"
        try:
            await host.ask({"event": "link_down", "args": {}})
            os.kill(host.pid, signal.SIGKILL)
            await asyncio.wait_for(host.ended.wait(), _PATIENCE_S)
            assert host.failure == "its process has ended by itself (killed by SIGKILL)"
            with pytest.raises(InputError) as refused:
                await host.ask({"event": "link_up", "args": {}})
            assert refused.value.message == f"controller {host.name} is not running"
        finally:
            await host.close()

    asyncio.run(kill_and_ask())


def test_a_mistake_in_the_controller_ends_it_and_is_named(
    use: Use, capfd: pytest.CaptureFixture[str]
) -> None:
    use("mistaken", _FAILS_AT_START)
    assert asyncio.run(_ended(_host())) == (
        "the controller has ended by itself (RuntimeError: a mistake)"
    )
    assert "Traceback" in capfd.readouterr().err  # the traceback, for the developer


@pytest.mark.parametrize("name", ["mumbling", "listing", "mumbling_later", "listing_later"])
def test_a_process_with_unreadable_output_counts_as_ended(use: Use, name: str) -> None:
    use(name, _GARBAGE)
    failure = asyncio.run(_ended(_host()))
    assert failure.startswith("its process has sent an invalid report (")


def test_a_process_that_does_not_end_is_killed_and_named(
    use: Use, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    use("deaf", _IGNORES_STDIN)
    monkeypatch.setattr("rcx_harness.serve.host.STOP_S", 0.01)

    async def close() -> Host:
        host = _host()
        await host.start()
        with watching([host.pid]):
            await asyncio.wait_for(host.close(), _PATIENCE_S)
        return host

    host = asyncio.run(close())
    assert capsys.readouterr().err == f"rcx: controller {host.name} did not end and was killed\n"
