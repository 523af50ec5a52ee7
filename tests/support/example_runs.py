"""Runs of the examples as their README says, and their traces as recorded from matiec."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from plc_bench import ROOT
from rcx_harness.cell import Cell
from rcx_tools.docs.examples import Example, Recorder, chart_specs, examples

__all__ = ["EXAMPLES", "ROOT", "Finished", "changes", "finished", "recorded_trace"]

_AREAS = ("so", "si", "rcx_si", "rcx_so")

EXAMPLES = list(examples().values())


@dataclass(frozen=True)
class Finished:
    """A finished example: its cell after the run, and the chart of the run."""

    cell: Cell
    chart: str


@cache
def finished(name: str, engine: str = "builtin") -> Finished:
    """Run an example for the time in its command. Tests share the result and must not change it."""
    example = examples()[name]
    recorder = Recorder(chart_specs()[name]) if name in chart_specs() else None
    cell = example.build(engine, watch=recorder.watch if recorder else ())
    if recorder:
        recorder.listen(cell)
    cell.run(example.duration)
    return Finished(cell, recorder.chart() if recorder else "")


def recorded_trace(example: Example) -> Path:
    """Return the path of the example's trace, which was recorded from matiec."""
    return ROOT / "tests/data/traces/examples" / f"{example.name}.jsonl"


def changes(lines: Iterable[str]) -> Iterator[str]:
    """Return the lines of a trace that show a change on the wire, except the first line.

    Zeros at the end of an area are left out.
    """
    before: dict[object, object] = {}
    for line in list(lines)[1:]:
        entry = json.loads(line)
        for key in ("vars", "positions", "poses"):
            entry.pop(key, None)
        entry |= {key: _short(entry[key]) for key in _AREAS if key in entry}
        kind = next(key for key in ("scan", "cycle", "violation") if key in entry)
        which = kind, entry.get("controller", 1)
        shown = [value for key, value in entry.items() if key not in ("t_us", kind)]
        if kind == "violation" or before.get(which) != shown:
            yield json.dumps(entry, separators=(",", ":"), ensure_ascii=False)
        before[which] = shown


def _short(area: str) -> str:
    short = area.rstrip("0")
    return short + "0" * (len(short) % 2) or area[:2]  # None differs from an area of zeros
