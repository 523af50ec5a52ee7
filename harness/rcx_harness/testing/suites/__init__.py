"""Our own implementation of the interface of the unit-test framework TcUnit, for `rcx test`.

TcUnit is the most used unit-test framework of TwinCAT. The folder `st` contains the function blocks
that a suite may call. It follows the public documentation of TcUnit (https://tcunit.org, API and
FAQ).
"""

from __future__ import annotations

from pathlib import Path

from structured_text.testing.suites.framework import Framework

__all__ = ["FRAMEWORK"]

FRAMEWORK = Framework(
    folder=Path(__file__).resolve().parent / "st",
    namespace="TcUnit",
    suite="FB_TestSuite",
    run=("RUN", "RUN_IN_SEQUENCE"),
    note="RcxTest_Note",
    selected="RcxTest_Selected",
    suites="RcxTest_Suites",
    count="RcxTest_Count",
    current="RcxTest_Suite_Number",
    started="RcxTest_Started",
    done="RcxTest_Done",
    aborted="RcxTest_Aborted",
    call="RcxTest_Run",
    tests="RcxTests",
    test="RcxTest_Number",
    failed="RcxTest_Failed",
    case="RcxTest_Case",
    words={
        "counts": "RcxCounts",
        "fail": "RcxFail",
        "text": "RcxText",
        "advance": "RcxTest_Advance",
        "mock": "RcxTest_Mock",
        "calls": "RcxTest_Calls",
        "returns": "RcxTest_Returns",
        "test": "TEST",
        "finished": "TEST_FINISHED",
        "run": "RUN",
    },
)
