"""The process of a served controller: its adapter, its 5 ms cycle, and a pipe to its parent.

`rcx_harness.serve.host` starts it with its settings as JSON. Standard input receives requests, one
per line. Standard output first reports whether the process listens, and then the state of the
controller ten times a second. The process ends when its standard input ends, at the latest with its
parent. If a part of the process has ended by itself, the process reports this and ends as well.
"""

from __future__ import annotations

import json
import os
import queue
import sys
import threading
import time
import traceback
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from rcx_harness.enip import child
from rcx_harness.enip.child import be_punctual, tell
from rcx_harness.enip.cyclic.shared import now_us
from rcx_harness.enip.options import AdapterOptions, Identity
from rcx_harness.enip.target.adapter import Adapter
from rcx_harness.robot import Controller, RobotConfig
from rcx_harness.robot.listing import listings
from rcx_harness.serve.station import Station
from rcx_harness.spec.wire import CYCLE_US
from rcx_harness.trace import Trace
from structured_text.errors import InputError

__all__ = ["REPORT_CYCLES", "Channel", "Pace", "main", "run"]


class Pace:
    """A fixed grid of cycles on a monotonic clock.

    A late cycle runs once. The cycles missed meanwhile are skipped and counted. Therefore neither a
    late wake-up nor a standstill of this computer shifts later cycles. The controller's time is a
    whole number of periods and stays real time.
    """

    def __init__(self, start_us: int, period_us: int) -> None:
        self._start_us = start_us
        self._period_us = period_us
        self._next = 0  # number of the next cycle on the grid
        self.cycles = 0
        self.skipped = 0

    def wait_us(self, now_us: int) -> int:
        """Return the time until the next cycle; 0 if it is due."""
        return max(0, self._start_us + self._next * self._period_us - now_us)

    def take(self, now_us: int) -> int:
        """Begin the cycle that is due.

        Returns:
            The controller's time of this cycle [us], 0 for the first.
        """
        number = max(self._next, (now_us - self._start_us) // self._period_us)
        self.skipped += number - self._next
        self.cycles += 1
        self._next = number + 1
        return number * self._period_us


#: Cycles between two reports to the parent: ten reports a second.
REPORT_CYCLES = 20

_WAITING_LINES = 50
_NO_MORE = ""
_LAST_LINE_S = 2.0


class Channel:
    """The pipes to and from the parent; they never delay a cycle."""

    def __init__(self, lines: queue.Queue[str] | None = None) -> None:
        self._out = lines if lines is not None else queue.Queue(_WAITING_LINES)
        self._in: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
        self._writer = threading.Thread(target=self._write, daemon=True)
        self.ended = threading.Event()

    def start(self) -> None:
        """Start the threads that read and write."""
        threading.Thread(target=self._read, daemon=True).start()
        self._writer.start()

    @property
    def has_room(self) -> bool:
        """Return whether the parent reads the reports, so that another line can be queued."""
        return not self._out.full()

    def tell(self, line: str) -> None:
        """Send a line; drop it if the parent does not read."""
        try:
            self._out.put_nowait(line)
        except queue.Full:
            return

    def finish(self, line: str) -> None:
        """Send a last line; if the parent reads, wait until it is written."""
        with suppress(queue.Full):
            self._out.put(line, timeout=_LAST_LINE_S)
            self._out.put(_NO_MORE, timeout=_LAST_LINE_S)
            self._writer.join(_LAST_LINE_S)

    def take(self) -> dict[str, Any] | None:
        """Return the next message of the parent, or None."""
        try:
            return self._in.get_nowait()
        except queue.Empty:
            return None

    def put(self, message: dict[str, Any]) -> None:
        """Queue a message as if the parent had sent it."""
        self._in.put(message)

    def _read(self) -> None:
        for line in sys.stdin:
            self.put(json.loads(line))
        self.ended.set()

    def _write(self) -> None:
        try:
            while (line := self._out.get()) != _NO_MORE:
                print(line, flush=True)
        except OSError:
            self.ended.set()


def run(
    station: Station,
    channel: Channel,
    clock_us: Callable[[], int],
    sleep_us: Callable[[int], None],
    failure: Callable[[], str] = lambda: "",
) -> str:
    """Run the controller's cycles until the channel or a part of the controller has ended.

    `failure` returns the part that has ended by itself, and how. It is called before each report.

    Returns:
        The result of `failure`; empty if the channel has ended.
    """
    station.begin_us = clock_us()
    pace = Pace(station.begin_us, CYCLE_US)
    while not channel.ended.is_set():
        if wait_us := pace.wait_us(clock_us()):
            sleep_us(wait_us)
            continue
        while (message := channel.take()) is not None:
            answer = {"answer": message.get("id"), "error": _obey(station, message)}
            channel.tell(json.dumps({**answer, "t_us": station.now_us}))
        before = pace.skipped
        now_us = pace.take(clock_us())
        station.step(now_us, skipped=pace.skipped - before)
        if pace.cycles % REPORT_CYCLES == 1:
            if reason := failure():
                return reason
            if channel.has_room:
                channel.tell(station.report().to_json())
    return ""


def main(argument: str) -> None:
    """Serve one controller until the parent closes standard input.

    Args:
        argument: JSON object with `robot` and `trace` (files or empty), `size` (or null), `seed`,
            and for the adapter `host`, `port`, `cyclic` (UDP port), `identity` and `options`.
    """
    settings = json.loads(argument)
    try:
        controller = Controller(_config(settings), settings["seed"])
        adapter = _adapter(settings, controller.config.size)
        trace = _trace(settings, controller)
    except InputError as error:
        tell({"error": str(error)})
        return
    with adapter:
        station = Station(controller, adapter.shared, trace, settings["host"])
        channel = Channel()
        channel.tell(json.dumps({"port": adapter.address[1], "size": adapter.size}))
        be_punctual("in turn")
        channel.start()
        try:
            reason = run(
                *(station, channel, now_us),
                sleep_us=lambda us: time.sleep(us / 1e6),
                failure=lambda: adapter.failure,
            )
            station.finish()
        except InputError as error:  # for example, the trace can no longer be written
            reason = str(error)
        except Exception as error:  # an internal error: report it to the parent
            traceback.print_exc()
            reason = f"the controller has ended by itself ({type(error).__name__}: {error})"
        if reason:
            channel.finish(json.dumps({"died": reason}))
    # A thread still reads standard input. A normal exit of the interpreter would wait for it.
    os._exit(1 if reason else 0)


def _config(settings: dict[str, Any]) -> RobotConfig:
    config = RobotConfig.load(Path(settings["robot"])) if settings["robot"] else RobotConfig()
    return replace(config, size=settings["size"]) if settings["size"] else config


def _trace(settings: dict[str, Any], controller: Controller) -> Trace | None:
    """Return the trace of the cycles in which areas or tasks have changed, or None."""
    if not settings["trace"]:
        return None
    header = {"by": "rcx serve", "of": settings["host"], "cycle_us": CYCLE_US}
    return Trace(
        {**header, "size": controller.config.size, "only": "changes"},
        settings["trace"],
        keep=0,
        programs=[listings(controller)],
    )


def _adapter(settings: dict[str, Any], size: int) -> Adapter:
    return Adapter(
        size,
        Identity(**settings["identity"]),
        host=settings["host"],
        port=settings["port"],
        cyclic=settings["cyclic"],
        options=AdapterOptions(**settings["options"]),
    )


def _obey(station: Station, message: dict[str, Any]) -> str:
    """Execute a message of the parent; return an error message, or an empty text."""
    try:
        station.obey(message)
    except InputError as error:
        return str(error)
    return ""


if __name__ == "__main__":
    child.run(main)
