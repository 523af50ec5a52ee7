"""The examples of plc/examples, run as their README says, and generators of their charts.

plc/examples/charts.toml lists the signals of each chart. Their values come from a run. The module
needs the repository and does not work in an installed package.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cache, partial
from html import escape
from itertools import pairwise
from pathlib import Path
from typing import Any

from rcx_harness.cell import Cell
from rcx_harness.cell.stimulus import Stimulus
from rcx_harness.robot import Controller
from rcx_harness.robot.ports import port
from rcx_harness.spec import signals
from rcx_harness.trace import Cycle, Record, Scan, Violation
from rcx_harness.trace.chart import Lane
from rcx_harness.trace.chart_svg import CURVE, STYLE, Look, Scale, document, draw_lane, rule, text
from structured_text.errors import InputError
from structured_text.output.toml_files import load_toml
from structured_text.output.units import parse_us

__all__ = ["FOLDER", "ChartSpec", "Example", "Recorder", "chart_specs", "example_chart", "examples"]
__all__ += ["files"]

ROOT = Path(__file__).resolve().parents[3]
FOLDER = ROOT / "plc/examples"

_DURATION = "5s"
_LANE = re.compile(r"(?:(\d):)?(.*)")

_WIDTH, _ROW, _TOP = 1080, 28, 44
_LETTER = 7.3
#: Possible distances of two time marks [us]. The first distance with at most `_MOST_MARKS` marks is
#: used.
_MARKS = (50_000, 100_000, 200_000, 500_000, 1_000_000, 2_000_000, 5_000_000)
_MOST_MARKS = 12
_STYLE = (
    STYLE + ".b{font-size:10.5px;text-anchor:middle}.m{font-size:10px;fill:#777}"
    ".e{text-anchor:end}.h{font-weight:bold;font-size:15px}"
)
_LOOK = Look(edge=0)
_ORIGIN = "<!-- generated from plc/examples/charts.toml and a run of the example; do not edit -->"


@dataclass(frozen=True)
class Example:
    """One example: a folder of plc/examples, with the options of its command in the README."""

    folder: Path
    options: dict[str, list[str]]

    @property
    def name(self) -> str:
        """Return the name of the example, such as `01_power_up`."""
        return self.folder.name

    @property
    def duration(self) -> str:
        """Return the virtual time for which the command in the README runs."""
        return self.options.get("for", [_DURATION])[0]

    def build(
        self,
        engine: str = "auto",
        link: str = "direct",
        *,
        program: Sequence[Path] | None = None,
        lib: Path | None = None,
        watch: Sequence[str] = (),
        robot: Sequence[Path] | None = None,
    ) -> Cell:
        """Return a cell like that of `rcx run`, with the stimulus queued.

        Args:
            engine: See `Cell.build`, also for `link`, `lib` and `watch`.
            link: Kind of the network.
            program: Files to use instead of the files in the folder.
            lib: Folder of the library.
            watch: Variables for the trace.
            robot: Robot files to use instead of those of the command.
        """
        options = self.options
        if robot is None and "robot" in options:
            robot = [ROOT / file for file in options["robot"]]
        cell = Cell.build(
            sorted(self.folder.glob("*.st")) if program is None else program,
            lib=lib,
            engine=engine,
            link=link,
            size=int(options["size"][0]) if "size" in options else None,
            m=[int(value) for value in options.get("m", [])],
            n=[int(value) for value in options.get("n", [])],
            robot=robot,
            watch=watch,
        )
        Stimulus.load(self.folder / "stimulus.toml").schedule(cell)
        return cell


@cache
def examples() -> dict[str, Example]:
    """Return the examples by name, one for each line of the README that begins with `rcx run`."""
    found = {}
    for line in (FOLDER / "README.md").read_text(encoding="utf-8").splitlines():
        if line.startswith("rcx run "):
            words = shlex.split(line)
            options: dict[str, list[str]] = {}
            for word, value in pairwise(words):
                if word.startswith("--"):
                    options.setdefault(word[2:], []).append(value)
            folder = (ROOT / words[2]).parent
            found[folder.name] = Example(folder, options)
    return found


@dataclass(frozen=True)
class ChartSpec:
    """One entry of charts.toml.

    Attributes:
        title: Title above the chart.
        begin_us: Start of the chart, in the time of the run.
        end_us: End of the chart.
        lanes: Lanes as written in charts.toml, from top to bottom.
    """

    title: str
    begin_us: int
    end_us: int
    lanes: tuple[str, ...]


@cache
def chart_specs() -> dict[str, ChartSpec]:
    """Return the entries of charts.toml, by the name of the example.

    Raises:
        InputError: the file cannot be read, or an entry is wrong.
    """
    file = FOLDER / "charts.toml"
    found = {}
    for name, entry in load_toml(file).items():
        try:
            begin, end = parse_us(entry["begin"]), parse_us(entry["end"])
            found[name] = ChartSpec(entry["title"], begin, end, tuple(entry["lanes"]))
        except (KeyError, TypeError) as error:
            raise InputError(f"{name!r} is not complete: {error}", file=file) from None
    return found


@cache
def example_chart(name: str) -> str:
    """Return the chart of an example, from a run on the built-in engine.

    Raises:
        InputError: the run broke a rule, or a lane does not name a signal.
    """
    example, recorder = examples()[name], Recorder(chart_specs()[name])
    with example.build("builtin", watch=recorder.watch) as cell:
        recorder.listen(cell)
        cell.run(example.duration)
    return recorder.chart()


def files() -> dict[str, Callable[[], str]]:
    """Return the generators of the charts, by their path in the repository."""
    return {
        f"plc/examples/{name}/chart.svg": partial(example_chart, name) for name in chart_specs()
    }


@dataclass
class Recorder:
    """Observer that records the lanes of a chart during a run."""

    spec: ChartSpec
    watch: list[str] = field(init=False)
    """Variables that the cell must watch."""

    def __post_init__(self) -> None:
        """Find the signals of all lanes. Raise InputError if a signal does not exist."""
        self._lanes = [_Signal(lane) for lane in self.spec.lanes]
        self.watch = [lane.signal for lane in self._lanes if lane.signal.startswith("Main.")]

    def listen(self, cell: Cell) -> None:
        """Record the lanes of this cell from now on."""
        cell.trace.listen(lambda record: self._take(cell, record))

    @property
    def lanes(self) -> list[Lane]:
        """Return the recorded lanes, in the order of the chart."""
        return [one.lane for one in self._lanes]

    def chart(self, origin: str = _ORIGIN) -> str:
        """Return the recorded lanes as an SVG picture with a linear time axis.

        Args:
            origin: Comment that names the source of the picture.
        """
        lanes = self.lanes
        left = 30 + round(_LETTER * max(len(lane.name) for lane in lanes))
        axis = Scale(left, _WIDTH - 12, self.spec.begin_us, self.spec.end_us)
        body: list[str] = []
        top = _TOP + 24
        for lane in lanes:
            high = CURVE + 14 if lane.kind == "curve" else _ROW
            body.append(rule("r", 8, top + high, axis.right, top + high))
            body.append(text(12, top + high / 2 + 5, lane.name))
            body += draw_lane(lane, axis, top + high - 6, _LOOK)
            top += high
        marks = [text(12, 24, self.spec.title, "h"), text(12, _TOP + 12, "time [s]", "m")]
        for t_us, x in axis.round_times(_MARKS, _MOST_MARKS):
            marks.append(text(x, _TOP + 12, f"{t_us / 1e6:g}", "t"))
            marks.append(rule("g", x, _TOP + 18, x, top))
        title = f"<title>{escape(self.spec.title)}</title>"
        return document(_WIDTH, top + 12, _STYLE, [*marks, *body], [title, origin])

    def _take(self, cell: Cell, record: Record) -> None:
        if isinstance(record, Violation):
            raise InputError(f"{self.spec.title}: {record.text}")
        for lane in self._lanes:
            lane.take(cell, record)


class _Signal:
    """A signal with its lane: `SIGNAL = label`, `curve SIGNAL = label`, `stage SIGNAL = label`.

    A signal is `Main.X`; `SI01` or `SO02` as the PLC writes or reads it; `axis 1`, the position of
    an axis [pulses]; a port of the controller such as `DO(20)`; or `button`, the hard-wired
    emergency stop of the controller. The prefix `2:` selects the second controller.
    """

    def __init__(self, text: str) -> None:
        name, _, label = (part.strip() for part in text.partition("="))
        word, _, rest = name.partition(" ")
        kind, name = (word, rest) if word in ("curve", "stage") else ("", name)
        match = _LANE.fullmatch(name)
        assert match is not None
        self.signal, self._controller = match[2], int(match[1] or 1)
        self._level: Callable[[Scan], Any] | None = None
        self._state: Callable[[Controller], Any] | None = None
        default = self._find(self.signal)
        self.lane = Lane(label or self.signal, kind or default)

    def take(self, cell: Cell, record: Record) -> None:
        """Record a change. The state of the controller is read after each controller cycle."""
        if isinstance(record, Violation) or record.controller != self._controller:
            return
        if self._level is not None and isinstance(record, Scan):
            self.lane.note(record.t_us, self._level(record))
        elif self._state is not None and isinstance(record, Cycle):
            self.lane.note(record.t_us, self._state(cell.robots[self._controller - 1]))

    def _find(self, name: str) -> str:
        if name.startswith("Main."):
            self._level = lambda scan: (scan.vars or {})[name]
            return "variable"
        if name.startswith("axis "):
            axis = int(name[5:]) - 1
            self._state = lambda robot: robot.positions[axis]
            return "curve"
        if name == "button":
            self._state = lambda robot: robot.machine.hard_wired_stop
            return "event"
        if "(" in name:
            place = port(name)
            self._state = lambda robot: robot.machine.ports.read(place)
            return "output"
        row = signals().find(name)
        byte, bit, out = row.byte, row.bit, row.short.startswith("SO")
        self._level = lambda scan: (scan.so if out else scan.si)[byte] >> bit & 1
        return "output" if out else "input"
