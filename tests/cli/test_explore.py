"""`rcx explore` visits all states of a small program, and reports broken rules."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from multiprocessing import active_children
from pathlib import Path
from typing import Any

import pytest

from rcx_harness.cell import Cell
from rcx_harness.cell.sources import source_files
from rcx_harness.cell.stimulus import Stimulus
from rcx_harness.cli.app import main
from rcx_harness.cli.start import INTERRUPTED
from rcx_harness.spec.wire import ABNORMAL_END, NORMAL_END, READY, RUN
from rcx_harness.verify.explore import user
from rcx_harness.verify.explore.controller import FAULTS, Small, Wire
from rcx_harness.verify.explore.user import Settings, explore
from structured_text.farm.local import LocalCrew

Captured = pytest.CaptureFixture[str]

_PROGRAM = """PROGRAM Lamp
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    {variables}
  END_VAR
  {body}
END_PROGRAM
"""
_LATE = _PROGRAM.format(
    variables="Button, Key, Green : BOOL; Late : TON;",
    body="Late(IN := Button AND Key, PT := T#300ms);\n  Green := Late.Q;",
)
_COUNT = _PROGRAM.format(
    variables="Button : BOOL; Count : INT;",
    body="IF Button THEN\n    Count := (Count + 1) MOD 3;\n  END_IF;",
)
_STOPS = _PROGRAM.format(
    variables="Button : BOOL; Count : INT; Row : ARRAY [1..2] OF INT;",
    body="IF Button THEN\n    Count := Count + 1;\n    Row[Count] := 1;\n  END_IF;",
)
#: A program that changes SI(01) in every scan.
_FLICKERS = _PROGRAM.format(
    variables="On : BOOL;", body="On := NOT On;\n  OutputArea[32] := SEL(On, BYTE#0, BYTE#2);"
)
_ROBOT = """PROGRAM Robot
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Connected, Go, Back : BOOL;
    Robot : RCX_REF;
    ReadArea : FB_ReadArea;
    WriteArea : FB_WriteArea;
    {variables}
  END_VAR
  ReadArea(Robot := Robot, Image := InputArea, Connected := Connected);
  {body}
  WriteArea(Robot := Robot, Image := OutputArea, EmergencyStopOk := TRUE, StopOk := TRUE);
END_PROGRAM
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def _written(folder: Path, text: str) -> str:
    (folder / "Lamp.st").write_text(text, encoding="utf-8")
    return "Lamp.st"


def test_a_program_is_explored_to_its_end(folder: Path, capsys: Captured) -> None:
    """By hand, there are 7 states: the initial state, and 3 counts for each value of Button."""
    file = _written(folder, _COUNT)
    assert main(["explore", file, "--input", "Main.Button", "--faults", "none"]) == 0
    said = capsys.readouterr().out
    figures = "7 states, 14 scans judged, up to 3 scans from the start"
    assert f"explored to the end: {figures}; no rule is broken" in said
    assert "input Main.Button: false, true" in said
    assert "not explored: the link is lost and comes back" in said


def test_a_program_with_a_located_variable_is_explored(folder: Path, capsys: Captured) -> None:
    """A located variable that is never written does not change the number of states."""
    text = _COUNT.replace("Button : BOOL;", "Button : BOOL; Far AT %QB60 : ARRAY [0..3] OF BYTE;")
    assert (
        main(["explore", _written(folder, text), "--input", "Main.Button", "--faults", "none"]) == 0
    )
    assert "explored to the end: 7 states" in capsys.readouterr().out


def test_an_input_without_values_keeps_its_value_and_is_named(
    folder: Path, capsys: Captured
) -> None:
    assert main(["explore", _written(folder, _LATE), "--input", "Main.Key"]) == 0
    assert "Main.Button keeps its initial value (--input Main.Button" in capsys.readouterr().out


def test_a_reached_bound_is_reported(folder: Path, capsys: Captured) -> None:
    command = ["explore", _written(folder, _COUNT), "--input", "Main.Button"]
    for bound in (["--bound", "2"], ["--depth", "1"]):
        assert main([*command, *bound]) == 0
        said = capsys.readouterr().out
        assert "BOUND REACHED: " in said
        assert "explored to the end" not in said


def test_an_assertion_is_broken_by_a_shortest_run(folder: Path, capsys: Captured) -> None:
    """The shortest counterexample has 5 scans of 100 ms: an input changes, then 300 ms pass."""
    file = _written(folder, _LATE)
    always = "NOT (Main.Green AND Button)"
    inputs = ["--input", "Main.Button", "--input", "Main.Key"]
    assert main(["explore", file, *inputs, "--always", always]) == 1
    said = capsys.readouterr().out
    assert "BROKEN in scan 5, at 400 ms" in said
    assert "always: NOT (Green AND Button)" in said
    command = next(line for line in said.splitlines() if line.startswith("  rcx run "))
    assert main(command.split()[1:]) == 0  # `rcx run` does not check the option --always
    with Cell.build(file, scan="100ms") as cell:
        Stimulus.load("out/explore/broken.toml").schedule(cell)
        cell.scan(4)
        assert not cell["Main.Green"]
        cell.scan()
        assert cell["Main.Green"]
        assert cell["Main.Button"]
    assert "Lamp.st" not in [path.name for path in Path("out/explore").iterdir()]


#: Operator inputs for _LATE. Both inputs can be TRUE from the scan at 100 ms on, and the lamp
#: lights 300 ms later.
_LATE_DEMANDS = """[operator]
buttons = ["Main.Button"]
switches = ["Main.Key"]
"""


@pytest.mark.parametrize(
    ("demanded", "broken"),
    [
        ('[[always]]\nname = "dark"\nthat = "NOT (Main.Green AND Main.Button)"\n',
         "BROKEN in scan 5, at 400 ms|always dark: NOT (Main.Green AND Main.Button) is not so"),
        (  # the time limit for the lamp ends at 200 ms, in scan 3
            '[[eventually]]\nname = "lit"\nafter = "Main.Button AND Main.Key"\n'
            'that = "Main.Green"\nwithin = "100ms"\n',
            "BROKEN in scan 4, at 300 ms|eventually lit: Main.Green has not come within 100 ms",
        ),
        (  # the lamp lights only at 400 ms, but an input may turn FALSE before
            '[[eventually]]\nafter = "Main.Button AND Main.Key"\n'
            'that = "Main.Green"\nwithin = "200ms"\n',
            "BROKEN in scan 5, at 400 ms|has not come within 200 ms; Main.Green = FALSE",
        ),
        ('[[eventually]]\nafter = "Main.Button AND Main.Key"\n'
         'that = "Main.Green OR NOT Main.Button OR NOT Main.Key"\nwithin = "200ms"\n', ""),
    ],
)  # fmt: skip
def test_a_property_from_a_file_is_checked_and_can_be_run_again(
    folder: Path, capsys: Captured, demanded: str, broken: str
) -> None:
    (folder / "mine.toml").write_text(_LATE_DEMANDS + demanded)
    command = ["explore", _written(folder, _LATE), "--properties", "mine.toml"]
    assert main(command) == bool(broken)
    said = capsys.readouterr().out
    assert "input Main.Button: false, true;" in said
    assert "input Main.Key: false, true;" in said
    if not broken:
        assert "explored to the end" in said
        return
    for text in broken.split("|"):
        assert text in said
    assert "what it does not know" not in said
    again = next(line for line in said.splitlines() if line.startswith("  rcx run "))
    assert main(again.split()[1:]) == 1
    assert broken.split("|")[1] in capsys.readouterr().out


def test_a_property_may_use_the_value_of_the_last_scan(folder: Path, capsys: Captured) -> None:
    """BEFORE(x) is the value of x in the last scan. By hand, the third scan breaks the property."""
    demanded = '[[always]]\nthat = "BEFORE(Main.Count) <> 2 OR Main.Count <> 0"\n'
    (folder / "mine.toml").write_text(demanded + '[operator]\nbuttons = ["Main.Button"]\n')
    command = ["explore", _written(folder, _COUNT), "--properties", "mine.toml"]
    assert main(command) == 1
    assert "BROKEN in scan 3, at 200 ms" in capsys.readouterr().out


def test_operator_values_are_inputs_and_options_have_priority(
    folder: Path, capsys: Captured
) -> None:
    operator = 'buttons = ["Main.Button"]\nvalues = { "Main.Count" = [0, 2] }\n'
    (folder / "mine.toml").write_text(f"[operator]\n{operator}")
    command = ["explore", _written(folder, _COUNT), "--properties", "mine.toml"]
    assert main([*command, "--input", "Main.Button=true"]) == 0
    said = capsys.readouterr().out
    assert "input Main.Button: true;" in said
    assert "input Main.Count: 0, 2;" in said


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("mine.toml", '[[always]]\nthat = "Main.Cont = 1"\n', "did you mean Count"),
        ("mine.toml", '[operator]\nbuttons = ["Main.Btton"]\n', "did you mean Button"),
        ("mine.toml", "[[allways]]\n", "did you mean always"),
        (
            "mine.py",
            "import rcx_harness as rcx\n\n@rcx.always\ndef low(cell):\n    return True\n",
            "mine.py: low: properties in Python cannot be explored; write it as [[always]]",
        ),
    ],
)
def test_impossible_properties_end_with_2(
    folder: Path, capsys: Captured, name: str, text: str, message: str
) -> None:
    (folder / name).write_text(text)
    assert main(["explore", _written(folder, _COUNT), "--properties", name]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1


def test_assertions_in_comments_are_checked(folder: Path, capsys: Captured) -> None:
    text = _COUNT.replace("END_IF;", "END_IF;\n  (* prove: Count < 2 *)")
    assert main(["explore", _written(folder, text), "--input", "Main.Button"]) == 1
    assert "always: Count < 2" in capsys.readouterr().out


def test_a_broken_rule_of_the_wire_is_confirmed_by_rcx_run(folder: Path, capsys: Captured) -> None:
    """`rcx explore` finds a broken rule, and `rcx run` reports it as well.

    Source: manual chapter 5, 3, caution: 100 ms between changes of dedicated inputs.
    """
    file = _written(folder, _FLICKERS)
    assert main(["explore", file, "--scan", "100ms"]) == 1  # SI(01) turns ON while SI(00) is OFF
    assert "start against stop: SI(01) ON while SI(00) is OFF" in capsys.readouterr().out
    # SI(00) is ON from the first scan on
    released = _FLICKERS.replace("BYTE#0, BYTE#2", "BYTE#1, BYTE#3")
    file = _written(folder, released.replace("On : BOOL;", "On : BOOL := TRUE;"))
    assert main(["explore", file, "--scan", "100ms"]) == 0
    capsys.readouterr()
    assert main(["explore", file, "--scan", "50ms"]) == 1
    said = capsys.readouterr().out
    assert "interval: " in said
    assert "what it does not know" not in said
    command = next(line for line in said.splitlines() if line.startswith("  rcx run "))
    assert main(command.split()[1:]) == 1
    assert "interval: " in capsys.readouterr().out


def test_a_program_that_stops_is_reported_with_its_line(folder: Path, capsys: Captured) -> None:
    """The third scan with Button TRUE exceeds the array of two elements, so the program stops."""
    file = _written(folder, _STOPS)
    assert main(["explore", file, "--input", "Main.Button"]) == 1
    said = capsys.readouterr().out
    assert "BROKEN in scan 3" in said
    assert f"stops: {file}:8" in said


@pytest.mark.exhaustive(but=["On : FB_ServoOn; Move : FB_MovePtp;-body0"])
@pytest.mark.parametrize(
    ("variables", "body"),
    [
        ("On : FB_ServoOn; Move : FB_MovePtp;",
         "On(Robot := Robot, Execute := Go, Timeout := T#500ms);\n"
         "  Move(Robot := Robot, Execute := On.Done, Point := 1, Timeout := T#500ms);"),
        ("Up : FB_PowerUp; Port : FB_WriteIoPortBit;",
         "Up(Robot := Robot, Execute := Go, Timeout := T#1s);\n"
         "  Port(Robot := Robot, Execute := Back, PortNumber := 2, Timeout := T#1s);"),
        ("Stop : FB_EmergencyStop; Up : FB_ServoOnFromEmergencyStop;",
         "Stop(Robot := Robot, Execute := Go);\n  Up(Robot := Robot, Execute := Back);"),
        ("Jog : FB_Jog; Reset : FB_AlarmReset; Pulse : TP; Off : TOF; Ups : CTU;",
         "Pulse(IN := Go, PT := T#200ms);\n  Off(IN := Pulse.Q, PT := T#300ms);\n"
         "  Ups(CU := Off.Q, R := Back, PV := 2);\n" "  Jog(Robot := Robot, Enable := Pulse.Q);\n"
         "  Reset(Robot := Robot, Execute := Ups.Q);"),
    ],
)  # fmt: skip
def test_states_with_blocks_are_distinguished(folder: Path, variables: str, body: str) -> None:
    """No state is merged wrongly.

    A scan of each state is repeated with other values of the variables that the state omits.
    """
    file = _written(folder, _ROBOT.format(variables=variables, body=body))
    inputs: dict[str, list[str]] = {"Main.Go": [], "Main.Back": []}
    found = explore(source_files(file), Settings(inputs=inputs, states=250)).result
    assert found.broken is None, found.broken
    assert found.checked == 250
    assert found.transitions > 1000


@pytest.fixture
def given(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Return a list that collects the number of each item that is sent to a worker."""
    numbers: list[int] = []
    give = LocalCrew.give

    def noted(self: LocalCrew, number: int, item: Any) -> None:
        numbers.append(number)
        give(self, number, item)

    monkeypatch.setattr(LocalCrew, "give", noted)
    monkeypatch.setattr(user, "_ALONE_S", 0.0)
    return numbers


@pytest.mark.exhaustive(but=["program0-words0-0-explored to the end"])
@pytest.mark.parametrize(
    ("program", "words", "code", "said"),
    [
        (_COUNT, ["--input", "Main.Button"], 0, "explored to the end"),
        (_LATE, ["--input", "Main.Button", "--input", "Main.Key", "--always", "NOT Green"], 1,
         "BROKEN in scan 5"),
        (_ROBOT.format(variables="On : FB_ServoOn;",
                       body="On(Robot := Robot, Execute := Go AND NOT Back);"),
         ["--input", "Main.Go", "--input", "Main.Back", "--bound", "60"], 0, "BOUND REACHED"),
    ],
)  # fmt: skip
def test_the_number_of_workers_does_not_change_the_result(
    folder: Path,
    capsys: Captured,
    given: list[int],
    program: str,
    words: list[str],
    code: int,
    said: str,
) -> None:
    command = ["explore", _written(folder, program), *words]
    assert main([*command, "--workers", "0"]) == code
    alone = capsys.readouterr().out
    assert said in alone
    assert main([*command, "--workers", "1"]) == code
    assert capsys.readouterr().out == alone
    assert not given
    assert main([*command, "--workers", "2"]) == code
    assert capsys.readouterr().out == alone
    assert len(given) > 10


@pytest.mark.exhaustive
def test_ctrl_c_ends_the_command_and_its_workers(
    folder: Path, capsys: Captured, given: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ctrl-C ends the command and all its workers.

    `main` prints nothing, because `cli.start` does.
    """
    ended = LocalCrew.ended

    def with_ctrl_c(self: LocalCrew) -> Iterator[Any]:
        if len(given) > 5:
            assert active_children()
            signal.raise_signal(signal.SIGINT)
        yield from ended(self)

    monkeypatch.setattr(LocalCrew, "ended", with_ctrl_c)
    words = ["--input", "Main.Button", "--workers", "2"]
    assert main(["explore", _written(folder, _COUNT), *words]) == INTERRUPTED
    assert not active_children()
    said = capsys.readouterr()
    assert said.out == said.err == ""


def test_the_simplified_controller_answers_as_in_the_manual() -> None:
    """The simplified controller of `rcx explore` makes only the moves that the manual describes.

    Source: guide chapter 1, 1.2 (status); manual chapter 5, 2 and 3.1 (servo, stops).
    """
    every = frozenset(FAULTS)
    at_first = Small()
    # without a request the controller does nothing
    assert list(at_first.moves(Wire(), frozenset())) == [""]
    taken = at_first.seen(Wire(0x0001, 0x0041))
    assert set(taken.moves(Wire(0x0001, 0x0041), frozenset())) == {"", "run"}
    runs = taken.after("run")
    assert runs.status == RUN
    assert set(runs.moves(Wire(0x0001), every)) == {"", "end", "abnormal", "alarm", "link"}
    for move, status in (("end", NORMAL_END), ("abnormal", ABNORMAL_END)):
        ended = runs.after(move)
        assert ended.status == status
        # the PLC still sends the command code
        assert "ready" not in ended.moves(Wire(0x0001), every)
        assert "ready" in ended.moves(Wire(0), every)
    on = taken.seen(Wire(0, 0x0043)).after("servo")
    assert on.so & 0x0004
    # the PLC turns SI(00) OFF, which is an emergency stop
    assert not on.seen(Wire(0, 0x0042)).so & 0x0004
    assert on.seen(Wire(0, 0x0042)).so & 0x0001
    lost = on.after("link")
    assert (lost.link, lost.status) == (False, READY)
    back = lost.after("link up").seen(Wire(0, 0x0043))
    assert "servo" not in back.moves(Wire(0, 0x0043), every)  # SI(01) stays ON, so there is no edge


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--scan", "0s"], "--scan of 0 s is too short"),
        (["--faults", "fire"], "--faults fire: no such fault; use link, alarm, abnormal"),
        (["--input", "Main.Nothing"], "has no member Nothing"),
        (["--input", "Main.Count"], "no values for Main.Count; write --input Main.Count=1,2,3"),
        (["--input", "Main.Count=many"], "'many' is not a value for Main.Count"),
        (["--input", "Main.Count=99999"], "99999"),
        (["--input", "Main.Button", "--input", "main.button"], "is given twice"),
        (["--always", "Nothing = 1"], "'Nothing = 1' cannot be checked"),
        (["--always", " "], "is not an expression"),
        (["--size", "50"], "an area of 50 bytes does not exist"),
    ],
)
def test_bad_input_ends_with_2(
    folder: Path, capsys: Captured, words: list[str], message: str
) -> None:
    assert main(["explore", _written(folder, _COUNT), *words]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert "Traceback" not in error


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            ("Count : INT;", "Count : INT; p : POINTER TO INT;"),
            "a variable of type POINTER TO INT cannot be explored",
        ),
        (("Count : INT;", "Count : INT; A, B : RCX_REF;"), "the program has 2 robots"),
        (("IF Button", "IF TIME() > T#1s AND Button"), "reads the time"),
    ],
)
def test_programs_that_cannot_be_explored_are_refused(
    folder: Path, capsys: Captured, change: tuple[str, str], message: str
) -> None:
    assert main(["explore", _written(folder, _COUNT.replace(*change))]) == 2
    assert message in capsys.readouterr().err
