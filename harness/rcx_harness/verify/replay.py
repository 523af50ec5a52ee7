"""What a search has found as a stimulus file, and the same run in a cell, with its chart."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rcx_harness.cell.cell import Cell
from rcx_harness.cell.stimulus import Entry, Stimulus, stimulus_text
from rcx_harness.trace.chart import Timeline
from rcx_harness.trace.chart_svg import svg_chart
from rcx_harness.verify.properties import Declared, judge_run
from structured_text.output.files import replace_files
from structured_text.output.replays import MARK, check

__all__ = ["replayed"]


@contextmanager
def replayed(
    entries: Iterable[Entry],
    about: str,
    stimulus: Path,
    chart: Path | None,
    *given: Any,
    properties: Sequence[Declared] = (),
    **settings: Any,
) -> Iterator[Cell]:
    """Write a stimulus file, give the cell that it is scheduled for, and then write its chart.

    Args:
        entries: The run.
        about: Comment at the beginning of the file.
        stimulus: Where the stimulus file goes.
        chart: Where the timing chart (SVG) goes.
        given: The program, as `Cell.build` takes it.
        properties: What judges the run besides the rules.
        settings: More that `Cell.build` takes; the engine is the built-in one.

    Raises:
        InputError: a file cannot be written, or is there already and none of a search.
    """
    for file in (stimulus, chart):
        if file is not None:
            check(file)
    replace_files({stimulus: stimulus_text(entries, f"{MARK.removeprefix('# ')}{about}")})
    timeline = Timeline()
    with Cell.build(*given, engine="builtin", **settings) as cell:
        cell.trace.listen(timeline.take)
        if properties:
            judge_run(cell, properties)
        Stimulus.load(stimulus).schedule(cell)
        yield cell
        if chart is not None:
            replace_files({chart: svg_chart(timeline, stimulus.name)})
