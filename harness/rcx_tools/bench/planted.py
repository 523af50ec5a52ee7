"""A cell with five planted faults: does what its README says find each of them, and how soon?

The commands `rcx campaign` and `rcx sweep` are those of tests/data/planted/cell/README.md. They run
on the good cell, and on the cell with each fault; every replay that they leave is run again.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from rcx_harness.verify.storm.replay import MARK
from rcx_tools.bench.figure import Figure, Options, at_least, at_most, shown
from structured_text.errors import InputError
from structured_text.output.system import processors
from structured_text.output.toml_files import load_toml

__all__ = ["FAULTS", "PLANTED", "Fault", "Result", "commands", "found_by", "measure", "planted"]

PLANTED = Path(__file__).resolve().parents[3] / "tests/data/planted"

#: Five minutes on two processors [s of processor time].
_MOST_S = 2 * 5 * 60
_MOST_LINES = 20


@dataclass(frozen=True)
class Fault:
    """One row of faults.toml; `before` stands once in `file`, and becomes `after`."""

    name: str
    file: str
    what: str
    breaks: str
    before: str
    after: str


FAULTS = tuple(Fault(**row) for row in load_toml(PLANTED / "faults.toml")["fault"])


def planted(folder: Path, fault: Fault | None = None) -> Path:
    """Copy the project into a new folder `cell` in `folder`, with the fault in it.

    Returns:
        The project's folder.

    Raises:
        ValueError: `before` does not stand once in the file.
    """
    project = Path(shutil.copytree(PLANTED / "cell", folder / "cell"))
    if fault:
        file = folder / fault.file
        text = file.read_text(encoding="utf-8")
        if text.count(fault.before) != 1:
            raise ValueError(f"{fault.name}: `before` does not stand once in {fault.file}")
        file.write_text(text.replace(fault.before, fault.after), encoding="utf-8")
    return project


class Result(NamedTuple):
    """What the commands have found in a project.

    Attributes:
        told: The failure of each replay.
        lines: How long each is.
        again: Of how many `rcx run` shows it again.
        cpu_s: Processor time of the commands [s].
        wall_s: How long they took.
    """

    told: list[str]
    lines: list[int]
    again: int
    cpu_s: float
    wall_s: float


def measure(options: Options) -> dict[str, Figure]:
    """The good cell, and the cell with each fault."""
    seeds, every = ("3", "400") if options.quick else ("", "")
    asked = [_changed(words, seeds, every) for words in commands()]
    good = _result(None, asked)
    found = {"planted_good_failures": at_most(len(good.told), "failures", 0, "the cell as it is")}
    results = {}
    for fault in FAULTS[-2:-1] if options.quick else FAULTS:
        one = results[fault] = _result(fault, asked)
        peer = f"s of processor time; {', '.join(_kinds(one)) or 'nothing failed'}"
        found[f"planted_{fault.name.replace(' ', '_')}"] = shown(one.cpu_s, "s", peer)
    every_one = list(results.values())
    right = sum(found_by(fault, one.told) for fault, one in results.items())
    replays = sum(len(one.lines) for one in every_one)
    again = sum(one.again for one in every_one)
    longest = max((max(one.lines, default=0) for one in every_one), default=0)
    cpu_s = sum(one.cpu_s for one in every_one)
    beside = "both commands, all faults; 5 min on 2 processors"
    wall = f"on {processors()} processors, with all else that runs there"
    return found | {
        "planted_found": at_least(right, "faults", len(results), "by the property they break"),
        "planted_longest_replay": at_most(longest, "lines", _MOST_LINES, f"of {replays} replays"),
        "planted_not_replayed": at_most(replays - again, "replays", 0, "by rcx run"),
        "planted_processor_time": at_most(cpu_s, "s", _MOST_S, beside),
        "planted_time": shown(sum(one.wall_s for one in every_one), "s", wall),
    }


def commands() -> list[list[str]]:
    """The words of campaign and sweep as the cell's README has them."""
    text = (PLANTED / "cell/README.md").read_text(encoding="utf-8")
    return [line.split() for line in re.findall(r"^rcx ((?:campaign|sweep) .*)$", text, re.M)]


def found_by(fault: Fault, told: Sequence[str]) -> bool:
    """Is there a failure of the property that a fault breaks?"""
    kinds = (fault.breaks, f"always {fault.breaks}")
    return any(one.startswith(tuple(f"{kind} at " for kind in kinds)) for one in told)


def _changed(words: Sequence[str], seeds: str, every: str) -> list[str]:
    """The command with other numbers, where they are given."""
    instead = {"--seeds": seeds, "--every": every}
    before = ["", *words]
    return [instead.get(last) or word for last, word in zip(before, words, strict=False)]


def _result(fault: Fault | None, asked: Sequence[Sequence[str]]) -> Result:
    with tempfile.TemporaryDirectory() as folder:
        project = planted(Path(folder), fault)
        began, before = time.monotonic(), os.times()
        said = [_rcx(project, words) for words in asked]
        after, wall_s = os.times(), time.monotonic() - began
        cpu_s = sum(after[2:4]) - sum(before[2:4])
        told, lines = [], []
        for file in sorted(project.glob("out/*/*.toml")):
            text = file.read_text(encoding="utf-8")
            told.append(text.splitlines()[0].removeprefix(MARK))
            lines.append(text.count("\n"))
        again = sum(_fails(project, words) for words in _replays(said))
    return Result(told, lines, again, cpu_s, wall_s)


def _rcx(project: Path, words: Sequence[str]) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "rcx_harness", *words]
    done = subprocess.run(command, cwd=project, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1):
        raise InputError(f"rcx {words[0]} ended with {done.returncode}: {done.stderr[-500:]}")
    return done


def _replays(said: Sequence[subprocess.CompletedProcess[str]]) -> Iterator[list[str]]:
    for done in said:
        for line in done.stdout.splitlines():
            if line.startswith("  rcx run "):
                yield line.split()[1:]


def _fails(project: Path, words: Sequence[str]) -> bool:
    return _rcx(project, words).returncode == 1


def _kinds(one: Result) -> list[str]:
    return list(dict.fromkeys(told.split(" at ")[0] for told in one.told))
