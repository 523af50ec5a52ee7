"""`make bench ONLY=scan` measures areas, idle blocks and handshakes."""

from __future__ import annotations

import pytest

from rcx_tools.bench import scan
from rcx_tools.bench.figure import Options
from structured_text.errors import InputError


def test_without_a_compiler_its_figures_are_said_to_be_missing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(scan, "why_not", lambda engine: f"{engine} not found")
    measured = scan.measure(Options(quick=True))
    assert len(measured) == len(scan.ENGINES) * len(scan.ROWS)
    assert {(figure.value, figure.met) for figure in measured.values()} == {(None, False)}
    assert {figure.peer for figure in measured.values()} == {
        "matiec not found",
        "strucpp not found",
    }


@pytest.mark.exhaustive
def test_each_program_of_the_benchmark_runs_with_its_handshakes() -> None:
    """Each program of the benchmark runs on the built-in engine, and executes handshakes.

    Programs that work on this engine also work on the compilers.
    """
    assert scan.paid("builtin", rounds=1, scans=200).area > 0


@pytest.mark.exhaustive
def test_a_handshake_that_does_not_run_gives_no_figure(monkeypatch: pytest.MonkeyPatch) -> None:
    """If too few commands were executed, no figure is reported.

    Ten robots in 200 scans, with at most eight scans per command, must execute many commands.
    """
    stands = scan.RUNNING.replace("NOT Move{k}.Done", "FALSE")
    monkeypatch.setattr(scan, "RUNNING", stands)
    with pytest.raises(InputError, match="builtin: 0 commands in 200 scans are too few"):
        scan.paid("builtin", rounds=1, scans=200)
