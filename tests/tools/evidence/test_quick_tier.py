"""The score of the quick tier of the tests is compared with that of all tests."""

from __future__ import annotations

import io

import pytest
from rich.console import Console

from rcx_tools.evidence.mutants.select import Judges, TestStates
from rcx_tools.evidence.mutants.tiers import print_quick_tier, quick_tier
from structured_text.mutants.mutant import Mutant
from structured_text.mutants.report import Judged
from tiers import keep_samples

_MUTANT = Mutant("", "FB_X", "", 0, "", "", "", None)
_LATE = frozenset({"tests/a.py::test_matrix[1]", "tests/a.py::test_matrix[2]"})


def _judged(*by: str) -> list[Judged]:
    return [Judged(_MUTANT, one != "", one) for one in by]


def test_mutants_that_only_exhaustive_tests_detect_are_counted_by_function() -> None:
    """Mutants that only exhaustive tests detect are counted by function.

    Quick tests detect three of five. A run that does not end counts as detected.
    """
    found = quick_tier(
        _judged(*sorted(_LATE), "tests/a.py::test_quick", "a test does not end", "t::u", ""), _LATE
    )
    assert found == {
        "killed": 3,
        "share": 60.0,
        "only_exhaustive": {"tests/a.py::test_matrix": 2},
    }


def test_the_report_shows_both_scores() -> None:
    output = io.StringIO()
    judged = _judged(*sorted(_LATE), "tests/a.py::test_quick", "")
    found = {"mutants": 4, "killed": 3, "score": 75.0, "quick": quick_tier(judged, _LATE)}
    print_quick_tier(Console(file=output, width=200), "library", found)
    assert output.getvalue().splitlines() == [
        "library: make test finds 1 of 4 (25.00 %), all tests find 3 (75.00 %); "
        "quick share 33.33 %",
        "     2 only by tests/a.py::test_matrix",
    ]


def test_exhaustive_tests_run_last(repository_states: TestStates) -> None:
    """Exhaustive tests run last, even if they are fast and have detected many mutants."""
    late, quick = "tests/a.py::test_matrix[1]", "tests/b.py::test_quick"
    seconds = {late: 0.01, quick: 5.0}
    judges = Judges(repository_states, {}, seconds, exhaustive=_LATE)
    judges.killed("FB_X", late)
    assert judges.ordered("FB_X", [late, quick], ()) == [quick, late]


@pytest.fixture
def repository_states(tmp_path_factory: pytest.TempPathFactory) -> TestStates:
    """Return an empty dictionary in place of the recorded states of tests."""
    return TestStates(tmp_path_factory.getbasetemp())


def test_a_sample_that_does_not_exist_ends_the_collection(request: pytest.FixtureRequest) -> None:
    """A sample id that no longer exists is an error, because a test would leave the quick tier."""
    item = pytest.Function.from_parent(request.node.parent, name="test_x[a]", callobj=lambda: None)
    item.add_marker(pytest.mark.exhaustive(but=["a", "gone"]))
    with pytest.raises(pytest.UsageError, match=r"test_x\[gone\]"):
        keep_samples([item], whole=True)
    assert item.get_closest_marker("exhaustive") is None
