"""The matrix of seeded bugs and methods is complete, and each bug is detected by some method."""

from __future__ import annotations

from pathlib import Path

from rcx_tools.evidence.campaign import seeded as campaign
from rcx_tools.evidence.explore import interlock
from rcx_tools.evidence.explore import seeded as explore
from rcx_tools.evidence.mutants.seeded import bugs
from structured_text.output.toml_files import load_toml

_HERE = Path(__file__).parent
_ROWS = {row.pop("name"): row for row in load_toml(_HERE / "matrix.toml")["bug"]}
_EXPLORE = [bug.name for bug in (*explore.SEEDED, *interlock.SEEDED)]
_CAMPAIGN = [bug.name for bug in campaign.SEEDED]
_TESTS = [bug.name for bug in bugs(_HERE / "seeded.toml") if bug.of_library]


def test_each_seeded_bug_of_the_library_has_a_row() -> None:
    """Source: the tables in bugs/ and seeded.toml. The bugs in proof_bugs are not in the matrix."""
    assert list(_ROWS) == [*_EXPLORE, *_CAMPAIGN, *_TESTS]


def test_each_seeded_bug_is_detected_by_the_method_of_its_table() -> None:
    """Source: `make explore`, `make campaign` and `make mutants` fail if they miss a bug."""
    tables = {"explore": _EXPLORE, "campaign": _CAMPAIGN, "tests": _TESTS}
    missed = [
        (name, method)
        for method, names in tables.items()
        for name in names
        if _ROWS[name].get(method, -1) < 0
    ]
    assert missed == []


def test_each_method_is_the_first_to_detect_some_bug() -> None:
    """Each method is the first to detect some bug; otherwise it would not be worth its code."""
    first = set()
    for row in _ROWS.values():
        found = {method: seconds for method, seconds in row.items() if seconds >= 0}
        first.add(min(found, key=lambda method: found[method]))
    assert first >= {"tests", "contract", "explore", "campaign"}
