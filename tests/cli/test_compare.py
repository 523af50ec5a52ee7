"""`rcx compare` reads its files and options, and reports differences by its exit code.

The comparison itself is tested in tests/look/compare.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from captures import Story, pcap, pcapng
from rcx_harness.cli.app import main
from rcx_harness.robot import RobotConfig
from rcx_harness.trace import Cycle, Trace
from recorded_robot import RecordedMaster, short_run

Captured = pytest.CaptureFixture[str]


@pytest.fixture(scope="module")
def trace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a trace of a controller whose servo delay and version are not the defaults."""
    master = RecordedMaster(servo_on_delay=80.0, host_version=0x0112)
    short_run(master)
    path = tmp_path_factory.mktemp("recorded") / "cell.jsonl"
    written = Trace({"by": "rcx run"}, path, keep=0)
    for number, (t_us, si, so) in enumerate(master.cycles):
        written.add(Cycle(t_us, number, si or b"", so))
    written.close()
    return path


def test_both_sides_of_the_first_differences_are_shown(trace: Path, capsys: Captured) -> None:
    assert main(["compare", str(trace)]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert "controller 1 is recorded, controller 2 is virtual" in lines
    at = next(k for k, line in enumerate(lines) if "SO(02) Servo ON status output, for" in line)
    # the request comes at 400 ms; the model answers after 50 ms
    assert lines[at].strip().startswith("0.450 s")
    assert lines[at + 1].split() == ["recorded", "OFF"]
    assert lines[at + 2].split() == ["virtual", "ON"]
    assert "servo-on" in lines[at + 3]
    response = next(k for k, line in enumerate(lines) if " response, for" in line)
    assert "host_version 274" in lines[response + 1]
    assert "host_version 264" in lines[response + 2]
    assert "ReadVersion (16#0501)" in lines[response + 3]
    assert lines[-1] == "2 differences"


def test_the_robot_file_of_the_recording_fits_exactly(
    trace: Path, tmp_path: Path, capsys: Captured
) -> None:
    robot = tmp_path / "robot.toml"
    robot.write_text("servo_on_delay = 80\nhost_version = 0x0112\n", encoding="utf-8")
    assert main(["compare", str(trace), "--robot", str(robot)]) == 0
    assert "the virtual controller answers the same" in capsys.readouterr().out
    robot.write_text("servo_on_delay = [20, 100]\nhost_version = 0x0112\n", encoding="utf-8")
    assert main(["compare", str(trace), "--robot", str(robot)]) == 0


@pytest.mark.exhaustive
def test_fit_extends_the_old_robot_file(trace: Path, tmp_path: Path, capsys: Captured) -> None:
    old, new = tmp_path / "old.toml", tmp_path / "new.toml"
    text = "servo_on_delay = 20 # too short\njog_limit = 'normal'\n\n[points.7]\npulses = [1, 2]\n"
    old.write_text(text, encoding="utf-8")
    assert main(["compare", str(trace), "--robot", str(old), "--fit", str(new), "--json"]) == 0
    table = json.loads(capsys.readouterr().out)
    assert table["differences"] == table["left"] == []
    knobs = {one["key"]: one for one in table["knobs"]}
    assert knobs["servo_on_delay"]["value"] == 80.0
    assert knobs["host_version"] == {"key": "host_version", "value": 0x0112, "found": True,
                                     "why": knobs["host_version"]["why"], "others": [],
                                     "instead": []}  # fmt: skip
    assert not knobs["jog_limit"]["found"]
    found = RobotConfig.load(new)
    assert (found.servo_on_delay, found.host_version) == (80.0, 0x0112)
    assert found.jog_limit == "normal"
    assert found.points[7].data[:2] == (1, 2)
    assert "too short" not in new.read_text(encoding="utf-8")
    assert old.read_text(encoding="utf-8") == text

    assert main(["compare", str(trace), "--fit", str(new)]) == 2
    assert "already exists; name another file" in capsys.readouterr().err


def test_a_capture_is_compared_like_a_trace(tmp_path: Path, capsys: Captured) -> None:
    """A capture gives the same result as a trace. It has one packet of each side every 10 ms."""
    master = RecordedMaster(servo_on_delay=80.0, host_version=0x0112)
    short_run(master)
    story = Story()
    story.open(0)
    for t_us, si, so in master.cycles[::2]:
        story.both(10_000 + t_us, si or bytes(48), so)
    robot = tmp_path / "robot.toml"
    robot.write_text("servo_on_delay = 80\nhost_version = 0x0112\n", encoding="utf-8")
    for path in (
        pcapng(tmp_path / "cell.pcapng", story.frames()),
        pcap(tmp_path / "cell.pcap", story.frames()),
    ):
        assert main(["compare", str(path), "--robot", str(robot)]) == 0
        assert "the virtual controller answers the same" in capsys.readouterr().out
        assert main(["compare", str(path), "--quiet"]) == 1
        output = capsys.readouterr().out
        assert "host_version 274" in output
        assert "host_version 264" in output
        assert "SO(02) Servo ON status output, for" in output
    found = tmp_path / "found.toml"
    assert main(["compare", str(path), "--quiet", "--fit", str(found)]) == 0
    text = found.read_text(encoding="utf-8")
    assert "host_version = 274" in text
    assert "servo_on_delay = 8" in text  # 80 ms plus at most a packet interval
    capsys.readouterr()
    assert main(["compare", str(path), "--robot", str(found)]) == 0


def test_a_capture_of_256_bytes_is_compared_completely(tmp_path: Path, capsys: Captured) -> None:
    """The comparison reports that the last word, SOW(127), is 7 in the capture but 0 in the model.

    In the capture a robot program wrote 7. The robot file does not contain this program.
    """
    master = RecordedMaster(size=256, host_version=0x0112)
    short_run(master)
    story = Story()
    # sizes with count and header: 2 + 4 + 256 and 2 + 256 bytes
    story.open(0, o_to_t="0649", t_to_o="0249")
    for number, (t_us, si, so) in enumerate(master.cycles):
        last = (b"\x07\x00" if number > 100 else bytes(2)) if si else so[-2:]
        story.both(10_000 + t_us, si or bytes(256), so[:-2] + last)
    path = pcap(tmp_path / "cell.pcap", story.frames())
    assert main(["judge", str(path), "--json"]) == 0
    robot = json.loads(capsys.readouterr().out)["controllers"][0]
    assert "256" in json.dumps(robot)
    own = tmp_path / "robot.toml"
    own.write_text("size = 256\nhost_version = 0x0112\n", encoding="utf-8")
    assert main(["compare", str(path), "--robot", str(own), "--quiet", "--json"]) == 1
    table = json.loads(capsys.readouterr().out)
    found = [(one["channel"], one["recorded"]) for one in table["differences"]]
    assert found == [("SOW(127)", 7)]
    assert main(["compare", str(path), "--quiet"]) == 1
    output = capsys.readouterr().out
    assert ", 256 bytes, times within" in output
    assert "host_version 274" in output
    assert "SOW(127)" in output


def test_events_explain_a_persons_actions(tmp_path: Path, capsys: Captured) -> None:
    master = RecordedMaster()
    master.run(200)
    master.happen("manual_mode")
    master.run(200)
    path = tmp_path / "cell.jsonl"
    written = Trace({"by": "rcx run"}, path, keep=0)
    for number, (t_us, si, so) in enumerate(master.cycles):
        written.add(Cycle(t_us, number, si or b"", so))
    written.close()
    assert main(["compare", str(path), "--quiet"]) == 1
    assert "SO(10) AUTO mode status output" in capsys.readouterr().out
    events = tmp_path / "events.toml"
    events.write_text('[[at]]\ntime = "200ms"\nrobot = "manual_mode"\n', encoding="utf-8")
    assert main(["compare", str(path), "--events", str(events)]) == 0
    for wrong, message in (
        ('set = { "Main.Go" = true }', "has more than robot events; use time and robot"),
        ('robot = "link_down"', "'link_down' is not an event of a robot"),
    ):
        events.write_text(f'[[at]]\ntime = "200ms"\n{wrong}\n', encoding="utf-8")
        assert main(["compare", str(path), "--events", str(events)]) == 2
        assert message in capsys.readouterr().err


def test_bad_input_is_reported_in_one_line(trace: Path, tmp_path: Path, capsys: Captured) -> None:
    robot = tmp_path / "robot.toml"
    robot.write_text("size = 256\n", encoding="utf-8")
    empty = tmp_path / "empty.jsonl"
    empty.write_text('{"format":"rcx-trace/1","by":"rcx scan"}\n', encoding="utf-8")
    for arguments, message in (
        ([str(tmp_path / "none.pcap")], "cannot be read"),
        ([str(empty)], "the recording contains neither the PLC"),
        ([str(trace), "--robot", str(robot)], "the recording has areas of 48 bytes, not 256"),
        ([str(trace), "--controller", "here"], "--controller 'here' is not an IPv4 address"),
        ([str(trace), "--tolerance", "-1ms"], "--tolerance: '-1ms' is not a duration"),
        ([str(trace), "--size", "50"], "an area of 50 bytes does not exist"),
    ):
        assert main(["compare", *arguments]) == 2
        error = capsys.readouterr().err
        assert message in error
        assert error.count("\n") == 1


def test_the_chart_is_written(trace: Path, tmp_path: Path) -> None:
    chart = tmp_path / "chart.svg"
    assert main(["compare", str(trace), "--quiet", "--chart", str(chart)]) == 1
    text = chart.read_text(encoding="utf-8")
    assert "2: SO(02)" in text
    assert "recorded, and virtual (2)" in text
