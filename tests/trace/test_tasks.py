"""Traces, charts and wave files have the tasks of robot programs. Expected values are by hand."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from rcx_harness import InputError
from rcx_harness.trace import Cycle, Record, Scan, Trace, read_trace
from rcx_harness.trace.chart import Timeline, text_chart
from rcx_harness.trace.chart_svg import svg_chart
from rcx_harness.trace.scale import scaled_text
from rcx_harness.trace.tasks import statement_of, task_text
from rcx_harness.trace.wave import Wave

_LINES = ["WAIT SI(20)=1  ' the PLC asks", '  S$="it\'s"', "HALT"]
_PROGRAMS = [[{"name": "PLACE", "file": "PLACE.PGM", "lines": _LINES}]]
_HEADER = {"scan_us": 10_000, "cycle_us": 5000, "size": 48}


def _task(line: int, state: str = "running", task: int = 1, program: str = "PLACE") -> Any:
    return {"task": task, "program": program, "line": line, "state": state}


def _cycle(ms: int, *tasks: Any, controller: int = 1) -> Cycle:
    return Cycle(ms * 1000, ms // 5, b"", bytes(48), controller, tasks=tasks)


def _scan(ms: int, si: int = 0) -> Scan:
    return Scan(ms * 1000, ms // 10, bytes(48), bytes(32) + bytes([si]) + bytes(15))


#: SI(00) turns ON at 20 ms. Task 2 joins at 20 ms and leaves at 40 ms. The program stops at 30 ms.
_RUN: tuple[Record, ...] = (
    _cycle(0, _task(1, "ready")),
    _scan(0),
    _cycle(10, _task(1)),
    _cycle(20, _task(2), _task(7, task=2, program="LAMP")),
    _scan(20, si=1),
    _cycle(30, _task(2, "stopped"), _task(7, task=2, program="LAMP")),
    _cycle(40, _task(1, "ended")),
    _scan(60),
)


def _timeline(*records: Record) -> Timeline:
    timeline = Timeline()
    for record in records:
        timeline.take(record)
    return timeline


def test_the_lines_have_exactly_the_documented_format() -> None:
    """The lines of a trace have exactly the format of docs/reference/trace.md.

    The header has the listings, and a cycle has the tasks. Without robot programs nothing is added.

    Source: docs/reference/trace.md.
    """
    trace = Trace(_HEADER, programs=_PROGRAMS)
    trace.add(_cycle(5, _task(2)))
    trace.add(_cycle(10))
    head, first, second = trace.lines()
    assert head.endswith(
        ',"size":48,"programs":[[{"name":"PLACE","file":"PLACE.PGM","lines":["WAIT SI(20)=1  '
        '\' the PLC asks","  S$=\\"it\'s\\"","HALT"]}]]}'
    )
    tasks = '"tasks":[{"task":1,"program":"PLACE","line":2,"state":"running"}]'
    assert first.endswith(f'"rcx_so":"{"00" * 48}",{tasks}}}')
    assert second.endswith('"tasks":[]}')
    assert "programs" not in Trace(_HEADER, programs=[[], []]).header
    assert "tasks" not in Cycle(0, 0, b"", b"").line()


def test_a_trace_is_read_as_it_was_written(tmp_path: Path) -> None:
    records = [_cycle(5, _task(2)), Cycle(10_000, 2, b"", bytes(48))]
    trace = Trace(_HEADER, tmp_path / "t.jsonl", programs=_PROGRAMS)
    for record in records:
        trace.add(record)
    trace.close()
    header, read = read_trace(tmp_path / "t.jsonl")
    assert header["programs"] == _PROGRAMS
    assert list(read) == records


@pytest.mark.parametrize(
    "wrong",
    [
        {"task": 0},
        {"task": True},
        {"line": 0},
        {"line": "2"},
        {"program": 1},
        {"state": None},
    ],
)
def test_a_task_that_is_none_is_refused_with_its_line(tmp_path: Path, wrong: Any) -> None:
    record = json.loads(_cycle(5, _task(2)).line())
    record["tasks"][0] |= wrong
    head = json.dumps({"format": "rcx-trace/1", **_HEADER})
    file = tmp_path / "t.jsonl"
    file.write_text(f"{head}\n{json.dumps(record)}\n", encoding="utf-8")
    with pytest.raises(InputError, match="not a record of a trace") as caught:
        list(read_trace(file)[1])
    assert caught.value.line == 2


def test_a_task_in_words() -> None:
    assert task_text(_task(4)) == "PLACE:4"
    assert task_text(_task(4, "stopped"), "HALT") == "PLACE:4 stopped HALT"
    assert task_text(_task(1, "ready"), "HALT") == "PLACE ready"


def test_a_statement_is_shown_without_its_comment() -> None:
    """A statement is shown without its comment.

    An apostrophe in a quoted text does not begin a comment.
    """
    assert statement_of(_PROGRAMS[0], _task(1)) == "WAIT SI(20)=1"
    assert statement_of(_PROGRAMS[0], _task(2)) == 'S$="it\'s"'
    assert statement_of(_PROGRAMS[0], _task(4)) == ""
    assert statement_of(_PROGRAMS[0], _task(1, program="LAMP")) == ""


def test_a_chart_has_a_lane_for_each_task() -> None:
    """A chart has a lane for each task, but a change of a task adds no column.

    Only SI(00) adds columns: ON at 20 ms and OFF at 60 ms.
    """
    timeline = _timeline(*_RUN)
    lanes = {lane.name: lane for lane in timeline.lanes()}
    assert lanes["Task 1"].first == "PLACE ready"
    assert lanes["Task 1"].changes == [
        (10_000, "PLACE:1"),
        (20_000, "PLACE:2"),
        (30_000, "PLACE:2 stopped"),
        (40_000, "PLACE ended"),
    ]
    assert (lanes["Task 2"].first, lanes["Task 2"].changes) == (
        "",
        [(20_000, "LAMP:7"), (40_000, "")],
    )
    assert timeline.instants() == [20_000, 60_000]
    lines = {line[:6]: line for line in text_chart(timeline, 80, ascii_only=True).splitlines()}
    assert lines["Task 1"].endswith("--XPLACE:2-XPLACE ended-")
    assert ">PLACE:2</text>" in svg_chart(timeline)


def test_true_to_scale_a_lane_has_every_line() -> None:
    timeline = _timeline(*_RUN)
    lines = scaled_text(timeline, 77, ascii_only=True, line_us=61_000).splitlines()
    lane = next(line for line in lines if line.startswith("Task 1"))
    assert lane.index("PLACE:1") < lane.index("PLACE:2") < lane.index("PLACE ended")


def test_lanes_of_further_controllers_bear_their_number() -> None:
    timeline = _timeline(_cycle(0, _task(1)), _cycle(0, _task(3), controller=2))
    assert [lane.name for lane in timeline.lanes()][-2:] == ["Task 1", "2: Task 1"]


def test_a_wave_file_has_line_task_and_state_of_each_program(tmp_path: Path) -> None:
    """A wave file has line, task and state of each program.

    While a program is not in a task, its line and its task are 0.
    """
    programs = [[*_PROGRAMS[0], {"name": "LAMP", "lines": []}]]
    wave = Wave(tmp_path / "w.vcd", trace=Trace(_HEADER, programs=programs))
    for record in _RUN:
        wave.take(record)
    wave.close()
    text = (tmp_path / "w.vcd").read_text(encoding="ascii")
    assert _changes(text, "PLACE", "line") == ["b1", "b10", "b1"]
    assert _changes(text, "PLACE", "state") == ["sready", "srunning", "sstopped", "sended"]
    assert _changes(text, "LAMP", "task") == ["b0", "b10", "b0"]


def _changes(text: str, scope: str, name: str) -> list[str]:
    """Return the values of a variable in a wave file, with the first at time 0."""
    section = text[text.index(f"$scope module {scope} $end") :]
    found = re.search(rf"\$var \w+ \d+ (\S+) {name} ", section)
    assert found
    form = re.compile(rf"([brs]\S*) {re.escape(found[1])}")
    body = text[text.index("$dumpvars") :].splitlines()
    return [match[1] for line in body if (match := form.fullmatch(line))]
