"""`rcx campaign` and `rcx explore` find a deadlock and a race between PLC and robot program."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from planted import HANDSHAKES, OF_HANDSHAKES, planted
from rcx_harness.cli.app import main
from rcx_harness.verify.storm.campaign import Storms
from rcx_harness.verify.storm.cells import CellsOf
from rcx_harness.verify.storm.sweep import Moments, Sweep, injects

Captured = pytest.CaptureFixture[str]
#: With the fault, line 11 of HANDOVER.PGM is `WAIT SI(20)=1`. SO(21) means that the robot is ready.
_DEADLOCK = (
    "deadlock handover: nothing has moved for 2000 ms: "
    "PLC waits for SO(21), robot program HANDOVER waits in line 11 for SI(20)=1"
)
#: With this fault, the PLC writes the word one scan too late.
_RACE = (
    "stable place: SIW(2) from 1 to 2: changed 1 scan after SI(21) became ON, "
    "before SO(20) has acknowledged it"
)
_TOLD = {"deadlock": _DEADLOCK, "race": _RACE}
_both = pytest.mark.parametrize("name", _TOLD)


@pytest.fixture
def there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def _explored(cell: Path, begin: str = "13s") -> int:
    """Run `rcx explore` with Cancel as the only input, from the time `begin` on."""
    words = ["explore", str(cell / "Handover.st"), "--robot", str(cell / "robot.toml")]
    words += ["--properties", str(cell / "campaign.toml"), "--workers", "0", "--faults", "none"]
    words += ["--stimulus", str(cell / "stimulus.toml"), "--begin", begin]
    words += ["--input", "Main.Start=false", "--input", "Main.CellSafe=true"]
    return main(words)


def _replayed(said: str, capsys: Captured) -> str:
    """Run the printed `rcx run` command, and return its output."""
    words = re.findall(r"^  rcx (run .*)$", said, re.MULTILINE)[0].split()
    assert main(words) == 1
    return capsys.readouterr().out


@pytest.mark.exhaustive
@_both
def test_explore_finds_a_planted_fault_and_rcx_run_shows_it(
    name: str, there: Path, capsys: Captured
) -> None:
    """`rcx explore` finds the deadlock with one press of Cancel, and the race without any input."""
    cell = planted(there, OF_HANDSHAKES[name], HANDSHAKES)
    assert _explored(cell, *["1500ms"] * (name == "race")) == 1
    said = capsys.readouterr().out
    assert f"  property: {_TOLD[name]}\n" in said
    changes = re.findall(r"^  scan \d+: (Main.*)$", said, re.MULTILINE)
    assert changes == (["Main.Cancel := true"] if name == "deadlock" else [])
    assert f"property: {_TOLD[name]}" in _replayed(said, capsys)


@pytest.mark.exhaustive
def test_the_corrected_cell_is_explored_to_its_end(there: Path, capsys: Captured) -> None:
    """In the corrected cell, Cancel at any time leads to no deadlock and no race."""
    assert _explored(planted(there, home=HANDSHAKES)) == 0
    assert "explored to the end" in capsys.readouterr().out


def _failures(cell: Path, seed: int) -> dict[str, str]:
    """Run one seed of a campaign, and return the text of each failure by its kind."""
    options = {"robot": [cell / "robot.toml"], "engine": "builtin"}
    of = CellsOf.of([cell / "Handover.st"], options, [cell / "campaign.toml"])
    result = Storms(of).prepare()(seed)
    return {kind: text for kind, (_, text) in result.failures.items()}


#: Seeds of a campaign that show the faults.
_SEEDS = {"deadlock": 36, "race": 5}


@pytest.mark.exhaustive(but=["race"])
@_both
def test_a_seed_of_a_campaign_shows_a_planted_fault(name: str, there: Path) -> None:
    """The seed shows the fault, and has no failure in the corrected cell."""
    fault = OF_HANDSHAKES[name]
    (there / "good").mkdir()
    failures = _failures(planted(there, fault, HANDSHAKES), _SEEDS[name])
    assert f"{fault.breaks}: {failures[fault.breaks]}" == _TOLD[name]
    assert _failures(planted(there / "good", home=HANDSHAKES), _SEEDS[name]) == {}


@pytest.mark.exhaustive
def test_a_campaign_reports_lines_that_no_seed_has_executed(there: Path, capsys: Captured) -> None:
    """The campaign reports the lines of a robot program that no seed has executed.

    Lines 14 to 16 are a subroutine that is never called.
    """
    cell = planted(there, home=HANDSHAKES)
    program = cell / "HANDOVER.PGM"
    text = program.read_text(encoding="utf-8")
    program.write_text(text + "*NEVER:\n  SO(22)=1\nRETURN\n", encoding="utf-8")
    for _ in range(2):  # the second call only reads the saved results
        assert _campaign(cell, "--seeds", "1", "--seed-from", "5") == 0
        said = capsys.readouterr().out
        assert "\nrobot program HANDOVER: lines 15 to 16 not reached\n" in said


@pytest.mark.exhaustive
@_both
def test_a_campaign_finds_a_planted_fault_and_rcx_run_shows_it(
    name: str, there: Path, capsys: Captured
) -> None:
    """`rcx campaign` finds the fault, and its `rcx run` command shows it again.

    For the deadlock, the message says for which signal each program waits.
    """
    cell = planted(there, OF_HANDSHAKES[name], HANDSHAKES)
    assert _campaign(cell, "--seeds", "3", "--seed-from", str(_SEEDS[name])) == 1
    said = capsys.readouterr().out
    assert f"\n{OF_HANDSHAKES[name].breaks}: " in said
    if name == "deadlock":
        assert "  needs: Main.Cancel" in said
        late = "Main.Done <> (TRUE|FALSE) has not come within 20000 ms; Main.Done = (TRUE|FALSE)"
        assert re.search(f"{late}; {re.escape(_DEADLOCK.rpartition(': ')[2])}", said)
    assert f"property: {OF_HANDSHAKES[name].breaks}" in _replayed(said, capsys)


@pytest.mark.exhaustive
def test_a_campaign_and_a_sweep_of_the_corrected_cell_find_nothing(
    there: Path, capsys: Captured
) -> None:
    """In the corrected cell, 30 seeds of a campaign and a sweep of every third scan find nothing.

    The sweep also injects faults in the middle of the robot program.
    """
    cell = planted(there, home=HANDSHAKES)
    assert _campaign(cell, "--seeds", "30") == 0, capsys.readouterr().out
    words = [
        "--stimulus",
        str(cell / "stimulus.toml"),
        "--for",
        "3s",
        "--every",
        "3",
        "--out",
        "swept",
    ]
    assert _campaign(cell, *words, command="sweep") == 0, capsys.readouterr().out


@pytest.mark.exhaustive
def test_a_sweep_injects_in_the_middle_of_the_robot_program(there: Path) -> None:
    """A press of Cancel during the movement of line 9 (2140 to 2250 ms) leads to the deadlock."""
    (there / "good").mkdir()
    for name, cell in (
        ("deadlock", planted(there, OF_HANDSHAKES["deadlock"], HANDSHAKES)),
        ("good", planted(there / "good", home=HANDSHAKES)),
    ):
        options = {"robot": [cell / "robot.toml"], "engine": "builtin"}
        files = [cell / "Handover.st"], options, [cell / "campaign.toml"]
        of = CellsOf.of(*files, cell / "stimulus.toml")
        (cancel,) = injects(["Main.Cancel=true"], 1, 50_000)
        failing = Sweep(of).prepare()(Moments(cancel, 216, 222, 5))
        assert list(failing) == ([216, 221] if name == "deadlock" else [])


def _campaign(cell: Path, *more: str, command: str = "campaign") -> int:
    words = [command, str(cell / "Handover.st"), "--robot", str(cell / "robot.toml")]
    words += ["--engine", "builtin", "--properties", str(cell / "campaign.toml")]
    return main([*words, "--workers", "0", *more])
