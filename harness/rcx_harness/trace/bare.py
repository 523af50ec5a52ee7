"""The records of a program without a robot, for what takes those of a cell."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rcx_harness.trace.records import Record, Scan
from structured_text.bench.samples import Sample

__all__ = ["heard"]


def heard(take: Callable[[Record], None]) -> Callable[[Any], None]:
    """What takes the records of a cell, for those of a bench: its scans have no areas."""

    def hear(record: Any) -> None:
        if isinstance(record, Sample):
            record = Scan(record.t_us, record.scan, b"", b"", record.vars)
        take(record)

    return hear
