"""The parent's side of the served controllers: their processes, and their last reports."""

from __future__ import annotations

import asyncio
import itertools
import json
import shutil
import sys
import tempfile
from collections import deque
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from rcx_harness.enip.child import how_ended
from rcx_harness.enip.cyclic.connections import IO_PORT
from rcx_harness.enip.errors import ProcessDiedError
from rcx_harness.enip.options import AdapterOptions, Identity
from rcx_harness.enip.originator.client import PORT
from rcx_harness.serve.history import History
from rcx_harness.serve.status import Event, Status
from structured_text.errors import InputError
from structured_text.output import system
from structured_text.output.limits import MOST_LINE_BYTES

__all__ = ["MODULE", "STOP_S", "Host", "Settings"]

#: Module that the child process runs, and the time after which it is killed if it does not end [s].
MODULE = "rcx_harness.serve.station_process"
STOP_S = 5.0
_ANSWER_S = 5.0
_MOST_EVENTS = 5000
_MOST_WAY = 100


@dataclass(frozen=True)
class Settings:
    """The settings of one served controller.

    Args:
        robot: File with the properties of the controller; empty for the defaults.
        trace: File for the trace of the controller; empty: no trace.
        size: Bytes of the controller's areas, 48 or 256; None for the size in the file.
    """

    host: str = "127.0.0.1"
    port: int = PORT
    cyclic: int = IO_PORT
    robot: str = ""
    trace: str = ""
    size: int | None = None
    seed: int = 0
    identity: Identity = field(default_factory=Identity)
    options: AdapterOptions = field(default_factory=AdapterOptions)


class Host:
    """A served controller in a separate process.

    Attributes:
        size: Bytes of the controller's areas, known after `start`.
        ended: Event that is set when the process has ended, unexpectedly or not.
        shapes: Geometry of the robots of the controller (`rcx_harness.robot.shape`).
        drawn: Number of times that `shapes` has changed.
        listings: The controller's robot programs (`rcx_harness.robot.listing`); empty if none
            exists as source text.
        way: Latest positions during movements, as in `Status.way`; the page reads them before they
            are dropped.
        failure: The name of a process that has ended by itself, and how it ended. Empty while all
            processes run.
        events: Events that the reader has not removed yet.
        silent: Whether the process gives no sign of life; the watchdog sets this attribute.
    """

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.status = Status()
        self.history = History()
        self.size = 0
        self.ended = asyncio.Event()
        self.failure = ""
        self._process: asyncio.subprocess.Process | None = None
        self._reader: asyncio.Task[None] | None = None
        self._heard = asyncio.Event()  # set at the first report of the process, or at its end
        self._numbers = itertools.count(1)
        self._waiting: dict[int, asyncio.Future[tuple[str, int]]] = {}
        self._folder = ""  # the folder that contains the recording
        self.shapes: tuple[dict[str, Any], ...] = ()
        self.drawn = 0
        self.listings: tuple[dict[str, Any], ...] = ()
        self.way: deque[tuple[int, ...]] = deque(maxlen=_MOST_WAY)
        self.events: deque[Event] = deque(maxlen=_MOST_EVENTS)
        self.reports = 0
        self.silent = False

    @property
    def name(self) -> str:
        """Return the address of the controller, with the port if it is not the standard port."""
        usual = self.settings.port == Settings.port
        return self.settings.host if usual else f"{self.settings.host}:{self.settings.port}"

    @property
    def pid(self) -> int:
        """Return the process ID of the controller; 0 before `start`."""
        return self._process.pid if self._process else 0

    async def start(self) -> None:
        """Start the process, and wait until it listens and has sent its first report."""
        self._process = await asyncio.create_subprocess_exec(
            sys.executable,
            "-m",
            MODULE,
            json.dumps(asdict(self.settings)),
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            limit=MOST_LINE_BYTES,
            **system.APART,
        )
        first = await self._read_line()
        if first is None:
            how = how_ended(await self._process.wait())
            raise ProcessDiedError(f"the process of controller {self.name} ended at once, {how}")
        if "error" in first:
            await self.close()
            raise InputError(first["error"])
        self.size = first["size"]
        self._reader = asyncio.create_task(self._read())
        await self._heard.wait()

    async def record(self, *, on: bool) -> None:
        """Start a recording, which replaces the previous one, or end the current recording."""
        if on and not self._folder:
            self._folder = tempfile.mkdtemp(prefix="rcx-serve-")
        await self.ask({"record": str(self._file) if on else None})

    @property
    def _file(self) -> Path:
        return Path(self._folder) / "recording.jsonl"

    def recording(self) -> Path:
        """Return the file with the recording."""
        if not self._folder or not self._file.exists():
            raise InputError("nothing has been recorded", hint="start a recording first")
        if self.status.recording:
            raise InputError("the recording is not finished", hint="stop it first")
        return self._file

    async def ask(self, message: Mapping[str, Any]) -> int:
        """Send a request to the controller (`Station.obey`) and wait for its answer.

        Returns:
            The controller's time of the answer [us].
        """
        pipe = self._process.stdin if self._process else None
        if pipe is None or self.ended.is_set():
            raise InputError(f"controller {self.name} is not running")
        number = next(self._numbers)
        answer: asyncio.Future[tuple[str, int]] = asyncio.get_running_loop().create_future()
        self._waiting[number] = answer
        try:
            pipe.write(json.dumps({**message, "id": number}).encode() + b"\n")
            error, t_us = await asyncio.wait_for(answer, _ANSWER_S)
        except (OSError, asyncio.TimeoutError):
            raise InputError(f"controller {self.name} does not answer") from None
        finally:
            self._waiting.pop(number, None)
        if error:
            raise InputError(error)
        return t_us

    async def close(self) -> None:
        """End the process; later calls do nothing."""
        if self._process is not None:
            await self._end(self._process)
        if self._folder:
            shutil.rmtree(self._folder, ignore_errors=True)
            self._folder = ""

    async def _end(self, process: asyncio.subprocess.Process) -> None:
        if process.stdin is not None:
            process.stdin.close()  # the process ends when its standard input ends
        try:
            await asyncio.wait_for(process.wait(), STOP_S)
        except asyncio.TimeoutError:
            print(f"rcx: controller {self.name} did not end and was killed", file=sys.stderr)
            process.kill()
            await process.wait()
        if self._reader is not None:
            await self._reader
        self.ended.set()

    async def _read(self) -> None:
        assert self._process is not None
        try:
            while (message := await self._read_line()) is not None:
                if "answer" in message:
                    waiting = self._waiting.get(message["answer"])
                    if waiting is not None and not waiting.done():
                        waiting.set_result((message["error"], message["t_us"]))
                elif "died" in message:
                    self.failure = message["died"]
                else:
                    self.take(Status.from_table(message))
                    self._heard.set()
            how = how_ended(await self._process.wait())
            self.failure = self.failure or f"its process has ended by itself ({how})"
        except (ValueError, TypeError, LookupError) as error:  # the line is too long or malformed
            self.failure = f"its process has sent an invalid report ({error})"
        finally:
            self.ended.set()
            self._heard.set()

    def take(self, status: Status) -> None:
        """Process a report of the controller."""
        self.status = status
        self.reports += 1
        self.events += status.events
        self.way += status.way
        if status.shapes:
            self.shapes, self.drawn = status.shapes, self.drawn + 1
        self.listings = status.listings or self.listings
        self.history.add(status.changes, status.t_us)

    async def _read_line(self) -> dict[str, Any] | None:
        assert self._process is not None
        assert self._process.stdout is not None
        line = await self._process.stdout.readline()
        if not line:
            return None
        table: dict[str, Any] = json.loads(line)
        return table
