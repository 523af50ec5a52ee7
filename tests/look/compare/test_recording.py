"""`rcx compare` refuses a recording that is too long."""

from __future__ import annotations

from pathlib import Path

import pytest

from captures import Story, area, pcap
from rcx_harness.look.compare.recording import load
from structured_text.errors import InputError


def test_a_recording_of_days_is_not_replayed_in_cycles_of_5_ms(tmp_path: Path) -> None:
    """A recording of a year is refused, because its replay would need 6,300,000,000 cycles.

    Source: docs/reference/limits.md, files.
    """
    story = Story()
    story.open(0)
    for number in range(1, 9):
        story.both(number * 10_000, area(), area())
    assert load(pcap(tmp_path / "short.pcap", story.frames())).size == 48
    for hours in range(20, 61, 20):
        story.both(hours * 3_600_000_000, area(), area())
    told = r"days\.pcap: lasts 59 h, and at most 24 h are compared; cut out the part"
    with pytest.raises(InputError, match=told):
        load(pcap(tmp_path / "days.pcap", story.frames()))
