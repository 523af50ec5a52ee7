"""`rcx points` saves, compares and restores the point data of a controller."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from probed_robot import StationLine
from rcx_harness.cli import points as cli
from rcx_harness.cli.app import main
from rcx_harness.look.judge.judge import JudgeOptions, judge
from rcx_harness.robot import Axis, RobotConfig
from rcx_harness.robot.stored import Hand, Pallet, Point
from serve_process import ServeProcess, own_addresses

Captured = pytest.CaptureFixture[str]
Robot = Callable[..., StationLine]


@pytest.fixture
def robot(monkeypatch: pytest.MonkeyPatch) -> Robot:
    """Return a function that replaces the network by a virtual controller."""

    def made(config: RobotConfig | None = None) -> StationLine:
        line = StationLine(config or RobotConfig())
        monkeypatch.setattr(cli, "NetworkLine", lambda *_: line)
        return line

    return made


def _backup(file: Path, *more: str) -> list[str]:
    return ["points", "backup", "h", str(file), "--kind", "points", "--numbers", "0-60", *more]


def test_a_backup_compares_equal(robot: Robot, tmp_path: Path, capsys: Captured) -> None:
    line = robot()
    file, table = tmp_path / "new" / "points.toml", tmp_path / "points.csv"
    assert main(_backup(file, "--csv", str(table))) == 0
    out = capsys.readouterr().out
    assert out.startswith("SAFETY. This program becomes the master of a real robot")
    assert "points: 2 of 61 are defined\n" in out
    assert out.endswith(f"written: {file}, {table}\n")
    head, _, tables = file.read_text(encoding="utf-8").partition("\n\n")
    assert head == "# rcx points backup h\n# a virtual controller"
    assert tables == (
        "[points.19]\npulses = [120000, -45000, 30000, 0, 0, 0]\n\n"
        "[points.50]\nmm = [10.000, -20.000, 5.000, -18.000, 0.000, 0.000]\n"
    )
    assert table.read_text(encoding="utf-8").count("\n") == 3
    assert line.closed
    robot()
    assert main(["points", "compare", "h", str(file)]) == 0
    assert capsys.readouterr().out.endswith("0 of 2 differ\n")


def test_a_backup_as_all_file_compares_equal(
    robot: Robot, tmp_path: Path, capsys: Captured
) -> None:
    """A backup as .ALL file has no differences. Its sections without point data are reported.

    Point 19 is in pulses, and point 50 is in mm.
    """
    config = RobotConfig(
        comments={3: '"A" '},
        shifts={2: (1000, -2500, 0, 90_000)},
        hands={(1, 4): Hand((0, 150_000, 15_000, 1)), (1, 5): Hand((7, 2_000, 0, 0))},
        pallets={1: Pallet(2, 3, 1, 50)},
        undefined_data_alarm="6.204",
    )
    robot(config)
    file = tmp_path / "points.ALL"
    assert main(["points", "backup", "h", str(file), "--numbers", "0-60"]) == 0
    text = file.read_text(encoding="utf-8")
    assert text == (
        "[PNT]\nP19=120000 -45000 30000 0 0 0\n"
        "P50=10.000 -20.000 5.000 -18.000 0.000 0.000\n\n"
        '[PCM]\nPC3=""A""\n\n[SFT]\nS0=0.000 0.000 0.000 0.000\nS2=1.000 -2.500 0.000 90.000\n\n'
        "[HND]\nH0=0 0.000 0.000\nH4=0.000 150.000 15.000 R\nH5=7 2.000 0.000\n\n"
        "[PLT]\nPL1\nNX=2\nNY=3\nNZ=1\nPLP=50\n\n"
    )
    file.write_text(f"{text}[PGM]\nNAME=A\nHALT\n[XYZ]\n", encoding="utf-8")
    robot(config)
    assert main(["points", "compare", "h", str(file)]) == 0
    shown = capsys.readouterr()
    assert shown.out.endswith("0 of 9 differ\n")
    assert "skipped: line 27: section [XYZ]\nskipped: 1 program\n" in shown.err
    robot()
    assert main(["points", "restore", "h", str(file), "--write"]) == 0
    assert capsys.readouterr().out.endswith("0 of 9 differ\n")


def test_hands_of_other_robots_are_left_out_of_an_all_file(
    robot: Robot, tmp_path: Path, capsys: Captured
) -> None:
    robot(RobotConfig(axes=(Axis(), Axis(robot=2)), hands={(2, 1): Hand((1, 0, 0, 0))}))
    file = tmp_path / "points.all"
    backup = ["points", "backup", "h", str(file), "--kind", "hands", "--robot", "2"]
    assert main(backup) == 1
    assert (
        "left out: hands of robot 2: a .ALL file has only those of robot 1"
        in capsys.readouterr().err
    )


def test_an_existing_file_is_never_overwritten(
    robot: Robot, tmp_path: Path, capsys: Captured, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cli, "NetworkLine", lambda *_: pytest.fail("the command has connected"))
    file = tmp_path / "points.toml"
    file.write_text("mine", encoding="utf-8")
    assert main(_backup(file)) == 2
    assert main(_backup(tmp_path / "other.toml", "--csv", str(file))) == 2
    assert capsys.readouterr().err.count("already exists; name another one\n") == 2
    assert main(_backup(tmp_path / "a", "--csv", str(tmp_path / "a"))) == 2
    assert "both files are the same" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["points.toml"]
    assert file.read_text(encoding="utf-8") == "mine"


def test_an_unwritable_file_is_found_before_reading(
    tmp_path: Path, capsys: Captured, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cli, "NetworkLine", lambda *_: pytest.fail("the command has connected"))
    (tmp_path / "file").write_text("", encoding="utf-8")
    assert main(_backup(tmp_path / "file" / "a.toml")) == 2
    assert main(_backup(tmp_path / "a.toml", "--csv", "/proc/no/a.csv")) == 2
    assert capsys.readouterr().err.count("cannot be written: ") == 2
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_compare_shows_the_differences(robot: Robot, tmp_path: Path, capsys: Captured) -> None:
    robot()
    file = tmp_path / "points.toml"
    assert main(_backup(file)) == 0
    robot(RobotConfig(points={50: Point((1, 0, 0, 0, 0, 0)), 51: Point()}))
    capsys.readouterr()
    assert main(["points", "compare", "h", str(file)]) == 1
    assert capsys.readouterr().out.partition("works.\n")[2] == (
        "point 19\n  file        pulses = [120000, -45000, 30000, 0, 0, 0]\n"
        "  controller  not defined\n"
        "point 50\n  file        mm = [10.000, -20.000, 5.000, -18.000, 0.000, 0.000]\n"
        "  controller  pulses = [1, 0, 0, 0, 0, 0]\n"
        "2 of 2 differ\n"
    )
    robot(RobotConfig(points={50: Point((1, 0, 0, 0, 0, 0)), 51: Point()}))
    options = ["--numbers", "51-52", "--kind", "points"]
    assert main(["points", "compare", "h", str(file), *options]) == 1
    assert "point 51\n  file        not defined\n" in (out := capsys.readouterr().out)
    assert out.endswith("3 of 4 differ\n")


def test_restore_writes_the_differences_only_with_the_option(
    robot: Robot, tmp_path: Path, capsys: Captured, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot()
    file = tmp_path / "points.toml"
    assert main(_backup(file)) == 0
    monkeypatch.setattr(cli, "NetworkLine", lambda *_: pytest.fail("the command has connected"))
    assert main(["points", "restore", "h", str(file)]) == 2
    assert "then add --write" in capsys.readouterr().err
    line = robot(RobotConfig(points={50: RobotConfig().points[50], 51: Point()}))
    assert main(["points", "restore", "h", str(file), "--write"]) == 0
    assert capsys.readouterr().out.endswith("1 written\n0 of 2 differ\n")
    points = line.controller.machine.memory.points
    assert points == {51: Point(), **{n: RobotConfig().points[n] for n in (19, 50)}}
    assert line.closed


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("arm1 = 1.0", ":5: 'points.11.arm1' cannot be 1.0; use arm rotation -1, 0 or 1"),
        ("hand = 2.0", ":5: 'points.11.hand' cannot be 2.0; use hand 0, 1 or 2"),
        (
            "[points.010]\nmm = [2]",
            ":5: 'points.010' gives points.10 a second time; remove one of them",
        ),
        ("[shifts]\n1 = [1e308]", ":6: 'shifts.1' cannot be 1e+308; use 32 bit numbers"),
    ],
)
def test_a_file_is_checked_before_the_first_command(
    tmp_path: Path, capsys: Captured, monkeypatch: pytest.MonkeyPatch, text: str, message: str
) -> None:
    monkeypatch.setattr(cli, "NetworkLine", lambda *_: pytest.fail("the command has connected"))
    file = tmp_path / "points.toml"
    points = "[points.10]\nmm = [1.0]\n[points.11]\nmm = [1.0]\n"
    file.write_text(f"{points}{text}\n", encoding="utf-8")
    assert main(["points", "restore", "h", str(file), "--write"]) == 2
    assert capsys.readouterr().err == f"rcx: {file}{message}\n"


def test_a_comment_that_is_empty_in_the_file_is_cleared(robot: Robot, tmp_path: Path) -> None:
    file = tmp_path / "c.toml"
    file.write_text("[comments]\n1 = ''\n2 = 'B'\n", encoding="utf-8")
    line = robot(RobotConfig(comments={1: "A"}))
    assert main(["points", "restore", "h", str(file), "--write"]) == 0
    assert line.controller.machine.memory.comments == {1: "", 2: "B"}


@pytest.mark.parametrize("text", ["A\x07", "A\0B", "A\t", "\x7f"])
def test_a_comment_that_cannot_be_written_back_is_left_out(
    robot: Robot, tmp_path: Path, capsys: Captured, text: str
) -> None:
    """A comment with characters that no command can send is left out and reported.

    Source: guide 4.3.2.
    """
    file, options = tmp_path / "c.toml", ["--kind", "comments", "--numbers", "0-2"]
    robot(RobotConfig(comments={0: "ONE"})).controller.machine.memory.comments[2] = text
    assert main(["points", "backup", "h", str(file), *options]) == 1
    out, err = capsys.readouterr()
    left = "left out: comments of 2: characters other than 16#20 to 16#7E"
    assert err == f"rcx: {left}\n"
    assert "comments: 2 of 3 are defined\n" in out
    written = file.read_text(encoding="utf-8")
    assert f"# {left}\n" in written
    assert written.endswith('[comments]\n0 = "ONE"\n')
    line = robot(RobotConfig())
    line.controller.machine.memory.comments[2] = text
    assert main(["points", "restore", "h", str(file), "--write"]) == 0
    assert line.controller.machine.memory.comments == {0: "ONE", 2: text}


def test_a_refused_command_writes_no_file(robot: Robot, tmp_path: Path, capsys: Captured) -> None:
    line = robot(RobotConfig(undefined_point_alarm="4.209"))
    assert main(_backup(tmp_path / "a.toml")) == 1
    assert capsys.readouterr().err == "rcx: reading point 0 ended in the alarm 4.209\n"
    assert list(tmp_path.iterdir()) == []
    assert line.closed
    robot(RobotConfig(undefined_point_alarm="4.209"))
    assert main(_backup(tmp_path / "a.toml", "--undefined", "4.209")) == 0


def test_a_lost_connection_exits_with_1(robot: Robot, tmp_path: Path, capsys: Captured) -> None:
    line = robot()
    line.lost_after_us = 2_000_000
    assert main(_backup(tmp_path / "a.toml")) == 1
    lost = "rcx: the connection is lost: no packets arrive any more; no file was written\n"
    assert capsys.readouterr().err == lost
    line = robot()

    def interrupted() -> bytes:
        if line.now_us > 2_000_000:
            raise KeyboardInterrupt
        return StationLine.read(line)

    line.read = interrupted  # type: ignore[method-assign]
    assert main(_backup(tmp_path / "a.toml")) == 130
    assert capsys.readouterr().err == "rcx: stopped by Ctrl-C; no file was written\n"
    assert line.closed
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("action", "remaining"),
    [
        (["compare"], "nothing was compared"),
        (["restore", "--write"], "what was being written may be stored; run it again to go on"),
    ],
)
def test_a_stopped_command_reports_the_remaining_work(
    robot: Robot, tmp_path: Path, capsys: Captured, action: list[str], remaining: str
) -> None:
    file = tmp_path / "a.toml"
    file.write_text("[points.1]\npulses = [1]\n", encoding="utf-8")
    robot().lost_after_us = 400_000
    assert main(["points", action[0], "h", str(file), *action[1:]]) == 1
    assert capsys.readouterr().err.endswith(f"no packets arrive any more; {remaining}\n")


def test_a_connection_that_cannot_be_opened_exits_with_2(
    robot: Robot, tmp_path: Path, capsys: Captured
) -> None:
    """If the connection cannot be opened, the exit code is 2, as for bad input."""
    line = robot()
    line.happen("", "power_off")
    assert main(_backup(tmp_path / "a.toml")) == 2
    error = "rcx: no connection to h: it does not answer; look at the cable\n"
    assert capsys.readouterr().err == error
    assert line.closed
    assert list(tmp_path.iterdir()) == []


def test_the_longest_wait_is_an_option(robot: Robot, tmp_path: Path, capsys: Captured) -> None:
    """`--timeout` sets the longest wait for a command. Source: guide 1.1, note."""
    robot(RobotConfig(command_delay=3_500.0))
    options = ["--numbers", "0-1", "--timeout", "3s"]
    assert main([*_backup(tmp_path / "a.toml"), *options]) == 1
    error = "rcx: reading point 0: no end within 3 s, the status was 16#0100\n"
    assert capsys.readouterr().err == error
    robot(RobotConfig(command_delay=3_500.0))
    assert main([*_backup(tmp_path / "a.toml"), *options[:2]]) == 0


def test_hands_of_other_robots_are_backed_up_on_request(robot: Robot, tmp_path: Path) -> None:
    robot()
    file = tmp_path / "h.toml"
    options = ["--kind", "hands", "--robot", "1"]
    assert main(["points", "backup", "h", str(file), *options]) == 0
    text = file.read_text(encoding="utf-8")
    assert "[hands.1]\n0 = [0, 0, 0, 0]\n" in text
    assert text.count("= [0, 0, 0, 0]") == 32


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["backup", "--kind", "axes"], "--kind 'axes' is not a kind of data; use points, comments"),
        (["backup", "--numbers", "9-3"], "--numbers '9-3' is not a range of points; write 0-99"),
        (["backup", "--numbers", "0-30000"], "the last number is 29999"),
        (["backup", "--numbers", "a"], "--numbers 'a' is not a range"),
        (["backup", "--robot", "5"], "--robot 5 is not a robot; use 1 to 4"),
        (["backup", "--undefined", "alarm"], "--undefined 'alarm' is not an alarm; write 6.204"),
        (["backup", "--timeout", "soon"], "--timeout: 'soon' is not a duration; write it as 10ms"),
        (["backup", "--timeout", "99ms"], "--timeout 99ms is too short; use 100ms to 365d"),
        (["backup", "--size", "50"], "an area of 50 bytes does not exist"),
        (["backup", "--write"], "--write is for restore only"),
        (["compare", "--write"], "--write is for restore only"),
        (["compare", "--csv", "a.csv"], "--csv is for backup only"),
        (["compare", "--robot", "1"], "--robot is for backup only"),
        (["restore", "--write", "--numbers", "1"], "--numbers is for backup and compare only"),
        (["compare"], "points.toml"),
        (["compare", "--kind", "hands"], "points.toml"),
    ],
)
def test_bad_input_is_reported_in_one_line(
    arguments: list[str],
    message: str,
    capsys: Captured,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(cli, "NetworkLine", lambda *_: pytest.fail("the command has connected"))
    action, *options = arguments
    file = tmp_path / "points.toml"
    if "hands" in options:
        file.write_text("[comments]\n1 = 'A'\n", encoding="utf-8")
    assert main(["points", action, "h", str(file), *options]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1


@pytest.mark.exhaustive
def test_a_backup_is_restored_over_the_network(tmp_path: Path, capsys: Captured) -> None:
    """A backup of one controller is restored to another one over EtherNet/IP.

    The trace shows that the data of each command reach the controller before the code.

    Source: manual chapter 3, 2: commands travel in the cyclic areas; guide 2, steps 1 and 2.
    """
    seen = tmp_path / "seen.jsonl"
    old, new = own_addresses(2)
    empty = tmp_path / "robot.toml"
    empty.write_text("[points.7]\nmm = [1.0]\n", encoding="utf-8")
    file = tmp_path / "points.toml"
    options = ["--rpi", "4ms", "--kind", "points"]
    with ServeProcess("--address", old) as served:
        served.wait_for("Ctrl-C ends it")
        backup = ["points", "backup", old, str(file), "--numbers", "48-51", *options]
        assert main(backup) == 0
        served.interrupt()
        served.end()
    with ServeProcess("--address", new, "--robot", str(empty), "--trace", str(seen)) as served:
        served.wait_for("Ctrl-C ends it")
        assert main(["points", "compare", new, str(file), *options]) == 1
        assert main(["points", "restore", new, str(file), "--write", *options]) == 0
        served.interrupt()
        served.end()
    assert capsys.readouterr().out.endswith("1 written\n0 of 1 differ\n")
    judged = judge(JudgeOptions(seen), lambda text: None)
    assert [one.commands for one in judged.followers.values()] == [4]
    assert [one.together for one in judged.followers.values()] == [0]


def test_a_missing_controller_is_reported_in_one_line(tmp_path: Path, capsys: Captured) -> None:
    assert main(["points", "backup", "127.0.0.1", str(tmp_path / "a"), "--port", "1"]) == 2
    assert capsys.readouterr().err.count("\n") == 1
