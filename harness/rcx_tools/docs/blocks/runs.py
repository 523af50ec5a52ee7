"""The run of an example in the virtual cell: outputs of the block, times, and signal changes."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from rcx_harness.cell import Cell
from rcx_harness.cell.stimulus import Stimulus
from rcx_harness.trace.chart import Lane, Timeline
from rcx_tools.docs.blocks.examples import FOLDER, START_US, Snippet, program, snippets, stimulus
from rcx_tools.docs.blocks.source import CONTRACT
from rcx_tools.docs.blocks.tracks import DRAWN, not_too_many, tracks_of
from rcx_tools.docs.examples import ChartSpec, Recorder
from structured_text.errors import InputError

__all__ = ["Run", "run_of", "run_snippet"]


#: Time limit of a run. It is longer than the longest movement of the examples.
_LONGEST_US = 20_000_000
#: If a block does not end, a run continues for this time after the start, else after its end.
_AFTER_US = 300_000
#: A chart with a linear time axis begins this time before the start of the block.
_BEFORE_US = 100_000

#: WORD pins that are not shown, because a BOOL pin or a table of the page shows their value.
_NUMBERS = ("ErrorID", "AlarmGroup", "AlarmCategory", "Code")
#: Order of the PLCopen outputs in a chart. They are below the inputs.
_ORDER = {"Busy": 2, "Active": 3, "Done": 4, "Valid": 4, "Error": 5}


@dataclass(frozen=True)
class Run:
    """The result of a run of an example.

    Attributes:
        snippet: The example.
        lanes: The signals that changed, in the order of the chart.
        left_out: Addresses of words that changed but are not drawn.
        outputs: The block's own outputs at the end, by name.
        took_us: Time from the start of the block to its end. None for a block without a start
            input.
        seconds: The value of `--for` with which `rcx run` shows the same, as text.
        scaled: Recorder of a chart with a linear time axis. None if the example has no such chart.
    """

    snippet: Snippet
    lanes: tuple[Lane, ...]
    left_out: tuple[str, ...]
    outputs: dict[str, Any]
    took_us: int | None
    seconds: str
    scaled: Recorder | None = None

    @property
    def timeline(self) -> Timeline:
        """Return the lanes of the run as data for a chart."""
        return _Lanes(self.lanes)


class _Lanes(Timeline):
    """A chart of selected lanes that begins at the start of the block."""

    def __init__(self, lanes: Sequence[Lane]) -> None:
        super().__init__()
        self._shown = list(lanes)

    def lanes(self) -> list[Lane]:
        return self._shown

    def instants(self) -> list[int]:
        every = super().instants()
        before = [t_us for t_us in every if t_us < 0]
        held = any(lane.kind == "word" and lane.value_at(-1) for lane in self._shown)
        # If a word is not 0 before the start, its digits need an extra column.
        return [*(before[-1:] if held else []), *(t_us for t_us in every if t_us >= 0)]


@cache
def run_of(name: str, engine: str = "builtin") -> Run:
    """Return the run of a block's example."""
    return run_snippet(snippets()[name], engine=engine)


def run_snippet(snippet: Snippet, *, engine: str = "builtin") -> Run:
    """Generate an example and run it until its block has ended.

    Raises:
        InputError: the block does not end as described on its page, or a rule is broken.
    """
    files = (snippet.path, snippet.stimulus_path)
    texts = (program(snippet), stimulus(snippet))
    if all(map(_has, files, texts)):
        return _run(snippet, *files, engine)  # an unchanged file stays compiled in a cache
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder, snippet.path.name), Path(folder, "stimulus.toml")
        for file, text in zip(made, texts, strict=True):
            file.write_text(text, encoding="utf-8")
        return _run(snippet, *made, engine)


def _has(file: Path, text: str) -> bool:
    """Return whether the file exists and contains exactly this text."""
    return file.is_file() and file.read_text(encoding="utf-8") == text


def _run(snippet: Snippet, source: Path, events: Path, engine: str) -> Run:
    pins = [pin for pin in snippet.pou.pins if pin.section != "VAR_IN_OUT"]
    instance = snippet.call.instance if snippet.call else snippet.pou.name.removeprefix("FB_")
    shown = [pin for pin in pins if pin.type in DRAWN and pin.name not in _NUMBERS]
    shown.sort(key=lambda pin: _ORDER.get(pin.name, 1 if pin.section == "VAR_OUTPUT" else 0))
    flags = [f"Main.{instance}.{pin.name}" for pin in shown]
    flags += [one for one in snippet.show if one.startswith("Main.") and one not in flags]
    size = snippet.size
    recorder = Recorder(ChartSpec(snippet.pou.name, 0, 0, snippet.lanes)) if snippet.lanes else None
    watch = [*flags, *(recorder.watch if recorder else ())]
    robot = FOLDER / "programs" / snippet.robot
    with Cell.build(source, engine=engine, robot=robot, size=size, watch=watch) as cell:
        tracks = list(tracks_of(snippet, flags))
        if recorder:
            recorder.listen(cell)
        for track in tracks:
            cell.trace.listen(track.take)
        Stimulus.load(events).schedule(cell)
        begin, end = _until_end(snippet, cell, f"Main.{instance}")
        outputs = _outputs(snippet, cell, f"Main.{instance}")
        cell.run(_AFTER_US)
        stop = snippet.stop and max(entry.t_us for entry in Stimulus.load(events).entries)
        if stop and cell.now_us < stop + _AFTER_US:
            cell.run(stop + _AFTER_US - cell.now_us)
        if snippet.last:
            outputs = _outputs(snippet, cell, f"Main.{instance}")
        if cell.violations:
            raise InputError(f"{snippet.pou.name}: {cell.violations[0].text}", file=snippet.path)
        if (
            snippet.pou.pin("Error")
            and cell[f"Main.{instance}.Error"]
            and "Error" not in _may(snippet)
        ):
            raise _failed(snippet, cell, f"Main.{instance}")
        last = cell.now_us
    few, left_out = not_too_many([track for track in tracks if track.changed(begin, last)])
    lanes = tuple(track.lane_of(begin) for track in few)
    took = end - begin if snippet.pou.pin("Execute") or snippet.pou.pin("Enable") else None
    seconds = f"{-(-last // 500_000) / 2:g}s"
    if recorder:
        recorder.spec = replace(recorder.spec, begin_us=begin - _BEFORE_US, end_us=last)
    return Run(snippet, lanes, tuple(left_out), outputs, took, seconds, recorder)


def _may(snippet: Snippet) -> tuple[str, ...]:
    """Return the outputs that may be TRUE at the end.

    Error is one of them if the example cuts the link.
    """
    return ("Error",) if any("link_down" in str(event) for event in snippet.events) else ()


def _until_end(snippet: Snippet, cell: Cell, path: str) -> tuple[int, int]:
    """Run until the block has ended. Return the times of its start and end [us]."""
    pou = snippet.pou
    starts = "Execute" if pou.pin("Execute") else "Enable" if pou.pin("Enable") else ""
    ends = "Done" if pou.pin("Done") else "Valid"
    if not starts:
        cell.run(START_US + _AFTER_US)
        return (START_US if snippet.before else 0), cell.now_us
    begin = 0
    while cell.now_us < _LONGEST_US:
        cell.scan()
        if not begin and cell[f"{path}.{starts}"]:
            begin = cell.now_us
        if begin and cell[f"{path}.{ends}"]:
            end = cell.now_us
            if ends == "Valid":
                cell.run(100_000)
            return begin, end
        for step in snippet.before:
            if step.end != "Error" and cell[f"Main.{step.instance}.Error"]:
                raise _failed(snippet, cell, f"Main.{step.instance}")
        if cell[f"{path}.Error"]:
            raise _failed(snippet, cell, path)
    raise InputError(f"{pou.name} is still busy after 20 s", file=snippet.path)


def _failed(snippet: Snippet, cell: Cell, path: str) -> InputError:
    text = f"{snippet.pou.name}: {path} ends with ErrorID 16#{cell[path + '.ErrorID']:04X}"
    with suppress(InputError):
        text += f", alarm {cell[path + '.AlarmGroup']}.{cell[path + '.AlarmCategory']}"
    return InputError(text, file=snippet.path)


def _outputs(snippet: Snippet, cell: Cell, path: str) -> dict[str, Any]:
    own = [pin.name for pin in snippet.pou.of("VAR_OUTPUT") if pin.name not in CONTRACT]
    shown = [name for name in own if name not in ("AlarmGroup", "AlarmCategory")]
    return {name: cell[f"{path}.{name}"] for name in shown}
