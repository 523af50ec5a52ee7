"""A page of a million scans: how long it takes to write and to open, how smoothly it moves.

A busy cell: the first seconds of example 04, pick and place, again and again, each time to other
places, with positions and variables. Opened by chromium without a window, from the file; moved with
the curves of positions and speeds in view.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from statistics import median
from typing import Any

from rcx_harness import Cell
from rcx_harness.cell.sources import default_lib
from rcx_harness.cell.stimulus import Stimulus
from rcx_harness.trace import Cycle, Record, Violation
from rcx_harness.trace.view.page import View
from rcx_tools.bench.figure import Figure, Options, at_most, missing, shown
from rcx_tools.chromium import MISSING, chromium, is_there, opened

__all__ = ["FRAME_MS", "OPEN_S", "measure", "million"]

_EXAMPLE = default_lib().parent / "examples/04_pick_and_place"
_WATCH = "Main.Carry.*,Main.Cycle.Count"
_SCAN_US, _PERIOD_US = 10_000, 4_000_000
_SCANS = 1_000_000
OPEN_S, FRAME_MS = 3.0, 50.0
#: Presses keys one after the other, each in a frame of its own; gives the lengths of the frames.
_MOVE = """
const done = arguments[arguments.length - 1];
const keys = ["+", "+", "+", "ArrowRight", "ArrowRight", "-", "-", "-", "ArrowLeft", "0"];
const frames = [];
let before = performance.now();
document.getElementById("rows").scrollTop = 1e6;
const next = (now) => {
  frames.push(now - before);
  before = now;
  if (frames.length > 100) return done(frames);
  document.dispatchEvent(new KeyboardEvent("keydown", { key: keys[frames.length % keys.length] }));
  requestAnimationFrame(next);
};
requestAnimationFrame(next);
"""


def measure(options: Options) -> dict[str, Figure]:
    """Time to write, size, time to open, length of a frame; with `quick` of a shorter run."""
    with tempfile.TemporaryDirectory(prefix="rcx-") as folder:
        file = Path(folder) / "view.html"
        begun = time.monotonic()
        file.write_text(million(_SCANS // 100 if options.quick else _SCANS), encoding="utf-8")
        found = {
            "view, written": shown(time.monotonic() - begun, "s", "one run, 1,000,000 scans"),
            "view, size": shown(file.stat().st_size / 1e6, "MB"),
        }
        return found | _opened(file)


def million(scans: int = _SCANS) -> str:
    """The page of so many scans, as HTML."""
    header, records = _recorded()
    view = View(header)
    for record in _again(records, scans * _SCAN_US // _PERIOD_US):
        view.take(record)
    return view.page(f"{scans:,} scans")


def _recorded() -> tuple[dict[str, Any], list[Record]]:
    """Header and records of the example's first seconds."""
    robot = _EXAMPLE / "robot.toml"
    with Cell.build(
        _EXAMPLE, engine="builtin", robot=robot, scan="10ms", watch=_WATCH, positions="mm"
    ) as cell:
        Stimulus.load(_EXAMPLE / "stimulus.toml").schedule(cell)
        cell.run(_PERIOD_US - _SCAN_US // 2)
        return dict(cell.trace.header), list(cell.trace)


def _again(records: Sequence[Record], times: int) -> Iterator[Record]:
    for number in range(times):
        begin_us, further = number * _PERIOD_US, 1 + number % 997 / 1000
        for record in records:
            assert not isinstance(record, Violation)
            record = record._replace(t_us=begin_us + record.t_us)
            if isinstance(record, Cycle) and record.positions is not None:
                where = tuple(round(value * further, 3) for value in record.positions)
                record = record._replace(positions=where)
            yield record


def _opened(file: Path) -> dict[str, Figure]:
    """What chromium needs to open and to move it."""
    open_name, frame_name = "view, opened", "view, frame while zooming and moving"
    if not is_there():
        return {
            open_name: missing("s", f"<= {OPEN_S:g}", MISSING),
            frame_name: missing("ms", f"<= {FRAME_MS:g}", MISSING),
        }
    with chromium() as browser:
        times = [opened(browser, file) / 1000 for _ in range(3)]
        frames = sorted(browser.execute_async_script(_MOVE))
        version = f"chromium {browser.capabilities['browserVersion']}, no GPU"
        peer = f"{version}; the longest of {len(frames)} {frames[-1]:.0f} ms"
        return {
            open_name: at_most(median(times), "s", OPEN_S, f"{version}; median of 3"),
            frame_name: at_most(median(frames), "ms", FRAME_MS, peer),
        }
