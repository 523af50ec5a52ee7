"""`rcx probe` asks for confirmation of each step, writes a report, and works with `rcx serve`."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from probed_robot import StationLine
from rcx_harness.cli import probe as cli
from rcx_harness.cli.app import main
from rcx_harness.look.probe.catalogue import questions
from rcx_harness.robot import RobotConfig
from serve_process import ServeProcess, own_addresses
from structured_text.output.toml_files import load_toml

Captured = pytest.CaptureFixture[str]


class _Terminal:
    def __init__(self, somebody: bool) -> None:
        self._somebody = somebody

    def isatty(self) -> bool:
        return self._somebody


@pytest.fixture
def line(monkeypatch: pytest.MonkeyPatch) -> StationLine:
    """Replace the network by a virtual controller, and return the line to it."""
    made = StationLine(RobotConfig())
    monkeypatch.setattr(cli, "NetworkLine", lambda *_: made)
    return made


@pytest.fixture
def types(monkeypatch: pytest.MonkeyPatch) -> Callable[..., list[str]]:
    """Return a function that simulates a user who types the given words, then only Enter."""

    def typing(*words: str) -> list[str]:
        left, asked = list(words), []

        def typed(text: str = "") -> str:
            asked.append(text)
            word = left.pop(0) if left else ""
            if word == "^C":
                raise KeyboardInterrupt
            return word

        monkeypatch.setattr("builtins.input", typed)
        monkeypatch.setattr(sys, "stdin", _Terminal(somebody=True))
        return asked

    return typing


def test_the_list_has_every_question_and_sends_nothing(capsys: Captured) -> None:
    assert main(["probe", "--list"]) == 0
    out = capsys.readouterr().out
    assert all(f"   {one.id:<22} {one.title}" in out for one in questions())
    assert "free-axes              The test would set an axis free, and the axis may fall." in out


def test_only_confirmed_steps_are_performed(
    line: StationLine, types: Callable[..., list[str]], tmp_path: Path, capsys: Captured
) -> None:
    asked = types("yes", "y", "n")
    out = tmp_path / "mine"
    only = ["--only", "versions", "--only", "settings"]
    given = ["--by", "A. B.", "--robot", "RCX340", "--date", "2030-12-31", "--out", str(out)]
    assert main(["probe", "192.168.0.10", *only, *given]) == 0
    assert len(asked) == 3
    shown = capsys.readouterr().out
    assert shown.startswith("SAFETY. This program becomes the master of a real robot.")
    table = load_toml(tmp_path / "mine.toml")
    rules = {one["id"]: one for one in table["rule"]}
    assert rules["versions"]["verdict"] == "confirmed"
    assert rules["first-settings"]["reason"] == "not confirmed"
    assert (tmp_path / "mine.md").read_text(encoding="utf-8").startswith("# Probe of RCX340")
    assert (tmp_path / "mine.jsonl").is_file()
    assert line.closed
    assert main(["probe", "192.168.0.10", *only, *given]) == 2
    assert "already exists; name another file with --out" in capsys.readouterr().err


def test_each_step_with_motion_needs_the_word_move(
    line: StationLine, types: Callable[..., list[str]], tmp_path: Path
) -> None:
    types("yes", "y")
    options = ["--risk", "3", "--only", "servo-on", "--out", str(tmp_path / "a")]
    assert main(["probe", "192.168.0.10", *options]) == 0
    assert load_toml(tmp_path / "a.toml")["rule"]
    assert line.controller.machine.data.accumulated.motor_power_on_count == 0
    types("yes", "move")
    line.__init__(RobotConfig())  # type: ignore[misc]
    options[-1] = str(tmp_path / "b")
    assert main(["probe", "192.168.0.10", *options]) == 0
    assert line.controller.machine.data.accumulated.motor_power_on_count == 1


def test_without_a_confirmation_nothing_is_done(
    line: StationLine, types: Callable[..., list[str]], tmp_path: Path, capsys: Captured
) -> None:
    types("no")
    assert main(["probe", "192.168.0.10", "--out", str(tmp_path / "a")]) == 2
    assert capsys.readouterr().err == "rcx: nothing was done\n"
    assert list(tmp_path.iterdir()) == []
    assert not line.closed


def test_ctrl_c_ends_the_probe_with_a_report_and_130(
    line: StationLine, types: Callable[..., list[str]], tmp_path: Path, capsys: Captured
) -> None:
    types("yes", "y", "^C")
    assert main(["probe", "192.168.0.10", "--out", str(tmp_path / "a")]) == 130
    assert capsys.readouterr().err == "rcx: stopped by Ctrl-C; all inputs are OFF\n"
    assert load_toml(tmp_path / "a.toml")["ended"] == "stopped by Ctrl-C"
    assert line.closed


def test_a_refuted_rule_is_exit_code_1(
    types: Callable[..., list[str]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = StationLine(RobotConfig(host_version=0x0112))
    monkeypatch.setattr(cli, "NetworkLine", lambda *_: made)
    types("yes", "y")
    options = ["--only", "versions", "--out", str(tmp_path / "a")]
    assert main(["probe", "192.168.0.10", *options]) == 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "HOST is missing"),
        (["h", "--risk", "4"], "--risk 4 is not a risk"),
        (["h", "--risk", "2", "--yes-reading"], "--yes-reading is for --risk 1 only"),
        (["h", "--only", "nothing"], "no question is called 'nothing'"),
        (
            ["h", "--only", "interval"],
            "interval can do more than --risk 1 allows; allow it with --risk 2",
        ),
        (["h", "--date", "today"], "--date 'today' is not a date; write 2030-12-31"),
        (["h", "--size", "50"], "an area of 50 bytes does not exist"),
        (["h"], "each step must be confirmed at a terminal, and there is none; use --yes-reading"),
    ],
)
def test_bad_input_is_reported_in_one_line(
    arguments: list[str], message: str, capsys: Captured, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "stdin", _Terminal(somebody=False))
    monkeypatch.setattr(cli, "NetworkLine", lambda *_: pytest.fail("the command has connected"))
    assert main(["probe", *arguments]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1


@pytest.mark.exhaustive
def test_a_probe_over_the_network_reads_the_controller(tmp_path: Path, capsys: Captured) -> None:
    (address,) = own_addresses(1)
    robot = tmp_path / "robot.toml"
    robot.write_text("host_version = 0x0112\n", encoding="utf-8")
    with ServeProcess("--address", address, "--robot", str(robot)) as served:
        served.wait_for("Ctrl-C ends it")
        only = ["--only", "versions", "--only", "mp-ready", "--only", "first-image-command"]
        options = ["--yes-reading", *only, "--out", str(tmp_path / "a"), "--rpi", "20ms"]
        assert main(["probe", address, *options]) == 1
        served.interrupt()
        served.end()
    table = load_toml(tmp_path / "a.toml")
    assert table["ended"] == ""
    assert "Host 0x0112" in table["firmware"]
    assert "vendor" in table["identity"][0]
    rules = {one["id"]: one["verdict"] for one in table["rule"]}
    assert rules["versions"] == "refuted"
    assert rules["mp-ready"] == rules["first-image-command"] == "confirmed"
    assert "SAFETY" in capsys.readouterr().out


def test_a_report_that_appears_during_the_probe_is_not_written_over(
    line: StationLine, tmp_path: Path, capsys: Captured
) -> None:
    read = line.read

    def meanwhile() -> bytes:
        (tmp_path / "p.md").write_text("mine", encoding="utf-8")
        return read()

    line.read = meanwhile  # type: ignore[method-assign]
    options = ["--yes-reading", "--only", "versions", "--out", str(tmp_path / "p")]
    assert main(["probe", "h", *options]) == 2
    assert capsys.readouterr().err.endswith(f"the output is in {tmp_path}/p-1.md\n")
    assert (tmp_path / "p.md").read_text(encoding="utf-8") == "mine"
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == ["p-1.md", "p.jsonl", "p.md", "p.toml"]
