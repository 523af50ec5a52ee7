"""The debugger shows and sets values: scopes, expressions, areas, telegrams, completions."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from editor import Editor, RefusedError

Start = Callable[..., Editor]


def _values(rows: dict[str, dict[str, Any]]) -> dict[str, str]:
    return {name: row["value"] for name, row in rows.items()}


def test_the_scopes_of_a_block_and_of_its_caller(stopped: Start) -> None:
    editor = stopped({"line": 31, "condition": "Value = 2 AND k = 2"})
    assert _values(editor.scope("Inputs, outputs")) == {"Up": "TRUE", "Value": "2"}
    inner = editor.scope("Variables")
    assert inner["k"]["value"] == "2"
    # Two iterations of this scan have run, and the third value is from the previous scan.
    assert inner["Steps"]["value"] == "[2, 2, 1]"
    assert inner["Steps"]["type"] == "ARRAY [1..3] OF DINT"
    steps = editor.below(inner["Steps"])
    assert _values(steps) == {"[1]": "2", "[2]": "2", "[3]": "1"}
    assert steps["[3]"]["evaluateName"] == "Steps[3]"
    outer = editor.scope("Variables", level=1)
    assert outer["Lamp"]["value"] == "DARK"
    assert outer["Lamp"]["type"] == "LIGHT"
    assert editor.below(outer["C"])["Value"]["evaluateName"] == "C.Value"


def test_a_function_shows_what_lasts_for_its_call(stopped: Start) -> None:
    editor = stopped({"line": 11, "condition": "X = 3"})
    assert _values(editor.scope("Variables")) == {"Sum": "3", "Twice": "0"}


def test_a_long_array_is_shown_in_pages(at_entry: Start) -> None:
    """A long array is shown in pages, as the client requests it. RCX_IMAGE has 512 bytes."""
    editor = at_entry()
    area = editor.scope("Variables")["InputArea"]
    assert area["indexedVariables"] == 512
    assert list(editor.below(area, start=300, count=2)) == ["[300]", "[301]"]


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("C.Value + Doubled", "9"),
        ("Lamp", "DIM"),
        ("Lamp = BRIGHT", "FALSE"),
        ("Lamp = DIM AND NOT Go", "FALSE"),
        ("C.Steps[1 + 1]", "3"),
        ("Twice(X := 20)", "40"),
        ("DINT_TO_REAL(Doubled) / 4.0", "1.5"),
        ("Main.C.k", "4"),
        ("T#1500ms", "T#1500ms"),
        ("MAX(C.Value, 7)", "7"),
        ("InputArea[0]", "16#00"),
    ],
)
def test_an_expression_has_its_own_value(stopped: Start, expression: str, value: str) -> None:
    """An expression is evaluated at the stop: in the third scan, before line 57.

    There Value is 3, Doubled is 6, and Lamp is DIM.
    """
    assert stopped({"line": 57, "condition": "Doubled = 6"}).value(expression) == value


@pytest.mark.parametrize(
    ("expression", "message"),
    [
        ("Doubld", "Doubled"),
        ("1 / (Doubled - Doubled)", "division by zero"),
        ("C.Steps[Doubled]", "the index 6 is not in 1..3"),
        ("Doubled +", "Doubled"),
        ("1); Go := FALSE; x := (1", "not an expression"),
    ],
)
def test_an_expression_without_a_value_says_why(
    stopped: Start, expression: str, message: str
) -> None:
    editor = stopped({"line": 57, "condition": "Doubled = 6"})
    with pytest.raises(RefusedError, match=message.replace(".", r"\.")) as refused:
        editor.value(expression)
    assert "\n" not in str(refused.value)
    assert editor.value("Go") == "TRUE"


def _set(editor: Editor, scope: str, name: str, value: str) -> str:
    frames = editor.request("stackTrace", threadId=1)["stackFrames"]
    scopes = editor.request("scopes", frameId=frames[0]["id"])["scopes"]
    (found,) = [one for one in scopes if one["name"] == scope]
    reference = found["variablesReference"]
    editor.below(found)
    body = editor.request("setVariable", variablesReference=reference, name=name, value=value)
    return str(body["value"])


def test_a_variable_is_set_to_any_expression_of_its_type(at_entry: Start) -> None:
    editor = at_entry()
    assert _set(editor, "Variables", "Doubled", "2 * 2 + 1") == "5"
    assert _set(editor, "Variables", "Lamp", "BRIGHT") == "BRIGHT"
    assert _set(editor, "Variables", "Go", "false") == "FALSE"
    editor.go("rcx/stepScan", scans=4)
    assert editor.value("C.Value") == "0", "Go was FALSE in all four scans"


def test_an_element_and_an_output_of_a_block_are_set_by_expression(at_entry: Start) -> None:
    editor = at_entry()
    editor.request("setExpression", expression="C.Value", value="40")
    editor.request("setExpression", expression="Main.C.Steps[2]", value="-1")
    assert editor.value("C.Steps") == "[0, -1, 0]"
    editor.go("next")
    assert editor.value("C.Value") == "41"


def test_a_variable_of_a_call_is_set_in_each_frame(stopped: Start) -> None:
    editor = stopped(11)
    assert editor.say("Sum := 100") == "Sum = 100"
    assert editor.value("Sum") == "100"
    editor.go("stepOut")
    assert editor.value("Doubled") == "101", "100 + X"


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("Go", "5", "BOOL"),
        ("Doubled", "3000000000", "outside DINT"),
        ("Doubled", "1.5", "DINT"),
        ("Lamp", "GREEN", "GREEN"),
        ("C", "1", "C is a Counter; set its members or elements one by one"),
    ],
)
def test_a_value_that_does_not_fit_is_refused_and_nothing_changes(
    at_entry: Start, name: str, value: str, message: str
) -> None:
    editor = at_entry()
    before = editor.value(name)
    with pytest.raises(RefusedError, match=message):
        _set(editor, "Variables", name, value)
    assert editor.value(name) == before


def test_names_are_completed(at_entry: Start) -> None:
    editor = at_entry()

    def found(text: str) -> list[str]:
        targets = editor.request("completions", text=text, column=len(text) + 1)["targets"]
        return [one["label"] for one in targets]

    assert found("Go AND Dou") == ["Doubled"]
    assert found("C.V") == ["Value"]
    assert found("c.") == ["Up", "Value", "Steps", "k"]


def test_areas_and_telegrams_are_decoded(editor: Editor, repository: Path, tmp_path: Path) -> None:
    """Areas and telegrams are shown with the names of their signals and commands.

    The servos turn ON after the start. Then the hand opens by DO(20), command 0x0301.

    Source: manual chapter 5, 1 (SO(02) is bit 2 of m+32); guide, I/O port assignment.
    """
    stimulus = tmp_path / "start.toml"
    stimulus.write_text(
        '[[at]]\ntime = "100ms"\nset = { "Main.CellSafe" = true }\n'
        '[[at]]\ntime = "600ms"\nset = { "Main.Start" = true }\n'
    )
    example = repository / "plc" / "examples" / "04_pick_and_place"
    program = example / "PickPlace.st"
    out = "OutputArea[0] = BYTE#16#01 AND OutputArea[1] = BYTE#16#03"
    reached = {"line": 20, "condition": out}
    editor.start({program: [reached]}, sources=[str(example)], stimulus=str(stimulus))
    areas = editor.scope("Areas")
    so = editor.below(areas["From robot"])
    assert so["SO02 Servo ON status output"]["value"] == "TRUE"
    assert so["status"]["value"] == "16#0000 command ready"
    assert len(editor.below(so["bytes"])) == 48
    si = editor.below(areas["To robot"])
    assert si["command"]["value"] == "16#0301 WriteIoPortBit"
    editor.set(program)
    editor.go("rcx/stepScan", scans=10)
    telegrams = editor.scope("Telegrams")
    text = list(telegrams.values())[-1]["value"]
    assert text.startswith("WriteIoPortBit (16#0301): I/O port assignment, bit units; port 2")
    assert "normal end" in text
