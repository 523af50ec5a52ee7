"""Scans until planted faults are found: `rcx campaign` with `--guided`, compared with drawn storms.

The faults are those of tests/data/planted. Each search ends at its first failure of the property
that the fault breaks, and is stopped after `_MOST` scans.
"""

from __future__ import annotations

import shutil
import statistics
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rcx_harness.verify.guided.branch import Guided
from rcx_harness.verify.guided.corpus import Corpus, guided
from rcx_harness.verify.storm.campaign import Storms, storms
from rcx_harness.verify.storm.cells import CellsOf
from rcx_tools.bench.figure import Figure, Options, at_most, shown
from structured_text.errors import InputError
from structured_text.farm import Farm
from structured_text.output.toml_files import load_toml

__all__ = ["measure"]

_PLANTED = Path("tests/data/planted")
#: Number of seeds of each search, and with `quick`.
_SEEDS, _QUICK = 10, 2
#: A search is stopped after this number of scans, and with `quick`.
_MOST, _MOST_QUICK = 100_000, 20_000
#: Distance of the first seeds of two drawn campaigns.
_APART = 1_000
_SCAN_US = 10_000


def measure(options: Options) -> dict[str, Figure]:
    """Measure both searches for each planted fault; the target is half of the drawn scans."""
    faults = load_toml(_PLANTED / "faults.toml")["fault"]
    seeds = range(_QUICK if options.quick else _SEEDS)
    most = _MOST_QUICK if options.quick else _MOST
    figures: dict[str, Figure] = {}
    for fault in faults:
        with tempfile.TemporaryDirectory() as folder:
            cells = _cells(Path(folder), fault)
        breaks = fault["breaks"]
        name = fault["name"].replace(" ", "_")
        drawn = statistics.median(_drawn(cells, breaks, seed, most) for seed in seeds)
        found = statistics.median(_guided(cells, breaks, seed, most) for seed in seeds)
        beside = f"{len(seeds)} seeds, at most {most} scans each"
        figures[f"guided_{name}_drawn"] = shown(drawn, "scans", beside)
        figures[f"guided_{name}"] = at_most(found, "scans", round(drawn / 2), beside)
    return figures


def _cells(folder: Path, fault: Mapping[str, str]) -> CellsOf:
    """Return the cell with a fault in it.

    Raises:
        InputError: the text that the fault replaces does not occur exactly once.
    """
    cell = Path(shutil.copytree(_PLANTED / "cell", folder / "cell"))
    file = folder / fault["file"]
    text = file.read_text(encoding="utf-8")
    if text.count(fault["before"]) != 1:
        raise InputError(f"{fault['name']}: `before` does not occur once", file=file)
    file.write_text(text.replace(fault["before"], fault["after"]), encoding="utf-8")
    options: dict[str, Any] = {"engine": "builtin"}
    options["robot"] = [cell / "robot_a.toml", cell / "robot_b.toml"]
    return CellsOf.of([cell / "plc"], options, [cell / "campaign.toml"])


def _drawn(cells: CellsOf, breaks: str, seed: int, most: int) -> int:
    scans = 0
    seeds = range(seed * _APART, (seed + 1) * _APART)
    for _, one in storms(Farm(0), Storms(cells), seeds):
        at = _found(one.failures, breaks)
        scans += one.scans if at is None else at
        if at is not None or scans >= most:
            break
    return min(scans, most)


def _guided(cells: CellsOf, breaks: str, seed: int, most: int) -> int:
    scans = 0
    for _, one in guided(Farm(0), Guided(cells, seed), most, Corpus(seed)):
        at = _found(one.texts, breaks)
        scans += one.scans if at is None else min(at, one.scans)
        if at is not None or scans >= most:
            break
    return min(scans, most)


def _found(failures: Mapping[str, tuple[int, str]], breaks: str) -> int | None:
    """Return the scan in which the property of a fault was broken; None if it was not."""
    times = [
        t_us
        for kind, (t_us, _) in failures.items()
        if kind == breaks or kind.startswith(f"always {breaks}")
    ]
    return min(times) // _SCAN_US if times else None
