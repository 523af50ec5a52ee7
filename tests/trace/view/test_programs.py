"""A page of `rcx view` shows robot programs.

Expected values were taken from the records by hand.
"""

from __future__ import annotations

from typing import Any

import pytest

from rcx_harness.trace import Cycle
from rcx_harness.trace.view.page import View
from structured_text.errors import InputError
from view_page import PageContent

_PLACE = {"name": "PLACE", "file": "PLACE.PGM", "lines": ["WAIT SI(20)=1 ' request", "HALT"]}
_LAMP = {"name": "LAMP", "lines": ["DO(21)=1"]}


def _task(line: int, state: str = "running", task: int = 1, program: str = "PLACE") -> Any:
    return {"task": task, "program": program, "line": line, "state": state}


def _cycle(ms: int, *tasks: Any, controller: int = 1) -> Cycle:
    return Cycle(ms * 1000, ms // 5, bytes(48), bytes(48), controller, tasks=tasks)


def _shown(*records: Cycle, programs: Any = ((_PLACE, _LAMP),)) -> PageContent:
    view = View({"format": "rcx-trace/1", "programs": programs})
    for record in records:
        view.take(record)
    return PageContent(view.page("a run"))


def test_a_task_is_a_lane_with_the_statements_of_its_lines() -> None:
    page = _shown(
        _cycle(0, _task(1, "ready")),
        _cycle(5, _task(1)),
        _cycle(10, _task(2, "stopped"), _task(1, task=3, program="LAMP")),
        _cycle(20),
    )
    assert page.changes("Task 1") == [
        (-1, "PLACE ready"),
        (5_000, "PLACE:1 WAIT SI(20)=1"),
        (10_000, "PLACE:2 stopped HALT"),
        (20_000, "no program"),
    ]
    assert page.changes("Task 3") == [
        (-1, "no program"),
        (10_000, "LAMP:1 DO(21)=1"),
        (20_000, "no program"),
    ]
    assert page.groups()["Robot programs"] == ["Task 1", "Task 3"]


def test_the_page_has_the_listings_and_the_line_of_each_text() -> None:
    """The page contains the listings, and maps each text of a task to program and line."""
    page = _shown(_cycle(0, _task(1, "ready")), _cycle(5, _task(2)))
    (entry,) = page.table["programs"]
    assert [one["lines"] for one in entry["programs"]] == [_PLACE["lines"], _LAMP["lines"]]
    assert [one["title"] for one in entry["programs"]] == ["PLACE.PGM", "LAMP"]
    ((number, lane),) = entry["tasks"]
    assert (number, page.table["lanes"][lane]["name"]) == (1, "Task 1")
    texts = page.table["texts"]
    assert entry["texts"] == {
        str(texts.index("PLACE ready")): ["PLACE", 1, "ready"],
        str(texts.index("PLACE:2 HALT")): ["PLACE", 2, "running"],
    }


def test_each_controller_has_its_own_listings() -> None:
    """Each controller has its own listings, even for two programs of the same name."""
    other = {"name": "PLACE", "lines": ["MOVE P,P1"]}
    page = _shown(
        _cycle(0, _task(1)),
        _cycle(0, _task(1), controller=2),
        programs=[[_PLACE], [other]],
    )
    assert [entry["title"] for entry in page.table["programs"]] == ["Controller 1", "Controller 2"]
    assert page.changes("Task 1") == [(-1, "PLACE:1 WAIT SI(20)=1")]
    assert page.changes("2: Task 1") == [(-1, "PLACE:1 MOVE P,P1")]
    groups = [title for title in page.groups() if "programs" in title]
    assert groups == ["Controller 1: Robot programs", "Controller 2: Robot programs"]


def test_a_recording_without_tasks_has_no_listing() -> None:
    """A recording without tasks has no listing, such as a trace written by `rcx judge`."""
    records = [Cycle(0, 0, bytes(48), bytes(48))]
    assert _shown(*records).table["programs"] == []
    assert _shown(*records, programs=[]).table["programs"] == []


@pytest.mark.parametrize(
    "programs",
    [3, [3], [[3]], [[{"name": "A"}]], [[{"name": 1, "lines": []}]], [[{**_LAMP, "lines": [1]}]]],
)
def test_a_header_with_other_programs_is_refused(programs: Any) -> None:
    with pytest.raises(InputError, match="robot programs"):
        View({"programs": programs})


def test_tasks_of_an_unknown_program_have_no_statement() -> None:
    """A task with an unknown program is shown without a statement.

    The header is from another run.
    """
    page = _shown(_cycle(0, _task(9, program="OTHER"), _task(99, task=2)))
    assert page.changes("Task 1") == [(-1, "OTHER:9")]
    assert page.changes("Task 2") == [(-1, "PLACE:99")]


def test_more_tasks_than_any_controllers_have_are_refused() -> None:
    with pytest.raises(InputError, match="are not those that the header describes"):
        _shown(_cycle(0, *(_task(1, task=k) for k in range(1, 100))))
