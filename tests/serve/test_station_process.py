"""The 5 ms loop of a served controller runs on a simulated clock."""

from __future__ import annotations

import io
import json
import os
import queue
import sys

import pytest

from rcx_harness.robot import Controller
from rcx_harness.serve.station import Station
from rcx_harness.serve.station_process import REPORT_CYCLES, Channel, run
from served import NetworkInMemory

#: Time limit of each wait in these tests [s].
_PATIENCE_S = 60


class Time:
    """A clock that advances only in `sleep`. It ends the parent's channel after `until_us`."""

    def __init__(self, channel: Channel, until_us: int, late_us: dict[int, int] | None = None):
        self.now_us = 1_000_000
        self._channel = channel
        self._end_us = self.now_us + until_us
        self._late_us = late_us or {}
        self.slept: list[int] = []

    def clock(self) -> int:
        """Return the simulated time [us]."""
        return self.now_us

    def sleep(self, wait_us: int) -> None:
        """Advance the clock by this time, or by more if the process should be late."""
        self.slept.append(wait_us)
        self.now_us += wait_us + self._late_us.get(len(self.slept), 0)
        if self.now_us >= self._end_us:
            self._channel.ended.set()


def _run(until_us: int, late_us: dict[int, int] | None = None, waiting: int = 100) -> list[str]:
    lines: queue.Queue[str] = queue.Queue(waiting)
    channel = Channel(lines)
    time = Time(channel, until_us, late_us)
    run(Station(Controller(), NetworkInMemory()), channel, time.clock, time.sleep)
    return [lines.get_nowait() for _ in range(lines.qsize())]


def test_a_cycle_comes_every_5_ms_and_a_report_ten_times_a_second() -> None:
    reports = [json.loads(line) for line in _run(1_000_000)]
    assert [one["t_us"] for one in reports] == [100_000 * k for k in range(10)]
    assert [one["cycles"] for one in reports] == [1 + REPORT_CYCLES * k for k in range(10)]
    assert reports[-1]["skipped"] == 0


def test_after_a_standstill_the_missed_cycles_are_skipped_and_counted() -> None:
    reports = [json.loads(line) for line in _run(300_000, late_us={3: 52_000})]
    assert reports[-1]["skipped"] == 10
    assert reports[-1]["t_us"] == 5000 * (reports[-1]["cycles"] - 1 + 10)


def test_a_parent_that_does_not_read_gets_fewer_reports_and_blocks_nothing() -> None:
    reports = [json.loads(line) for line in _run(2_000_000, waiting=3)]
    assert [one["t_us"] for one in reports] == [0, 100_000, 200_000]


def test_changes_while_the_parent_does_not_read_are_reported_later() -> None:
    lines: queue.Queue[str] = queue.Queue(1)
    channel = Channel(lines)
    network = NetworkInMemory()
    time = Time(channel, 600_000)
    told: list[str] = []

    def sleep(wait_us: int) -> None:
        time.sleep(wait_us)
        passed_us = time.now_us - 1_000_000
        if passed_us == 250_000:  # two reports were due, but only the first fitted into the pipe
            network.send(bytes(32) + b"\x01" + bytes(15))
        if passed_us == 450_000:
            told.append(lines.get_nowait())

    run(Station(Controller(), network), channel, time.clock, sleep)
    assert json.loads(told[0])["t_us"] == 0
    changes = json.loads(lines.get_nowait())["changes"]
    assert next(one["t_us"] for one in changes if one["connected"]) == 250_000


def test_events_of_the_parent_happen_and_are_answered_by_their_number() -> None:
    lines: queue.Queue[str] = queue.Queue(100)
    channel = Channel(lines)
    channel.put({"id": 7, "event": "alarm", "args": {"group": 12, "category": 762}})
    channel.put({"id": 8, "event": "nothing"})
    channel.put({"id": 9, "event": "link_down", "args": {}})
    network = NetworkInMemory()
    time = Time(channel, 10_000)
    run(Station(Controller(), network), channel, time.clock, time.sleep)
    told = [json.loads(lines.get_nowait()) for _ in range(lines.qsize())]
    answers = [one for one in told if "answer" in one]
    assert [one["answer"] for one in answers] == [7, 8, 9]
    assert [bool(one["error"]) for one in answers] == [False, True, False]
    assert "unknown event 'nothing'" in answers[1]["error"]
    reports = [one for one in told if "answer" not in one]
    assert reports[0]["alarms"][0].startswith("12.762")
    assert reports[0]["link_cut"]


def test_the_end_of_the_parents_stream_ends_the_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """If the stream of the parent ends, the process ends after the earlier messages."""
    monkeypatch.setattr(sys, "stdin", io.StringIO('{"event": "link_down"}\n'))
    channel = Channel()
    channel.start()
    assert channel.ended.wait(_PATIENCE_S)
    assert channel.take() == {"event": "link_down"}


def test_a_parent_that_no_longer_reads_ends_the_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """If the parent no longer reads, the process ends, even if the other pipe is open."""

    class Broken(io.StringIO):
        def write(self, text: str) -> int:
            raise BrokenPipeError

    reader, writer = os.pipe()
    with os.fdopen(reader) as stdin:
        monkeypatch.setattr(sys, "stdin", stdin)
        monkeypatch.setattr(sys, "stdout", Broken())
        channel = Channel()
        channel.start()
        channel.tell("{}")
        heard = channel.ended.wait(_PATIENCE_S)
        os.close(writer)
        assert heard
