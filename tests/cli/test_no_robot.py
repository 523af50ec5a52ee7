"""With `--no-robot`, commands run a program without a robot and without areas."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from rcx_harness.cli.app import main
from rcx_harness.cli.debug import launched
from rcx_harness.trace import Scan, read_trace
from structured_text.errors import InputError

Captured = pytest.CaptureFixture[str]

_MOTOR = """PROGRAM Main
  VAR Start, Stop, Motor : BOOL; Count : INT; END_VAR
  IF Stop THEN Motor := FALSE; ELSIF Start THEN Motor := TRUE; END_IF;
  IF Motor AND Count < 3 THEN Count := Count + 1; END_IF;
END_PROGRAM
"""


@pytest.fixture
def motor(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Write a program without areas into the current folder, and return its file name."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("RCX_MATIEC", raising=False)
    (tmp_path / "motor.st").write_text(_MOTOR, encoding="utf-8")
    (tmp_path / "s.toml").write_text('at = [{ time = "95ms", set = { "Main.Start" = true } }]')
    (tmp_path / "p.toml").write_text('[[always]]\nthat = "Main.Count < 3"\n')
    return "motor.st"


def test_a_program_without_areas_runs_with_all_outputs(motor: str, capsys: Captured) -> None:
    """A run without a robot writes trace, chart, waves and page. Count is 3 at 120 ms."""
    files = ["--trace", "t.jsonl", "--chart", "c.svg", "--vcd", "w.vcd", "--view", "v.html"]
    options = ["--stimulus", "s.toml", "--watch", "Main.*", "--show", "--engine", "builtin"]
    assert main(["run", motor, "--no-robot", "--for", "1s", *options, *files]) == 0
    out = capsys.readouterr().out
    assert "1 s on the builtin engine: 100 scans, no violations" in out
    assert "Main.Count" in out
    assert "connection" not in out
    assert "Remote" not in out
    header, records = read_trace("t.jsonl")
    assert "size" not in header
    counts = ((one.t_us, one.vars) for one in records if isinstance(one, Scan))
    assert next(t_us for t_us, values in counts if values and values["Main.Count"] == 3) == 120_000
    assert "Main.Motor" in Path("c.svg").read_text(encoding="utf-8")
    assert "Motor" in Path("w.vcd").read_text(encoding="utf-8")
    assert main(["view", "t.jsonl", "-o", "again.html"]) == 0


def test_properties_and_coverage_work_without_a_robot(motor: str, capsys: Captured) -> None:
    options = ["--stimulus", "s.toml", "--for", "1s", "--properties", "p.toml", "--coverage"]
    assert main(["run", motor, "--no-robot", *options]) == 1
    out = capsys.readouterr().out
    assert "violation at 120 ms: plc, scan 13: property: always Main.Count < 3" in out
    assert "75.0 % 3/4" in out, "the line that stops the motor is not executed"


def test_missing_areas_are_reported_with_what_to_do(motor: str, capsys: Captured) -> None:
    assert main(["run", motor, "--engine", "builtin"]) == 2
    said = capsys.readouterr().err
    assert "declare InputArea and OutputArea" in said
    assert "in a list of global variables" in said
    assert "--no-robot" in said


@pytest.mark.parametrize(
    ("command", "option"),
    [
        ("run", "--robot=robot.toml"),
        ("run", "--link=enip"),
        ("run", "--size=256"),
        ("run", "--rpi=20ms"),
        ("run", "--m=4"),
        ("run", "--connect=192.168.0.2"),
        ("run", "--positions=mm"),
        ("run", "--from=127.0.0.1"),
        ("explore", "--faults=link"),
        ("explore", "--size=256"),
        ("run", "--size=48"),
        ("run", "--link=direct"),
        ("run", "--m=0"),
        ("run", "--rpi=10ms"),
        ("explore", "--faults=link,alarm,abnormal"),
        ("explore", "--n=0"),
    ],
)
def test_an_option_for_a_robot_is_refused(
    motor: str, capsys: Captured, command: str, option: str
) -> None:
    assert main([command, motor, "--no-robot", option]) == 2
    name = option.partition("=")[0]
    told = f"{name} needs a robot, and the program runs without one; "
    told += f"leave out {name}, or leave out --no-robot"
    assert told in capsys.readouterr().err


@pytest.mark.parametrize("key", ['robot = "alarm"', 'hold = "SO02"', 'area = "00"'])
def test_a_stimulus_for_a_robot_is_refused(motor: str, capsys: Captured, key: str) -> None:
    Path("r.toml").write_text(f'at = [\n  {{ time = "1s", {key} }},\n]\n')
    assert main(["run", motor, "--no-robot", "--stimulus", "r.toml"]) == 2
    told = f"r.toml:2: {key.partition(' ')[0]!r} needs a robot, and the program runs without one"
    assert told in capsys.readouterr().err


def test_all_states_of_a_program_alone_are_explored(motor: str, capsys: Captured) -> None:
    """All 17 states of the program are explored; the number was determined by hand.

    With the motor off there are 3 input states and 4 counts. With the motor on there are 3 counts
    with Start ON and 2 counts with Start OFF. Each state has three successors: no input changes, or
    one of two inputs changes.
    """
    inputs = ["--input", "Main.Start", "--input", "Main.Stop", "--workers", "0"]
    assert main(["explore", motor, "--no-robot", "--always", "Count < 4", *inputs]) == 0
    out = capsys.readouterr().out
    assert "explored to the end: 17 states, 51 scans judged" in out
    assert "controller" not in out


def test_a_counterexample_runs_again(motor: str, capsys: Captured) -> None:
    options = ["--input", "Main.Start", "--properties", "p.toml", "--workers", "0"]
    assert main(["explore", motor, "--no-robot", *options]) == 1
    out = capsys.readouterr().out
    assert "BROKEN in scan 3, at 200 ms" in out
    line = next(one.split() for one in out.splitlines() if one.startswith("  rcx run "))
    assert main(line[1:]) == 1
    assert "violation at 200 ms: plc, scan 3: property" in capsys.readouterr().out


def test_a_program_alone_is_proved_or_refuted_with_a_run(motor: str, capsys: Captured) -> None:
    """`rcx prove` proves that Stop has priority, and gives a run that breaks Count < 3."""
    assertion = "(* prove: NOT (Stop AND Motor) *)\nEND_PROGRAM"
    Path(motor).write_text(_MOTOR.replace("END_PROGRAM", assertion), encoding="utf-8")
    assert main(["prove", motor, "--no-robot"]) == 0
    out = capsys.readouterr().out
    assert "inputs, with any value in each scan: Main.Start, Main.Stop\n" in out
    assert "2 properties: 2 proved, 0 refuted, 0 unknown" in out  # the total counts both properties
    Path(motor).write_text(_MOTOR.replace("END_PROGRAM", "(* prove: Count < 3 *)\nEND_PROGRAM"))
    assert main(["prove", motor, "--no-robot"]) == 1
    out = capsys.readouterr().out
    assert "refuted: assert motor.st:5: after 3 scans of 10 ms" in out
    line = next(one.split() for one in out.splitlines() if one.startswith("  rcx run "))
    assert main([*line[1:], "--watch", "Main.Count", "--trace", "t.jsonl"]) == 0
    _, records = read_trace("t.jsonl")
    last = [one.vars for one in records if isinstance(one, Scan) and one.vars][-1]
    assert last == {"Main.Count": 3}
    assert main(["prove", motor]) == 2
    assert "--no-robot" in capsys.readouterr().err


def test_a_client_of_the_debugger_launches_a_program_alone(motor: str) -> None:
    launch = {"sources": motor, "for": "1s", "stimulus": "s.toml"}
    with pytest.raises(InputError, match="no process image"):
        launched(launch, [])
    with pytest.raises(InputError, match="noRobot is not true or false"):
        launched({**launch, "noRobot": "yes"}, [])
    with pytest.raises(InputError, match="--rpi needs a robot"):
        launched({**launch, "noRobot": True, "rpi": "20ms"}, [])
    with pytest.raises(InputError, match="--rpi needs a robot"):
        launched({**launch, "rpi": "10ms"}, [], alone=True)
    for machine in (
        launched({**launch, "noRobot": True}, []).machine,
        launched(launch, [], alone=True).machine,
    ):
        for _ in range(11):
            machine.scan()
        assert machine.program.read("Main.Motor") is True
        machine.close()


@pytest.mark.exhaustive
def test_tests_with_a_bench_detect_mutants(motor: str, tmp_path: Path) -> None:
    """A test with a Bench, without a robot, detects all mutants of the assignment."""
    (tmp_path / "motor.st").write_text(
        "PROGRAM Main\n  VAR Start, Motor : BOOL; END_VAR\n  Motor := Start;\nEND_PROGRAM\n"
    )
    (tmp_path / "test_motor.py").write_text(
        "from structured_text import Bench\n\n"
        "def test_it_runs():\n"
        '    with Bench.build("motor.st") as bench:\n'
        '        bench["Main.Start"] = True\n'
        "        bench.scan()\n"
        '        assert bench["Main.Motor"]\n'
    )
    options = ["--workers", "1", "--json", "found.json", "--fail-under", "100"]
    assert main(["mutants", motor, *options, "--", "pytest", "-q", "-p", "no:cacheprovider"]) == 0
    found = json.loads(Path("found.json").read_text(encoding="utf-8"))["mutants"]
    assert found["killed"] == found["mutants"] > 0


_TIMES = """PROGRAM Main
  VAR D : DINT; END_VAR
  D := TIME_TO_DINT(T#2s);
END_PROGRAM
"""


@pytest.mark.parametrize(
    ("options", "value"), [([], 2), (["--dialect", "codesys"], 2000), (["--dialect", "iec"], 2)]
)
def test_a_program_runs_in_the_dialect_of_the_user(
    motor: str, options: list[str], value: int
) -> None:
    """The option or variable for the dialect decides the result.

    Source: docs/reference/language.md.
    """
    Path(motor).write_text(_TIMES, encoding="utf-8")
    run = ["run", motor, "--no-robot", "--for", "20ms", "--watch", "Main.D", "--trace", "t.jsonl"]
    assert main([*run, *options]) == 0
    last = json.loads(Path("t.jsonl").read_text(encoding="utf-8").splitlines()[-1])
    assert last["vars"] == {"Main.D": value}
    assert os.environ.get("RCX_DIALECT") is None


@pytest.mark.parametrize("command", ["run", "check", "prove", "explore", "campaign", "sweep"])
def test_an_unknown_dialect_is_bad_input(motor: str, command: str, capsys: Captured) -> None:
    """An unknown dialect ends the command with 2 and a proposal. Source: docs/reference/cli.md."""
    assert main([command, motor, "--dialect", "codsys"]) == 2
    assert "there is no dialect 'codsys'; did you mean codesys" in capsys.readouterr().err


def test_a_launch_of_the_debugger_may_name_the_dialect(motor: str) -> None:
    """The key `dialect` of a launch sets the dialect of the program.

    Source: docs/how-to/debug.md.
    """
    Path(motor).write_text(_TIMES, encoding="utf-8")
    machine = launched(
        {"program": motor, "noRobot": True, "dialect": "tia", "for": "1s"}, []
    ).machine
    assert machine.program.project.dialect == "tia"


@pytest.mark.parametrize(
    ("statement", "property_"),
    [("List[Place] := 1;", "index"), ("Place := 1 / Place;", "division")],
)
def test_a_proof_without_assertions_lists_the_operations(
    statement: str, property_: str, tmp_path: Path, capsys: Captured
) -> None:
    """A program without an assertion and without a robot has properties, too.

    Place is 0 in the first scan. So the index is outside of 1..5, and 1 is divided by 0.

    Source: docs/how-to/prove.md, What is proved.
    """
    declared = "VAR Place : INT; List : ARRAY [1..5] OF INT; END_VAR"
    file = tmp_path / "Main.st"
    file.write_text(f"PROGRAM Main\n{declared}\n{statement}\nEND_PROGRAM\n")
    assert main(["prove", str(file), "--no-robot", "--out", str(tmp_path / "out")]) == 1
    assert f"refuted: {property_} Main.st:3" in capsys.readouterr().out


def test_operations_of_several_task_intervals_are_searched(
    tmp_path: Path, capsys: Captured
) -> None:
    """With several intervals nothing is proved, but a run that breaks an operation is found.

    Place is 0 in the first scan, which is outside of 1..5.

    Source: docs/how-to/prove.md, Assumptions.
    """
    file = tmp_path / "Main.st"
    file.write_text(
        "PROGRAM Fast\nVAR Place : INT; List : ARRAY [1..5] OF INT; END_VAR\n"
        "List[Place] := 1;\nEND_PROGRAM\n"
        "PROGRAM Slow\nVAR Count : INT; END_VAR\nCount := 1;\nEND_PROGRAM\n"
        "CONFIGURATION Both\nRESOURCE Plc ON PLC\n"
        "TASK Short (INTERVAL := T#10ms, PRIORITY := 1);\n"
        "TASK Long (INTERVAL := T#20ms, PRIORITY := 2);\n"
        "PROGRAM P1 WITH Short : Fast;\nPROGRAM P2 WITH Long : Slow;\n"
        "END_RESOURCE\nEND_CONFIGURATION\n"
    )
    assert main(["prove", str(file), "--no-robot", "--out", str(tmp_path / "out")]) == 1
    assert "refuted: index Main.st:3: after 1 scans of 10 ms" in capsys.readouterr().out


def test_operations_that_cannot_be_examined_are_unknown(tmp_path: Path, capsys: Captured) -> None:
    """A proof does not support SIN of a variable, so it does not say that all is proved.

    Source: docs/how-to/prove.md, Proved, refuted, unknown.
    """
    file = tmp_path / "Main.st"
    file.write_text("PROGRAM Main\nVAR R : REAL; END_VAR\nR := SIN(R);\nEND_PROGRAM\n")
    assert main(["prove", str(file), "--no-robot", "--limit", "1s"]) == 1
    said = capsys.readouterr().out
    assert "unknown: operations: not decided: the standard function SIN is not supported" in said
