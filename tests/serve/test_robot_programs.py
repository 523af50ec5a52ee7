"""Robot programs of a served controller have the same listings, lines and traces as in a cell."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from plc_bench import ROOT
from rcx_harness.cell import Cell
from rcx_harness.cli.app import main
from rcx_harness.robot import RobotConfig, RobotProgram
from rcx_harness.robot.listing import listings
from rcx_harness.serve import web
from rcx_harness.trace import Cycle, Trace, read_trace
from served import ServedHost, image
from view_page import PageContent
from web_client import WebClient

_FOLDER = ROOT / "tests/data/robot_programs"
_TEXT = "*AGAIN:\nWAIT SI(20)=1\nSO(20)=1\nWAIT SI(20)=0\nSO(20)=0\nGOTO *AGAIN"
_LISTING: dict[str, Any] = {"name": "ECHO", "lines": _TEXT.splitlines()}
_HEAD = {"by": "rcx serve", "of": "127.0.0.1", "cycle_us": 5000, "size": 48, "only": "changes"}
_CONFIG = RobotConfig(programs=(RobotProgram(name="ECHO", text=_TEXT),), booted=True)


def _inputs(bits: int, *, request: bool = False, start: bool = False) -> bytes:
    """Return the area with SI(00) to SI(07), SI(20) and SI(12)."""
    area = bytearray(image(bits))
    area[33], area[34] = 4 * start, int(request)
    return bytes(area)


def _started(config: RobotConfig = _CONFIG, trace: Trace | None = None) -> ServedHost:
    """Return a controller 300 ms after power-on, when SI(12) has started its program."""
    host = ServedHost(config, trace=trace)
    for bits in (0x01, 0x41):
        host.network.send(_inputs(bits))
        host.run(150)
    host.network.send(_inputs(0x41, start=True))
    host.run(100)
    return host


def _task(line: int, state: str = "running") -> dict[str, Any]:
    return {"task": 1, "program": "ECHO", "line": line, "state": state}


def test_the_first_report_has_the_listings_and_each_report_the_tasks() -> None:
    host = ServedHost(_CONFIG)
    assert host.status.listings == (_LISTING,)
    assert host.status.tasks == (_task(1, "ready"),)
    second = host.run(5)
    assert second.listings == ()
    assert host.listings == (_LISTING,)
    host = _started()
    assert host.status.tasks == (_task(2),)
    host.station.happen("power_off")
    assert host.run(5).tasks == ()


def test_without_a_text_a_report_has_neither() -> None:
    host = ServedHost()
    assert (host.status.listings, host.status.tasks) == ((), ())


def test_the_page_can_ask_for_both() -> None:
    client = WebClient(web.application([_started(), ServedHost()], "token"))
    try:
        assert client.get("/token/api/robots/0/programs").json == [_LISTING]
        shown = client.get("/token/api/robots/0").json
        assert (shown["programs"], shown["tasks"]) == (1, [_task(2)])
        assert client.get("/token/api/robots/1/programs").json == []
        assert client.get("/token/api/robots/1").json["programs"] == 0
    finally:
        client.close()


def test_a_recording_has_the_listings_and_each_change_of_a_line(tmp_path: Path) -> None:
    """A recording has the listings and each change of the executed line.

    SI(20) is ON for 50 ms. The outputs change in the same cycles.
    """
    host, file = _started(), tmp_path / "r.jsonl"
    host.station.obey({"record": str(file)})
    for request in (True, False):
        host.network.send(_inputs(0x41, request=request))
        host.run(50)
    host.station.obey({"record": None})
    header, records = read_trace(file)
    assert header["programs"] == [[_LISTING]]
    tasks = [one.tasks for one in records if isinstance(one, Cycle) and one.tasks is not None]
    assert tasks == [(_task(2),), (_task(4),), (_task(2),)]


def _in_turn(trace: Trace | None = None) -> ServedHost:
    """Return a controller whose program alternates between two delays of 40 ms.

    The areas do not change.
    """
    text = "*AGAIN:\nDELAY 40\nDELAY 40\nGOTO *AGAIN"
    config = RobotConfig(programs=(RobotProgram(name="ECHO", text=text),), booted=True)
    return _started(config, trace)


def test_a_trace_has_the_cycles_in_which_only_a_line_changes(tmp_path: Path) -> None:
    file = tmp_path / "t.jsonl"
    host = _in_turn(Trace(_HEAD, file, keep=0, programs=[[_LISTING]]))
    host.run(200)
    host.station.finish()
    *cycles, last = [one for one in read_trace(file)[1] if isinstance(one, Cycle)]
    moved = [one for one in cycles if one.tasks and one.tasks[0]["state"] == "running"]
    assert [one.tasks for one in moved[:4]] == [(_task(2),), (_task(3),), (_task(2),), (_task(3),)]
    times = [one.t_us for one in moved[:4]]
    assert [later - earlier for earlier, later in pairwise(times)] == [40_000] * 3
    assert len({(one.rcx_si, one.rcx_so) for one in moved[1:]}) == 1
    assert (last.t_us, last.tasks) == (host.now_us, None)


def test_a_recording_has_the_cycles_in_which_only_a_line_changes(tmp_path: Path) -> None:
    """Cycles in which only the executed line changes are recorded.

    In 200 ms the line changes four or five times after the first cycle.
    """
    host, file = _in_turn(), tmp_path / "r.jsonl"
    host.station.obey({"record": str(file)})
    host.run(200)
    host.station.obey({"record": None})
    cycles = [one for one in read_trace(file)[1] if isinstance(one, Cycle)]
    assert len({(one.rcx_si, one.rcx_so) for one in cycles}) == 1
    lines = [one.tasks[0]["line"] for one in cycles if one.tasks is not None]
    assert len(lines) in (5, 6)
    assert all(later != earlier for earlier, later in pairwise(lines))


def test_rcx_view_shows_the_tasks_of_a_served_controller(tmp_path: Path) -> None:
    """`rcx view` shows the tasks of a served controller.

    It judges the trace first, which keeps the tasks.
    """
    file = tmp_path / "t.jsonl"
    host = _started(trace=Trace(_HEAD, file, keep=0, programs=[[_LISTING]]))
    host.station.finish()
    assert main(["view", str(file)]) == 0
    page = PageContent(file.with_suffix(".html").read_text(encoding="utf-8"))
    assert [text for _, text in page.changes("Task 1")] == ["ECHO ready", "ECHO:2 WAIT SI(20)=1"]


@pytest.fixture(scope="module")
def direct() -> list[Cycle]:
    """Return the cycles of Supervisor.st and PLACE.PGM in a cell: 3 s with the direct link."""
    with Cell.build(
        _FOLDER / "Supervisor.st", engine="builtin", robot=_FOLDER / "robot.toml"
    ) as cell:
        cell["Main.CellSafe"] = True
        cell.run("500ms")
        cell["Main.Start"] = True
        cell.run("2500ms")
        assert cell["Main.Count"] == 2
        return cell.trace.cycles()


def test_with_the_same_inputs_a_served_controller_and_a_cell_agree(
    direct: list[Cycle], tmp_path: Path
) -> None:
    """With the same inputs, a served controller and a cell have the same outputs and lines."""
    file = tmp_path / "t.jsonl"
    config = RobotConfig.load(_FOLDER / "robot.toml")
    host = ServedHost(config, trace=Trace(_HEAD, file, keep=0))
    assert len(listings(host.station.controller)) == 1
    assert direct[0].rcx_si == b""
    for cycle in direct[1:]:
        if cycle.rcx_si:
            host.network.send(cycle.rcx_si)
        host.run(5)
    host.station.finish()
    changes = []
    seen: tuple[bytes, bytes] | None = None
    for cycle in direct:
        if (cycle.rcx_si, cycle.rcx_so) != seen or cycle.tasks is not None:
            changes.append(cycle)
        seen = (cycle.rcx_si, cycle.rcx_so)
    served = [one for one in read_trace(file)[1] if isinstance(one, Cycle)]
    assert served[: len(changes)] == changes
    assert sum(one.tasks is not None for one in changes) > 10
