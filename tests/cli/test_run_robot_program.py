"""`rcx run` with a robot program that stops with an error."""

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
    """Point 77 does not exist: alarm 6.204. The exit code is 1, as with a violation."""
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
