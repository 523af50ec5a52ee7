"""A recording that is started and stopped during a run has the right content for its readers."""

from __future__ import annotations

import asyncio
import json
from pathlib import Path
from typing import Any

import pytest

from rcx_harness.cli.app import main
from rcx_harness.robot import RobotConfig
from rcx_harness.serve import recorder
from rcx_harness.trace import Cycle, Violation, read_trace
from served import ServedHost
from structured_text.errors import InputError
from view_page import PageContent

_RELEASED = bytes(32) + b"\x41" + bytes(15)


@pytest.fixture
def served() -> ServedHost:
    """Return a YK400XEC with a master, 200 ms after its start. Both arms are stretched."""
    host = ServedHost(RobotConfig(robot=("YK400XEC",)))
    host.network.send(bytes(48))
    host.run(200)
    return host


def record(host: ServedHost, file: Path | None) -> None:
    host.station.obey({"record": str(file) if file else None})


def test_a_recording_has_the_cycles_with_changes_and_begins_at_0(
    served: ServedHost, tmp_path: Path
) -> None:
    """The recording has the cycles with a change, and its time begins at 0.

    SI(00) turns ON 50 ms after the start, and a movement begins 50 ms later. Nothing else changes
    until 500 ms. With stretched arms of 225 and 175 mm, Y is 400 mm.
    """
    file = tmp_path / "r.jsonl"
    record(served, file)
    served.run(50)
    served.network.send(bytes(32) + b"\x01" + bytes(15))
    served.run(50)
    served.station.controller.positions[1] = -29239  # 10 degrees to the left
    served.run(400)
    assert (served.status.recording, served.status.recorded) == (True, 4)
    record(served, None)
    assert not served.run(10).recording
    header, records = read_trace(file)
    assert header["by"] == "rcx serve"
    assert header["positions"] == [
        ["Position X [mm]", "Position Y [mm]", "Position Z [mm]", "Position R [deg]"]
    ]
    assert header["robots"][0][0]["name"] == "YK400XEC"
    first, stop, *_, moved, last = [one for one in records if isinstance(one, Cycle)]
    assert (first.t_us, first.positions) == (0, (0, 400, 0, 90))
    assert stop.rcx_si[32] == 1
    assert (moved.t_us, moved.poses) == (105_000, ({"left": True},))
    assert moved.positions is not None
    assert moved.positions[0] == pytest.approx(175 * 0.17365, abs=0.01)  # sine of 10 degrees
    assert last.t_us == 500_000


def test_a_broken_rule_is_recorded_once_and_read_by_judge_and_view(
    served: ServedHost, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A broken rule is in the recording once, and `rcx judge` and `rcx view` read it.

    SI(00) and SI(06) change in one exchange, which breaks two rules (chapter 5, 3).
    """
    file = tmp_path / "r.jsonl"
    record(served, file)
    served.run(100)
    served.network.send(_RELEASED)
    served.run(100)
    served.station.controller.positions[2] = 50_000
    served.run(100)
    record(served, None)
    broken = [one for one in read_trace(file)[1] if isinstance(one, Violation)]
    assert [one.rule for one in broken] == ["interval"]
    assert main(["judge", str(file)]) == 1
    assert "SI(00) ON and SI(06) ON" in capsys.readouterr().out
    assert main(["view", str(file)]) == 0
    page = PageContent(file.with_suffix(".html").read_text(encoding="utf-8"))
    times = [t_us for t_us, _ in page.changes("Rules broken")[1:]]
    assert times
    assert set(times) == {broken[0].t_us}
    assert page.changes("Position Z [mm]")[1][0] == 205_000
    assert page.table["robots"][0]["title"] == "Robot 1, YK400XEC"


def test_it_begins_anew_and_ends_by_itself(
    served: ServedHost, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "r.jsonl"
    record(served, file)
    served.network.send(_RELEASED)
    served.run(200)
    record(served, file)
    served.run(50)
    record(served, None)
    assert [one.t_us for one in read_trace(file)[1]] == [0, 50_000]
    monkeypatch.setattr(recorder, "MOST_CYCLES", 3)
    record(served, file)
    for place in range(10):
        served.station.controller.positions[2] = 1000 * place
        served.run(0)
    assert not served.status.recording
    assert len(list(read_trace(file)[1])) <= 4


def test_the_page_starts_stops_and_gives_it(served: ServedHost) -> None:
    async def use() -> None:
        with pytest.raises(InputError, match="nothing has been recorded; start a recording first"):
            served.recording()
        await served.record(on=True)
        with pytest.raises(InputError, match="the recording is not finished; stop it first"):
            served.recording()
        await served.record(on=False)
        file = served.recording()
        head: dict[str, Any] = json.loads(file.read_text(encoding="utf-8").splitlines()[0])
        assert head["of"] == "127.0.0.1"
        await served.close()
        assert not file.exists()

    asyncio.run(use())
