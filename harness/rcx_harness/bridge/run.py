"""The steps of `rcx bridge`: connect both sides, exchange data, show the state, end with zeros."""

from __future__ import annotations

import queue
import sys
import threading
import time
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field
from functools import partial

from rich.console import Console, Group
from rich.live import Live
from rich.text import Text

from rcx_harness.bridge.core import Limits, Lost, Registers, State
from rcx_harness.bridge.figures import figures_text, plc_text, robot_text, state_text
from rcx_harness.bridge.loop import Loop, RobotLink
from rcx_harness.bridge.plc import PlcError, PlcLink
from rcx_harness.enip.closing import Closing
from rcx_harness.enip.cyclic.shared import now_us
from rcx_harness.enip.originator.client import PORT
from rcx_harness.enip.originator.opening import multiplier_of
from rcx_harness.enip.originator.scanner import Scanner
from structured_text.errors import InputError
from structured_text.output.system import fine_timers, told_to_end
from structured_text.output.throttle import Throttle

__all__ = ["BridgeOptions", "Running", "bridge", "news_lines"]

_SHOW_EVERY_S = 0.25
_FIGURES_EVERY_S = 5.0
_KEEP_EVERY_S = 0.5
_FIRST_S, _LOOK_S = 2.0, 0.01
_STYLES = {State.RUN: "bold green", State.CLEARING: "yellow"}


@dataclass(frozen=True)
class BridgeOptions:
    """The options of `rcx bridge`.

    Attributes:
        address: Local address of the connection to the controller; empty: the system chooses.
        period_us: Time from one exchange with the PLC to the next, in microseconds.
        rpi_us: Packet interval to and from the controller, in microseconds.
        wait: Whether the bridge starts even if one side does not answer yet.
    """

    plc_host: str
    plc_port: int
    robot: str
    robot_port: int = PORT
    address: str = ""
    registers: Registers = field(default_factory=Registers)
    unit: int = 1
    period_us: int = 10_000
    rpi_us: int = 10_000
    limits: Limits = field(default_factory=Limits)
    wait: bool = False
    quiet: bool = False


class Running(Closing):
    """A running bridge: a thread exchanges data, and another thread reopens the robot's connection.

    Attributes:
        news: Changes of state: monotonic time in seconds, state, reason; `None` if one of the
            threads has ended unexpectedly.
    """

    def __init__(self, options: BridgeOptions) -> None:
        fine_timers()
        self._options = options
        self._stop = threading.Event()
        self.start_s = time.perf_counter()
        self.news: queue.SimpleQueue[tuple[float, State, str] | None] = queue.SimpleQueue()
        timeout_s = options.limits.gap_us / 1e6
        self._plc = PlcLink(
            *(options.plc_host, options.plc_port, options.registers),
            unit=options.unit,
            timeout_s=timeout_s,
        )
        multiplier = multiplier_of(options.limits.gap_us, options.rpi_us)
        size = options.registers.size

        connect = partial(
            Scanner,
            *(options.robot, size, options.rpi_us),
            multiplier=multiplier,
            address=options.address,
            port=options.robot_port,
        )
        self.robot = RobotLink(f"{options.robot}:{options.robot_port}", size, connect)
        self.loop = Loop(
            *(self._plc, self.robot, options.registers, options.limits),
            on_state=lambda state, reason: self.news.put((time.perf_counter(), state, reason)),
        )
        self._first_contact()
        self._thread = threading.Thread(target=self._exchange, daemon=True)
        self._thread.start()
        self.robot.opener.start(_KEEP_EVERY_S, on_died=lambda: self.news.put(None))

    def close(self) -> None:
        """Write zeros to both sides, then close both connections; later calls do nothing."""
        self._stop.set()
        self._thread.join()
        self.robot.opener.end()
        self.loop.end()
        self._plc.close()
        self.robot.close()

    def _first_contact(self) -> None:
        """Connect both sides once; if a side fails without `wait`, raise InputError."""
        try:
            self._plc.connect()
            self._plc.read()
            self.robot.opener.open()
            self._first_packet()
        except (PlcError, InputError) as error:
            if self._options.wait:
                return
            self._plc.close()
            if isinstance(error, PlcError):
                hint = "switch its Modbus server on, or start the bridge with --wait"
                raise InputError(str(error), hint=hint) from None
            raise

    def _first_packet(self) -> None:
        """Wait for the first packet of the robot, so that its delay is not reported as a loss."""
        until_s = time.perf_counter() + _FIRST_S
        while isinstance(self.robot.read(), Lost) and time.perf_counter() < until_s:
            self._stop.wait(_LOOK_S)

    def _exchange(self) -> None:
        period_s = self._options.period_us / 1e6
        due_s = time.perf_counter()
        try:
            while not self._stop.is_set():
                self.loop.turn()
                # If an exchange is late by more than a period, skip the missed exchanges to avoid a
                # burst.
                due_s = max(due_s + period_s, time.perf_counter() - period_s)
                self._stop.wait(max(0.0, due_s - time.perf_counter()))
        finally:
            if not self._stop.is_set():
                self.news.put(None)


def bridge(options: BridgeOptions) -> int:
    """Run the bridge until SIGINT or SIGTERM.

    Returns:
        0 after a signal, 1 if the exchange has ended unexpectedly.
    """
    stop = threading.Event()
    with told_to_end(stop.set), Running(options) as running:
        if not options.quiet:
            _announce(options)
        ended = _show(running, stop, options)
    if ended:
        print("rcx: the exchange has ended by itself", file=sys.stderr)
    return int(ended)


def _announce(options: BridgeOptions) -> None:
    registers = options.registers
    print(
        f"PLC {options.plc_host}:{options.plc_port}: reads holding registers "
        f"{registers.text(registers.read)}, writes {registers.text(registers.write)}"
    )
    print(
        f"robot {options.robot}: {registers.size} bytes. Ctrl-C ends it; the robot then loses its "
        "master.",
        flush=True,
    )


def _show(running: Running, stop: threading.Event, options: BridgeOptions) -> bool:
    """Show the state until `stop` is set; return True early if a thread has ended unexpectedly."""
    console = Console()
    start_s = shown_s = running.start_s
    live = console.is_terminal and not options.quiet
    throttle = Throttle()
    with Live(console=console, auto_refresh=False) if live else nullcontext() as screen:
        while not stop.wait(_SHOW_EVERY_S):
            now_s = time.perf_counter()
            news = []
            while not running.news.empty():
                if (one := running.news.get()) is None:
                    return True
                news.append(one)
            for line in news_lines(news, start_s, now_s, throttle, quiet=options.quiet):
                console.print(line, markup=False, highlight=False, soft_wrap=True)
            rate, look = running.loop.figures.look(now_us()), running.robot.look()
            if screen is not None:
                style = _STYLES.get(running.loop.state, "bold red")
                text = state_text(running.loop.state, running.loop.reason)
                lines = [Text(text, style), Text(plc_text(rate)), Text(robot_text(look))]
                screen.update(Group(*lines), refresh=True)
            elif not options.quiet and now_s - shown_s >= _FIGURES_EVERY_S:
                shown_s = now_s
                print(f"{now_s - start_s:10.3f} s  {figures_text(rate, look)}", flush=True)
    return False


def news_lines(
    news: Sequence[tuple[float, State, str]],
    start_s: float,
    now_s: float,
    throttle: Throttle,
    *,
    quiet: bool,
) -> list[str]:
    """Return lines with the changes of state and their times; limit the number of lines."""
    shown = [one for one in news if not quiet or one[1] not in (State.RUN, State.CLEARING)]
    lines = []
    for happened_s, state, reason in shown:
        texts = throttle.let_pass("state", [state_text(state, reason)], round(happened_s * 1e6))
        lines += [f"{happened_s - start_s:10.3f} s  {text}" for text in texts]
    rest = throttle.let_pass("state", (), round(now_s * 1e6))
    return lines + [f"{now_s - start_s:10.3f} s  {text}" for text in rest]
