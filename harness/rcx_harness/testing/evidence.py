"""The evidence of a failed test: chart, trace and variables of its cell."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

from rcx_harness.cell import Cell
from rcx_harness.robot.listing import task_places
from rcx_harness.trace.chart import Timeline, text_chart
from rcx_harness.trace.chart_svg import svg_chart
from rcx_harness.trace.explaining import shown_errors
from rcx_harness.trace.tasks import statement_of, task_text
from rcx_harness.trace.view.page import View
from rcx_harness.watch.block_errors import error_names, error_text
from structured_text.language.types import BlockType, ElementaryType, EnumType
from structured_text.output.console import draws
from structured_text.output.files import replace_files
from structured_text.output.units import format_us

__all__ = ["LastChanges", "broken_rules", "chart_of", "state_of", "watched_of", "write_files"]

_SECOND_US = 1_000_000
#: If the last second has fewer changes than this number, a chart covers a longer time.
_FEWEST = 6
_WIDTH = (80, 120)
_MOST_RULES = 20


class LastChanges(Timeline):
    """The chart of the end of a run: the last second, or longer if it has only a few changes."""

    def __init__(self, cell: Cell) -> None:
        super().__init__(cell.trace)
        for record in cell.trace:
            self.take(record)
        if not cell.closed:
            self.explain(shown_errors(cell.program))
        every = super().instants()
        recent = [t_us for t_us in every if t_us >= cell.now_us - _SECOND_US]
        last = recent if len(recent) >= _FEWEST else every[-_FEWEST:]
        self._shown = sorted({*last, cell.now_us})

    def instants(self) -> list[int]:
        """Return the times of the last changes, and the time of the end."""
        return self._shown

    @property
    def since_us(self) -> int:
        """Return the time at which the chart begins."""
        return self._shown[0]


def chart_of(cell: Cell) -> str:
    """Return the chart of the end of a run as text, below a line with its time range."""
    chart = LastChanges(cell)
    width = max(_WIDTH[0], min(shutil.get_terminal_size((100, 24)).columns, _WIDTH[1]))
    out = sys.__stdout__
    plain = not draws((out.encoding if out is not None else "") or "utf-8")
    trace = cell.trace.header
    head = (
        f"{format_us(chart.since_us)} to {format_us(cell.now_us)}, the end of the test "
        f"(scan {cell.scans}); scan {format_us(cell.timing.scan_us)}, engine {trace['engine']}, "
        f"link {trace['link']}, seed {trace['seed']}"
    )
    return f"{head}\n\n{text_chart(chart, width, ascii_only=plain)}"


def state_of(cell: Cell) -> str:
    """Return variables of the programs, blocks that are busy or in error, and robot tasks.

    Variables with structures and blocks as types are left out.

    A task is shown with its line if the robot program has source text.
    """
    return "\n".join([*_state(cell), *_tasks(cell)])


def watched_of(cell: Cell) -> str:
    """Return the watched variables, one per line."""
    return "\n".join(f"{path} = {value}" for path, value in cell.watched().items())


def broken_rules(cell: Cell) -> str:
    """Return the broken rules, one per line, each with its time."""
    shown = [f"{format_us(one.t_us):>14}  {one.text}" for one in cell.violations[:_MOST_RULES]]
    rest = len(cell.violations) - _MOST_RULES
    return "\n".join([*shown, f"... and {rest} more"] if rest > 0 else shown)


def write_files(cell: Cell, folder: Path, title: str, suffix: str = "") -> list[Path]:
    """Write chart, trace and page into a folder, and replace the files of an earlier run.

    Trace and page contain the records in memory: the latest 40,000, about two minutes.
    """
    names = (f"chart{suffix}.svg", f"trace{suffix}.jsonl", f"view{suffix}.html")
    chart, trace, page = (folder / name for name in names)
    lines = "".join(line + "\n" for line in cell.trace.lines())
    drawn = svg_chart(LastChanges(cell), title)
    view = View(cell.trace.header)
    for record in cell.trace:
        view.take(record)
    contents = {chart: drawn, trace: lines, page: view.page(title)}
    replace_files(contents)
    return list(contents)


def _state(cell: Cell) -> Iterator[str]:
    for name, kind in cell.program.instances().items():
        assert isinstance(kind, BlockType)
        for variable in kind.variables:
            path = f"{name}.{variable.name}"
            if isinstance(variable.type, (ElementaryType, EnumType)):
                yield f"{path} = {_shown(cell, path, variable.type)}"
            elif isinstance(variable.type, BlockType):
                yield from _block(cell, path, variable.type)


def _tasks(cell: Cell) -> Iterator[str]:
    """Yield a line for each task: `robot task 1: PLACE:4 WAIT SI(20)=1`."""
    for number, (robot, programs) in enumerate(zip(cell.robots, cell.trace.programs, strict=True)):
        who = f"controller {number + 1}, " if number else ""
        for task in task_places(robot) if programs else ():
            text = task_text(task, statement_of(programs, task))
            yield f"{who}robot task {task['task']}: {text}"


def _block(cell: Cell, path: str, kind: BlockType) -> Iterator[str]:
    pins = {variable.name for variable in kind.variables}
    if "ErrorID" in pins and cell[f"{path}.ErrorID"]:
        yield f"{path}: {error_text(cell.program, path, kind)}"
    elif "Busy" in pins and cell[f"{path}.Busy"]:
        yield f"{path}: busy"


def _shown(cell: Cell, path: str, kind: ElementaryType | EnumType) -> str:
    value = cell[path]
    if kind == ElementaryType("WORD"):
        number = int(str(value))
        about = f" ({error_names()[number]})" if number in error_names() else ""
        return f"16#{number:04X}{about}"
    return str(value)
