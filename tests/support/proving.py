"""Copies of a few blocks of plc/lib for proofs, and the solver's verdicts for them."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

from rcx_tools.evidence.prove.library import Library
from rcx_tools.evidence.prove.property import Property
from rcx_tools.evidence.prove.solve import ask
from structured_text.output.toml_files import load_toml
from structured_text.projects.needed import needed

_ROOT = Path(__file__).resolve().parents[2]
_LIBRARY = sorted((_ROOT / "plc/lib").rglob("*.st"))


def library(folder: Path, *blocks: str, bug: str = "", bugs: str = "") -> Library:
    """Write a library of these blocks and the blocks they use, with one bug if `bug` is given."""
    own = [file for file in _LIBRARY if file.stem in blocks]
    for file in {*own, *needed(own, _LIBRARY)}:
        copy = folder / file.relative_to(_ROOT / "plc/lib")
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(file, copy)
    if bug:
        change = _change(bugs, bug)
        file = folder / change["file"]
        text = file.read_text(encoding="utf-8")
        assert text.count(change["old"]) == 1
        file.write_text(text.replace(change["old"], change["new"]), encoding="utf-8")
    return Library(folder)


def _change(bugs: str, name: str) -> dict[str, Any]:
    table = load_toml(_ROOT / f"tests/tools/evidence/proof_bugs/{bugs}.toml")
    found: dict[str, Any] = next(bug for bug in table["bug"] if bug["name"] == name)
    return found


def statuses(item: Property, of: Library, part: str) -> set[str]:
    """Return the solver's verdicts for the proof goals of one part."""
    return {ask(goal.assumed, goal.claim, 20.0).status for goal in item.goals(of, part)}
