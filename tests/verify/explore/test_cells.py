"""A cell with its controller can be explored, with events such as a lost link.

The exploration distinguishes all states that behave differently.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from planted import HANDSHAKES
from rcx_harness.cell import Cell
from rcx_harness.cell.stimulus import Stimulus
from rcx_harness.cli.app import main
from rcx_harness.verify.explore.cell_states import CellStates
from rcx_harness.verify.explore.cells import CellSettings, explore_cell, replay_cell
from rcx_harness.verify.properties import Judge
from rcx_harness.verify.storm.cells import CellsOf
from structured_text.errors import InputError

Captured = pytest.CaptureFixture[str]
_CELL = HANDSHAKES / "cell"
#: Time after which the time limits of PowerUp (10 s) have ended, so its timers no longer change.
_BEGIN_US = 13_000_000


def _cells(properties: Path | None = None) -> CellsOf:
    options = {"robot": [_CELL / "robot.toml"], "engine": "builtin", "scan": "100ms"}
    demands = [properties or _CELL / "campaign.toml"]
    return CellsOf.of([_CELL / "Handover.st"], options, demands, _CELL / "stimulus.toml")


def _settings(**given: object) -> CellSettings:
    return CellSettings(_cells(), begin_us=_BEGIN_US, **given)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def cell() -> Cell:
    """Return a cell in which the robot brings parts in a loop."""
    made = _cells().make().cell(0, keep=0)
    Stimulus.load(_CELL / "stimulus.toml").schedule(made)
    return made


@pytest.fixture(scope="module")
def states(cell: Cell) -> CellStates:
    """Return the states of the cell after 13 s."""
    made = CellStates(cell, Judge(cell, (), lambda kind, text: None))
    cell.run("13s")
    return made


def test_a_restored_state_equals_the_stored_state(cell: Cell, states: CellStates) -> None:
    """A restored state equals the stored state, also in the middle of a movement."""
    while not cell.robot.machine.motion.under_way:
        cell.run("5ms")
    before, key = states.freeze(), states.key()
    cell.run("1s")
    after = states.key(), cell.robot.positions[:2]
    states.thaw(before)
    assert states.key() == key
    assert cell.robot.machine.motion.under_way
    cell.run("1s")
    assert (states.key(), cell.robot.positions[:2]) == after


def test_a_cycle_of_the_handshake_recurs(cell: Cell, states: CellStates) -> None:
    """The states of a handshake recur after two parts, which take a whole number of scans.

    Then the PLC names the first place again.
    """
    seen = {}
    for number in range(40):
        key = states.key()
        if key in seen:
            break
        seen[key] = number
        cell.scan()
    assert number < 39


@pytest.mark.parametrize("change", ["position", "point", "variable", "output", "alarm"])
def test_what_a_robot_program_can_notice_is_part_of_the_key(
    cell: Cell, states: CellStates, change: str
) -> None:
    before, key = states.freeze(), states.key()
    machine = cell.robot.machine
    if change == "position":
        machine.positions[0] += 1
    elif change == "point":
        machine.points[7] = machine.points[1]
    elif change == "variable":
        machine.program.tasks[0].variables["N%"] = 77
    elif change == "output":
        machine.ports.banks["MO"][2] ^= 1
    else:
        machine.alarms.warning = not machine.alarms.warning
    assert states.key() != key
    states.thaw(before)
    assert states.key() == key


def test_link_and_alarm_come_at_any_time_and_the_replay_shows_what_breaks(
    tmp_path: Path,
) -> None:
    """Events of link and alarm are tried in every scan, and the replay shows the failure.

    Without the link the program does not run, so a single event is the shortest run.
    """
    properties = tmp_path / "properties.toml"
    properties.write_text(
        '[[always]]\nname = "runs"\nthat = "Main.Running OR NOT BEFORE(Main.Running)"\n',
        encoding="utf-8",
    )
    settings = CellSettings(_cells(properties), {}, frozenset({"link", "alarm"}), _BEGIN_US)
    found = explore_cell(settings)
    assert found.result.broken is not None
    path = [one.tell() for one in found.result.broken.path]
    assert path[0] in ("link lost", "SO(03) ON: alarm")
    assert set(path[1:]) <= {"nothing"}
    stimulus, shown = replay_cell(settings, found, tmp_path)
    assert shown
    assert stimulus.read_text(encoding="utf-8").count('time = "13000ms"') == 1


def test_a_state_key_that_omits_too_much_is_detected(monkeypatch: pytest.MonkeyPatch) -> None:
    """If the key of a state omits too much, the exploration detects this and gives no result.

    Here the key contains only bits of the PLC, so different states have the same key.
    """
    cells: list[Cell] = []
    init = CellStates.__init__

    def noted(self: CellStates, cell: Cell, judge: Judge) -> None:
        cells.append(cell)
        init(self, cell, judge)

    def key(self: CellStates) -> bytes:
        return cells[-1].exchanged()[0][1][32:36]

    monkeypatch.setattr(CellStates, "__init__", noted)
    monkeypatch.setattr(CellStates, "key", key)
    monkeypatch.setattr(CellStates, "freeze_with_key", lambda self: (self.freeze(), key(self)))
    with pytest.raises(InputError, match="cannot be distinguished"):
        explore_cell(_settings(inputs={"Main.Cancel": []}))


def test_a_run_that_goes_on_when_the_exploration_begins_is_refused() -> None:
    settings = CellSettings(_cells(), begin_us=300_000)
    with pytest.raises(InputError, match="the run has an entry at 500 ms"):
        explore_cell(settings)


def test_a_robot_program_that_reads_the_time_is_refused(tmp_path: Path, capsys: Captured) -> None:
    """A robot program that reads the time is refused.

    TCOUNTER is the milliseconds since power-on.
    """
    (tmp_path / "CLOCK.PGM").write_text("SO(20)=0\nN=TCOUNTER\n", encoding="utf-8")
    robot = tmp_path / "robot.toml"
    robot.write_text('[[programs]]\nfile = "CLOCK.PGM"\n', encoding="utf-8")
    words = [str(_CELL / "Handover.st"), "--robot", str(robot), "--out", str(tmp_path)]
    assert main(["explore", *words]) == 2
    assert "robot program CLOCK reads the time in line 2" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--always", "Cancel"], "--always cannot be combined with --robot"),
        (["--no-robot"], "leave out --robot, or leave out --no-robot"),
        (["--faults", "fire"], "--faults fire"),
        (["--input", "Main.Nobody"], "no member Nobody"),
    ],
)
def test_what_does_not_go_with_a_robot_file_is_one_message(
    words: list[str], said: str, tmp_path: Path, capsys: Captured
) -> None:
    files = [str(_CELL / "Handover.st"), "--robot", str(_CELL / "robot.toml")]
    assert main(["explore", *files, "--out", str(tmp_path), *words]) == 2
    assert said in capsys.readouterr().err


def test_a_beginning_without_a_robot_file_is_refused(tmp_path: Path, capsys: Captured) -> None:
    words = [str(_CELL / "Handover.st"), "--out", str(tmp_path), "--begin", "1s"]
    assert main(["explore", *words]) == 2
    assert "--begin needs --robot" in capsys.readouterr().err


def test_a_deadlock_needs_the_program_of_a_robot(tmp_path: Path, capsys: Captured) -> None:
    """A deadlock property is refused without a robot program, as with the small controller."""
    properties = ["--properties", str(_CELL / "campaign.toml")]
    words = [str(_CELL / "Handover.st"), "--out", str(tmp_path), *properties]
    assert main(["explore", *words]) == 2
    assert "a deadlock needs the program of a robot" in capsys.readouterr().err


def test_the_small_controller_of_an_exploration_knows_the_ports_of_a_property(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Captured
) -> None:
    """The small controller of an exploration has the ports that a property names.

    With Button the PLC sets SI(20), and SIW(2) in the next scan.
    """
    monkeypatch.chdir(tmp_path)
    Path("Late.st").write_text(
        """PROGRAM Late
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Button, Before : BOOL;
  END_VAR
  OutputArea[34] := SEL(Button, BYTE#0, BYTE#1);
  OutputArea[4] := SEL(Before, BYTE#0, BYTE#7);
  Before := Button;
END_PROGRAM
""",
        encoding="utf-8",
    )
    Path("stable.toml").write_text(
        '[[stable]]\nname = "late"\nstrobe = "SI(20)"\ndata = "SIW(2)"\n', encoding="utf-8"
    )
    words = ["Late.st", "--input", "Main.Button", "--properties", "stable.toml"]
    assert main(["explore", *words, "--faults", "none"]) == 1
    said = capsys.readouterr().out
    assert (
        "property: stable late: SIW(2) from 0 to 7: changed 1 scan after SI(20) became ON" in said
    )
    assert "scan 2: Main.Button := true\n  scan 3: nothing\n" in said


def test_proving_takes_no_robot_file(capsys: Captured) -> None:
    """`rcx prove` refuses a robot file, because a proof holds for every answer of the robot."""
    words = [str(_CELL / "Handover.st"), "--robot", str(_CELL / "robot.toml")]
    assert main(["prove", *words]) == 2
    assert "it holds for every answer of the robot" in capsys.readouterr().err
