"""The debugger stops at lines, conditions, counts, blocks, changes, faults and broken rules."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from editor import Editor

Start = Callable[..., Editor]


def test_a_breakpoint_moves_to_the_next_statement(at_entry: Start, lamps: Path) -> None:
    """A breakpoint at a line without a statement moves to the next statement.

    Line 27 is END_IF and line 54 is ELSIF. After line 58 there are no statements.
    """
    editor = at_entry()
    told = editor.set(lamps, 27, 54, 50, 59)
    assert [one.get("line") for one in told] == [28, 55, 50, None]
    assert [one["verified"] for one in told] == [True, True, True, False]
    assert told[3]["message"] == "there is no statement from this line on"


def test_in_a_file_that_is_not_of_the_program_it_says_so(at_entry: Start, tmp_path: Path) -> None:
    (tmp_path / "Other.st").write_text("(* nothing *)\n")
    (told,) = at_entry().set(tmp_path / "Other.st", 1)
    assert not told["verified"]
    assert "the running program has no declaration in" in told["message"]


def test_lines_with_statements_are_listed(at_entry: Start, lamps: Path) -> None:
    asked = {"source": {"path": str(lamps)}, "line": 50, "endLine": 60}
    found = at_entry().request("breakpointLocations", **asked)["breakpoints"]
    assert [one["line"] for one in found] == [50, 51, 52, 53, 55, 57, 58]


def test_a_condition_is_an_expression_of_the_block(stopped: Start) -> None:
    """The condition of a breakpoint is an expression with the variables of the block.

    Value is n in the n-th scan, and k counts the iterations.
    """
    editor = stopped({"line": 30, "condition": "Value = 4 AND k > 2"})
    assert (editor.line, editor.value("Value"), editor.value("k")) == (30, "4", "3")


def test_a_condition_may_use_variables_of_a_call(stopped: Start) -> None:
    assert stopped({"line": 11, "condition": "Sum = 5"}).value("X") == "5"


@pytest.mark.parametrize(
    ("wanted", "message"),
    [
        ({"condition": "Valu = 4"}, "Valu"),
        ({"condition": "Value + 1"}, "BOOL"),
        ({"condition": "Value ="}, "Value ="),
        ({"hitCondition": "often"}, "'often' is not a count of hits; write 5, >= 5 or % 10"),
        ({"logMessage": "Value is {Valu}"}, "Valu"),
    ],
)
def test_a_wrong_breakpoint_is_not_set_and_says_why(
    at_entry: Start, lamps: Path, wanted: dict[str, Any], message: str
) -> None:
    (told,) = at_entry().set(lamps, {"line": 28, **wanted})
    assert not told["verified"]
    assert message in told["message"]
    assert "\n" not in told["message"]


@pytest.mark.parametrize(
    ("count", "values"),
    [("3", ["3"]), (">= 3", ["3", "4"]), ("% 3", ["3", "6"]), ("< 3", ["1", "2"])],
)
def test_a_count_of_hits_decides(stopped: Start, count: str, values: list[str]) -> None:
    editor = stopped({"line": 28, "hitCondition": count})
    found = [editor.value("Value")]
    while len(found) < len(values):
        editor.go()
        found.append(editor.value("Value"))
    assert found == values


def test_hits_that_are_run_again_are_the_same_hits(stopped: Start) -> None:
    editor = stopped({"line": 28, "hitCondition": "4"})
    assert editor.value("Value") == "4"
    editor.go("rcx/stepScan", scans=-3)
    editor.go()
    assert editor.value("Value") == "4"


def test_a_logpoint_prints_once_for_each_hit_and_does_not_stop(editor: Editor, lamps: Path) -> None:
    """A logpoint prints once for each hit and does not stop the run.

    A breakpoint after the logpoint makes the scan run twice, but the logpoint prints once.
    """
    log = {"line": 28, "logMessage": "value {Value}, doubled {Value * 2}"}
    editor.start({lamps: [log, {"line": 58, "condition": "Doubled = 6"}]}, sources=[str(lamps)])
    assert [one for one in editor.output if one.startswith("value")] == [
        "value 1, doubled 2",
        "value 2, doubled 4",
        "value 3, doubled 6",
    ]


def test_a_block_can_be_named_instead_of_a_line(at_entry: Start) -> None:
    """If a breakpoint names a block, the run stops at the first statement of each call.

    It does not stop in each loop iteration.
    """
    editor = at_entry()
    wanted = [{"name": "twice"}, {"name": "Thrice"}]
    told = editor.request("setFunctionBreakpoints", breakpoints=wanted)["breakpoints"]
    assert [one["verified"] for one in told] == [True, False]
    assert told[1]["message"] == "there is no POU Thrice with statements"
    editor.go()
    assert editor.stack()[0] == ("Twice()", 10)
    editor.go()
    assert editor.value("X") == "2"


def _watched(editor: Editor, name: str) -> list[dict[str, Any]]:
    info = editor.request("dataBreakpointInfo", name=name)
    wanted = [{"dataId": info["dataId"], "accessType": "write"}]
    found: list[dict[str, Any]] = editor.request("setDataBreakpoints", breakpoints=wanted)[
        "breakpoints"
    ]
    return found


def test_a_data_breakpoint_stops_after_the_change(at_entry: Start) -> None:
    """A data breakpoint stops after the statement that changes the variable.

    Lamp is DARK, then DIM in the third scan (line 55), then BRIGHT in the sixth (line 53).
    """
    editor = at_entry()
    assert _watched(editor, "Lamp")[0]["verified"]
    why = editor.go()
    assert (why["reason"], why["text"]) == ("data breakpoint", "Main.Lamp: DARK -> DIM")
    assert (editor.line, editor.value("C.Value")) == (57, "3")
    why = editor.go()
    assert why["text"] == "Main.Lamp: DIM -> BRIGHT"
    assert (editor.line, editor.value("C.Value")) == (57, "6")


def test_an_array_is_watched_as_a_whole(at_entry: Start) -> None:
    editor = at_entry()
    _watched(editor, "C.Steps")
    why = editor.go()
    assert why["text"] == "Main.C.Steps: [0, 0, 0] -> [1, 0, 0]"


def test_variables_of_a_call_are_not_watched(stopped: Start) -> None:
    info = stopped(11).request("dataBreakpointInfo", name="Sum")
    assert info["dataId"] is None
    assert info["description"] == "Sum is not a variable that lasts from scan to scan"


def test_a_division_by_zero_stops_at_its_statement_with_the_stack_there(at_entry: Start) -> None:
    """A division by zero stops the run at its statement, with its call stack.

    After the user has corrected a variable, the run continues from there.
    """
    editor = at_entry()
    editor.go("rcx/stepScan", scans=3)
    editor.say("Divisor := 0")
    why = editor.go()
    assert why["reason"] == "exception"
    assert why["text"].endswith("Lamps.st:58: division by zero")
    assert editor.stack() == [("Main (Lamps)", 58)]
    assert editor.request("exceptionInfo", threadId=1)["description"] == why["text"]
    assert editor.go()["text"] == why["text"], "the program cannot continue unchanged"
    editor.say("Divisor := 2")
    editor.go("next")
    assert (editor.line, editor.value("Part")) == (50, "4")


def test_an_index_out_of_range_stops_inside_the_block(stopped: Start) -> None:
    editor = stopped(30)
    editor.say("k := 9")
    why = editor.go()
    assert why["reason"] == "exception"
    assert editor.stack() == [("Main.C (Counter)", 30), ("Main (Lamps)", 50)]


_BREAKS = """\
PROGRAM Breaks
  VAR
    InputArea  : RCX_IMAGE;
    OutputArea : RCX_IMAGE;
    Scans      : INT;
  END_VAR
  Scans := Scans + 1;
  IF Scans = 20 THEN
    OutputArea[46] := BYTE#16#01;
  END_IF;
END_PROGRAM
"""


@pytest.mark.parametrize("filters", [["rules"], []])
def test_a_broken_rule_stops_the_run_after_its_scan_if_requested(
    editor: Editor, tmp_path: Path, filters: list[str]
) -> None:
    """If requested, a broken rule stops the run after its scan.

    Bytes n+46 and n+47 are reserved (manual chapter 1, 4.1).
    """
    program = tmp_path / "Breaks.st"
    program.write_text(_BREAKS)
    editor.request("initialize")
    editor.request("launch", sources=[str(program)], **{"for": "1s"})
    editor.request("setExceptionBreakpoints", filters=filters)
    editor.request("configurationDone")
    why = editor.event("stopped")
    if not filters:
        assert why["text"] == "the end of the run (1s)"
        return
    assert why["reason"] == "exception"
    assert "reserved" in why["text"]
    assert editor.value("Scans") == "20"
    assert len(editor.below(editor.scope("Run")["broken rules"])) == 1
