"""Replays: the failure that a search found, written as a stimulus file and run in a cell."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TypeVar

from rcx_harness.cell.cell import Cell
from rcx_harness.cell.stimulus import Entry, Stimulus, stimulus_text
from rcx_harness.trace.bare import heard
from rcx_harness.trace.chart import Timeline
from rcx_harness.trace.chart_svg import svg_chart
from rcx_harness.verify.properties import Declared, judge_run
from structured_text.bench import Bench
from structured_text.bench.stimulus import Stimulus as PlcStimulus
from structured_text.output.files import replace_files
from structured_text.output.replays import MARK, check

__all__ = ["replayed"]

_Made = TypeVar("_Made", bound=Bench)


@contextmanager
def replayed(
    made: Callable[[], _Made],
    entries: Iterable[Entry],
    about: str,
    stimulus: Path,
    chart: Path | None,
    *,
    properties: Sequence[Declared] = (),
    kind: type[PlcStimulus] = Stimulus,
) -> Iterator[_Made]:
    """Write a stimulus file, yield the cell for which it is scheduled, then write its chart.

    `made` is a function that builds the cell, or the bench of a program without a robot. `about` is
    the comment at the beginning of the file. `properties` are checked in addition to the rules.
    """
    for file in (stimulus, chart):
        if file is not None:
            check(file)
    replace_files({stimulus: stimulus_text(entries, f"{MARK.removeprefix('# ')}{about}")})
    with made() as cell:
        timeline = Timeline() if isinstance(cell, Cell) else Timeline(cell.trace)
        cell.trace.listen(heard(timeline.take))
        if properties:
            judge_run(cell, properties)
        kind.load(stimulus).schedule(cell)
        yield cell
        if chart is not None:
            replace_files({chart: svg_chart(timeline, stimulus.name)})
