"""Small programs that every engine must run alike, and their recorded traces.

A probe is `NAME.st` in tests/data/language. `NAME.json` beside it maps the number of a scan to the
values, by path, that are written before this scan. `record.py` records the probe's trace
from matiec in tests/data/traces/NAME.jsonl. The first line of a trace names its origin, the second
has every variable before the first scan, and each further line has the variables that changed in a
scan.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from datetime import date, datetime, time, timedelta
from pathlib import Path
from typing import Any

from structured_text.engines.base import Program
from structured_text.language.types import BlockType, StructType

__all__ = ["Probe", "differences", "language_probes", "recorded_trace", "trace", "trace_file"]

_DATA = Path(__file__).parents[3] / "data"


@dataclass(frozen=True)
class Probe:
    """A program, with the times and inputs of its run.

    Attributes:
        name: Name of the trace.
        files: ST files of the program.
        scans: Number of scans.
        scan_us: Time from scan to scan, microseconds.
        writes: For each scan number, the values (by path) to write before that scan.
    """

    name: str
    files: tuple[Path, ...]
    scans: int = 40
    scan_us: int = 10_000
    writes: Mapping[int, Mapping[str, Any]] = field(default_factory=dict)


def language_probes() -> list[Probe]:
    """Return the probes of tests/data/language, by name."""
    return [
        Probe(path.stem, (path,), writes=_writes(path.with_suffix(".json")))
        for path in sorted((_DATA / "language").glob("*.st"))
    ]


def _writes(file: Path) -> dict[int, dict[str, Any]]:
    if not file.exists():
        return {}
    written = json.loads(file.read_text(encoding="utf-8"))
    return {int(scan): values for scan, values in written.items()}


def trace(program: Program, probe: Probe) -> list[str]:
    """Run a probe on an engine.

    Returns:
        The lines of its trace.
    """
    digest = hashlib.sha256("".join(file.read_text("utf-8") for file in probe.files).encode())
    head = {
        "format": "rcx-probe/1",
        "generated from": [file.name for file in probe.files],
        "sha256": digest.hexdigest(),
        "by": "tests/structured_text/engines/agreement/record.py",
        "scan_us": probe.scan_us,
    }
    return [json.dumps(head), *(json.dumps(changed) for changed in _run(program, probe))]


def _run(program: Program, probe: Probe) -> Iterator[dict[str, Any]]:
    places = [item for item in program.walk() if item[0].partition(".")[0] in program.instances()]
    paths = [path for path, kind in places if not isinstance(kind, (StructType, BlockType))]
    seen: dict[str, Any] = {path: _plain(program.read(path)) for path in paths}
    yield seen
    for scan in range(probe.scans):
        for path, value in probe.writes.get(scan, {}).items():
            program.write(path, value)
        program.scan(scan * probe.scan_us)
        now = {path: _plain(program.read(path)) for path in paths}
        yield {path: value for path, value in now.items() if repr(value) != repr(seen[path])}
        seen = now


def _plain(value: Any) -> Any:
    """Return a value in JSON form: durations in microseconds, dates as ISO text."""
    if isinstance(value, list):
        return [_plain(item) for item in value]
    if isinstance(value, dict):
        return {name: _plain(item) for name, item in value.items()}
    if isinstance(value, timedelta):
        return value // timedelta(microseconds=1)
    if isinstance(value, (date, time, datetime)):
        return value.isoformat()
    return value


def trace_file(probe: Probe) -> Path:
    """Return the path of the trace that was recorded from matiec."""
    return _DATA / "traces" / f"{probe.name}.jsonl"


def recorded_trace(probe: Probe) -> list[str]:
    """Return the lines of the trace that was recorded from matiec."""
    return trace_file(probe).read_text(encoding="utf-8").splitlines()


def differences(expected: list[str], got: list[str]) -> list[str]:
    """Return the differences of two traces, one line each with scan, variable, expected and got."""
    found = []
    if expected[0] != got[0]:
        found.append(f"the trace is of other sources: {expected[0]}, now {got[0]}")
    if len(expected) != len(got):
        found.append(f"expected {len(expected) - 2} scans, got {len(got) - 2}")
    for scan, (left, right) in enumerate(zip(expected[1:], got[1:], strict=False), start=-1):
        if left != right:
            one, two = json.loads(left), json.loads(right)
            for path in sorted({*one, *two}):
                was, now = (json.dumps(side.get(path, "as before")) for side in (one, two))
                if was != now:
                    found.append(f"scan {scan}: {path} expected {was}, got {now}")
    return found
