"""A signal that never changes has a line in the chart if it explains why nothing happens."""

from __future__ import annotations

from pathlib import Path

import pytest

from rcx_harness.cli.app import main
from rcx_harness.trace import Scan, Trace, Violation
from rcx_harness.trace.chart import Timeline, text_chart
from rcx_harness.trace.chart_svg import svg_chart
from structured_text.language.types import ElementaryType

SI00, SI01, SI06, SI10, SI12, SI14, SI15, SI17 = (1 << k for k in (0, 1, 6, 8, 10, 12, 13, 15))
SO00, SO02, SO13 = 1 << 0, 1 << 2, 1 << 11


def area(bits: int = 0, code: int = 0, group: int = 0, category: int = 0) -> bytes:
    head = b"".join(word.to_bytes(2, "little") for word in (code, group, category))
    return head + bytes(26) + bits.to_bytes(2, "little") + bytes(14)


def timeline(*steps: tuple[bytes, bytes], trace: Trace | None = None) -> Timeline:
    """Return a timeline with a scan per 100 ms: the areas that were read and written."""
    made = Timeline(trace)
    for number, (so, si) in enumerate(steps):
        made.take(Scan(number * 100_000, number, so, si))
    return made


def signals(made: Timeline) -> list[str]:
    """Return the signals that have a line in the chart."""
    lines = text_chart(made, 100).splitlines()
    return [line[:6] for line in lines if line[:2] in ("SI", "SO")]


def off(made: Timeline) -> set[str]:
    """Return the signals of the chart that are OFF from the first to the last column."""
    lines = text_chart(made, 100, ascii_only=True).splitlines()
    return {
        line[:6] for line in lines if line[:2] in ("SI", "SO") and set(line.split()[-1]) == {"_"}
    }


@pytest.mark.parametrize(
    ("si", "so", "expected"),
    [
        # Chapter 5, 2: an output that should answer an input, but never turned ON, has a line.
        (SI00 | SI06 | SI17, 0, {"SO(11)"}),
        (SI00 | SI06 | SI14, 0, {"SO(11)"}),
        (SI10, 0, {"SO(12)"}),
        (SI00 | SI01, 0, {"SO(02)"}),
        (SI00 | SI01, SO02, set()),
        # Chapter 5, 2 and 3.2: SI(15) needs AUTO mode. SI(12) also needs SI(00) and SI(06).
        (SI15, 0, {"SO(14)", "SO(10)"}),
        (SI00 | SI12, 0, {"SO(13)", "SO(10)", "SI(06)"}),
        (SI00 | SI12, SO13, set()),
        # Chapter 5, 3.1: an emergency stop that SI(00) has never released.
        (0, SO00, {"SI(00)"}),
        (SI00, SO00, set()),
    ],
)
def test_a_missing_answer_has_a_line_in_the_chart(si: int, so: int, expected: set[str]) -> None:
    """Source: manual chapter 5, 2 and 3."""
    assert off(timeline((area(), area()), (area(so), area(si)))) == expected


@pytest.mark.parametrize(
    ("group", "category", "expected"),
    [
        (6, 302, ["SO(11)"]),  # origin incomplete
        (6, 301, ["SO(02)"]),  # servo off
        (12, 400, ["SI(06)"]),  # alarm 12.400, "standard in stop on"
        (2, 334, []),  # no signal shows "over soft limit"
    ],
)
def test_the_signal_of_an_alarm_that_ended_a_command_has_a_line(
    group: int, category: int, expected: list[str]
) -> None:
    """Source: spec/public_alarms.toml, names of alarms."""
    made = timeline(
        (area(), area()),
        (area(), area(code=0x0001)),
        (area(code=0x4000, group=group, category=category), area()),
    )
    assert signals(made) == expected


def test_a_signal_that_a_broken_rule_names_has_a_line() -> None:
    """Source: docs/reference/trace.md, charts."""
    made = timeline((area(), area()), (area(SO13), area(SI00 | SI12)))
    made.take(Violation(100_000, "start against stop", "plc: SI(12) ON while SI(06) is OFF"))
    assert signals(made) == ["SI(00)", "SI(06)", "SI(12)", "SO(13)"]


def test_a_signal_that_the_cause_of_an_error_names_has_a_line_in_every_band() -> None:
    """If the cause of an ErrorID names a signal, the signal has a line in each band of the chart.

    16#807B means that SO(11) is OFF. The ErrorID is watched, or reported at the end of the run.

    Source: docs/reference/errors.md.
    """
    made = timeline(*((area(SO02 * (k % 2)), area()) for k in range(40)))
    assert set(signals(made)) == {"SO(02)"}
    made.explain([0x807B, 0x1234])
    assert signals(made) == ["SO(02)", "SO(11)"] * signals(made).count("SO(02)")
    assert "SO(11) Return-to-origin complete status output" in svg_chart(made)
    watched = Timeline(Trace({}, watched={"Main.Fault": ElementaryType("WORD")}))
    for number, value in enumerate([0, 0x807B, 0]):
        watched.take(Scan(number, number, area(), area(), vars={"Main.Fault": value}))
    assert signals(watched) == ["SO(11)"]


@pytest.mark.parametrize("fault", ["16#0000", "16#807B"])
def test_rcx_run_reads_the_errors_of_the_program_at_the_end(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], fault: str
) -> None:
    """Source: docs/reference/trace.md, charts."""
    file = tmp_path / "Main.st"
    file.write_text(
        "PROGRAM Main\n  VAR InputArea, OutputArea : ARRAY [0..47] OF BYTE; Fault : WORD; END_VAR\n"
        f"  Fault := WORD#{fault};\n  OutputArea[32] := BYTE#16#01;\nEND_PROGRAM\n"
    )
    robot = tmp_path / "robot.toml"
    robot.write_text("origin_complete = false\n")
    words = ["--for", "100ms", "--engine", "builtin", "--show", "--robot", str(robot)]
    assert main(["run", str(file), *words]) == 0
    assert ("SO(11)" in capsys.readouterr().out) is (fault != "16#0000")
