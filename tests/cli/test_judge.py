"""`rcx judge` reports violations in its output and by its exit code."""

from __future__ import annotations

import gzip
import json
import sys
from pathlib import Path

import pytest

from captures import Story, area, pcap, pcapng
from rcx_harness.cli.app import main
from rcx_harness.look.judge import judge as judge_module
from rcx_harness.trace import Cycle, Scan

Captured = pytest.CaptureFixture[str]


def _story(*, good: bool) -> Story:
    """Return a capture in AUTO mode in which SI(00) turns ON at 200 ms.

    SI(06) follows 150 ms later if `good` is TRUE, otherwise 50 ms later, which is too early.
    """
    story = Story()
    story.open(0)
    for k in range(1, 51):
        second = 35 if good else 25
        si = (k >= 20) | (k >= second) << 6
        story.both(10_000 * k, area(dedicated=si), area(dedicated=0x0112))
    return story


@pytest.fixture
def good(tmp_path: Path) -> Path:
    return pcapng(tmp_path / "good.pcapng", _story(good=True).frames())


@pytest.fixture
def bad(tmp_path: Path) -> Path:
    return pcap(tmp_path / "bad.pcap", _story(good=False).frames())


def test_a_good_recording_ends_with_0(good: Path, capsys: Captured) -> None:
    assert main(["judge", str(good)]) == 0
    shown = capsys.readouterr()
    assert shown.err == ""
    assert "    0.200000 s  SI(00) ON   Emergency stop input" in shown.out.splitlines()
    assert shown.out.endswith("no violations\n")


def test_a_broken_rule_ends_with_1_and_is_reported_with_its_time(
    bad: Path, capsys: Captured
) -> None:
    """An interval of 50 ms is reported with its time and its packet, and the exit code is 1.

    The manual demands 100 ms (chapter 5, 3, caution). The PLC's packet at 10 * k ms has number 2 *
    k + 1.
    """
    assert main(["judge", str(bad), "--quiet"]) == 1
    last = capsys.readouterr().out.splitlines()[-2:]
    text = "plc, packet 51: interval: SI(06) ON only 50 ms after SI(00) ON; at least 100 ms"
    assert last == [f"violation at 0.250000 s: {text}", "1 violation"]


def test_chart_and_trace_are_written(bad: Path, tmp_path: Path, capsys: Captured) -> None:
    """The chart and the trace are written. Judging this trace gives the same violation."""
    chart, trace = tmp_path / "chart.svg", tmp_path / "trace.jsonl"
    outputs = ["--chart", str(chart), "--trace", str(trace), "--show"]
    assert main(["judge", str(bad), *outputs]) == 1
    assert "time [ms]" in capsys.readouterr().out
    assert "SI(06) Stop input" in chart.read_text(encoding="utf-8")
    assert main(["judge", str(trace), "--quiet"]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "trace.jsonl: a trace of rcx judge, 0.250 s"
    assert lines[-1] == "1 violation"


def test_files_of_the_user_are_not_overwritten(
    good: Path, tmp_path: Path, capsys: Captured
) -> None:
    for option in ("--trace", "--chart"):
        assert main(["judge", str(good), option, str(good)]) == 2
        assert "would be overwritten, but it is an input" in capsys.readouterr().err
    mine = tmp_path / "mine.txt"
    mine.write_text("keep this")
    assert main(["judge", str(good), "--chart", str(mine)]) == 2
    assert mine.read_text() == "keep this"


def test_a_trace_of_a_run_has_the_same_result_as_the_run(
    repository: Path, tmp_path: Path, capsys: Captured
) -> None:
    """The trace of example 01 has no violation, and its servos are on at 820 ms."""
    example, trace = repository / "plc/examples/01_power_up", tmp_path / "run.jsonl"
    given = ["--robot", str(example / "robot.toml"), "--stimulus", str(example / "stimulus.toml")]
    assert main(["run", str(example), *given, "--for", "2s", "--trace", str(trace)]) == 0
    capsys.readouterr()
    assert main(["judge", str(trace)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "    0.820000 s  SO(02) ON   Servo ON status output" in lines
    assert any(line.startswith("run.jsonl: a trace of rcx run, 1.990 s") for line in lines)


@pytest.mark.parametrize(("by", "found"), [("rcx serve", 1), ("rcx judge", 0)])
def test_a_trace_that_was_not_yet_judged_is_judged(
    tmp_path: Path, capsys: Captured, by: str, found: int
) -> None:
    """In a trace of `rcx serve`, simultaneous changes of SI(01) and SI(06) are reported.

    `rcx serve` does not check the rules for PLCs when it writes a trace.
    """
    so = area(dedicated=0x0112)
    every: list[Cycle | Scan] = []
    for number, bits in enumerate((0x01, 0x01, 0x43)):
        seen = (1_000_000 * number, number, area(dedicated=bits), so)
        every.append(Cycle(*seen) if by == "rcx serve" else Scan(*seen[:2], so, seen[2]))
    file = tmp_path / "trace.jsonl"
    head = json.dumps({"format": "rcx-trace/1", "by": by})
    file.write_text("\n".join([head, *(one.line() for one in every)]) + "\n")
    assert main(["judge", str(file), "--quiet"]) == found
    said = "plc, cycle 2: interval: SI(01) ON and SI(06) ON in one scan" in capsys.readouterr().out
    assert said == bool(found)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, "cannot be read: No such file or directory"),
        (b"", "is neither a capture (pcapng, pcap) nor a trace (jsonl)"),
        (b"hello", "is neither a capture (pcapng, pcap) nor a trace (jsonl)"),
        (gzip.compress(b"anything", mtime=0), "nor a trace (jsonl); unpack it first"),
        (b"\xd4\xc3\xb2\xa1", "not a capture: truncated"),
        (b'{"format":"rcx-trace/1"}\n', "contains no scan and no cycle"),
        (b'{"format":"rcx-trace/1"}\n{"t_us":', ":2: is cut off in this line"),
        (b'{"format":"rcx-trace/1"}\n{"t_us":"\xff"}\n', ":2: not a line of a trace"),
        (b'{"format":"rcx-trace/1"}\n{"t_us":0,"scan":0,"so":"00","si":"00"}\n', "1 and 1 bytes"),
    ],
)
def test_an_invalid_recording_is_one_line_and_exit_code_2(
    tmp_path: Path, capsys: Captured, content: bytes | None, message: str
) -> None:
    file = tmp_path / "file.jsonl"
    if content is not None:
        file.write_bytes(content)
    assert main(["judge", str(file)]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.startswith(f"rcx: {file}")
    assert error.count("\n") == 1


def test_a_capture_that_is_cut_off_is_judged_and_reported(bad: Path, capsys: Captured) -> None:
    bad.write_bytes(bad.read_bytes()[:-5])
    assert main(["judge", str(bad), "--quiet"]) == 2
    shown = capsys.readouterr()
    assert shown.out.splitlines()[-1] == "1 violation"
    assert "is cut off after packet 101, 0.500 s; the packets before it were judged" in shown.err


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--controller", "robot"], "--controller 'robot' is not an IPv4 address"),
        (["--size", "50"], "an area of 50 bytes does not exist"),
        (["--port", "0"], "--port 0 is not a port"),
        (["--tolerance", "soon"], "--tolerance: 'soon' is not a duration"),
        (["--controller", "192.168.0.99"], "contains no connection of a controller"),
    ],
)
def test_bad_options_are_named(
    good: Path, capsys: Captured, options: list[str], message: str
) -> None:
    assert main(["judge", str(good), *options]) == 2
    assert message in capsys.readouterr().err


def test_a_missing_capture_library_is_reported_with_the_install_command(
    good: Path, capsys: Captured, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "cypcap", None)
    assert main(["judge", str(good)]) == 2
    error = capsys.readouterr().err
    assert (
        error
        == "rcx: reading captures needs the library cypcap; pip install 'rcx-harness[capture]'\n"
    )


def test_slow_work_shows_its_progress(
    good: Path, capsys: Captured, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Long work prints its progress every two seconds.

    The test's clock advances 1 s at each call.
    """
    seconds = iter(range(10_000))
    monkeypatch.setattr("rcx_harness.cli.progress.time.monotonic", lambda: next(seconds))
    monkeypatch.setattr(judge_module, "REPORT_EVERY", 10)
    assert main(["judge", str(good), "--quiet"]) == 0
    told = capsys.readouterr().err.splitlines()
    assert len(told) >= 4
    assert all(line.startswith("reading: ") and line.endswith("%") for line in told)
