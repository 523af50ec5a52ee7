"""Measured figures, as a table and as JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from rich import box
from rich.table import Table

__all__ = ["OUT_OF_REACH", "Figure", "Options", "as_table", "at_least", "at_most", "percentile"]
__all__ += ["shown", "store"]

NO_TARGET = "none"
#: Suffix of `peer` for a target that cannot be met (reason: docs/explanation/timing.md).
OUT_OF_REACH = "; out of reach: docs/explanation/timing.md"


@dataclass(frozen=True)
class Figure:
    """One row of out/bench.json.

    Attributes:
        value: The measured value. None if a required tool is missing. `peer` then names the tool.
        unit: Unit of the value. For a count, the counted items.
        target: Target as text; `none` for a figure without a target.
        peer: A measurement in the same run for comparison, or the method of measurement.
        met: Whether the value meets the target. For a figure without a target this is True.
    """

    value: float | None
    unit: str
    target: str = NO_TARGET
    peer: str = NO_TARGET
    met: bool = True

    @property
    def missed(self) -> bool:
        """Return whether the figure misses a target that can be met."""
        return not self.met and not self.peer.endswith(OUT_OF_REACH)


@dataclass(frozen=True)
class Options:
    """The extent of the measurements.

    Attributes:
        seconds: Length of each run in real time.
        rpi_us: Packet intervals of cyclic I/O [us].
        quick: Whether to take only a few samples, to check that the benchmark works.
    """

    seconds: float = 10.0
    rpi_us: tuple[int, ...] = (10_000, 5_000, 2_000, 1_000)
    quick: bool = False


def at_least(value: float, unit: str, least: float, peer: str = NO_TARGET) -> Figure:
    """Return a figure with a target: the value must be at least `least`."""
    return Figure(_rounded(value), unit, f">= {least:g}", peer, value >= least)


def at_most(value: float, unit: str, most: float, peer: str = NO_TARGET) -> Figure:
    """Return a figure with a target: the value must be at most `most`."""
    target = f"<= {most:g}" if most else "0"
    return Figure(_rounded(value), unit, target, peer, value <= most)


def shown(value: float, unit: str, peer: str = NO_TARGET) -> Figure:
    """Return a figure without a target."""
    return Figure(_rounded(value), unit, peer=peer)


def missing(unit: str, target: str, why: str) -> Figure:
    """Return a figure that cannot be measured on this machine."""
    return Figure(None, unit, target, why, met=False)


def as_table(figures: Mapping[str, Figure]) -> Table:
    """Return a table of the figures and their targets."""
    table = Table(box=box.SIMPLE, pad_edge=False)
    table.add_column("figure", no_wrap=True)
    table.add_column("value", justify="right", no_wrap=True)
    table.add_column("unit", no_wrap=True)
    for name in ("target", "met", "measured beside"):
        table.add_column(name)
    for name, one in figures.items():
        met = "" if one.target == NO_TARGET else "yes" if one.met else "NO"
        peer = "" if one.peer == NO_TARGET else one.peer
        target = "" if one.target == NO_TARGET else one.target
        value = "-" if one.value is None else f"{one.value:,g}"
        table.add_row(name, value, one.unit, target, met, peer)
    return table


def store(figures: Mapping[str, Figure], file: Path) -> None:
    """Write figures to a JSON file. Other figures in the file stay unchanged."""
    known: dict[str, object] = {}
    if file.is_file():
        try:
            known = json.loads(file.read_text(encoding="utf-8"))
        except ValueError:
            known = {}
        if not isinstance(known, dict):
            known = {}
    known |= {name: asdict(one) for name, one in figures.items()}
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(json.dumps(known, indent=1) + "\n", encoding="utf-8")


def percentile(values: Sequence[int], share: float) -> int:
    """Return a percentile: the value that the given share of all values does not exceed.

    Without values the result is 0.
    """
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(len(ordered) * share))] if ordered else 0


def _rounded(value: float) -> float:
    """Return the value, rounded to four digits. Whole numbers are not rounded."""
    return value if isinstance(value, int) or value == int(value) else float(f"{value:.4g}")
