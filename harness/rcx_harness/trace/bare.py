"""Conversion of the records of a program without a robot into records of a cell."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rcx_harness.trace.records import Record, Scan
from structured_text.bench.samples import Sample

__all__ = ["heard"]


def heard(take: Callable[[Record], None]) -> Callable[[Any], None]:
    """Return a listener that converts the records of a bench to records of a cell.

    The areas of the converted scans are empty.
    """

    def hear(record: Any) -> None:
        if isinstance(record, Sample):
            record = Scan(record.t_us, record.scan, b"", b"", record.vars)
        take(record)

    return hear
