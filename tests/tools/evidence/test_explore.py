"""The exploration of the library detects seeded bugs. The bounds are small in these tests."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from random import Random
from typing import Any

import pytest

from rcx_harness.trace import Scan, Violation, read_trace
from rcx_harness.verify.explore import state_tables
from rcx_tools.evidence import results
from rcx_tools.evidence.checks import CHECKS
from rcx_tools.evidence.explore import command, interlock
from rcx_tools.evidence.explore.command import Item, Known
from rcx_tools.evidence.explore.model import DOWN, UP, Model
from rcx_tools.evidence.explore.models import MODELS
from rcx_tools.evidence.explore.replay import replay
from rcx_tools.evidence.explore.search import LIBRARY, Explorer
from rcx_tools.evidence.explore.seeded import SEEDED, Seeded

pytestmark = pytest.mark.exhaustive

#: Number of states that a test explores of each model. `make explore` explores all states.
BOUND = 20


def model_named(name: str) -> Model:
    return next(model for model in MODELS if model.name == name)


class _Here:
    """A farm (pool of workers) that runs its work in this process."""

    def __init__(self, jobs: int) -> None:
        assert jobs > 0

    def as_ready(
        self, work: Callable[[Any], Any], items: Iterable[Any]
    ) -> Iterator[tuple[Any, Any]]:
        return ((item, work(item)) for item in items)


def _rows(figures: dict[str, Any]) -> dict[str, str]:
    """Return the rows of figures that the page shows."""
    check = next(one for one in CHECKS if one.name == "explore")
    return {label: told(figures) for label, told in check.rows}


def bug_named(name: str) -> Seeded:
    return next(bug for bug in SEEDED if bug.name == name)


@pytest.mark.exhaustive(but=["alone", "stopped", "arbitration", "retries", "stop", "emergency"])
@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.name)
def test_no_rule_is_broken_within_a_small_bound(model: Model) -> None:
    result = Explorer(model).run(BOUND)
    assert result.broken is None, result.broken
    assert result.transitions == BOUND * len(model.choices())
    assert result.checked == BOUND


def test_a_small_model_is_explored_to_its_end_and_has_a_bound() -> None:
    commands = model_named("commands")
    alone = replace(
        commands,
        blocks=(replace(commands.blocks[0], does=(DOWN, UP)),),
        situations=commands.situations[:3:2],
        quiet=commands.quiet[:1],
    )
    result = Explorer(alone).run()
    assert result.met
    assert result.states > 50
    assert set(result.bounds) == {quiet.title for quiet in alone.quiet}
    assert all(0 < bound < 10 for bound in result.bounds.values())


@pytest.mark.exhaustive(but=["a hold that is asked for can be released in the same scan-3"])
@pytest.mark.parametrize(
    ("name", "scans"),
    [
        ("the interval is not waited for", 2),
        ("SI(06) goes ON together with SI(00)", 3),
        ("the recovery of the link does not count as a change", 3),
        ("a hold that is asked for can be released in the same scan", 3),
    ],
)
def test_a_seeded_bug_is_found_with_a_shortest_trace_that_opens_as_a_chart(
    name: str, scans: int, tmp_path: Path
) -> None:
    bug = bug_named(name)
    library = bug.library(tmp_path)
    model = model_named(bug.model)
    result = Explorer(model, library).run()
    assert result.broken is not None
    assert len(result.broken.path) == scans
    shown = replay(model, result.broken, library, tmp_path / "trace.jsonl")
    assert shown.rules == list(result.broken.rules)
    assert shown.rules[0].startswith(bug.rule)
    header, records = read_trace(tmp_path / "trace.jsonl")
    found = list(records)
    assert header["scan_us"] == model.tick_ms * 1000
    assert sum(isinstance(record, Scan) for record in found) == scans
    assert [one.text for one in found if isinstance(one, Violation)] == shown.rules
    assert "Rule broken" in shown.chart("found")


def test_a_hang_is_found_with_the_way_into_it(tmp_path: Path) -> None:
    bug = bug_named("a holder that has gone keeps its turn")
    library = bug.library(tmp_path)
    commands = model_named(bug.model)
    alone = replace(commands, blocks=commands.blocks[:1], situations=commands.situations[:4])
    result = Explorer(alone, library).run()
    assert result.broken is not None
    assert result.broken.quiet is not None
    assert result.broken.rules[0].startswith("hang")
    shown = replay(alone, result.broken, library)
    assert shown.rules == list(result.broken.rules)
    assert len(shown.trace.scans()) > len(result.broken.path)


def test_every_seeded_bug_changes_a_block(tmp_path: Path) -> None:
    for bug in SEEDED:
        changed = [file for file in bug.library(tmp_path) if file not in LIBRARY]
        assert [file.stem for file in changed] == [bug.block]
        assert model_named(bug.model)


@pytest.mark.parametrize(
    ("block", "variable"), [("FB_RCXDEDICATEDINPUTS", "WasUp"), ("RCX_REF", "SI")]
)
def test_a_state_that_leaves_out_what_counts_is_noticed(
    block: str, variable: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    table = state_tables.TYPES[block]
    wrong = replace(table, dropped=f"{table.dropped} {variable}")
    monkeypatch.setitem(state_tables.TYPES, block, wrong)
    with pytest.raises(AssertionError, match="leaves out has an effect"):
        Explorer(model_named("inputs")).run(BOUND)


@pytest.mark.parametrize("name", ["inputs", "jobs"])
def test_a_scan_run_call_by_call_gives_the_state_of_a_whole_scan(name: str) -> None:
    """A scan that is run call by call leads to the same state as a scan of the whole program.

    The model `inputs` has pins, a block with Enable and late scans. The model `jobs` has variables.

    Source: the whole program, which `check` runs.
    """
    model = model_named(name)
    explorer, random = Explorer(model), Random(1)
    state = explorer.first()
    for _ in range(2):
        for choice in explorer.choices(state):
            following, broken = explorer.step(state, choice)
            explorer.check(state, choice, following, random)
            assert not broken
        state = following


def test_a_call_is_not_run_again_from_the_same_state() -> None:
    """Source: docs/explanation/timing.md, what an exploration takes."""
    explorer = Explorer(model_named("commands"))
    scan, scans = explorer.program.scan, []

    def counted(now_us: int) -> None:
        scans.append(now_us)
        scan(now_us)

    explorer.program.scan = counted  # type: ignore[method-assign]
    first = explorer.first()
    ends = []
    for choices in (explorer.choices(first), explorer.choices(first)):
        ends.append([explorer.step(first, choice) for choice in choices])
        ran, scans[:] = len(scans), []
    assert ends[0] == ends[1]
    assert ran == 0


def test_a_broken_rule_is_reported_each_time(tmp_path: Path) -> None:
    """Source: guide, chapter 1: inputs change 100 ms apart at least."""
    bug = bug_named("the interval is not waited for")
    model = model_named(bug.model)
    library = bug.library(tmp_path)
    found = Explorer(model, library).run().broken
    assert found is not None
    explorer = Explorer(model, library)
    state = explorer.first()
    for choice in found.path[:-1]:
        explorer.choices(state)
        state, broken = explorer.step(state, choice)
        assert not broken
    explorer.choices(state)
    told = [explorer.step(state, found.path[-1])[1] for _ in range(2)]
    assert told == [list(found.rules)] * 2
    assert told[0][0].startswith("interval")


def test_the_model_with_the_most_choices_is_explored_first_and_bugs_come_last() -> None:
    """Source: two processes end together only if what is left at the end is short."""
    items = command.items(command.EVERY_MODEL.values())
    assert [item.name for item in items[:2]] == ["inputs", "jobs"]
    assert [item.bug for item in items if item.bug] == list(command.EVERY_BUG)
    models = [item.model for item in items if item.bug is None]
    assert sorted(models) == sorted(command.EVERY_MODEL)
    assert not any(item.bug for item in items[: len(models)])


def test_a_variable_that_is_not_fixed_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    table = state_tables.TYPES["FB_RCXDEDICATEDINPUTS"]
    monkeypatch.setitem(
        state_tables.TYPES, "FB_RCXDEDICATEDINPUTS", replace(table, fixed="Nothing WasUp")
    )
    with pytest.raises(AssertionError, match="is not fixed"):
        Explorer(model_named("inputs")).run(BOUND)


def test_only_fb_scan_time_reads_the_elapsed_time_of_a_timer() -> None:
    """Only FB_ScanTime reads the elapsed time of a timer, so other states omit it.

    The states contain only the ticks since the start of a TON, and whether it has ended.
    FB_ToolPosition, which reads the age of its data, is not in a model.
    """
    readers = {file.stem for file in LIBRARY if ".ET" in file.read_text(encoding="utf-8")}
    assert readers == {"FB_RcxScanTime", "FB_ToolPosition"}
    assert not any("FB_ToolPosition" in str(model.blocks) for model in MODELS)


def test_robots_at_one_area_are_explored_with_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pair = interlock.InterlockModel("entry", "two robots", robots=2, moves=("go", "out"), at_once=2)
    bug = next(one for one in interlock.SEEDED if one.name == "two hold it")
    monkeypatch.setattr(command, "OUT", tmp_path)
    monkeypatch.setattr(results, "FOLDER", tmp_path)
    monkeypatch.setattr(command, "EVERY_MODEL", {"entry": pair})
    monkeypatch.setattr(command, "EVERY_BUG", (bug,))
    monkeypatch.setattr(command, "Farm", _Here)
    assert command.main([]) == 0
    written = json.loads((tmp_path / "explore.json").read_text(encoding="utf-8"))
    figures = written["figures"]
    assert figures["models"]["entry"]["complete"]
    assert figures["states"] == figures["models"]["entry"]["states"] > 50
    assert (figures["seeded_bugs"], figures["seeded_bugs_found"]) == (1, 1)
    assert figures["longest_until_free_scans"] == 0
    assert figures["longest_until_granted_scans"] > 2
    assert _rows(figures)["models explored to the end"] == "1 of 1"
    shown = (tmp_path / "explore/seeded_01.txt").read_text(encoding="utf-8").splitlines()
    assert shown[0].startswith("scan 1: ")
    assert shown[-1].startswith("safety: ")


def test_every_model_and_every_bug_has_a_name_of_its_own() -> None:
    names = [model.name for model in MODELS]
    names += [model.name for model in interlock.MODELS]
    names += [bug.name for bug in (*SEEDED, *interlock.SEEDED)]
    assert len(set(names)) == len(names)


def test_an_outcome_is_kept_until_what_it_rests_on_changes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bug = bug_named("the interval is not waited for")
    whole, entry, found = Item("inputs"), Item("entry"), Item("inputs", bug)
    open_end, lost = Item("jog"), Item("inputs", bug_named("SI(06) goes ON together with SI(00)"))
    met = {"states": 7, "complete": True, "rules": [], "bounds": {"answers": 3}}
    broken = {"states": 9, "complete": False, "rules": ["interval: too soon"], "bounds": {}}
    file = tmp_path / "explore.jsonl"
    known = Known(file, seed=1)
    for item, outcome in (
        (whole, met),
        (entry, met),
        (open_end, {**met, "complete": False}),
        (found, broken),
        (lost, {**broken, "rules": ["hang: never free again"]}),
    ):
        assert known.get(item) is None
        known.keep(item, outcome)

    again = Known(file, seed=1)
    kept = {item: again.get(item) for item in (whole, entry, open_end, found, lost)}
    told = {item: one and one["states"] for item, one in kept.items()}
    assert told == {whole: 7, entry: 7, open_end: None, found: 9, lost: None}
    assert Known(file, seed=2).get(whole) is None
    inputs, jog = model_named("inputs"), model_named("jog")
    changed = {**command.EVERY_MODEL, "inputs": replace(inputs, blocks=jog.blocks)}
    monkeypatch.setattr(command, "EVERY_MODEL", changed)
    assert again.get(whole) is None
    assert again.get(entry) is not None
    monkeypatch.setattr(command, "RULES", command.RULES[:-1])
    assert Known(file, seed=1).get(entry) is None
    assert Known(file, seed=1, fresh=True).get(entry) is None
