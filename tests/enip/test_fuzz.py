"""Malformed and hostile input does no harm: a part of `make fuzz` with fixed seeds."""

from __future__ import annotations

import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from random import Random

import pytest

import enip_fuzz
from enip_attacks import ATTACKER
from enip_frames import HEADER, frame, send_rr, valid_frames
from enip_fuzz import Bench, FuzzFailure, bench, fuzz


def can_bind(address: str) -> bool:
    """Return whether this computer can use the loopback address."""
    with socket.socket() as tried:
        try:
            tried.bind((address, 0))
        except OSError:
            return False
    return True


pytestmark = pytest.mark.skipif(
    not can_bind(ATTACKER), reason="only 127.0.0.1 is a loopback address on this system"
)


@pytest.fixture
def target() -> Iterator[Bench]:
    with bench() as made:
        yield made


@pytest.mark.exhaustive(but=["2"])
@pytest.mark.parametrize("seed", [1, 2])
def test_hostile_input_is_answered_or_cut_off_and_disturbs_no_other_peer(
    target: Bench, seed: int
) -> None:
    """During 300 attacks, a reader, new clients and the robot's master work without disturbance."""
    report = fuzz(target, seed, lambda number: number >= 300)
    assert report.attacks.total() == 300
    assert report.checks == 16
    assert len(report.attacks) == 10, f"not every kind of attack: {report.attacks}"
    # The fuzzer sends valid requests as well as requests that are refused.
    assert {0x00, 0x01, 0x03, 0x64, 0x65} <= report.statuses.keys()
    assert {0x00, 0x01, 0x04, 0x08, 0x0C, 0x0E} <= report.replies.keys()


@pytest.mark.exhaustive
def test_a_write_to_the_controller_is_reported(target: Bench) -> None:
    target.check()
    target.scanner.write(bytes(48))
    with pytest.raises(FuzzFailure, match=r"seed 5, attack \d+: something was written"):
        fuzz(target, 5, lambda number: number >= 1000)


@pytest.mark.exhaustive
def test_a_lost_connection_of_the_master_is_reported(target: Bench) -> None:
    def goal(number: int) -> bool:
        if number == 25:
            target.scanner.close_connection()
        return number >= 60

    with pytest.raises(FuzzFailure, match=r"seed 5, attack 40: (the master has lost|something)"):
        fuzz(target, 5, goal)


@pytest.mark.exhaustive
def test_the_frames_it_starts_from_are_right(target: Bench) -> None:
    """The undamaged frames of the fuzzer have the right form. Only their contents are refused."""
    with socket.create_connection(target.adapter.address) as wire:
        wire.sendall(frame(0x65, b"\x01\x00\x00\x00"))
        session = HEADER.unpack(wire.recv(4096)[: HEADER.size])[2]
        assert session
        for sent in valid_frames(Random(1), session):
            _, length, _, status, _, _ = HEADER.unpack_from(sent)
            assert (len(sent), status) == (HEADER.size + length, 0)
        wire.sendall(send_rr(b"\x0e\x03\x20\x04\x24\x64\x30\x03", session))
        answer = wire.recv(4096)
    assert answer[HEADER.size + 16 :] == b"\x8e\x00\x00\x00" + enip_fuzz.TO_MASTER


@pytest.mark.exhaustive
def test_make_fuzz_prints_its_seed_and_its_result(repository: Path) -> None:
    command = [sys.executable, str(repository / "tests/support/enip_fuzz.py")]
    done = subprocess.run(
        [*command, "--count", "20", "--seed", "4"],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[0] == "seed 4"
    assert lines[1].startswith("20 attacks with seed 4: ")
    assert "2 checks by well-behaved peers" in lines[3]
