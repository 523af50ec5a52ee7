"""The debugger names rungs, stops once for an element of a rung, and steps through its statements.

The lines of the program are the lines of its drawing, see `drawing`.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from drawing import drawing_files
from editor import Editor, RefusedError
from plcopen_drawings import element, project
from structured_text import Bench
from structured_text.debug.bench import BenchMachine
from structured_text.debug.session import Launched
from structured_text.projects.sources import source_files


@pytest.fixture
def debugged(tmp_path: Path) -> Iterator[Editor]:
    """Return an editor that has stopped before the first statement; Start is TRUE."""
    bench = Bench.build(drawing_files(tmp_path), engine="builtin", scan="10ms")
    bench["Main.Start"] = True
    editor = Editor(lambda _: Launched(BenchMachine(bench, 60_000, "60ms")))
    editor.start(stopOnEntry=True)
    yield editor
    editor.close()


def _on_functions(editor: Editor, *names: str) -> list[dict[str, Any]]:
    wanted = [{"name": name} for name in names]
    found: list[dict[str, Any]] = editor.request("setFunctionBreakpoints", breakpoints=wanted)[
        "breakpoints"
    ]
    return found


def test_the_title_of_a_call_names_the_rung_and_the_statement(debugged: Editor) -> None:
    assert debugged.stack() == [
        ("Main (Main), rung 1: Lamp := (Start OR Lamp) AND NOT Stop", 4),
    ]


def test_steps_go_through_the_statements_of_a_rung(debugged: Editor) -> None:
    """Each statement of rung 2 is a step, although all have line 6; then rung 3 follows.

    Rung 3 executes line 9 before line 8. In the first scan Motor is TRUE and Stop FALSE.
    """
    steps = []
    for _ in range(7):
        debugged.go("next")
        ((title, line),) = debugged.stack()
        steps.append((line, title.removeprefix("Main (Main), ")))
    assert steps == [
        (6, "rung 2: Motor := Lamp"),
        (6, "rung 2: IF Motor THEN"),
        (6, "rung 2: Count := Count + 1"),
        (6, "rung 2: IF Stop THEN"),
        (9, "rung 3: First := Count > 1"),
        (8, "rung 3: Last := First"),
        (4, "rung 1: Lamp := (Start OR Lamp) AND NOT Stop"),
    ]


def test_steps_go_back_through_the_statements_of_a_rung(debugged: Editor) -> None:
    for _ in range(4):
        debugged.go("next")
    debugged.go("stepBack")
    assert debugged.stack()[0][0].endswith("Count := Count + 1")


def test_the_reason_of_a_stop_names_the_rung(debugged: Editor) -> None:
    stop = debugged.go("next")
    assert stop["description"] == "step (scan 1, 0 ms, Main, rung 2)"


def test_a_breakpoint_stops_once_for_an_element(debugged: Editor, tmp_path: Path) -> None:
    """Line 5 has no statement, so the breakpoint moves to line 6.

    It stops once in each scan, before the first statement of rung 2.
    """
    (told,) = debugged.set(tmp_path / "main.xml", 5)
    assert (told["verified"], told["line"]) == (True, 6)
    for count in ("0", "1", "2"):
        debugged.go()
        assert debugged.stack() == [("Main (Main), rung 2: Motor := Lamp", 6)]
        assert debugged.value("Count") == count


@pytest.mark.parametrize("name", ["Main rung 3", "main: Rung 3", "Main,rung  3", "Main 3"])
def test_a_function_breakpoint_stops_at_a_rung(debugged: Editor, name: str) -> None:
    """The first statement of rung 3 is that of line 9, although line 8 is before it."""
    (told,) = _on_functions(debugged, name)
    assert (told["verified"], told["line"]) == (True, 9)
    for count in ("1", "2"):
        debugged.go()
        assert debugged.stack() == [("Main (Main), rung 3: First := Count > 1", 9)]
        assert debugged.value("Count") == count


def test_a_function_breakpoint_at_a_pou_stops_at_its_first_rung(debugged: Editor) -> None:
    """The first statement of a POU need not be the first one in the file."""
    (told,) = _on_functions(debugged, "Main")
    assert (told["verified"], told["line"]) == (True, 4)
    debugged.go()
    assert debugged.stack()[0][1] == 4


@pytest.mark.parametrize(
    ("name", "message"),
    [
        (
            "Main rung 7",
            "Main has no rung 7 with statements; did you mean rung 3 or rung 2 or rung 1",
        ),
        ("Main step Fill", "Main has no step Fill with statements; it has rung 1, rung 2, rung 3"),
        ("Other rung 1", "there is no POU Other rung 1 with statements"),
    ],
)
def test_a_wrong_rung_is_answered_with_the_rungs(debugged: Editor, name: str, message: str) -> None:
    (told,) = _on_functions(debugged, name)
    assert (told["verified"], told["message"]) == (False, message)


def test_where_names_the_rung(debugged: Editor) -> None:
    debugged.go("next")
    assert debugged.say(".where") == (
        "scan 1, 0 ms: PLC: Main (Main), rung 2: Motor := Lamp, line 6"
    )


def test_the_console_draws_the_rung_with_what_has_power(tmp_path: Path) -> None:
    """Start is TRUE, and the trigger of its edge has been called; the coil is next."""
    rung = element("leftPowerRail", 1) + element("contact", 2, "Start", "1", edge="rising")
    rung += element("contact", 3, "Bits.1", "2", at="9 0", negated="true")
    rung += element("coil", 4, "Motor", "3", at="20 0", storage="set")
    rung += element("inVariable", 5, "N", at="0 99") + element("outVariable", 6, "M", "5", "9 99")
    text = project("Start Motor : BOOL; Bits : WORD; N M : INT", f"<LD>{rung}</LD>")
    (tmp_path / "plc.xml").write_text(text, encoding="utf-8")
    bench = Bench.build(source_files(tmp_path / "plc.xml", None), engine="builtin", scan="10ms")
    bench["Main.Start"] = True
    bench["Main.N"] = 7
    editor = Editor(lambda _: Launched(BenchMachine(bench, 60_000, "60ms")))
    editor.start(stopOnEntry=True)
    editor.go("next")
    assert editor.say(".draw").splitlines() == [
        "Network 1",
        "┃  Start = TRUE  Bits.1 = FALSE  Motor = FALSE  │",
        "┃━━━━━━┤P├━━━━━━━━━━━━┤/├━━━━━━━━━━━━━(S)━━━━━━━│",
    ]
    editor.go("next")
    editor.go("next")
    assert editor.say(".draw").splitlines() == ["Network 2", "N = 7──M = 0"]
    editor.close()


def test_a_statement_of_text_has_no_drawing(debugged: Editor) -> None:
    """The lines of this program name rungs, but no reader has given their diagram."""
    with pytest.raises(RefusedError, match="this statement has no drawing"):
        debugged.say(".draw")
