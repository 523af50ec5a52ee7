"""A cell can have several controllers, each with its own areas, clock, faults and robot file."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from plc_bench import ROOT
from rcx_harness.cell import Cell
from rcx_harness.cell.stimulus import Stimulus
from rcx_harness.cli.app import main
from rcx_harness.robot import RobotConfig
from rcx_harness.trace import Cycle, Scan, Trace, Violation, read_trace
from rcx_harness.trace.chart import Timeline
from rcx_harness.trace.wave import Wave
from structured_text.errors import InputError

_EXAMPLE = ROOT / "tests/data/by_hand/12_two_robots"
_TWO = (RobotConfig(), RobotConfig())


def _cell(**options: object) -> Cell:
    arguments: dict[str, object] = {"robot": _TWO, "engine": "builtin", **options}
    return Cell.build(sorted(_EXAMPLE.glob("*.st")), **arguments)  # type: ignore[arg-type]


def test_each_controller_has_its_own_connection_and_its_own_status() -> None:
    with _cell() as cell:
        cell.run("100ms")
        assert len(cell.robots) == 2
        assert cell.robots[0] is cell.robot
        cell.inject("link_down", controller=2)
        cell.run("300ms")
        assert (cell["Main.Connected"], cell["Main.Connected2"]) == (True, False)
        assert not cell.connected, "only some of the controllers"
        assert [one.machine.link for one in cell.robots] == ["normal", "lost"]


def test_the_areas_begin_at_m_and_n_or_follow_one_another() -> None:
    with _cell(m=(0, 200), n=(100,)) as cell:
        cell["Main.ReadArea2.m"] = cell["Main.WriteArea1.n"] = 0
        cell.run("50ms")
        image = bytes(cell["Main.InputArea"])
        lines = cell.trace.scans()[-2:]
        assert image[:48] == lines[0].so
        assert image[200:248] == lines[1].so
        assert any(lines[1].so)
        assert image[48:200] == bytes(152)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"m": (0, 40)}, "the areas at m = 0 and m = 40 overlap"),
        ({"n": (48, 0, 96)}, r"3 offsets n are given for 2 robot\(s\)"),
        ({"n": (0, 500)}, "needs 48 bytes"),
        ({"robot": ()}, "no robot is given"),
        ({"link": "enip-realtime"}, "in real time a cell has one robot"),
    ],
)
def test_impossible_areas_are_refused(options: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        _cell(**options)


def test_an_event_for_a_missing_controller_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "s.toml"
    with _cell() as cell:
        with pytest.raises(InputError, match="no controller 3; the cell has 2"):
            cell.inject("alarm", controller=3)
        file.write_text('[[at]]\ntime = "1ms"\ncontroller = 3\nrobot = "alarm"\n')
        with pytest.raises(InputError, match="no controller 3; the cell has 2"):
            Stimulus.load(file).schedule(cell)
    for wrong in ("0", "true", '"2"'):
        file.write_text(f'[[at]]\ntime = "1ms"\ncontroller = {wrong}\nrobot = "alarm"\n')
        with pytest.raises(InputError, match="controller is not a number from 1"):
            Stimulus.load(file)


def test_a_stimulus_reaches_the_controller_that_it_names(tmp_path: Path) -> None:
    file = tmp_path / "s.toml"
    file.write_text(
        '[[at]]\ntime = "20ms"\ncontroller = 2\nrobot = "alarm"\n'
        '[[at]]\ntime = "20ms"\nrobot = "warning"\n'
        '[[at]]\ntime = "20ms"\ncontroller = 2\nhold = "SO10"\nrobot = "manual_mode"\n'
    )
    with _cell() as cell:
        Stimulus.load(file).schedule(cell)
        cell.run("100ms")
        first, second = (cell[f"Main.Robot{k}.SO"] for k in (1, 2))
    assert (first["SO03_Alarm"], second["SO03_Alarm"]) == (False, True)
    assert (first["SO15_Warning"], second["SO15_Warning"]) == (True, False)
    assert second["SO10_AutoMode"], "held"


def test_a_broken_rule_is_reported_with_its_controller(tmp_path: Path) -> None:
    """The message names controller 2 if reserved byte n + 46 of its area is not 0.

    Source: manual chapter 1, 4.1: reserved.
    """
    file = tmp_path / "trace.jsonl"
    with _cell(trace=file) as cell:
        cell.run("100ms")
        cell["Main.OutputArea[94]"] = 1
        cell.run("50ms")
        texts = [one.text for one in cell.violations]
        assert cell.trace.findings() == cell.violations
    assert {one.rule for one in cell.violations} == {"reserved"}
    assert [one for one in read_trace(file)[1] if isinstance(one, Violation)] == cell.violations
    assert texts[0].startswith("controller 2: plc, scan 10: reserved")
    assert all(text.startswith("controller 2: ") for text in texts)


@pytest.mark.parametrize("lost", [1, 2])
@pytest.mark.parametrize("on_loss", ["hold", "clear"])
def test_on_loss_affects_only_the_lost_controller(on_loss: str, lost: int) -> None:
    """If one controller is lost, its inputs in the PLC hold their values or become zero.

    The inputs from the other controller do not change.

    Source: docs/how-to/testing.md, `rcx_on_loss`.
    """
    with _cell(on_loss=on_loss) as cell:
        cell.run("100ms")
        shown = [bytes(cell["Main.InputArea"])[at : at + 48] for at in (0, 48)]
        assert all(any(area) for area in shown)
        cell.inject("link_down", controller=lost)
        cell.run("300ms")
        expected = list(shown)
        if on_loss == "clear":
            expected[lost - 1] = bytes(48)
        assert [bytes(cell["Main.InputArea"])[at : at + 48] for at in (0, 48)] == expected
        last = cell.trace.scans()[-2:]
        assert [one.controller for one in last] == [1, 2]
        assert [one.so for one in last] == expected
        cell.inject("link_up", controller=lost)
        cell.run("500ms")
        assert cell.connected
        assert all(any(one.so) for one in cell.trace.scans()[-2:])


def test_each_of_three_controllers_has_a_status_of_its_own(tmp_path: Path) -> None:
    """The connection states of three controllers are in Connected, Connected2 and Connected3."""
    file = tmp_path / "three.st"
    file.write_text(
        "PROGRAM P1\n  VAR\n    InputArea, OutputArea : RCX_IMAGE;\n"
        "    Connected, Connected2, Connected3 : BOOL;\n    Scans : INT;\n  END_VAR\n"
        "  Scans := Scans + 1;\nEND_PROGRAM\n"
    )
    robots = (RobotConfig(),) * 3
    with Cell.build(file, robot=robots, engine="builtin") as cell:
        cell.run("100ms")
        names = ("Connected", "Connected2", "Connected3")
        for lost in (3, 2, 1):
            assert [cell[f"Main.{name}"] for name in names[:lost]] == [True] * lost
            cell.inject("link_down", controller=lost)
            cell.run("300ms")
            expected = [number < lost for number in (1, 2, 3)]
            assert [cell[f"Main.{name}"] for name in names] == expected


def test_the_rules_of_the_wire_are_checked_for_connected_controllers_only() -> None:
    """While controller 2 is not connected, only the outputs to controller 1 are checked."""
    with _cell() as cell:
        cell.run("100ms")
        cell.inject("link_down", controller=2)
        cell.run("300ms")
        cell["Main.OutputArea[94]"] = cell["Main.OutputArea[47]"] = 1
        cell.scan()
        assert [one.text.split(":")[0] for one in cell.violations if "plc, " in one.text] == [
            "plc, scan 40"
        ]


def test_a_cell_of_two_controllers_can_be_restored() -> None:
    with _cell(jitter="3ms") as cell:
        cell.run("300ms")
        before = cell.snapshot()

        def rest() -> list[str]:
            cell.run("300ms")
            return list(cell.trace.lines())

        one = rest()
        cell.inject("alarm", controller=2)
        cell.run("100ms")
        cell.restore(before)
        assert rest() == one


def test_a_trace_of_two_controllers_can_be_read_again(tmp_path: Path) -> None:
    file = tmp_path / "trace.jsonl"
    with _cell(trace=file, watch=["Main.Connected2"]) as cell:
        cell.run("30ms")
        written = list(cell.trace)
    header, records = read_trace(file)
    assert header["controllers"] == 2
    assert list(records) == written
    lines = [json.loads(line) for line in file.read_text().splitlines()[1:]]
    scans = [(one["scan"], one.get("controller"), "vars" in one) for one in lines if "scan" in one]
    assert scans[:4] == [(0, None, True), (0, 2, False), (1, None, True), (1, 2, False)]
    assert {one.controller for one in written if isinstance(one, Cycle)} == {1, 2}


def test_chart_and_wave_show_each_controller(tmp_path: Path) -> None:
    timeline, wave = Timeline(), Wave(tmp_path / "wave.vcd", 2)
    trace = Trace({})
    trace.listen(timeline.take)
    trace.listen(wave.take)
    on = bytes(32) + b"\x01" + bytes(15)
    trace.add(Scan(0, 0, bytes(48), bytes(48)))
    trace.add(Scan(0, 0, bytes(48), on, None, 2))
    trace.add(Cycle(5_000, 1, on, bytes(48), 2))
    trace.add(Violation(5_000, "a rule", "in words"))
    wave.close()
    changed = [lane.name for lane in timeline.lanes() if lane.changes]
    assert changed == ["2: SI(00) Emergency stop input", "Rule broken"]
    text = (tmp_path / "wave.vcd").read_text()
    assert [word for word in ("plc", "plc_2", "robot", "robot_2") if f" {word} $end" in text] == [
        "plc", "plc_2", "robot", "robot_2"
    ]  # fmt: skip


def test_robot_and_area_options_can_be_repeated(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    chart = tmp_path / "chart.svg"
    arguments = ["run", str(_EXAMPLE), "--stimulus", str(_EXAMPLE / "stimulus.toml")]
    arguments += ["--engine", "builtin", "--for", "1500ms", "--chart", str(chart)]
    robots = [f"--robot={_EXAMPLE}/robot1.toml", f"--robot={_EXAMPLE}/robot2.toml"]
    assert main([*arguments, *robots, "--m", "0", "--m", "48"]) == 0
    assert "no violations" in capsys.readouterr().out
    assert "2: SI(00) Emergency stop input" in chart.read_text()
    assert main([*arguments, *robots[:1]]) == 2
    assert "no controller 2" in capsys.readouterr().err
