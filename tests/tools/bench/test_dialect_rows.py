"""The built-in engine and matiec agree in each row of the dialect table that both can run."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from rcx_tools.bench import dialect_rows, language
from rcx_tools.bench.dialect_rows import PROBES, compared_rows, probe_of, program_text
from rcx_tools.bench.figure import Options
from structured_text.engines.matiec.build import Matiec
from structured_text.engines.matiec.faults import places
from structured_text.engines.native.toolchain import find_c_compiler
from structured_text.language.dialects import MATIEC, rows, rules_of
from structured_text.language.load import load
from structured_text.language.source import in_dialect


def test_every_row_of_the_matiec_dialect_is_compared_except_the_interval_of_tasks() -> None:
    """Every row of the matiec dialect is compared, except the interval of a program without a task.

    This is the only rule that matiec cannot run.

    Source: language/dialects.toml.
    """
    own = [row for row in rows() if MATIEC in row.tools]
    assert [row.rule for row in own if probe_of(row) is None] == ["pace"]
    used = [id(probe_of(row)) for row in rows() if probe_of(row)]
    assert {id(probe) for probe in PROBES} == set(used)


def test_no_fault_of_matiec_concerns_a_compared_row(tmp_path: Path) -> None:
    """Source: engines/matiec/faults.toml."""
    file = tmp_path / "row.st"
    for row in rows():
        if (probe := probe_of(row)) is not None:
            file.write_text(program_text(probe), encoding="utf-8")
            for tool in row.tools:
                assert [str(place) for place in places(load([in_dialect(file, tool)]))] == []


@pytest.mark.exhaustive
def test_both_engines_agree_on_random_calls_of_each_row(matiec: Matiec) -> None:
    """Source: language/dialects.toml."""
    compiler = find_c_compiler()
    assert compiler is not None
    found = list(compared_rows(matiec, compiler, 10_000))
    assert [one.row for one in found] == list(rows())
    assert [one.text for one in found if one.difference] == []
    assert {one.calls >= 10_000 for one in found if one.calls} == {True}
    assert sum(bool(one.calls) for one in found) == sum(probe_of(row) is not None for row in rows())


@pytest.mark.exhaustive
@pytest.mark.parametrize(("rule", "value"), [("counters", "type"), ("time_unit", "ms")])
def test_a_row_that_matiec_computes_differently_is_reported(
    matiec: Matiec, monkeypatch: pytest.MonkeyPatch, rule: str, value: str
) -> None:
    """A row that matiec computes differently is reported.

    Counters and TIME are compared with rules of other dialects, so the comparison must fail.

    Source: language/dialects.toml; engines/matiec/faults.toml.
    """
    compiler = find_c_compiler()
    assert compiler is not None
    computed = getattr(rules_of(MATIEC), rule)
    probe = next(one for one in PROBES if one.rule == rule and computed in one.values)
    monkeypatch.setattr(dialect_rows, "PROBES", (replace(probe, values=(value,)),))
    found = [one for one in compared_rows(matiec, compiler, 300) if one.calls]
    assert found
    assert all(one.difference.startswith("differs in ") for one in found)
    assert all(" on matiec, call " in one.text for one in found)


@pytest.mark.exhaustive
def test_the_bench_prints_a_line_for_each_row_without_libraries(
    matiec: Matiec, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Source: docs/reference/language.md, measured on public libraries."""
    del matiec
    monkeypatch.delenv("RCX_LIBRARIES", raising=False)
    monkeypatch.delenv("RCX_REPOSITORIES", raising=False)
    figures = language.measure(Options(quick=True))
    lines = capsys.readouterr().out.splitlines()
    for row in rows():
        name = f"{row.title} ({', '.join(row.tools)}): "
        assert sum(line.startswith(name) for line in lines) == 1
    assert figures["language rows that differ"].met
    assert (figures["language calls of a row"].value or 0) >= 1000
