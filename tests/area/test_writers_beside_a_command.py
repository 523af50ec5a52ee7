"""Blocks that write to the robot program, called around FB_WriteArea, during a command."""

from __future__ import annotations

import pytest

from plc_bench import PlcBench

CODE = 0x4238
DATA = list(range(0x0101, 0x0110))
_PROGRAM = """PROGRAM Bench
  VAR
    InputArea  : {image};
    OutputArea : {image};
    After      : BOOL; (* the order of the calls *)
    Robot      : RCX_REF;
    ReadArea   : FB_ReadArea{words};
    First      : FB_RemoteCommand;
    Writer     : {block};
    WriteArea  : FB_WriteArea{words};
  END_VAR

  ReadArea(Robot := Robot, Image := InputArea, Connected := TRUE);
  First(Robot := Robot);
  IF NOT After THEN
    Writer({robot}Image := OutputArea);
  END_IF;
  WriteArea(Robot := Robot, Image := OutputArea, EmergencyStopOk := TRUE, StopOk := TRUE);
  IF After THEN
    Writer({robot}Image := OutputArea);
  END_IF;
END_PROGRAM
"""
#: Maps each writing block to the numbers that it accepts.
_WRITERS = {
    "FB_WriteWord": range(2, 16),
    "FB_WriteDoubleWord": range(2, 16, 2),
    "FB_WriteBit": (20, 27, 77, 100, 157),
    "FB_WritePort": (2, 7, 10, 15),
}


def _bench(block: str, words: str, *, after: bool) -> PlcBench:
    text = _PROGRAM.format(
        block=block + ("InWords" if words else ""),
        words=words,
        image="RCX_IMAGE_WORDS" if words else "RCX_IMAGE",
        robot="Robot := Robot, " if "Word" in block else "",
    )
    plc = PlcBench(program=text)
    plc["After"] = after
    plc.power_up()
    plc["First.Code"], plc["First.Data"] = CODE, DATA
    return plc


@pytest.mark.parametrize("after", [False, True], ids=["before", "after"])
@pytest.mark.parametrize("words", ["", "Words"], ids=["bytes", "words"])
@pytest.mark.parametrize("block", _WRITERS)
def test_no_writing_block_changes_a_command_that_was_sent(
    block: str, words: str, after: bool
) -> None:
    """Code and data do not change until the status has changed, in any order of calls.

    Source: manual chapter 1, 4.1, note on the words of remote commands; guide chapter 2.
    """
    plc = _bench(block, words, after=after)
    pin = "Number" if "Word" in block else "Port"
    for number in _WRITERS[block]:
        plc[f"Writer.{pin}"] = number
        plc["First.Execute"] = True
        out = 0
        for scan in range(12):
            value = scan % 2 == 1 if block == "FB_WriteBit" else 0x51 + scan
            plc["Writer.Value"] = value
            plc.answer(
                {7: 0x0100, 8: 0x0100, 9: 0x0200}.get(scan, 0), [0xAAAA] * (scan in (7, 8, 9))
            )
            plc.scan()
            assert not plc["Writer.Error"]
            if plc.words[0]:
                out += 1
                shown = " ".join(f"16#{word:04X}" for word in plc.words)
                assert plc.words == [CODE, *DATA], f"{pin} {number}, scan {scan}: {shown}"
            elif plc["Robot.Inner.Phase"] == "PHASE_COMMAND_DATA":
                assert plc.words[1:] == DATA, f"{pin} {number}, scan {scan}: data before the code"
        assert out >= 7
        assert plc["First.Done"]
        plc.change("First.Execute", to=False, scans=3)


@pytest.mark.parametrize("after", [False, True], ids=["before", "after"])
@pytest.mark.parametrize("words", ["", "Words"], ids=["bytes", "words"])
@pytest.mark.parametrize("block", ["FB_WriteWord", "FB_WriteDoubleWord"])
def test_between_commands_each_written_word_is_sent(block: str, words: str, after: bool) -> None:
    """Source: manual chapter 1, 4.1: SIW(2) to SIW(15) at n + 4 to n + 30."""
    plc = _bench(block, words, after=after)
    for number in _WRITERS[block]:
        plc["Writer.Number"], plc["Writer.Value"] = number, 0x1234
        plc.scan(2)
        assert plc.words[number] == 0x1234, f"SIW({number})"
        plc.change("Writer.Value", to=0, scans=2)
        assert plc.words[number] == 0, f"SIW({number})"
