"""Robot programs of a served controller: listings, lines, traces; the same as in a cell."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from plc_bench import ROOT
from rcx_harness.cell import Cell
from rcx_harness.robot import RobotConfig, RobotProgram
from rcx_harness.robot.listing import listings
from rcx_harness.serve import web
from rcx_harness.trace import Cycle, Trace, read_trace
from served import ServedHost, image
from web_client import WebClient

_FOLDER = ROOT / "tests/data/robot_programs"
_TEXT = "*AGAIN:\nWAIT SI(20)=1\nSO(20)=1\nWAIT SI(20)=0\nSO(20)=0\nGOTO *AGAIN"
_LISTING = {"name": "ECHO", "lines": _TEXT.splitlines()}
_CONFIG = RobotConfig(programs=(RobotProgram(name="ECHO", text=_TEXT),), booted=True)


def _inputs(bits: int, request: bool) -> bytes:
    """Return the area with SI(00) to SI(07), and SI(20)."""
    area = bytearray(image(bits))
    area[34] = int(request)
    return bytes(area)


def _started(trace: Trace | None = None) -> ServedHost:
    """Return a controller whose program runs and waits for SI(20)."""
    host = ServedHost(_CONFIG, trace=trace)
    host.network.send(_inputs(0x41, False))
    host.run(150)
    host.station.controller.program.main.go(host.now_us)
    host.run(5)
    return host


def _task(line: int, state: str = "running") -> dict[str, Any]:
    return {"task": 1, "program": "ECHO", "line": line, "state": state}


def test_the_first_report_has_the_listings_and_each_report_the_tasks() -> None:
    host = ServedHost(_CONFIG)
    assert host.status.listings == (_LISTING,)
    assert host.status.tasks == (_task(1, "ready"),)
    host.run(5)
    assert (host.status.listings, host.listings) == ((), (_LISTING,))
    host.station.controller.program.main.go(host.now_us)
    assert host.run(5).tasks == (_task(2),)
    host.station.happen("power_off")
    assert host.run(5).tasks == ()


def test_without_a_text_a_report_has_neither() -> None:
    host = ServedHost()
    assert (host.status.listings, host.status.tasks) == ((), ())


def test_the_page_can_ask_for_both() -> None:
    client = WebClient(web.application([_started(), ServedHost()], "token"))
    try:
        assert client.get("/token/api/robots/0/programs").json() == [_LISTING]
        shown = client.get("/token/api/robots/0").json()
        assert (shown["programs"], shown["tasks"]) == (1, [_task(2)])
        assert client.get("/token/api/robots/1/programs").json() == []
        assert client.get("/token/api/robots/1").json()["programs"] == 0
    finally:
        client.close()


def test_a_recording_has_the_listings_and_each_change_of_a_line(tmp_path: Path) -> None:
    """SI(20) is ON for 50 ms; the outputs change in the same cycles."""
    host, file = _started(), tmp_path / "r.jsonl"
    host.station.obey({"record": str(file)})
    for request in (True, False):
        host.network.send(_inputs(0x41, request))
        host.run(50)
    host.station.obey({"record": None})
    header, records = read_trace(file)
    assert header["programs"] == [[_LISTING]]
    tasks = [one.tasks for one in records if isinstance(one, Cycle) and one.tasks is not None]
    assert tasks == [(_task(2),), (_task(4),), (_task(2),)]


def test_a_trace_has_a_cycle_in_which_only_a_line_changes(tmp_path: Path) -> None:
    """The start of the program changes no area here, because SO(13) shows another task."""
    file = tmp_path / "t.jsonl"
    head = {"by": "rcx serve", "of": "127.0.0.1", "cycle_us": 5000, "size": 48, "only": "changes"}
    config = RobotConfig(
        programs=(RobotProgram(name="IDLE"), RobotProgram(name="ECHO", text=_TEXT)), booted=True
    )
    host = ServedHost(config, trace=Trace(head, file, keep=0, programs=[[_LISTING]]))
    host.network.send(_inputs(0x41, False))
    host.run(200)
    echo = host.station.controller.program.tasks[1]
    host.station.controller.program.register(echo, 2, 32)
    echo.go(host.now_us)
    host.run(50)
    host.station.finish()
    cycles = [one for one in read_trace(file)[1] if isinstance(one, Cycle)]
    *_, before, started, last = cycles
    assert (before.rcx_si, before.rcx_so) == (started.rcx_si, started.rcx_so)
    assert started.tasks is not None
    assert started.tasks[1] == {**_task(2), "task": 2}
    assert (started.t_us, last.t_us, last.tasks) == (200_000, host.now_us, None)


@pytest.fixture(scope="module")
def direct() -> list[Cycle]:
    """The cycles of Supervisor.st and PLACE.PGM in a cell: 3 s with the direct link."""
    with Cell.build(
        _FOLDER / "Supervisor.st", engine="builtin", robot=_FOLDER / "robot.toml"
    ) as cell:
        cell["Main.CellSafe"] = True
        cell.run("500ms")
        cell["Main.Start"] = True
        cell.run("2500ms")
        assert cell["Main.Count"] == 2
        return cell.trace.cycles()


def test_with_the_same_inputs_a_served_controller_does_the_same_as_in_a_cell(
    direct: list[Cycle], tmp_path: Path
) -> None:
    """The same outputs and lines in the same cycles, once time is virtual for both."""
    file = tmp_path / "t.jsonl"
    config = RobotConfig.load(_FOLDER / "robot.toml")
    head = {"by": "rcx serve", "of": "127.0.0.1", "cycle_us": 5000, "size": 48, "only": "changes"}
    host = ServedHost(config, trace=Trace(head, file, keep=0))
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
