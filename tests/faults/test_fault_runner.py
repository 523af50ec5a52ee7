"""The fault runs report each defect that was put into a copy of the library."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from fault_cell import CaseFailure
from fault_run import FAULTS, Rig
from plc_bench import ROOT

_JOB, _SERVO = "core/FB_RcxJob.st", "sequence/FB_ServoOn.st"
_IDLE, _REQUEST = "  IF NOT (Execute OR Busy OR Done OR Error) THEN\n", "Robot.Inner.Request"


def _first_failure(lib: Path, block: str, fault: str) -> str:
    broken = Rig(block, lib)
    try:
        for case in broken.cases(FAULTS[fault]):
            broken.run(case)
    except CaseFailure as failure:
        return str(failure)
    return ""


@pytest.mark.parametrize(
    ("file", "right", "wrong", "fault", "found"),
    [
        (
            _JOB,
            "    ELSIF Longest = 0 OR Waited < Longest THEN\n",
            "    ELSIF Longest >= 0 THEN\n",
            "none",
            "hangs: Busy for 111 scans, expected at most 110",
        ),
        (
            _JOB,
            "ELSIF NOT Execute OR NOT WasExecute THEN",
            "ELSIF Execute AND NOT WasExecute THEN",
            "none",
            "the outputs stay although Execute is FALSE and the end was shown",
        ),
        (
            _JOB,
            "Active AND Armed AND Applied AND Answer <> WORD#16#0000 THEN",
            "Active AND Armed AND Applied THEN",
            "none",
            "Done, but SO02 is OFF as the PLC reads it",
        ),
        (
            _SERVO,
            _IDLE,
            f"  IF Robot.SI.SI01_ServoOn AND Robot.SO.SO02_ServoOn THEN\n"
            f"    {_REQUEST} := {_REQUEST} OR WORD#16#0002;\n  END_IF;\n" + _IDLE,
            "none",
            "the requests are withdrawn",
        ),
        (
            _SERVO,
            _IDLE,
            "  IF Robot.SO.SO03_Alarm AND NOT Robot.SO.SO00_EmergencyStop THEN\n"
            f"    {_REQUEST} := {_REQUEST} OR WORD#16#0002;\n  END_IF;\n" + _IDLE,
            "emergency stop",
            "a request or a command starts by itself",
        ),
    ],
)
def test_a_fault_in_the_library_is_found(
    tmp_path: Path, file: str, right: str, wrong: str, fault: str, found: str
) -> None:
    lib = tmp_path / "lib"
    shutil.copytree(ROOT / "plc" / "lib", lib)
    text = (lib / file).read_text(encoding="utf-8")
    assert text.count(right) == 1
    (lib / file).write_text(text.replace(right, wrong), encoding="utf-8")
    assert found in _first_failure(lib, "FB_ServoOn", fault)
