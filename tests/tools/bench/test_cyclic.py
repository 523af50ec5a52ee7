"""The benchmark of cyclic I/O has a plan of runs, and starts its processes in order."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from types import SimpleNamespace
from typing import Any

import pytest

from rcx_tools.bench import cyclic
from rcx_tools.bench.cyclic import Case, Run, cases, measure
from rcx_tools.bench.figure import Options


def test_every_interval_and_number_of_controllers_is_run_with_and_without_a_flood() -> None:
    """Source: docs/explanation/timing.md: 10, 5, 2 and 1 ms; 1 and 16 controllers."""
    planned = [case for case in cases(Options()) if not case.ordinary]
    assert [(case.rpi_us, case.controllers) for case in planned[::2]] == [
        (10_000, 1), (5_000, 1), (2_000, 1), (1_000, 1), (10_000, 16),
    ]  # fmt: skip
    assert [case._replace(flooded=True) for case in planned[::2]] == planned[1::2]
    assert not any(case.flooded for case in planned[::2])


def test_the_shortest_intervals_are_also_run_without_priority() -> None:
    """Source: docs/explanation/timing.md: 2 and 1 ms, one controller."""
    ordinary = [case for case in cases(Options()) if case.ordinary]
    assert ordinary == [Case(2_000, 1, False, True), Case(1_000, 1, False, True)]
    assert [case.name for case in ordinary] == ["cyclic_2ms_ordinary", "cyclic_1ms_ordinary"]


def test_the_quick_plan_has_one_controller() -> None:
    """Source: make bench MORE=--quick: small samples."""
    assert {case.controllers for case in cases(Options(quick=True))} == {1}


def test_each_run_prints_a_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Source: docs/explanation/timing.md: long work shows progress."""

    def done(case: Case, seconds: float) -> Run:
        packets = round(case.rate * seconds)
        return Run(case, seconds, packets, packets, 0, 1, 1, 1, 0, 300.0)

    monkeypatch.setattr(cyclic, "run", done)
    loops_us = iter((55.0, 56.0, 57.0, 58.0))
    monkeypatch.setattr(cyclic, "bare", lambda rpi_us, seconds: next(loops_us))
    found = measure(Options(seconds=10.0, rpi_us=(2_000,)))
    assert [line.strip() for line in capsys.readouterr().out.splitlines()] == [
        "5 runs of 10 s",
        "1 of 5: cyclic_2ms, 1000 packets/s",
        "2 of 5: cyclic_2ms_flood, 1000 packets/s",
        "3 of 5: cyclic_2ms_ordinary, 1000 packets/s, without real-time priority",
        "4 of 5: cyclic_10ms_x16, 3200 packets/s",
        "5 of 5: cyclic_10ms_x16_flood, 3200 packets/s",
    ]
    assert found["cyclic_2ms_flood_rate"].unit == "of the quiet run"
    told = {name: found[f"cyclic_2ms_{name}cpu"] for name in ("", "ordinary_")}
    assert [(one.target, one.met) for one in told.values()] == [("<= 65", False)] * 2
    assert "bare loops 55 and 56 us" in told[""].peer
    assert "bare loops 57 and 58 us" in told["ordinary_"].peer
    assert {name for name, one in found.items() if one.target != "none"} == {
        "cyclic_2ms_missing", "cyclic_2ms_rate", "cyclic_2ms_flood_rate",
        "cyclic_2ms_ordinary_missing", "cyclic_2ms_ordinary_gap_p99", "cyclic_10ms_x16_missing",
        "cyclic_2ms_cpu", "cyclic_2ms_ordinary_cpu",
    }  # fmt: skip


def test_all_processes_have_started_before_the_first_packet(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """All processes have started before the first packet, because packets would delay their start.

    Source: sched(7): a process with SCHED_FIFO runs until it waits.
    """
    happened: list[str] = []
    status = SimpleNamespace(received=0, missing=0, gap_median_us=0, gap_p99_us=0)

    def adapter(size: int, host: str, **_: object) -> AbstractContextManager[Any]:
        happened.append(f"adapter {host}")
        shared = SimpleNamespace(status=lambda: status)
        return nullcontext(SimpleNamespace(address=(host, 44818), shared=shared))

    def scanner(host: str, *_: object, **__: object) -> AbstractContextManager[Any]:
        happened.append(f"scanner {host}")
        made = SimpleNamespace(statistics=lambda: status, write=lambda image: None)
        made.open = lambda: happened.append(f"open {host}")
        return nullcontext(made)

    def running(module: str, arguments: list[str]) -> AbstractContextManager[Any]:
        happened.append(arguments[0])
        process = SimpleNamespace(name=arguments[0], communicate=lambda: ("[]", None))
        return nullcontext(process)

    def note(text: str) -> Any:
        return lambda process: happened.append(f"{process.name} {text}")

    monkeypatch.setattr(cyclic, "Adapter", adapter)
    monkeypatch.setattr(cyclic, "Scanner", scanner)
    monkeypatch.setattr(cyclic, "running", running)
    monkeypatch.setattr(cyclic, "first_line", note("is ready"))
    monkeypatch.setattr(cyclic, "begin", note("begins"))
    monkeypatch.setattr(cyclic, "in_ordinary_time", lambda module: happened.append("ordinary"))
    monkeypatch.setattr(cyclic, "cpu_of_children", lambda module: 0.0)
    cyclic.run(Case(2_000, 2, flooded=True, ordinary=True), 0.0)
    assert happened == [
        "adapter 127.0.77.1", "scanner 127.0.77.1", "adapter 127.0.77.2", "scanner 127.0.77.2",
        "flood", "flood", "timer",
        "flood is ready", "flood is ready", "timer is ready", "ordinary",
        "open 127.0.77.1", "open 127.0.77.2", "flood begins", "flood begins", "timer begins",
    ]  # fmt: skip
