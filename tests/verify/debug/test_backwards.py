"""The debugger goes back by statement, to breakpoints and to changes.

Values that the user has set are set again when the scan is repeated.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from editor import Editor, RefusedError
from rcx_harness.cli.debug import launched
from rcx_harness.verify.debug.machine import CellMachine
from structured_text.debug.places import Places
from structured_text.debug.player import Player

Start = Callable[..., Editor]


def test_back_goes_through_the_lines_that_went_forward(at_entry: Start) -> None:
    editor = at_entry()
    editor.go("rcx/stepScan", scans=2)
    lines = []
    for _ in range(7):
        editor.go("stepBack")
        lines.append(editor.line)
    # The step goes back over the calls in lines 51 and 50. In the second scan Lamp is still DARK.
    assert lines == [58, 57, 52, 51, 50, 58, 57]
    assert editor.value("C.Value") == "1"


def test_back_out_of_a_block_comes_to_its_call(stopped: Start) -> None:
    editor = stopped({"line": 28, "condition": "Value = 3"})
    lines = []
    for _ in range(3):
        editor.go("stepBack")
        lines.append(editor.stack()[0])
    assert lines == [("Main.C (Counter)", 26), ("Main.C (Counter)", 25), ("Main (Lamps)", 50)]
    assert editor.value("C.Value") == "2"


def test_at_the_start_there_is_nothing_before(at_entry: Start) -> None:
    why = at_entry().go("stepBack")
    assert why["text"] == "the start of the run: there is nothing before it"


def test_back_to_the_breakpoint_before(stopped: Start) -> None:
    editor = stopped({"line": 53})
    assert editor.value("C.Value") == "6"
    editor.go()
    editor.go()
    assert editor.value("C.Value") == "8"
    editor.go("reverseContinue")
    assert (editor.line, editor.value("C.Value")) == (53, "7")
    editor.go("reverseContinue")
    editor.go("reverseContinue")
    assert editor.value("C.Value") == "0", "there is no earlier change, so this is the start"


def test_each_round_of_a_loop_is_a_hit(stopped: Start) -> None:
    editor = stopped({"line": 31})
    editor.go()
    editor.go()
    assert editor.value("k") == "3"
    editor.go("reverseContinue")
    assert (editor.value("Value"), editor.value("k")) == ("1", "2")


def test_the_debugger_goes_back_to_the_statement_that_changed_a_variable(at_entry: Start) -> None:
    """The debugger goes back to the statement that changed a variable.

    Lamp becomes BRIGHT in the sixth scan by line 53, and DIM in the third by line 55.
    """
    editor = at_entry()
    editor.go("rcx/stepScan", scans=200)
    frames = editor.request("stackTrace", threadId=1)["stackFrames"]
    editor.request("rcx/backToChange", variable="Lamp", frameId=frames[0]["id"])
    why = editor.event("stopped")
    assert why["text"] == "Main.Lamp: DIM -> BRIGHT"
    assert (editor.line, editor.value("C.Value"), editor.value("Lamp")) == (53, "6", "DIM")
    editor.say(".back Lamp")
    why = editor.event("stopped")
    assert why["text"] == "Main.Lamp: DARK -> DIM"
    assert (editor.line, editor.value("C.Value")) == (55, "3")
    editor.say(".back Lamp")
    assert editor.event("stopped")["text"] == "Main.Lamp has not changed before"
    assert editor.line == 55


def test_a_change_from_outside_is_shown(editor: Editor, lamps: Path, tmp_path: Path) -> None:
    """A change by a stimulus is shown in the scan in which it takes effect.

    A stimulus at 45 ms takes effect in the scan at 50 ms, the sixth.
    """
    stimulus = tmp_path / "off.toml"
    stimulus.write_text('[[at]]\ntime = "45ms"\nset = { "Main.Go" = false }\n')
    editor.start(sources=[str(lamps)], stimulus=str(stimulus), for_="1s")
    editor.say(".back Go")
    assert editor.event("stopped")["text"] == "Main.Go: TRUE -> FALSE"
    assert (editor.line, editor.value("C.Value")) == (50, "5")


def test_a_value_set_by_the_user_is_set_again_at_the_same_statement(stopped: Start) -> None:
    """A value that the user has set is set again at the same statement of a repeated run.

    Value becomes 100 inside the second scan, so two scans later it is 102.
    """
    editor = stopped({"line": 28, "condition": "Value = 2"})
    editor.say("Value := 100")
    editor.go("rcx/stepScan", scans=3)
    assert editor.value("C.Value") == "102"
    editor.go("rcx/stepScan", scans=-3)
    assert editor.value("C.Value") == "1"
    editor.go("rcx/stepScan", scans=2)
    assert editor.value("C.Value") == "101"


def test_to_change_the_past_forgets_what_came_after(at_entry: Start) -> None:
    editor = at_entry()
    editor.go("rcx/stepScan", scans=100)
    editor.go("rcx/stepScan", scans=-90)
    assert editor.value("C.Value") == "10"
    said = editor.say("C.Value := 1000")
    assert said == "C.Value = 1000; the scans after this one were discarded"
    editor.go("rcx/stepScan", scans=90)
    assert editor.value("C.Value") == "1090", "90 scans have run since"


def test_commands_of_the_console(at_entry: Start) -> None:
    editor = at_entry()
    editor.say(".goto 40")
    editor.event("stopped")
    assert editor.value("C.Value") == "39"
    editor.say(".goto 7")
    editor.event("stopped")
    assert editor.value("C.Value") == "6"
    editor.say(".start")
    editor.event("stopped")
    assert editor.value("C.Value") == "0"
    assert ".back X" in editor.say(".help")
    with pytest.raises(RefusedError, match=r"there is no command \.bcak; \.help lists them"):
        editor.say(".bcak X")
    with pytest.raises(RefusedError, match=r"'soon' is not a number; write \.scan 10"):
        editor.say(".scan soon")


def test_an_injected_event_is_repeated_at_the_same_time(editor: Editor, repository: Path) -> None:
    """An event that the user injects is repeated at the same time when the run is repeated.

    Without a link, the program reads Connected as FALSE 100 ms after the last packet.
    """
    example = repository / "plc" / "examples" / "04_pick_and_place"
    editor.start(sources=[str(example)], stopOnEntry=True, for_="2s")
    editor.say(".scan 100")
    editor.event("stopped")
    assert editor.value("Main.Connected") == "TRUE"
    assert editor.say(".inject link_down").startswith("link_down at scan 101")
    with pytest.raises(RefusedError, match="link_dwn"):
        editor.say(".inject link_dwn")
    editor.say(".scan 20")
    editor.event("stopped")
    assert editor.value("Main.Connected") == "FALSE"
    editor.say(".scan -40")
    editor.event("stopped")
    assert editor.value("Main.Connected") == "TRUE"
    editor.say(".scan 40")
    editor.event("stopped")
    assert editor.value("Main.Connected") == "FALSE", "the event happens again at the same time"


# --- the number of repeated scans ---------------------------------------------------------------


@pytest.mark.exhaustive
def test_a_step_back_repeats_few_scans_even_after_a_long_run(lamps: Path) -> None:
    """A step back repeats at most 64 scans, even after a long run.

    A run of 60,000 scans (10 minutes) has at most 1,000 snapshots, one in 64 scans. The repeated
    scans are at most 63, and the scan that is shown.
    """
    machine = launched({"sources": [str(lamps)], "for": "600s"}, []).machine
    player = Player(machine, Places(machine.program))
    while not machine.ended:
        player.plain()
    assert machine.scans == 60_000
    assert (player.stride, player.kept) == (64, 938)
    for scan in (59_999, 59_000, 31_007, 63, 1):
        before = player.rerun
        player.seek(scan)
        player.every(lambda: None)
        assert player.rerun - before <= 64
        assert machine.program.read("Main.C.Value") == scan + 1
    machine.close()


@pytest.mark.exhaustive
def test_a_repeated_scan_is_the_same_to_the_byte(repository: Path, tmp_path: Path) -> None:
    """A repeated scan gives the same bytes for the whole cell.

    This includes the program, random delays and network jitter.
    """
    stimulus = tmp_path / "start.toml"
    stimulus.write_text(
        '[[at]]\ntime = "100ms"\nset = { "Main.CellSafe" = true }\n'
        '[[at]]\ntime = "600ms"\nset = { "Main.Start" = true }\n'
    )
    example = repository / "plc" / "examples" / "04_pick_and_place"
    options = {"jitter": "7ms", "seed": 5, "phases": "random", "stimulus": str(stimulus)}
    machine = launched({"sources": [str(example)], "for": "3s", **options}, []).machine
    assert isinstance(machine, CellMachine)
    player = Player(machine, Places(machine.program))

    def area() -> tuple[bytes, bytes]:
        return machine.telegrams[0].so, machine.telegrams[0].si

    first = []
    while not machine.ended:
        player.plain()
        first.append(area())
    assert len(set(first)) > 10
    for start in (0, 100, 37):
        player.seek(start)
        again = []
        while not machine.ended:
            if machine.scans % 3:
                player.plain()
            else:
                player.every(lambda: None)
            again.append(area())
        assert again == first[start:]
    machine.close()
