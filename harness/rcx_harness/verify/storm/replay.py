"""A failing run as a stimulus file that `rcx run` replays, and the result of that replay."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

from rcx_harness.cell.stimulus import Entry, Stimulus, stimulus_text
from rcx_harness.robot import Violation
from rcx_harness.trace.chart import Band, Lane, Timeline
from rcx_harness.trace.chart_svg import svg_chart
from rcx_harness.verify.properties import Judge
from rcx_harness.verify.storm.cells import Cells
from rcx_harness.verify.storm.course import Course
from rcx_harness.verify.storm.storms import Failure, kind_of
from structured_text.output.replays import MARK
from structured_text.output.units import format_us

__all__ = ["Replay", "Replayed", "replay", "replay_of"]

#: How many of the latest changes the chart shows: of variables, and of all signals.
_TOLD, _LATEST = 18, 12


@dataclass(frozen=True)
class Replay:
    """A failing run that can be replayed.

    Attributes:
        told: The failure as a sentence.
    """

    text: str
    duration_us: int
    seed: int
    kind: str
    told: str

    @property
    def lines(self) -> int:
        """Return the number of lines of the stimulus file."""
        return self.text.count("\n")


@dataclass(frozen=True)
class Replayed:
    """The result of a replay: the broken rules and conditions, and the chart (SVG)."""

    found: tuple[str, ...]
    chart: str


def replay_of(
    done: Sequence[Entry], failure: Failure, expect: str, seed: int, scan_us: int
) -> Replay:
    """Return the replay of a run that has failed.

    `expect` is the condition that did not hold. It is empty if the run reports the failure itself.
    """
    entries = sorted((one for one in done if one.t_us <= failure.t_us), key=lambda one: one.t_us)
    after_us = failure.t_us + min(1_000, scan_us // 2)
    if expect:
        entries.append(Entry(after_us, expect=(expect,)))
    duration_us = -(-(after_us + scan_us) // 10_000) * 10_000
    told = f"{failure.kind} at {format_us(failure.t_us)}: {failure.text}"
    about = f"{MARK.removeprefix('# ')}{told}"
    return Replay(stimulus_text(entries, about), duration_us, seed, failure.kind, told)


def replay(cells: Cells, one: Replay, stimulus: Stimulus) -> Replayed:
    """Run a replay. The protocol rules, its own expectations and the properties are checked."""
    with cells.cell(one.seed) as cell:
        told_of = Course(cell, cells.demands).paths(one.kind)
    inputs = [path for entry in stimulus.entries for path in entry.values]
    watch = list(dict.fromkeys([*inputs, *told_of]))
    with cells.cell(one.seed, watch=watch) as cell:
        timeline = _Ending(cell.trace)
        cell.trace.listen(timeline.take)
        found: list[str] = []
        Judge(cell, cells.demands.properties, partial(_kept, found))
        stimulus.schedule(cell)
        cell.run(one.duration_us)
        found += [_kind(violation) for violation in cell.violations]
        title = one.told[: one.told.index(": ", len(one.kind))]
        return Replayed(tuple(found), svg_chart(timeline, title))


class _Ending(Timeline):
    """The chart of the end of a run.

    Inputs of the operator and variables of the property come first.
    """

    def lanes(self) -> list[Lane]:
        """Return the lanes of the chart. Variables come first."""
        variables = self._variables.lanes()
        names = {lane.name for lane in variables}
        return [*variables, *(lane for lane in super().lanes() if lane.name not in names)]

    def instants(self) -> list[int]:
        """Return the times of the latest changes: of variables, and of all signals."""
        of_variables = {t_us for lane in self._variables.lanes() for t_us, _ in lane.changes}
        return sorted({*sorted(of_variables)[-_TOLD:], *super().instants()[-_LATEST:]})

    def bands(self, widths: Sequence[int], room: int) -> list[Band]:
        """Return the bands. Signals that are constant in a band are left out of it."""

        def told(lane: Lane, band: Band) -> bool:
            return lane.always or lane.kind == "word" or any(map(lane.changes_at, band.instants))

        return [
            replace(band, lanes=tuple(lane for lane in band.lanes if told(lane, band)))
            for band in super().bands(widths, room)
        ]


def _kept(found: list[str], kind: str, text: str) -> None:
    found.append(kind)


def _kind(violation: Violation) -> str:
    return "expect" if violation.rule == "expect" else kind_of(violation)
