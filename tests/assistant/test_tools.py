"""The tools for assistants give the results of the commands, as data and as short texts."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from assistant_client import here
from rcx_harness.assistant import blocks
from rcx_harness.assistant.call import Answer, Call

COUNTER = """PROGRAM Counter
  VAR
    Sum : INT;
    Step : INT := 1;
  END_VAR
  Sum := Sum + Step;
END_PROGRAM
"""
#: Two scans of 10 ms. SI(00), bit 0 of byte 32, turns ON in the second scan; SO(00) and SO(01),
#: bits 0 and 1 of byte 32, are ON. Main.Step changes from 1 to 2.
_OFF, _ON, _BOTH = bytes(48), bytes(32) + b"\x01" + bytes(15), bytes(32) + b"\x03" + bytes(15)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "Counter.st").write_text(COUNTER)
    return tmp_path


def test_check_reports_a_mistake_with_file_and_line(folder: Path) -> None:
    (folder / "Counter.st").write_text(COUNTER.replace("Sum + Step", "Sum + Steps"))
    found = here("check", folder, files=["Counter.st"])
    assert found["data"]["exit_code"] == 2
    row = found["data"]["findings"][0]
    assert (row["level"], row["file"], row["line"]) == ("error", "Counter.st", 6)
    assert "Steps" in row["text"]
    assert found["text"].startswith("error: Counter.st:6:")


def test_a_run_has_its_last_values_and_a_replay(folder: Path) -> None:
    """The step is 1 in the scans at 0 ms and 10 ms, and 5 from the scan at 20 ms to that at 40 ms.

    So the sum is 1 + 1 + 3 * 5 = 17.
    """
    stimulus = '[[at]]\ntime = "20ms"\nset = { "Main.Step" = 5 }\n'
    given = {"files": ["Counter.st"], "stimulus": stimulus, "duration": "50ms", "no_robot": True}
    found = here("run", folder, **given, watch=["Main.Sum"], scan="10ms")
    data = found["data"]
    assert data["watched"] == {"Main.Sum": "17"}
    assert (data["exit_code"], data["violations"], data["end_us"]) == (0, [], 40_000)
    file = folder / data["trace"]
    assert file.is_file()
    assert file.with_name("stimulus.toml").read_text() == stimulus
    assert f"--stimulus={file.with_name('stimulus.toml').relative_to(folder)}" in data["replay"]


def test_the_same_run_has_the_same_bytes(folder: Path) -> None:
    given = {"files": ["Counter.st"], "duration": "50ms", "no_robot": True}
    first = json.dumps(here("run", folder, **given))
    trace = folder / json.loads(first)["data"]["trace"]
    bytes_of_first = trace.read_bytes()
    assert json.dumps(here("run", folder, **given)) == first
    assert trace.read_bytes() == bytes_of_first


@pytest.mark.parametrize("duration", ["601s", "11m"])
def test_a_run_that_is_too_long_is_refused(folder: Path, duration: str) -> None:
    found = here("run", folder, files=["Counter.st"], duration=duration)
    assert "which is too long for a call; use at most 10m" in found["error"]


def test_a_stimulus_with_a_mistake_is_refused(folder: Path) -> None:
    given = {"files": ["Counter.st"], "no_robot": True}
    found = here("run", folder, **given, stimulus='[[at]]\ntime = "1ms"\nst = 1\n')
    assert "stimulus.toml" in found["error"]
    assert "Traceback" not in found["error"]


def _trace(folder: Path) -> None:
    header = {"format": "rcx-trace/1", "scan_us": 10_000, "size": 48, "watch": {}}
    scans = [
        {"t_us": 0, "scan": 0, "so": _BOTH.hex(), "si": _OFF.hex(), "vars": {"Main.Step": "1"}},
        {"t_us": 10_000, "scan": 1, "so": _BOTH.hex(), "si": _ON.hex(), "vars": {"Main.Step": "2"}},
    ]
    broken = {"t_us": 10_000, "violation": "plc, scan 1: interval: SI changed too early"}
    lines = [json.dumps(one) for one in (header, *scans, broken)]
    (folder / "trace.jsonl").write_text("\n".join(lines) + "\n")


def test_a_trace_is_explained_with_its_events_and_state(folder: Path) -> None:
    """Source: the bits are those of the manual, chapter 5, 1 and 2."""
    _trace(folder)
    data = here("explain_trace", folder, trace="trace.jsonl")["data"]
    events = [(event["t_us"], event["text"]) for event in data["events"]]
    assert (10_000, "Main.Step changes from 1 to 2") in events
    assert any(t_us == 10_000 and text.startswith("SI(00) ON") for t_us, text in events)
    assert any(t_us == 0 and text.startswith("SO(01) ON") for t_us, text in events)
    assert (10_000, "broken rule: plc, scan 1: interval: SI changed too early") in events
    assert data["violation_count"] == 1
    names = [name.partition(" ")[0] for name in data["state"]["signals_on"]]
    assert names == ["SO(00)", "SO(01)", "SI(00)"]
    assert data["state"]["watched"] == {"Main.Step": "2"}


def test_a_trace_is_explained_around_a_time(folder: Path) -> None:
    _trace(folder)
    given = {"trace": "trace.jsonl", "at": "2ms", "window": "3ms"}
    data = here("explain_trace", folder, **given)["data"]
    assert {event["t_us"] for event in data["events"]} == {0}
    assert data["state"]["watched"] == {"Main.Step": "1"}


def test_a_time_after_the_end_of_a_trace_is_refused(folder: Path) -> None:
    _trace(folder)
    found = here("explain_trace", folder, trace="trace.jsonl", at="20ms")
    assert found["error"] == "trace.jsonl: ends at 10 ms, before 20 ms; use an earlier time"


def test_a_variable_that_changes_often_is_one_event(folder: Path) -> None:
    """Sum counts from 1 in the scan at 0 ms to 30 in the scan at 290 ms: 29 changes."""
    given = {"files": ["Counter.st"], "duration": "300ms", "scan": "10ms", "no_robot": True}
    trace = here("run", folder, **given, watch=["Main.Sum"])["data"]["trace"]
    data = here("explain_trace", folder, trace=trace)["data"]
    text = "Main.Sum changes 29 times until 290 ms, then 30"
    assert data["events"] == [{"t_us": 10_000, "text": text}]


def test_a_fault_of_the_package_is_an_answer(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The message names the error and its place, and has no traceback."""

    def fails(call: Call) -> Answer:
        raise ValueError(call.tool)

    monkeypatch.setattr(blocks, "list_blocks", fails)
    said = here("list_blocks", folder)["error"]
    assert said.startswith("this is an error of rcx itself: ValueError: list_blocks (test_tools.py")
    assert "\n" not in said
