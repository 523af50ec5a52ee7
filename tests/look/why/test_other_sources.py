"""A snapshot of values and a network capture are explained in the same way as a trace."""

from __future__ import annotations

from pathlib import Path

import pytest

from captures import Story, area, pcapng
from rcx_harness.cli.app import main

Captured = pytest.CaptureFixture[str]

#: Variables with the names of a block and of an RCX_REF, without the library.
PROGRAM = """
TYPE CHANNEL : STRUCT NextTicket, Serving : UINT; Orphan : BOOL; Holder : WORD; END_STRUCT; END_TYPE
TYPE ARBITRATION : STRUCT Command : CHANNEL; END_STRUCT; END_TYPE
TYPE OUTPUTS : STRUCT SO03_Alarm, SO10_AutoMode : BOOL; END_STRUCT; END_TYPE
TYPE REF : STRUCT
  Connected, StopOk : BOOL; Status : WORD; SO : OUTPUTS; Inner : ARBITRATION;
END_STRUCT; END_TYPE
TYPE PINS : STRUCT Busy, Active : BOOL; ErrorID : WORD; END_STRUCT; END_TYPE
PROGRAM Cell
  VAR Robot : REF; Move, Read : PINS; END_VAR
  Move.Busy := TRUE;
END_PROGRAM
CONFIGURATION Config0
  RESOURCE Res0 ON PLC
    TASK Cyclic(INTERVAL := T#10ms, PRIORITY := 0);
    PROGRAM Main WITH Cyclic : Cell;
  END_RESOURCE
END_CONFIGURATION
"""
VALUES = """
[variables]
"Main.Move.Busy" = true
"Main.Move.Active" = false
"Main.Read.Busy" = true
"Main.Read.Active" = true
"Main.Robot.Connected" = true
"Main.Robot.StopOk" = true
"Main.Robot.Status" = "16#0100"
"Main.Robot.Inner.Command.NextTicket" = 7
"Main.Robot.Inner.Command.Serving" = 5
"Main.Robot.Inner.Command.Holder" = 0x0101
"""


def _snapshot(folder: Path, values: str) -> list[str]:
    program, snapshot = folder / "Cell.st", folder / "values.toml"
    program.write_text(PROGRAM)
    snapshot.write_text(values)
    return ["why", str(program), "--snapshot", str(snapshot)]


def test_a_snapshot_is_explained(tmp_path: Path, capsys: Captured) -> None:
    """Code 16#0101 is ReadPoint. The tickets 5 and 6 are taken, and 5 has the turn."""
    assert main(_snapshot(tmp_path, VALUES)) == 1
    assert capsys.readouterr().out.splitlines()[:5] == [
        "in the snapshot",
        "It stands: channel-held.",
        "  1. Main.Move waits for its turn  [guide, 1.1]",
        "  2. Main.Read holds the channel (ReadPoint)  [guide, 1.1]",
        "  3. a remote command is out, the status is 16#0100",
    ]


@pytest.mark.parametrize(
    ("more", "cause"),
    [
        ('"Main.Robot.SO.SO03_Alarm" = true\n', "alarm"),
        ('[signals]\n"SO(10)" = false\n"SO(04)" = false\n', "main-power"),
        ('[words]\ncode = "16#0101"\n', "channel-held"),
    ],
)
def test_signals_of_a_snapshot_count(
    more: str, cause: str, tmp_path: Path, capsys: Captured
) -> None:
    """They come from the RCX_REF, or from the table of signals."""
    assert main(_snapshot(tmp_path, VALUES + more)) == 1
    assert f"It stands: {cause}." in capsys.readouterr().out


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ('[variables]\n"Main.Mov.Busy" = true\n', "values.toml:2: Main of type Cell has no member"),
        ('[signals]\n"SO(77)" = true\n', "values.toml:2: no signal is called 'SO(77)'"),
        ('[signals]\n"SO(10)" = 1\n', "values.toml:2: SO(10) is 1, and not true or false"),
        ('[words]\nstatus = "RUN"\n', "values.toml:2: status is 'RUN', and not a word"),
        ("[values]\n", "values.toml:1: unknown key 'values'"),
        ("signals = 1\n", "values.toml: 'signals' is not a table"),
    ],
)
def test_a_wrong_snapshot_has_one_message(
    values: str, message: str, tmp_path: Path, capsys: Captured
) -> None:
    """The message has the line of the mistake."""
    assert main(_snapshot(tmp_path, values)) == 2
    assert message in capsys.readouterr().err


def test_a_capture_is_explained(tmp_path: Path, capsys: Captured) -> None:
    """SI(00) and SI(06) are ON, and SO(00) and SO(01) stay ON: 16#0041 and 16#0113."""
    story = Story()
    story.open(0)
    for k in range(1, 151):
        story.both(10_000 * k, area(dedicated=0x0041), area(dedicated=0x0113))
    file = pcapng(tmp_path / "cell.pcapng", story.frames())
    assert main(["why", "--capture", str(file)]) == 1
    assert "It stands: emergency-stop-robot." in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([], "0 files are given"),
        (["a.jsonl", "b.jsonl"], "2 files are given"),
        (["--snapshot", "v.toml"], "--snapshot needs the files"),
        (["a.jsonl", "--capture", "c.pcap"], "--capture reads its own file"),
        (["a.st", "--snapshot", "v.toml", "--capture", "c.pcap"], "exclude each other"),
        (["a.st", "--snapshot", "v.toml", "--at", "1s"], "--at has no meaning"),
        (["--capture", "missing.pcap"], "missing.pcap"),
    ],
)
def test_sources_that_exclude_each_other(words: list[str], message: str, capsys: Captured) -> None:
    """Each is refused in one line."""
    assert main(["why", *words]) == 2
    shown = capsys.readouterr().err
    assert message in shown
    assert shown.count("\n") == 1


def test_a_text_instead_of_a_number_is_unknown(tmp_path: Path) -> None:
    """Such a value is not guessed, and does not end in a traceback."""
    values = VALUES.replace("= 7", '= "seven"').replace('"16#0100"', '"RUN"')
    assert main(_snapshot(tmp_path, values)) == 1
