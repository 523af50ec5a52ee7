"""A campaign finds typical programming errors, and gives a short run for each.

The tests use seeds that are known to show the faults.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from faulty_examples import FAULTY, Faulty, changed_example
from planted import FAULTS, PLANTED, Fault, found_by, planted
from rcx_harness.cell.stimulus import Stimulus
from rcx_harness.cli.app import main
from rcx_harness.verify.storm.campaign import Seed, Storms
from rcx_harness.verify.storm.cells import CellsOf
from rcx_harness.verify.storm.course import RECOVERY
from structured_text.output.replays import MARK

Captured = pytest.CaptureFixture[str]
_MOST_LINES = 20
#: For each fault, the seed of a run that shows it.
_SEEDS = {"lost part": 36, "latch": 8, "link loss": 33, "race": 14, "time limit": 0}


@pytest.mark.exhaustive
@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_a_planted_fault_is_found_and_its_replay_shows_it(
    fault: Fault, tmp_path: Path, capsys: Captured
) -> None:
    """The seed and its replay break the expected property, but only in the cell with the fault.

    `rcx campaign` wrote the replays from these seeds. Each replay has at most 20 lines.
    """
    (tmp_path / "good").mkdir()
    good, project = planted(tmp_path / "good"), planted(tmp_path, fault)
    kind = fault.breaks if fault.breaks == RECOVERY else f"always {fault.breaks}"
    assert kind in _seeds(project)(_SEEDS[fault.name]).failures

    replay = PLANTED / f"found/{fault.name.replace(' ', '_')}.toml"
    lines = replay.read_text(encoding="utf-8").splitlines()
    assert len(lines) <= _MOST_LINES
    assert found_by(fault, [lines[0].removeprefix(MARK)])
    length = f"{Stimulus.load(replay).entries[-1].t_us // 1000 + 20}ms"
    for cell, breaks in ((project, True), (good, False)):
        words = ["run", str(cell / "plc"), "--properties", str(cell / "campaign.toml")]
        for name in "ab":
            words += ["--robot", str(cell / f"robot_{name}.toml")]
        words += ["--seed", str(_SEEDS[fault.name]), "--engine", "builtin"]
        assert main([*words, "--stimulus", str(replay), "--for", length]) == breaks
        said = capsys.readouterr().out
        shown = "expect: " if kind == RECOVERY else f"property: {kind}"
        assert (shown in said) == breaks


@pytest.mark.exhaustive
@pytest.mark.parametrize("example", sorted({one.example for one in FAULTY}))
def test_storms_find_faults_in_examples_and_nothing_else(example: str, tmp_path: Path) -> None:
    """Each fault in an example is found with its seed. The unchanged example has no failure."""
    there = [one for one in FAULTY if one.example == example]
    good = _storms(tmp_path / "good", example)
    for number, one in enumerate(there):
        assert not good(one.seed).failures
        faulty = _storms(tmp_path / str(number), example, one)
        assert one.kind in faulty(one.seed).failures, one.name


def _storms(folder: Path, example: str, one: Faulty | None = None) -> Callable[[int], Seed]:
    folder.mkdir()
    changed_example(folder, example, one.changes if one else ())
    return _seeds(folder)


def _seeds(folder: Path) -> Callable[[int], Seed]:
    options = {"robot": sorted(folder.glob("robot*.toml")), "engine": "builtin"}
    program = sorted(folder.rglob("*.st"))
    return Storms(CellsOf.of(program, options, [folder / "campaign.toml"])).prepare()
