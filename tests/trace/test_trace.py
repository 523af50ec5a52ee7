from __future__ import annotations

import json
from collections.abc import Callable
from datetime import timedelta
from pathlib import Path

import pytest

from rcx_harness import Cell, InputError, RobotConfig
from rcx_harness.trace import Cycle, Scan, Trace, Violation, read_trace

Build = Callable[..., Cell]
HEADER = {"scan_us": 10000, "cycle_us": 5000, "size": 48}


def test_the_lines_have_exactly_the_documented_format() -> None:
    """Lines have a fixed order of keys, no spaces, and hexadecimal areas."""
    trace = Trace(HEADER)
    trace.add(Cycle(0, 0, b"", bytes.fromhex("0002")))
    trace.add(Scan(0, 0, bytes.fromhex("00ff"), bytes.fromhex("0100")))
    trace.add(Scan(10, 1, b"\0", b"\1", {"Main.X": 1.5, "Main.T": timedelta(milliseconds=1500)}))
    trace.add(Violation(10, "interval", "interval: SI(01) ON"))
    assert list(trace.lines()) == [
        '{"format":"rcx-trace/1","scan_us":10000,"cycle_us":5000,"size":48}',
        '{"t_us":0,"cycle":0,"rcx_si":"","rcx_so":"0002"}',
        '{"t_us":0,"scan":0,"so":"00ff","si":"0100"}',
        '{"t_us":10,"scan":1,"so":"00","si":"01","vars":{"Main.X":1.5,"Main.T":"T#1500ms"}}',
        '{"t_us":10,"violation":"interval: SI(01) ON"}',
    ]


def test_values_that_json_does_not_know_are_words() -> None:
    values = {"A": float("nan"), "B": float("-inf"), "C": [timedelta(0)], "D": {"E": True}}
    line = Scan(0, 0, b"", b"", values).line()
    assert json.loads(line)["vars"] == {"A": "nan", "B": "-inf", "C": ["T#0ms"], "D": {"E": True}}


def test_a_cell_writes_every_record_to_the_file(raw_cell: Build, tmp_path: Path) -> None:
    file = tmp_path / "deep" / "trace.jsonl"
    cell = raw_cell(
        trace=file, watch=["Main.Scans"], seed=4, robot=RobotConfig(boot_time=0.0), engine="builtin"
    )
    cell["Main.Bits0"] = 0x04
    cell.run("100ms")
    cell.close()
    header, records = read_trace(file)
    assert header == {"format": "rcx-trace/1", "scan_us": 10000, "cycle_us": 5000, "size": 48,
                      "engine": "builtin", "link": "direct", "seed": 4,
                      "watch": {"Main.Scans": "UDINT"}}  # fmt: skip
    assert list(records) == list(cell.trace)
    assert {type(record) for record in cell.trace} == {Scan, Cycle, Violation}
    assert cell.trace.scans()[-1].vars == {"Main.Scans": 10}


def test_memory_keeps_the_latest_records_and_the_file_all(tmp_path: Path) -> None:
    trace = Trace(HEADER, tmp_path / "t.jsonl", keep=10)
    for k in range(100):
        trace.add(Violation(k, "x", "x"))
    trace.close()
    assert [record.t_us for record in trace] == list(range(90, 100))
    assert len((tmp_path / "t.jsonl").read_text().splitlines()) == 101


def test_two_runs_of_one_seed_are_the_same_bytes(raw_cell: Build, tmp_path: Path) -> None:
    for name in ("a", "b"):
        cell = raw_cell(trace=tmp_path / name, phases="random", jitter="12ms", seed=9)
        cell.run("500ms")
        cell.close()
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "t.jsonl: is empty; a trace begins with a header"),
        ("{", "t.jsonl:1: not a line of a trace"),
        ('{"format":"rcx-trace/2"}\n',
         "t.jsonl:1: is a trace of format rcx-trace/2, and this version of rcx reads"),
        ("{}\n", "t.jsonl:1: not a trace of format rcx-trace/1"),
        ('{"format":"rcx-trace/1","size":49}\n',
         "t.jsonl:1: size is 49; use 48 or 256"),
        ('{"format":"rcx-trace/1","size":"48"}\n', "t.jsonl:1: size is '48', and not a number"),
        ('{"format":"rcx-trace/1","scan_us":-1}\n', "t.jsonl:1: scan_us is -1, and not a number"),
        ('{"format":"rcx-trace/1"}\nnonsense\n', "t.jsonl:2: not a line of a trace"),
        ('{"format":"rcx-trace/1"}\n{"t_us":1}\n', "t.jsonl:2: not a record of a trace"),
        ('{"format":"rcx-trace/1"}\n{"t_us":1,"scan":0,"so":"0g","si":""}\n',
         "t.jsonl:2: not a record of a trace"),
    ],
)  # fmt: skip
def test_a_file_that_is_no_trace_has_its_line(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "t.jsonl"
    file.write_text(text)
    with pytest.raises(InputError) as caught:
        list(read_trace(file)[1])
    assert message in str(caught.value)


def test_a_missing_trace_is_reported(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        read_trace(tmp_path / "none")
