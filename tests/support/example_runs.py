"""The examples as their README runs them, and their traces as recorded from matiec."""

from __future__ import annotations

import json
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from plc_bench import ROOT
from rcx_harness.cell import Cell
from rcx_harness.stimulus import Stimulus

__all__ = ["EXAMPLES", "SECONDS", "Example", "changes"]

#: How long the examples run, in virtual time.
SECONDS = 3

_TRACES = ROOT / "tests/data/traces/examples"


@dataclass(frozen=True)
class Example:
    """One folder of plc/examples with the options of its command in the README there."""

    folder: Path
    options: dict[str, str]

    def build(self, engine: str = "auto", link: str = "direct", trace: Path | None = None) -> Cell:
        """A cell as `rcx run` makes it, with the stimulus queued."""
        robot = self.options.get("robot")
        cell = Cell.build(
            sorted(self.folder.glob("*.st")),
            engine=engine,
            link=link,
            size=int(self.options.get("size", 48)),
            m=int(self.options.get("m", 0)),
            n=int(self.options.get("n", 0)),
            robot=None if robot is None else ROOT / robot,
            trace=trace,
        )
        Stimulus.load(self.folder / "stimulus.toml").schedule(cell)
        return cell

    @property
    def recorded(self) -> Path:
        """Where its trace, recorded from matiec, is kept."""
        return _TRACES / f"{self.folder.name}.jsonl"


def changes(trace: Path) -> Iterator[str]:
    """The lines of a trace that show anything new, without the first one."""
    before: dict[str, object] = {}
    for line in trace.read_text(encoding="utf-8").splitlines()[1:]:
        entry = json.loads(line)
        kind = next(key for key in ("scan", "cycle", "violation") if key in entry)
        shown = [value for key, value in entry.items() if key not in ("t_us", kind)]
        if kind == "violation" or before.get(kind) != shown:
            yield line
        before[kind] = shown


def _examples() -> Iterator[Example]:
    readme = (ROOT / "plc/examples/README.md").read_text(encoding="utf-8")
    for line in readme.splitlines():
        if "`rcx run " in line:
            words = shlex.split(line.split("`")[1])
            options = {
                word.removeprefix("--"): words[at + 1]
                for at, word in enumerate(words)
                if word.startswith("--")
            }
            yield Example((ROOT / words[2]).parent, options)


EXAMPLES = list(_examples())
