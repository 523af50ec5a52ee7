"""The benchmark calculates and reports its figures. Only `make bench` measures."""

from __future__ import annotations

import json
from importlib import import_module
from pathlib import Path

import pytest

from rcx_tools.bench import Figure
from rcx_tools.bench.__main__ import POINTS, main
from rcx_tools.bench.cyclic import Case, Run, figures
from rcx_tools.bench.figure import (
    OUT_OF_REACH,
    as_table,
    at_least,
    at_most,
    percentile,
    shown,
    store,
)
from rcx_tools.bench.processes import first_line, running
from rcx_tools.bench.suite import read
from structured_text.errors import InputError

_QUIET = Run(Case(2_000, 1, False), 60.0, 60_000, 60_000.0, 0, 1_999, 2_200, 2_100, 0, 25.0)


def test_a_quiet_run_without_a_missing_packet_meets_its_targets() -> None:
    """Source: docs/explanation/timing.md."""
    found = figures(_QUIET, None)
    assert found["cyclic_2ms_missing"] == Figure(0, "packets", "0", "none", True)
    assert found["cyclic_2ms_rate"] == Figure(1.0, "of nominal", ">= 0.98", "none", True)
    assert found["cyclic_2ms_packets"].value == 1000
    assert found["cyclic_2ms_cpu"].value == 25.0


def test_a_missing_packet_or_a_low_rate_misses_them() -> None:
    """Source: docs/explanation/timing.md."""
    bad = Run(Case(2_000, 1, False), 60.0, 58_000, 60_000.0, 2, 1_999, 2_200, 2_100, 0, 25.0)
    found = figures(bad, None)
    assert not found["cyclic_2ms_missing"].met
    assert not found["cyclic_2ms_rate"].met


def test_under_a_flood_the_rate_is_compared_with_the_quiet_run() -> None:
    """Source: docs/explanation/timing.md: within 10 %."""
    good = Run(Case(2_000, 1, True), 60.0, 55_000, 60_000.0, 9, 1_999, 2_200, 2_100, 0, 25.0)
    bad = Run(Case(2_000, 1, True), 60.0, 53_000, 60_000.0, 0, 1_999, 2_200, 2_100, 0, 25.0)
    assert figures(good, _QUIET)["cyclic_2ms_flood_rate"].met
    assert not figures(bad, _QUIET)["cyclic_2ms_flood_rate"].met
    assert figures(good, _QUIET)["cyclic_2ms_flood_missing"].met


def test_without_priority_the_loop_is_nearly_as_punctual_as_a_bare_timer() -> None:
    """Source: timing.md: at 2 ms, p99 is at most 1.1 times the p99 of the bare timer."""
    case = Case(2_000, 1, flooded=False, ordinary=True)
    good = figures(Run(case, 60.0, 59_000, 60_000.0, 3, 1_999, 2_300, 2_100, 3, 25.0), None)
    bad = figures(Run(case, 60.0, 59_000, 60_000.0, 4, 1_999, 2_320, 2_100, 3, 25.0), None)
    assert good["cyclic_2ms_ordinary_missing"].met
    assert good["cyclic_2ms_ordinary_gap_p99"].met
    assert not bad["cyclic_2ms_ordinary_missing"].met
    assert not bad["cyclic_2ms_ordinary_gap_p99"].met


@pytest.mark.parametrize(("ordinary", "least"), [(False, 0.98), (True, 0.95)])
def test_at_1_ms_nearly_all_packets_come(ordinary: bool, least: float) -> None:
    """Source: docs/explanation/timing.md: 98 % of nominal with real-time priority, 95 % without."""
    case = Case(1_000, 1, flooded=False, ordinary=ordinary)
    for packets, met in ((60_000 * least, True), (60_000 * least - 1, False)):
        run = Run(case, 30.0, round(packets), 60_000.0, 9, 999, 1_200, 1_100, 0, 25.0)
        assert figures(run, None)[f"{case.name}_rate"].met is met


def test_sixteen_controllers_at_10_ms_lose_no_packet() -> None:
    """Source: docs/explanation/timing.md."""
    case = Case(10_000, 16, flooded=False)
    for missing, met in ((0, True), (1, False)):
        run = Run(case, 10.0, 32_000, 32_000.0, missing, 9_999, 10_200, 10_100, 0, 25.0)
        assert figures(run, None)["cyclic_10ms_x16_missing"].met is met


def test_below_the_promised_interval_figures_are_shown_without_a_target() -> None:
    """Source: docs/explanation/timing.md."""
    run = Run(Case(1_000, 16, False), 60.0, 1, 60_000.0, 9, 1_999, 2_200, 2_100, 0, 25.0)
    found = figures(run, None)
    assert next(iter(found)) == "cyclic_1ms_x16_packets"
    assert all(one.target == "none" and one.met for one in found.values())


def test_limits_are_compared_with_the_right_figures() -> None:
    """Source: docs/explanation/timing.md: targets beside figures."""
    assert at_least(40.0, "x", 40).met
    assert not at_least(39.9, "x", 40).met
    assert at_most(0.3, "s", 0.3).met
    assert not at_most(1, "scans", 0).met
    assert at_most(1, "scans", 0).target == "0"
    assert as_table({"a": at_most(1, "scans", 0)}).row_count == 1


def test_a_target_out_of_reach_does_not_count_as_missed() -> None:
    """Source: docs/explanation/timing.md: targets out of reach are listed separately."""
    beyond = at_least(1, "x", 2, "peer" + OUT_OF_REACH)
    assert not beyond.met
    assert not beyond.missed
    assert at_least(1, "x", 2, "peer").missed
    assert not at_least(2, "x", 2, "peer").missed
    assert not shown(1, "x").missed
    table = as_table({"a": beyond, "b": at_least(1, "x", 2), "c": at_least(2, "x", 2)})
    assert list(table.columns[4].cells) == ["NO", "NO", "yes"]


@pytest.mark.parametrize(
    ("near", "far", "code"), [(1, 2, 0), (0, 2, 1), (1, 0, 1), (0, 0, 1)],
    ids=["all met", "one missed", "one out of reach", "neither"],
)  # fmt: skip
def test_the_benchmark_ends_with_1_if_a_target_is_not_met(
    near: float, far: float, code: int, monkeypatch: pytest.MonkeyPatch, tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    """Source: head of rcx_tools/bench/__main__.py; targets out of reach are listed separately."""
    monkeypatch.chdir(tmp_path)
    found = {"far": at_least(far, "x", 2, OUT_OF_REACH), "near": at_least(near, "x", 1)}
    monkeypatch.setattr("rcx_tools.bench.sizes.measure", lambda _: found)
    assert main(["--only", "sizes"]) == code
    said = capsys.readouterr().out
    assert ("out of reach: far" in said) is (far < 2)
    assert ("missed: near" in said) is (near < 1)


def test_the_file_keeps_the_figures_of_other_points(tmp_path: Path) -> None:
    """Source: docs/explanation/timing.md: out/bench.json."""
    file = tmp_path / "out" / "bench.json"
    store({"one": at_most(1, "s", 2)}, file)
    store({"two": at_most(3, "s", 2, "peer")}, file)
    assert json.loads(file.read_text()) == {
        "one": {"value": 1, "unit": "s", "target": "<= 2", "peer": "none", "met": True},
        "two": {"value": 3, "unit": "s", "target": "<= 2", "peer": "peer", "met": False},
    }


def test_a_damaged_file_is_replaced(tmp_path: Path) -> None:
    """Source: docs/explanation/timing.md: out/bench.json."""
    file = tmp_path / "bench.json"
    for damaged in ("{", "[1]"):
        file.write_text(damaged)
        store({"one": at_most(1, "s", 2)}, file)
        assert list(json.loads(file.read_text())) == ["one"]


def test_the_percentile_of_a_few_values() -> None:
    """Source: the definition: the smallest value that this share does not exceed."""
    assert percentile([], 0.99) == 0
    assert percentile([5], 0.99) == 5
    assert percentile(list(range(1, 101)), 0.99) == 100
    assert percentile(list(range(1, 101)), 0.5) == 51


@pytest.mark.parametrize("point", POINTS)
def test_every_point_can_be_measured(point: str) -> None:
    """Source: the Makefile: make bench ONLY=point."""
    assert callable(import_module(f"rcx_tools.bench.{point}").measure)


def test_an_unknown_point_is_reported_with_the_known_points(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Source: the Makefile: make bench ONLY=point."""
    assert main(["--only", "handshakes"]) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert "there is no point 'handshakes' to measure; handshake, sizes" in said


def test_a_wrong_duration_gives_one_message(capsys: pytest.CaptureFixture[str]) -> None:
    """Source: the Makefile: make bench FOR=10s."""
    assert main(["--for", "soon"]) == 2
    assert "'soon' is not a duration" in capsys.readouterr().err


def test_results_of_tests_are_read_as_pytest_writes_them(tmp_path: Path) -> None:
    """Source: pytest: --junitxml."""
    file = tmp_path / "tests.xml"
    file.write_text(
        '<testsuites><testsuite><testcase classname="a" name="one" time="0.5"/>'
        '<testcase classname="a" name="two" time="2"><failure/></testcase>'
        '<testcase classname="b" name="three"><skipped/></testcase></testsuite></testsuites>'
    )
    assert read(file) == [
        ("a::one", "passed", 0.5),
        ("a::two", "failed", 2.0),
        ("b::three", "skipped", 0.0),
    ]


def test_a_process_that_ends_at_its_start_is_reported() -> None:
    """Source: docs/explanation/timing.md: the page names missing figures."""
    said = pytest.raises(InputError, match="has ended at its start")
    with running("rcx_tools.bench.peer_that_is_not", []) as process, said:
        first_line(process)
