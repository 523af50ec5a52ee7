"""`rcx run` reports a robot program that stops with an error."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from plc_bench import ROOT
from rcx_harness.cli.app import main

FOLDER = ROOT / "tests/data/robot_programs"


def test_an_error_of_a_robot_program_is_shown_with_its_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A missing point stops the robot program with alarm 6.204, and the exit code is 1."""
    (tmp_path / "BAD.PGM").write_text("WAIT SI(20)=1\nMOVE P,P77\n")
    (tmp_path / "robot.toml").write_text('[[programs]]\nfile = "BAD.PGM"\n')
    files = [str(FOLDER / "Supervisor.st"), f"--robot={tmp_path / 'robot.toml'}"]
    stimulus = f"--stimulus={FOLDER / 'stimulus.toml'}"
    assert main(["run", *files, stimulus, "--engine=builtin", "--for=2s"]) == 1
    shown = capsys.readouterr().out
    assert re.search(r"robot program BAD stopped at \d+ ms in line 2: alarm 6\.204 \(Point", shown)
    assert "no violations, 1 stopped robot program" in shown


def test_a_wrong_robot_program_is_refused_before_the_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "BAD.PGM").write_text("WAIT SI(20)=1\nGOTO *NOWHERE\n")
    (tmp_path / "robot.toml").write_text('[[programs]]\nfile = "BAD.PGM"\n')
    robot = f"--robot={tmp_path / 'robot.toml'}"
    assert main(["run", str(FOLDER / "Supervisor.st"), robot, "--engine=builtin"]) == 2
    assert f"{tmp_path / 'BAD.PGM'}:2: there is no label *NOWHERE" in capsys.readouterr().err


def test_a_loop_without_a_wait_is_reported_and_the_run_continues(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A loop without a wait is reported with its line, and the run continues to its end.

    The program starts at 1.8 s, so 140 cycles remain.
    """
    (tmp_path / "BUSY.PGM").write_text("*L:\nIF SI(27)=1 THEN *E\nSGI0=SGI0+1\nGOTO *L\n*E: HALT\n")
    (tmp_path / "robot.toml").write_text('[[programs]]\nfile = "BUSY.PGM"\n')
    files = [str(FOLDER / "Supervisor.st"), f"--robot={tmp_path / 'robot.toml'}"]
    stimulus = f"--stimulus={FOLDER / 'stimulus.toml'}"
    assert main(["run", *files, stimulus, "--engine=builtin", "--for=2500ms"]) == 0
    shown = capsys.readouterr().out
    assert re.search(
        r"robot program BUSY: the loop at line [234] takes no time: 1[34]\d cycles ended at the "
        r"limit of 100 statements; add a WAIT or a DELAY",
        shown,
    )
    assert "500 controller cycles" in shown


def test_an_alarm_from_a_stimulus_is_not_an_error_of_the_program(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """If a stimulus raises an alarm that stops the robot program, the exit code is 0."""
    (tmp_path / "GO.PGM").write_text("MOVE P,100.0 0 0 0 0 0,S=5\n")
    (tmp_path / "robot.toml").write_text('[[programs]]\nfile = "GO.PGM"\n')
    text = (FOLDER / "stimulus.toml").read_text()
    alarm = '\n[[at]]\ntime = "2200ms"\nrobot = [{ event = "alarm", group = 12, category = 600 }]\n'
    (tmp_path / "stimulus.toml").write_text(text + alarm)
    files = [str(FOLDER / "Supervisor.st"), f"--robot={tmp_path / 'robot.toml'}"]
    stimulus = f"--stimulus={tmp_path / 'stimulus.toml'}"
    assert main(["run", *files, stimulus, "--engine=builtin", "--for=2500ms"]) == 0
    assert "stopped robot program" not in capsys.readouterr().out
