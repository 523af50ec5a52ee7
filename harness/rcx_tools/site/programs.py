"""Programs of the playground: every example of plc/examples, and the example of each block."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

from rcx_harness.cell.stimulus import Entry, Stimulus, entry_text
from rcx_tools.docs.blocks.examples import START_US, program, snippets
from rcx_tools.docs.examples import ROOT, Example, chart_specs, examples
from structured_text.output.units import parse_us

__all__ = ["FIRST", "ROOT", "bake_job", "block_jobs", "example_jobs", "programs_json"]

#: First program of the playground. play.js also contains the name.
FIRST = "04_scara"
#: Scan time for a configuration without a scan time [us].
_SCAN_US = 10_000
#: Run time after the last event in a block's example [us].
_BLOCK_US = 1_000_000
_TICK = re.compile(r"INTERVAL\s*:=\s*T(?:IME)?#(\w+)", re.IGNORECASE)
_SCARA, _SCARA_US = ROOT / "plc/examples/04_pick_and_place/scara.toml", 4_000_000
_ROBOT = ROOT / "docs/reference/blocks/programs/robot.toml"


def bake_job() -> str:
    """Return the first job of the playground in the form in which its page requests it."""
    job = example_jobs()[FIRST]
    times = {key: f"{job[key]}us" for key in ("scan", "for")}
    return json.dumps({**job, **times, "rpi": "10000us", "name": job["title"]})


def programs_json() -> str:
    """Return all programs as JSON: jobs for `drive.Runner`, with times in microseconds."""
    every = {"examples": example_jobs(), "blocks": block_jobs()}
    return json.dumps(every, ensure_ascii=False, separators=(",", ":"))


def example_jobs() -> dict[str, dict[str, Any]]:
    """Return the examples by name. The first program of the playground comes first."""
    every = {name: _example(one) for name, one in examples().items()}
    arm = {"title": "Pick and place with a SCARA robot", "robots": [_text(_SCARA)]}
    return {FIRST: {**every["04_pick_and_place"], **arm, "for": _SCARA_US}, **every}


@cache
def block_jobs() -> dict[str, dict[str, Any]]:
    """Return the examples of the blocks' pages, by the name of the block.

    Examples with robot programs in files are left out.
    """
    found = {}
    for name, snippet in snippets().items():
        if snippet.robot != _ROBOT.name:
            continue  # the example consists of several files
        moments = _moments(Stimulus.load(snippet.stimulus_path).entries)
        last = max([START_US, *(t_us for t_us, _ in moments)])
        found[name] = {
            "title": name,
            "files": {snippet.path.name: program(snippet)},
            "robots": [_text(_ROBOT)],
            "stimulus": moments,
            "scan": _SCAN_US,
            "for": last + _BLOCK_US,
            "size": snippet.size,
        }
    return found


def _example(one: Example) -> dict[str, Any]:
    sources = sorted([*one.folder.glob("*.st"), *one.folder.glob("*.PGM")])
    files = {file.name: _text(file) for file in sources}
    tick = _TICK.search("".join(files.values()))
    options = one.options
    job: dict[str, Any] = {
        "title": chart_specs()[one.name].title,
        "files": files,
        "robots": [_text(ROOT / file) for file in options.get("robot", [])],
        "stimulus": _moments(Stimulus.load(one.folder / "stimulus.toml").entries),
        "scan": parse_us(tick[1]) if tick else _SCAN_US,
        "for": parse_us(one.duration),
    }
    if "size" in options:
        job["size"] = int(options["size"][0])
    job |= {key: [int(at) for at in options[key]] for key in ("m", "n") if key in options}
    return job


def _moments(entries: Iterable[Entry]) -> list[tuple[int, str]]:
    """Return the entries of a stimulus as pairs of a time and the other keys as TOML."""
    found = []
    for entry in sorted(entries, key=lambda one: one.t_us):
        rest = re.sub(r'^\{ time = "\w+"(?:, )?', "", entry_text(entry)).removesuffix(" }")
        found.append((entry.t_us, rest))
    return found


def _text(file: Path) -> str:
    return file.read_text(encoding="utf-8")
