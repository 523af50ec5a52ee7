"""What explicit messages are measured with: one processor, and a server that only sends."""

from __future__ import annotations

import os

import pytest

from rcx_tools.bench import explicit
from rcx_tools.bench.processes import first_line, on_one_processor, running
from structured_text.errors import InputError


def test_the_server_that_only_sends_answers_as_a_get_is_answered() -> None:
    """Header of 24 bytes, 16 of the items, 4 of the reply, 48 of data; its client is content.

    Source: docs/explanation/timing.md: the same client.
    """
    with running(explicit.__name__, []) as process:
        port = int(first_line(process))
        with explicit.Asker(explicit.HOST, port) as asker:
            assert len(asker.ask(explicit.GET)) == 24 + 16 + 4 + 48


def test_a_process_that_ends_at_its_start_is_told() -> None:
    """Source: docs/explanation/timing.md: what is missing is said to be missing."""
    said = pytest.raises(InputError, match="has ended at its start")
    with running("rcx_tools.bench.peer_that_is_not", []) as process, said:
        first_line(process)


@pytest.mark.skipif(not hasattr(os, "sched_getaffinity"), reason="not on this system")
def test_asker_and_servers_share_a_processor_for_the_time_of_the_bench() -> None:
    """Source: sched_setaffinity(2): children inherit it."""
    before = os.sched_getaffinity(0)
    with on_one_processor():
        assert len(os.sched_getaffinity(0)) == 1
    assert os.sched_getaffinity(0) == before
