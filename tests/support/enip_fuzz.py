"""Malformed and hostile input for the EtherNet/IP adapter, with well-behaved peers beside it.

`make test` runs a short part with a fixed seed. `make fuzz` runs for any time:

    make fuzz FOR=60s SEED=1        (or COUNT=20000)

After every few attacks a well-behaved client reads the device, and a master's cyclic connection
runs all the time. These rules must hold. The adapter answers each attack with frames of the
protocol, or closes its connection. The well-behaved peers are not disturbed. The adapter's memory
and open files stay bounded. Assembly 150 contains only data from the master. The same seed and
number give the same attacks.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory

from enip_attacks import Attacker, Report, Target
from rcx_harness.enip.cyclic.connections import IO_PORT, OwnerState
from rcx_harness.enip.errors import EnipError
from rcx_harness.enip.originator.client import Client
from rcx_harness.enip.originator.scanner import Scanner
from rcx_harness.enip.target.adapter import Adapter
from structured_text.errors import InputError
from structured_text.output.units import parse_us

#: The robot's master. Packets of its connection must come from this address.
MASTER = "127.0.0.2"
TO_MASTER = bytes(range(48, 96))
TO_ROBOT = bytes(range(48))
#: Longest wait for a packet of the master [s]. Only a failure takes this long.
_PATIENCE_S = 20.0
_CHECK_EVERY = 20
#: Allowed growth of the adapter's processes after the first hundred attacks [KiB].
_GROWTH_KIB = 24_000


class FuzzFailure(AssertionError):  # noqa: N818 - a failed assertion
    """The error for an adapter that breaks a rule in the head of this module."""


@dataclass
class Bench:
    """The adapter under attack and two well-behaved peers."""

    adapter: Adapter
    scanner: Scanner
    reader: Client
    complaints: Path
    received: int = 0

    def target(self) -> Target:
        """Return the data that an attacker can know of the adapter."""
        connection = self.scanner.connection
        assert connection is not None
        host, port = self.adapter.address
        ids = (connection.o_to_t_id, connection.t_to_o_id)
        return Target((host, port), (host, self.adapter.io_port or IO_PORT), ids)

    def check(self) -> None:
        """Check that master and reader are undisturbed, and that no data come from the attacker.

        Raises:
            AssertionError: a peer is disturbed, or the adapter has written an error.
        """
        complaint = self.complaints.read_text(errors="replace")
        assert not complaint, f"the adapter wrote to stderr: {complaint[:2000]}"
        assert self.reader.get_assembly(100) == TO_MASTER, "the reader receives other data"
        with Client(*self.adapter.address) as newcomer:
            assert newcomer.get_attribute(1, 1, 1) == b"\x7c\x02", "the vendor id has changed"
        assert self.adapter.read_to_robot() == TO_ROBOT, "something was written to the model"
        received = self.scanner.read()
        assert received.connected, "the master has lost its connection"
        assert received.image == TO_MASTER, "the master receives other data"
        deadline = time.monotonic() + _PATIENCE_S
        while (status := self.adapter.shared.status()).received <= self.received:
            assert time.monotonic() < deadline, "the adapter no longer accepts the master's packets"
            time.sleep(0.001)
        assert status.owner is OwnerState.RUN, f"the owner is {status.owner.name}"
        self.received = status.received


@contextmanager
def bench() -> Iterator[Bench]:
    """Start an adapter with a master that owns its outputs, and a reader."""
    with TemporaryDirectory() as folder, ExitStack() as stack:
        complaints = Path(folder) / "stderr"
        with _standard_error_into(complaints):
            adapter = stack.enter_context(Adapter(48, cyclic=0))
        host, port = adapter.address
        scanner = stack.enter_context(
            Scanner(host, multiplier=7, address=MASTER, io_port=0, port=port)
        )
        reader = stack.enter_context(Client(host, port))
        adapter.write_to_master(TO_MASTER)
        scanner.write(TO_ROBOT, run=True)
        scanner.open()
        deadline = time.monotonic() + _PATIENCE_S
        while scanner.read().image != TO_MASTER or adapter.read_to_robot() != TO_ROBOT:
            if time.monotonic() > deadline:
                raise FuzzFailure("no data arrived over the cyclic connection")
            time.sleep(0.001)
        yield Bench(adapter, scanner, reader, complaints)


def fuzz(
    target: Bench,
    seed: int,
    goal: Callable[[int], bool],
    progress: Callable[[int, Report], None] | None = None,
) -> Report:
    """Attack until `goal(number of attacks)` is true.

    Raises:
        FuzzFailure: a rule was broken; the message has seed and number of the attack.
    """
    report = Report(seed)
    attacker = Attacker(target.target(), Random(seed), report)
    start_kib = 0
    number = 0
    try:
        for number in count():
            if number % _CHECK_EVERY == 0:
                target.check()
                report.checks += 1
            if number == 100:
                start_kib = memory_kib(target.adapter)
            if goal(number):
                break
            attacker.attack()
            if progress is not None:
                progress(number + 1, report)
        target.check()
    except (AssertionError, EnipError, OSError) as error:
        last = attacker.last.hex(" ")
        raise FuzzFailure(
            f"seed {seed}, attack {number}: {error or type(error).__name__}; last: {last[:600]}"
        ) from error
    finally:
        attacker.close()
    if start_kib:
        report.grown_kib = memory_kib(target.adapter) - start_kib
        if report.grown_kib > _GROWTH_KIB:
            raise FuzzFailure(f"seed {seed}: the adapter's memory grew by {report.grown_kib} KiB")
    return report


@contextmanager
def _standard_error_into(file: Path) -> Iterator[None]:
    """Redirect the standard error of processes that start in this context into this file."""
    sys.stderr.flush()
    before = os.dup(2)
    with file.open("wb") as opened:
        os.dup2(opened.fileno(), 2)
    try:
        yield
    finally:
        os.dup2(before, 2)
        os.close(before)


def memory_kib(adapter: Adapter) -> int:
    """Return the resident memory of the adapter's processes; 0 if the system does not report it."""
    return sum(_resident_kib(pid) for pid in (adapter.pid, *_children(adapter.pid)))


def _children(pid: int) -> list[int]:
    tasks = Path(f"/proc/{pid}/task")
    if not tasks.is_dir():
        return []
    texts = [(task / "children").read_text() for task in tasks.iterdir()]
    return [int(child) for text in texts for child in text.split()]


def _resident_kib(pid: int) -> int:
    try:
        pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    except OSError:
        return 0
    return pages * os.sysconf("SC_PAGE_SIZE") // 1024


def _duration(text: str) -> int:
    try:
        return parse_us(text)
    except InputError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def main() -> int:
    """Run the command line of `make fuzz`."""
    parser = argparse.ArgumentParser(description="Attack the EtherNet/IP adapter.")
    parser.add_argument(
        "--for",
        dest="duration_us",
        type=_duration,
        default="60s",
        help="duration of the run, e.g. 10s",
    )
    parser.add_argument("--count", type=int, help="number of attacks instead of a duration")
    parser.add_argument("--seed", type=int, default=None, help="default: random")
    options = parser.parse_args()
    seed = options.seed if options.seed is not None else Random().randrange(1 << 32)
    print(f"seed {seed}", flush=True)
    end = time.monotonic() + options.duration_us / 1e6
    told = time.monotonic()

    def goal(number: int) -> bool:
        return bool(number >= options.count if options.count else time.monotonic() >= end)

    def progress(number: int, report: Report) -> None:
        nonlocal told
        if time.monotonic() - told >= 2:
            told = time.monotonic()
            print(f"{number} attacks, {report.checks} checks", file=sys.stderr, flush=True)

    try:
        with bench() as target:
            report = fuzz(target, seed, goal, progress)
    except FuzzFailure as failure:
        print(f"failed: {failure}", file=sys.stderr)
        return 1
    print(report.text())
    return 0


if __name__ == "__main__":
    sys.exit(main())
