"""`rcx campaign --guided` keeps rare states, branches from them, and reports what is missing."""

from __future__ import annotations

from pathlib import Path

import pytest

from feeder import feeder
from rcx_harness.cli.app import main

Captured = pytest.CaptureFixture[str]
_CAMPAIGN = ["campaign", "Feeder.st", "--properties", "campaign.toml", "--engine", "builtin"]
_GUIDED = [*_CAMPAIGN, "--guided", "--workers", "0", "--seeds"]
_GOAL = '[[sometimes]]\nname = "{}"\nthat = "{}"\n'


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def _with_goal(folder: Path, name: str, that: str) -> None:
    with (folder / "campaign.toml").open("a") as file:
        file.write(_GOAL.format(name, that))


@pytest.mark.exhaustive
def test_a_planted_fault_is_found_and_replays(here: Path, capsys: Captured) -> None:
    """A lost link while the feeder runs is never reset, so the feeder does not recover."""
    feeder(here, latches=True)
    assert main([*_GUIDED, "20"]) == 1
    said = capsys.readouterr().out
    assert "recovery: " in said
    assert "needs: " in said
    assert "link_down" in said
    (command,) = [line.strip() for line in said.splitlines() if line.startswith("  rcx run ")]
    assert "did NOT fail" not in said
    assert main(command.split()[1:]) == 1


def test_a_good_cell_passes_and_its_gaps_are_listed(here: Path, capsys: Captured) -> None:
    feeder(here)
    assert main([*_GUIDED, "3"]) == 0
    said = capsys.readouterr().out
    assert "3 runs from seed 0: " in said
    assert "nothing failed" in said


@pytest.mark.parametrize("words", [[*_GUIDED, "2"], [*_CAMPAIGN, "--workers", "0", "--seeds", "1"]])
def test_a_goal_that_is_never_reached_fails(here: Path, capsys: Captured, words: list[str]) -> None:
    """The feeder feeds a part in each recovery; its speed has no value above 9."""
    feeder(here)
    _with_goal(here, "a part is fed", "Main.Fed > 0")
    assert main(words) == 0
    assert "never reached" not in capsys.readouterr().out
    _with_goal(here, "too fast", "Main.Speed > 9")
    assert main(words) == 1
    said = capsys.readouterr().out
    assert "sometimes too fast: never reached: Main.Speed > 9" in said
    assert "a part is fed" not in said


def test_another_engine_is_refused(here: Path, capsys: Captured) -> None:
    feeder(here)
    words = ["campaign", "Feeder.st", "--guided", "--engine", "matiec"]
    assert main(words) == 2
    assert "--guided needs the built-in engine" in capsys.readouterr().err
