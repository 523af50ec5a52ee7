"""One controller of a cell: its network, its areas in the PLC, and its monitors."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any, NamedTuple

from rcx_harness.cell.clock import Kind, Timing
from rcx_harness.cell.image import Image, owner_of_areas
from rcx_harness.cell.link import Link, make_network
from rcx_harness.robot import Controller, Violation
from rcx_harness.robot.listing import Tasks
from rcx_harness.robot.positions import where
from rcx_harness.robot.shape import poses
from rcx_harness.spec.wire import CYCLE_US
from rcx_harness.trace import Cycle, Scan, Trace
from rcx_harness.watch.wire import WireMonitor
from structured_text.bench.agenda import Agenda
from structured_text.engines.base import Program
from structured_text.errors import InputError
from structured_text.language.types import BlockType, ElementaryType

__all__ = ["Member", "Node", "status_path"]

Report = Callable[[Iterable[Violation]], None]


class Member(NamedTuple):
    """A controller with its link and the offsets of its areas in the process image, in bytes.

    If `far` is set, the controller is external. Then `robot` only has its size and never runs.
    """

    robot: Controller
    link: Link
    m: int = 0
    n: int = 0
    far: bool = False


class Node:
    """A controller in a cell, with its network and its share of the PLC's process image.

    Args:
        number: Number of the controller, from 1. Trace and violations contain the number only if it
            is not 1.
        report: Function that is called with the violations.
        clear: Whether the PLC's inputs are 0 without a connection.
        positions: Unit of the positions in the trace; empty: positions are not recorded.
    """

    def __init__(
        self,
        number: int,
        member: Member,
        image: Image,
        program: Program,
        timing: Timing,
        agenda: Agenda,
        trace: Trace,
        report: Report,
        *,
        seed: int,
        clear: bool,
        positions: str = "",
    ) -> None:
        self.number, self.robot, self.link = number, member.robot, member.link
        self.far = member.far
        """Whether the controller is external."""
        self.matched = self.link.size == self.robot.config.size
        """Whether master and robot have areas of equal size; otherwise there is no connection."""
        self.cycles = 0
        self._program, self.image = program, image
        self.m, self.n = member.m, member.n
        self._trace, self._report = trace, report
        self._no_area = bytes(self.link.size)
        self._clear = clear
        self._unit = positions
        self._stood: tuple[float, ...] | None = None
        self._posed: tuple[dict[str, Any], ...] = ()
        self._tasks = Tasks(self.robot)
        self._status = status_path(program, number)
        self._shown = program.reader([self._status] if self._status else [])
        self._so, self._connected = self._no_area, False
        self._given: tuple[bytes, bool] | None = None
        self.wire = WireMonitor(self.link.size)
        self._prefix = "" if number == 1 else f"controller {number}: "
        if not self.far:
            agenda.repeat(timing.phases[0], Kind.CYCLE, CYCLE_US, self._cycle, number)
        self.network = make_network(
            self.link, timing, agenda, matched=self.matched, seed=seed, controller=number
        )
        self.network.start(image.get)

    def before_scan(self, now: int) -> None:
        """Put the controller's last image into the process image."""
        connected = self.network.plc_connected(now)
        self._so = self._no_area if self._clear and not connected else self.network.input
        if self._given is not None:
            self._so, connected = self._given
        self._connected = connected
        if self._status is not None and self._shown()[0] is not connected:
            self._program.write(self._status, connected)
        self.image.put(self._so, connected)

    def after_scan(self, now: int, scan: int, watched: dict[str, Any] | None) -> None:
        """Send the PLC's outputs, record the scan and check it."""
        si = self.image.get()
        self.network.scanned(si)
        self._trace.add(Scan(now, scan, self._so, si, watched, self.number))
        if found := self.wire.scan(now, scan, self._so, si, self._connected):
            self._tell(found)

    @property
    def exchanged(self) -> tuple[bytes, bytes]:
        """Return the areas that the PLC has read and written in the last scan."""
        return self._so, self.image.get()

    def begin_anew(self) -> None:
        """Reset the monitor after a start of the PLC, so that earlier outputs no longer count."""
        commands, self.wire = self.wire.commands, WireMonitor(self.link.size)
        self.wire.commands = commands

    def give_area(self, area: bytes | None, connected: bool) -> None:
        """Let the PLC read `area` from its next scan on; None: the controller's answer again."""
        if area is not None and not isinstance(area, (bytes, bytearray)):
            raise InputError(f"area is {area!r:.40}, not bytes")
        if area is not None and len(area) > self.link.size:
            raise InputError(
                f"area has {len(area)} bytes, but the PLC's area has {self.link.size}",
                hint="shorten the area, or run with --size 256",
            )
        self._given = None if area is None else (area.ljust(self.link.size, b"\0"), connected)

    def snapshot(self) -> object:
        """Return the state of controller, network and monitor."""
        robot, network = self.robot.snapshot(), self.network.snapshot()
        return robot, network, self.wire.snapshot(), self.cycles, self._given

    def restore(self, snapshot: Any) -> None:
        """Restore the state of a snapshot."""
        robot, network, wire, self.cycles, self._given = snapshot
        self._stood, self._posed = None, ()
        self._tasks.forget()
        self.robot.restore(robot)
        self.network.restore(network)
        self.wire.restore(wire)

    def _cycle(self, now: int) -> None:
        robot, link, network = self.robot, self.link, self.network
        si = link.robot_read() if network.robot_connected(now) else None
        so = robot.cycle(now, si)
        if self.matched:
            link.robot_write(so)
        network.set_adapter(robot.online)
        moved, posed = (self._moved(), self._set()) if self._unit else (None, None)
        tasks = self._tasks.changed()
        self._trace.add(Cycle(now, self.cycles, si or b"", so, self.number, moved, posed, tasks))
        if robot.violations:
            self._tell(
                Violation(one.t_us, one.rule, f"robot, cycle {self.cycles}: {one.rule}: {one.text}")
                for one in robot.drain_violations()
            )
        self.cycles += 1

    def _moved(self) -> tuple[float, ...] | None:
        """Return the positions of the robots if they have changed; else None."""
        before, self._stood = self._stood, where(self.robot, self._unit)
        return None if self._stood == before else self._stood

    def _set(self) -> tuple[dict[str, Any], ...] | None:
        """Return the settings for the robots' appearance if they have changed; else None."""
        before, self._posed = self._posed, tuple(poses(self.robot))
        is_new = self._posed != before and bool(before or any(self._posed))
        return self._posed if is_new else None

    def _tell(self, found: Iterable[Violation]) -> None:
        if self._prefix:
            found = [replace(one, text=self._prefix + one.text) for one in found]
        self._report(found)


def status_path(program: Program, number: int) -> str | None:
    """Return the path of a program's connection status, such as `Main.Connected`.

    The status is a BOOL named `Connected`, or `Connected2` for controller 2. The function searches
    the PROGRAMs first, then the block with the areas. It returns None if there is no such BOOL.
    """
    wanted = "connected" if number == 1 else f"connected{number}"
    for name, kind in program.instances().items():
        assert isinstance(kind, BlockType)
        for variable in kind.variables:
            if variable.name.lower() == wanted and variable.type == ElementaryType("BOOL"):
                return f"{name}.{variable.name}"
    owner = owner_of_areas(program)
    beside = f"{owner}.{wanted}".lower()
    for path, type_ in program.walk() if owner else ():
        if path.lower() == beside and type_ == ElementaryType("BOOL"):
            return path
    return None
