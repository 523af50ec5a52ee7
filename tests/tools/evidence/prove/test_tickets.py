"""The order of blocks on a channel is proved; with a seeded bug, the proof fails."""

from __future__ import annotations

from pathlib import Path

import pytest
import z3

from rcx_tools.evidence.prove.library import Library
from rcx_tools.evidence.prove.solve import ask
from rcx_tools.evidence.prove.tickets import PROPERTIES, turns
from rcx_tools.evidence.results import ROOT
from structured_text.output.toml_files import load_toml
from structured_text.projects.needed import needed
from structured_text.prove.logic import PROVED, REFUTED

pytestmark = pytest.mark.exhaustive

_LIB = ROOT / "plc/lib"
_BUGS = ROOT / "tests/tools/evidence/proof_bugs/tickets.toml"
_BLOCKS = ("FB_RcxJob", "FB_RcxMakeHead", "FB_RcxTakeHead", "FB_RemoteCommand", "FB_ServoOn")
#: A property, a part of it that takes less than a second, words of its goals, and a seeded bug that
#: breaks it.
_PARTS = (
    ("turn-hands", "", "", "sequence-in-the-turn-of-the-commands"),
    ("turn-once", "SEQUENCE FB_RCXJOB", "no block was called", "ticket-passed-on-unseen"),
    ("turn-order", "SEQUENCE FB_RCXJOB", "keeps its ticket", "new-ticket-in-each-call"),
    ("turn-back", "SEQUENCE FB_RCXJOB", "passes", "turn-not-passed-on-after-an-error"),
    ("turn-free", "COMMAND FB_RCXJOB", "", "lost-link-keeps-waiting-blocks"),
    ("turn-limit", "SEQUENCE", "below its limit", "limit-exceeded-by-a-scan"),
)


def _library(folder: Path, bug: str = "") -> Library:
    """Return the part of plc/lib that the turns need, perhaps with a seeded bug."""
    files = sorted(_LIB.rglob("*.st"))
    wanted = [file for file in files if file.stem in _BLOCKS]
    for file in {*wanted, *needed(wanted, files)}:
        copy = folder / file.relative_to(_LIB)
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_bytes(file.read_bytes())
    for seeded in load_toml(_BUGS)["bug"]:
        if seeded["name"] == bug:
            changed = folder / seeded["file"]
            text = changed.read_text(encoding="utf-8")
            assert text.count(seeded["old"]) == 1
            changed.write_text(text.replace(seeded["old"], seeded["new"]), encoding="utf-8")
    return Library(folder)


def _answers(library: Library, name: str, part: str, of: str) -> set[str]:
    found = next(item for item in PROPERTIES if item.name == name)
    goals = [goal for goal in found.goals(library, part) if of in goal.name]
    assert goals
    return {ask(goal.assumed, goal.claim, 60).status for goal in goals}


@pytest.mark.exhaustive(but=[row[0] for row in _PARTS[:2]])
@pytest.mark.parametrize(("name", "part", "of", "bug"), _PARTS, ids=[row[0] for row in _PARTS])
def test_the_turns_are_proved_except_with_a_seeded_bug(
    tmp_path: Path, name: str, part: str, of: str, bug: str
) -> None:
    """Source: docs/explanation/scan-model.md, two turns."""
    assert _answers(_library(tmp_path / "right"), name, part, of) == {PROVED}
    assert REFUTED in _answers(_library(tmp_path / "wrong", bug), name, part, of)


@pytest.mark.exhaustive
def test_a_command_ends_although_its_block_is_no_longer_called(tmp_path: Path) -> None:
    """Source: guide chapter 2, command is held until 16#0200 or 16#4000."""
    assert _answers(_library(tmp_path), "turn-free", "COMMAND ORPHAN", "") == {PROVED}


def test_the_states_that_the_proofs_assume_exist(tmp_path: Path) -> None:
    """The states that the proofs assume exist, so the proofs are not empty.

    Example: two blocks wait, and one of them is called.
    """
    step = turns.call(_library(tmp_path), "COMMAND", 2)
    wait = [z3.And(job.lives(step.after.channel), job.waits) for job in step.after.jobs]
    assert ask(step.assumed, z3.Not(z3.And(*wait)), 60).status == REFUTED
