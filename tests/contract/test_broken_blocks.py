"""The contract runs report each fault that was put into a copy of the library."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from contract_bench import ContractBench, cases
from fault_cell import CaseFailure
from rcx_tools.evidence.broken import broken_library

_JOB, _TAKE_HEAD = "core/FB_RcxJob.st", "core/FB_RcxTakeHead.st"
_HANDSHAKE, _INPUTS = "core/FB_RcxHandshake.st", "core/FB_RcxDedicatedInputs.st"
_HEAD, _JOG = "core/FB_RcxMakeHead.st", "command/movement/FB_Jog.st"
_IDLE = "  IF NOT (Execute OR Busy OR Done OR Error) THEN\n"


def _messages(lib: Path, block: str) -> Iterator[str]:
    """Run all cases of a block, and yield the message of each failing case."""
    bench = ContractBench(block, sorted(lib.rglob("*.st")))
    for case in cases(block):
        try:
            bench.run(case)
        except CaseFailure as failure:
            yield str(failure).split(": ", 2)[2].partition(" (scan")[0]


@pytest.mark.exhaustive(
    but=[
        "Done without the answer",
        "Error without ErrorID",
        "a falling Execute cancels the work",
        "a jog that is not stopped",
        "the data come with the code",
    ]
)
@pytest.mark.parametrize(
    ("block", "file", "right", "wrong", "expected"),
    [
        pytest.param(*row[1:], id=row[0])
        for row in (
            (
                "a falling Execute cancels the work",
                "FB_ReadPoint",
                _JOB,
                "IF Answer = WORD#16#8001 OR",
                "IF NOT Execute THEN ErrorID := WORD#16#8013; ELSIF Answer = WORD#16#8001 OR",
                "the block ended with Error 16#8013, expected 16#0000",
            ),
            (
                "an edge while busy starts again",
                "FB_ReadPoint",
                _JOB,
                "  IF Busy AND Seen = Scan THEN\n",
                "  Busy := Busy AND (WasExecute OR NOT Execute);\n  Active := Active AND Busy;\n"
                "  IF Busy AND Seen = Scan THEN\n",
                "2 telegrams for one rising edge",
            ),
            (
                "the end is not cleared",
                "FB_ReadPoint",
                _JOB,
                "ELSIF NOT Execute OR NOT WasExecute THEN",
                "ELSIF Execute AND NOT WasExecute THEN",
                "Done is shown for more than one scan after Execute has fallen",
            ),
            (
                "Error without ErrorID",
                "FB_ServoOn",
                "sequence/FB_ServoOn.st",
                "  ErrorID := Job.ErrorID;",
                "  ErrorID := WORD#16#0000;",
                "Error is TRUE with ErrorID 16#0000; Error is true exactly when ErrorID is not 0",
            ),
            (
                "the end comes with Busy",
                "FB_ReadPoint",
                "command/definition/FB_ReadPoint.st",
                "  Busy := Job.Busy;",
                "  Busy := Job.Busy OR Job.Ended;",
                "Busy and Error are true together; expected at most one",
            ),
            (
                "the time limit is armed and not evaluated",
                "FB_ServoOn",
                _JOB,
                "    ELSIF Longest = 0 OR Waited < Longest THEN\n",
                "    ELSIF Longest >= 0 THEN\n",
                "the block hangs: Busy for more than 40 scans",
            ),
            (
                "Done without the answer",
                "FB_ServoOn",
                _JOB,
                "Active AND Armed AND Applied AND Answer <> WORD#16#0000 THEN",
                "Active AND Armed AND Applied THEN",
                "Done/Valid, but the controller's outputs do not confirm it",
            ),
            (
                "the data come with the code",
                "FB_MovePtp",
                _HANDSHAKE,
                "      Robot.Inner.Phase := PHASE_COMMAND_DATA;\n",
                "      Robot.Inner.Phase := PHASE_COMMAND_RUN;\n",
                "the data came together with the code, not before it",
            ),
            (
                "the code is not held",
                "FB_MovePtp",
                _HANDSHAKE,
                "Endless AND Robot.Status = WORD#16#0100\n",
                "Robot.Status = WORD#16#0100\n",
                "the code 0x0001 became 0x0000 before an end status",
            ),
            (
                "the next command does not wait for the ready status",
                "FB_MovePtp",
                _HANDSHAKE,
                "  ELSIF Robot.Status = WORD#16#0000 THEN\n    IF Hold",
                "  ELSIF Robot.Status < WORD#16#0300 THEN\n    IF Hold",
                "the code went out while the status was 0x0200",
            ),
            (
                "the code stays while there is no link",
                "FB_MovePtp",
                _HANDSHAKE,
                "IF NOT Recovery.Q THEN",
                "IF NOT Recovery.Q AND Robot.Inner.Phase <> PHASE_COMMAND_RUN THEN",
                "the code 0x0001 is out without connection or CPU_OK",
            ),
            (
                "an abnormal end is not told from a normal one",
                "FB_ReadPoint",
                _TAKE_HEAD,
                "    Robot.Inner.Answer := WORD#16#8020; (* Abnormal end *)\n",
                "    Robot.Inner.Answer := WORD#16#0200;\n",
                "the block ended with Done/Valid, but its cause did not occur",
            ),
            (
                "the group is not that of the alarm",
                "FB_ReadPoint",
                "command/definition/FB_ReadPoint.st",
                "Before := AlarmGroup,\n"
                "                                Response := Robot.Response[1]);",
                "Before := AlarmGroup,\n"
                "                                Response := Robot.Response[2]);",
                "alarm 600.600, expected 12.600",
            ),
            (
                "the interval is too short",
                "FB_ServoOn",
                _HEAD,
                "Spacing := Spacing + Extra;",
                "Spacing := Extra;",
                "changed 80 ms after the last change",
            ),
            (
                "two inputs change in one scan",
                "FB_ServoOn",
                _INPUTS,
                "    Change := Change AND First;\n",
                "    Change := Change AND (First OR WORD#16#0040);\n",
                "several inputs changed in one scan",
            ),
            (
                "a sequence does not see the loss of the link",
                "FB_ServoOn",
                "sequence/FB_ServoOn.st",
                "    Answer := WORD#16#8001; (* Not connected *)\n",
                "    Answer := WORD#16#0000;\n",
                "Busy without a connection",
            ),
            (
                "a sequence starts again by itself",
                "FB_ServoOn",
                "sequence/FB_ServoOn.st",
                _IDLE,
                f"  IF Robot.SO.SO03_Alarm THEN\n"
                f"    Robot.Inner.Request := WORD#16#0002;\n  END_IF;\n{_IDLE}",
                "an input is switched ON without a request",
            ),
            (
                "a wrong code",
                "FB_ReadPoint",
                "command/definition/FB_ReadPoint.st",
                "WORD#16#0101",
                "WORD#16#0102",
                "the code 0x0102 is not a command of this block",
            ),
            (
                "a jog that is not stopped",
                "FB_Jog",
                _JOG,
                "Robot.Inner.StopJog := Robot.Inner.StopJog OR (Out AND Halt AND Job.Busy);",
                "Robot.Inner.StopJog := Robot.Inner.StopJog OR (Out AND Halt AND NOT Job.Busy);",
                "the jog continues with SI(06) ON although Enable is FALSE",
            ),
            (
                "a level block that is Valid without Enable",
                "FB_AutoMode",
                "sequence/FB_AutoMode.st",
                "  IF NOT Enable THEN\n",
                "  IF NOT Enable AND NOT WasAuto THEN\n",
                "Enable is False, but the outputs are Done/Valid",
            ),
        )
    ],
)
def test_a_broken_block_is_found(
    block: str, file: str, right: str, wrong: str, expected: str
) -> None:
    reported = set()
    with broken_library(file, right, wrong) as lib:
        for text in _messages(lib, block):
            reported.add(text)
            if expected in text:
                return
    pytest.fail(f"the fault was not reported: {expected}; reported: {sorted(reported)}")
