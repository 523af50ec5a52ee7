"""In lock-step, the link over EtherNet/IP gives the same images as the direct link."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rcx_harness.cell.link import DirectLink, Link
from rcx_harness.enip.errors import ProcessDiedError
from rcx_harness.enip.links import LockstepLink
from structured_text.errors import InputError


@pytest.fixture(scope="module", params=[48, 256])
def lockstep(request: pytest.FixtureRequest) -> Iterator[LockstepLink]:
    link = LockstepLink(request.param)
    yield link
    link.close()


def play(link: Link, calls: list[tuple[str, int]]) -> list[bytes]:
    """Make the calls of a link, and return the images that were read.

    The first two calls write zeros. Later write calls write their number.
    """
    seen = []
    for call, number in [("scanner_write", 0), ("robot_write", 0), *calls]:
        if call.endswith("write"):
            image = (number * 0x0101).to_bytes(4, "little") * (link.size // 4)
            getattr(link, call)(image[:-1] + bytes([number % 251]))
        else:
            seen.append(getattr(link, call)())
    return seen


CALLS = st.tuples(
    st.sampled_from(["scanner_write", "scanner_read", "robot_read", "robot_write"]),
    st.integers(0, 0xFFFF),
)


@pytest.mark.exhaustive
@settings(max_examples=60, deadline=None, derandomize=True)
@given(calls=st.lists(CALLS, max_size=40))
def test_every_call_has_the_result_of_the_direct_link(
    lockstep: LockstepLink, calls: list[tuple[str, int]]
) -> None:
    assert play(lockstep, calls) == play(DirectLink(lockstep.size), calls)


def test_it_is_a_link_of_the_given_size(lockstep: LockstepLink) -> None:
    assert isinstance(lockstep, Link)
    assert lockstep.name == "enip"
    assert len(lockstep.scanner_read()) == len(lockstep.robot_read()) == lockstep.size


def test_a_new_link_starts_with_zeros() -> None:
    link = LockstepLink()
    assert link.scanner_read() == link.robot_read() == bytes(48)
    link.close()


def test_a_wrong_size_is_bad_input() -> None:
    with pytest.raises(InputError, match="64 bytes"):
        LockstepLink(64)


@pytest.mark.parametrize("call", ["scanner_read", "scanner_write"])
def test_a_killed_adapter_process_is_reported(call: str) -> None:
    """If the adapter's process is killed, the error names it, with exit code 1."""
    link = LockstepLink()
    link.robot_write(bytes(48))
    os.kill(link.adapter.pid, signal.SIGKILL)
    with pytest.raises(ProcessDiedError) as died:
        link.scanner_read() if call == "scanner_read" else link.scanner_write(bytes(48))
    link.close()
    assert "adapter has ended by itself (killed by SIGKILL)" in died.value.message
    assert died.value.exit_code == 1


@pytest.mark.exhaustive
def test_a_lockstep_link_can_be_closed_twice() -> None:
    link = LockstepLink()
    link.close()
    link.close()
