"""The shortest path to a broken rule, written as a stimulus file and run in a cell."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from rcx_harness.cell.cell import Cell
from rcx_harness.cell.compiled import Compiled
from rcx_harness.cell.stimulus import Entry, Stimulus
from rcx_harness.robot import RobotConfig
from rcx_harness.verify.explore.user import Choice, Explored, Settings
from rcx_harness.verify.replay import replayed
from structured_text.bench import Bench
from structured_text.bench.stimulus import Stimulus as PlcStimulus
from structured_text.errors import InputError
from structured_text.projects.sources import SourceFiles

__all__ = ["replay"]


def replay(
    sources: SourceFiles, explored: Explored, settings: Settings, folder: Path
) -> tuple[Path, bool]:
    """Write the stimulus of a broken rule and its chart, and run it in a cell.

    Returns:
        The stimulus file, and whether the run shows the same broken rules. A cell cannot check the
        conditions of `always` and the assertions in comments; only the exploration can.
    """
    broken = explored.result.broken
    assert broken is not None
    stimulus, chart = folder / "broken.toml", folder / "broken.svg"
    told = [f"{k * settings.scan_us // 1000} ms: {one.tell()}" for k, one in enumerate(broken.path)]
    areas = explored.areas if settings.robot else [None] * len(broken.path)

    def made() -> Bench:
        given: dict[str, Any] = {"engine": "builtin", "scan": settings.scan_us}
        if settings.robot:
            given |= {"robot": RobotConfig(size=settings.size), "m": settings.m, "n": settings.n}
            return Cell.build(Compiled(sources, given.pop("engine")), **given)
        paths = [one.path for one in broken.path if one.path]  # inputs that change
        return Bench.build(sources, watch=paths, **given)

    with replayed(
        made,
        _entries(broken.path, areas, settings.scan_us),
        "\n".join([*broken.rules, "broken in the last scan of:", *told]),
        stimulus,
        chart,
        properties=settings.properties,
        kind=Stimulus if settings.robot else PlcStimulus,
    ) as cell:
        stopped = ""
        try:
            cell.scan(len(broken.path))
        except InputError as error:
            stopped = f"stops: {error}"
        shown = [stopped, *(one.text.partition(": ")[2] for one in cell.violations)]
    return stimulus, all(rule in shown for rule in broken.rules)


def _entries(
    path: Sequence[Choice], areas: Sequence[tuple[bytes, bool] | None], scan_us: int
) -> Iterator[Entry]:
    """Yield the changes before each scan of a path."""
    before: tuple[bytes, bool] | None = None
    for number, (choice, area) in enumerate(zip(path, areas, strict=True)):
        values = {choice.path: choice.value} if choice.path else {}
        content, connected = (None, True) if area is None or area == before else area
        if values or content is not None:
            yield Entry(number * scan_us, values=values, area=content, connected=connected)
        before = area
