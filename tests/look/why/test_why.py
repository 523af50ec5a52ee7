"""`rcx why` reads a trace, and names the chain of causes; unknown values are not guessed."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import pytest

from rcx_harness.cli.app import main
from rcx_harness.look.why.chain import Chain, chains
from rcx_harness.look.why.recorded import facts_of_trace
from rcx_harness.trace import Cycle, Scan, Trace

Captured = pytest.CaptureFixture[str]

# Chapter 5, 1: bit n of byte 32 is signal 0n, bit n of byte 33 is signal 1n.
SI00, SI01, SI06, SI15 = (1 << k for k in (0, 1, 6, 13))
SO00, SO01, SO02, SO03, SO04, SO10, SO11 = (1 << k for k in (0, 1, 2, 3, 4, 8, 9))
#: A controller that is ready, in AUTO mode, with servos on; a PLC that holds nothing.
READY, FREE = SO01 | SO02 | SO04 | SO10 | SO11, SI00 | SI06
RUN, ABNORMAL = 0x0100, 0x4000
MOVE_PTP, READ_POINT = 0x001, 0x101


def area(bits: int, *words: int) -> bytes:
    head = b"".join(word.to_bytes(2, "little") for word in words)
    return head.ljust(32, b"\0") + bits.to_bytes(2, "little") + bytes(14)


def trace_of(
    folder: Path, steps: Iterable[tuple[bytes, bytes]], values: Mapping[str, Any] | None = None
) -> Path:
    """Write a trace with a scan and a cycle each second: output area, input area."""
    file = folder / "trace.jsonl"
    with_values = dict(values or {})
    trace = Trace({"scan_us": 1_000_000, "cycle_us": 1_000_000, "size": 48}, file)
    for number, (so, si) in enumerate(steps):
        trace.add(Cycle(number * 1_000_000, number, si, so))
        trace.add(Scan(number * 1_000_000, number, so, si, with_values))
    trace.close()
    return file


def chain_of(folder: Path, *steps: tuple[bytes, bytes], **values: Any) -> Chain:
    paths = {f"Main.{name.replace('_', '.')}": value for name, value in values.items()}
    facts = facts_of_trace(trace_of(folder, steps, paths), None)
    return chains(facts, facts.last_us)[0]


@pytest.mark.parametrize(
    ("outputs", "inputs", "expected"),
    [
        ((READY,), (FREE,), "not-recorded"),
        ((READY & ~SO01,), (FREE,), "cpu"),
        ((READY | SO00 | SO03,), (SI06,), "emergency-stop-input"),
        ((READY | SO00 | SO03,), (FREE,), "emergency-stop-robot"),
        ((READY | SO03,), (FREE,), "alarm"),
        ((READY & ~SO04,), (FREE,), "main-power"),
        ((READY,), (SI00,), "stop-input"),
        ((READY & ~SO02,), (FREE | SI01,), "no-authority"),
        ((READY & ~SO10,), (FREE | SI15,), "manual-mode"),
        ((READY, RUN), (FREE, MOVE_PTP), "executes"),
        ((READY, RUN), (FREE, 0), "never-ready"),
        ((READY, ABNORMAL), (FREE, MOVE_PTP), "no-reset"),
    ],
)
def test_the_areas_show_the_cause(
    outputs: tuple[int, ...], inputs: tuple[int, ...], expected: str, tmp_path: Path
) -> None:
    """The same areas for three seconds: nothing moves any more."""
    now = area(*outputs), area(*inputs)
    before = area(READY), area(FREE)
    assert chain_of(tmp_path, before, now, now, now).cause.key == expected


@pytest.mark.parametrize(
    ("alarm", "expected"),
    [
        ((12, 76), "no-authority"),  # "Disable remote command"
        ((2, 334), "command-alarm"),  # "Over soft limit"
        ((12, 400), "acknowledge"),  # the stop input was OFF, and is ON again
    ],
)
def test_the_alarm_of_the_last_command_is_the_cause(
    alarm: tuple[int, int], expected: str, tmp_path: Path
) -> None:
    """The command has ended with an alarm, and the PLC has reset the status."""
    ended = area(READY, ABNORMAL, *alarm), area(SI00 if alarm[1] == 400 else FREE, MOVE_PTP)
    chain = chain_of(tmp_path, (area(READY), area(FREE)), ended, (area(READY), area(FREE)))
    assert chain.cause.key == expected
    assert f"MovePtp ended with alarm {alarm[0]}.{alarm[1]} " in chain.steps[0].text


def test_a_lost_link_is_the_cause(tmp_path: Path) -> None:
    """The controller samples an empty area when no packets come."""
    good, lost = (area(READY), area(FREE)), (area(READY | SO00 | SO03), b"")
    assert chain_of(tmp_path, good, lost, lost).cause.key == "link"


def test_the_holder_of_the_channel_is_named(tmp_path: Path) -> None:
    """MovePtp has no turn; ReadPoint holds the channel, and its status stays 16#0100."""
    now = area(READY, RUN), area(FREE, READ_POINT)
    robot = {"Connected": True, "StopOk": True, "EmergencyStopOk": True}
    channel = {"NextTicket": 7, "Serving": 5, "Orphan": False, "Holder": READ_POINT}
    chain = chain_of(
        tmp_path,
        *[now] * 3,
        Robot={**robot, "Inner": {"Command": channel}},
        Move_Busy=True,
        Move_Active=False,
        Read_Busy=True,
        Read_Active=True,
    )
    assert chain.cause.key == "channel-held"
    assert [step.text for step in chain.steps] == [
        "Main.Move waits for its turn",
        "Main.Read holds the channel (ReadPoint)",
        "ReadPoint is out, the status is 16#0100",
    ]


def test_an_error_of_the_program_has_its_remedy(tmp_path: Path) -> None:
    """16#8017 is "Called out of place" in docs/reference/errors.md."""
    chain = chain_of(tmp_path, (area(READY), area(FREE)), Move_ErrorID=0x8017)
    assert chain.cause.key == "out-of-place"
    assert chain.to_go_on.startswith("Call it between FB_ReadArea and FB_WriteArea")


def test_a_past_fault_waits_for_an_acknowledgement(tmp_path: Path) -> None:
    """16#8006 is "Not in AUTO mode"; now SO(10) is ON."""
    chain = chain_of(tmp_path, (area(READY), area(FREE)), Fault=0x8006)
    assert chain.cause.key == "acknowledge"


def test_the_command_prints_the_chain(tmp_path: Path, capsys: Captured) -> None:
    """Exit code 1: something waits."""
    now = area(READY | SO00), area(SI06)
    file = trace_of(tmp_path, [now, now])
    assert main(["why", str(file)]) == 1
    assert capsys.readouterr().out.splitlines() == [
        "at 1.000 s",
        "It stands: emergency-stop-input.",
        "  1. the controller is in emergency stop, SO(00) is ON, since 0.000 s  [ch. 5, 2]",
        "  2. the PLC holds SI(00) OFF: EmergencyStopOk is FALSE, FB_EmergencyStop holds it, or "
        "Connected is FALSE (not recorded), since 0.000 s  [ch. 5, 3.1]",
        "To go on: Release every emergency stop, set EmergencyStopOk, reset the alarm, then switch "
        "the servos on.",
    ]


def test_the_json_has_the_same_chain(tmp_path: Path, capsys: Captured) -> None:
    """Exit code 0: the controller executes a command, so nothing waits."""
    file = trace_of(tmp_path, [(area(READY, RUN), area(FREE, MOVE_PTP))])
    assert main(["why", str(file), "--json", "-"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert (result["stands"], result["chains"][0]["cause"]) == (False, "executes")


def test_another_time_gives_the_state_at_that_time(tmp_path: Path) -> None:
    """The link is lost at 2 s; at 1 s nothing stands."""
    good, lost = (area(READY), area(FREE)), (area(READY), b"")
    file = trace_of(tmp_path, [good, good, lost])
    assert main(["why", str(file), "--at", "1s"]) == 0
    assert main(["why", str(file), "--at", "2s"]) == 1


def test_bad_input_is_one_message(tmp_path: Path, capsys: Captured) -> None:
    """A later time than the last record, and a file that is not a trace."""
    file = trace_of(tmp_path, [(area(READY), area(FREE))])
    assert main(["why", str(file), "--at", "9s"]) == 2
    assert "ends at 0 s, before 9 s" in capsys.readouterr().err
    file.write_text("no trace\n")
    assert main(["why", str(file)]) == 2
    assert capsys.readouterr().err.count("\n") == 1
