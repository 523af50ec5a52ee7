"""One PLC, one robot, one network between them, on one virtual clock."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, NamedTuple

from rcx_harness.cell_build import Files, check_outputs, make_link, make_robot, source_files
from rcx_harness.cell_image import find_image
from rcx_harness.cell_network import make_network
from rcx_harness.clocks import CYCLE_US, Duration, Kind, Timing
from rcx_harness.contract import ContractMonitor
from rcx_harness.contract_source import steady_instances
from rcx_harness.engine.base import Program, Value
from rcx_harness.engine.load import build as build_program
from rcx_harness.engine.types import BlockType, ElementaryType
from rcx_harness.errors import InputError
from rcx_harness.link import Link
from rcx_harness.monitor import WireMonitor
from rcx_harness.robot import EVENTS as ROBOT_EVENTS
from rcx_harness.robot import Controller, RobotConfig, Violation
from rcx_harness.trace import Cycle, Finding, Scan, Trace
from rcx_harness.units import format_us, parse_us

__all__ = ["EVENTS", "Cell", "CellTimeout"]

#: What `Cell.inject` and a stimulus can let happen, with a line of help.
EVENTS: dict[str, str] = {
    "link_down": "the network cable is unplugged: packets are lost",
    "link_up": "the network cable is plugged in again",
    **ROBOT_EVENTS,
}


class CellTimeout(AssertionError):  # noqa: N818 - a failed assertion, not a fault of the cell
    """What a test waited for did not come within its time."""


class _Snapshot(NamedTuple):
    program: object
    robot: object
    network: object
    agenda: Any
    monitors: tuple[Any, Any]
    trace: Any
    counts: tuple[int, int, int, int]


class Cell:
    """A PLC program and a virtual controller, joined by a network, in virtual time.

    Build it with `Cell.build`. At time 0 both are switched on; the link is there as soon as the
    controller has booted. `now_us` is the time up to which all has happened.
    """

    def __init__(
        self,
        program: Program,
        robot: Controller,
        link: Link,
        timing: Timing,
        *,
        m: int = 0,
        n: int = 0,
        seed: int = 0,
        on_loss: str = "hold",
        trace: str | Path | None = None,
        watch: Sequence[str] = (),
        steady: Collection[str] = (),
        notice: str = "",
    ) -> None:
        if on_loss not in ("hold", "clear"):
            raise InputError(f"on_loss is {on_loss!r}", hint="use 'hold' or 'clear'")
        self.robot, self.program, self.timing = robot, program, timing
        self._notice = notice
        self.now_us = 0
        self.scans = 0
        self.cycles = 0
        self.violations: list[Violation] = []
        """All broken rules so far, the PLC's and the controller's, in order of time."""
        self.matched = link.size == robot.config.size
        """Do master and robot agree on the area's size? Without that there is no connection."""
        self._link = link
        self._image = find_image(program, size=link.size, m=m, n=n)
        self._no_area = bytes(link.size)
        self._clear = on_loss == "clear"
        self._agenda, self._network = make_network(link, timing, matched=self.matched, seed=seed)
        self._status = _status_path(program)
        self._watch = tuple(watch)
        for path in self._watch:
            program.read(path)
        self._wire = WireMonitor(link.size)
        self._contract = ContractMonitor(program, steady)
        header: dict[str, Any] = {
            "scan_us": timing.scan_us,
            "cycle_us": CYCLE_US,
            "size": link.size,
        }
        header |= {"engine": program.engine, "link": link.name, "seed": seed}
        self.trace = Trace(header, trace)
        kinds = (Kind.CYCLE, Kind.PRODUCE_TO_ROBOT, Kind.PRODUCE_TO_PLC, Kind.SCAN)
        for kind, phase in zip(kinds, timing.phases, strict=True):
            self._agenda.add(phase, kind)

    @classmethod
    def build(
        cls,
        program: Files,
        *,
        lib: str | Path | None = None,
        scan: Duration | None = None,
        engine: str = "auto",
        link: str = "direct",
        size: int | None = None,
        m: int = 0,
        n: int = 0,
        robot: RobotConfig | str | Path | None = None,
        rpi: Duration = "10ms",
        jitter: Duration = 0,
        timeout: Duration | None = None,
        phases: str | Mapping[str, Duration] = "zero",
        on_loss: str = "hold",
        seed: int = 0,
        trace: str | Path | None = None,
        watch: Sequence[str] = (),
    ) -> Cell:
        """Compile a program with the library and put it into a cell.

        Args:
            program: One ST file or several; those of the library are added.
            lib: Folder of the library, all `.st` below it; default: the library of this package.
            scan: Period of the PLC's scan; default: the configuration's tick, or 10 ms.
            engine: `"auto"`, `"matiec"` or `"builtin"`.
            link: `"direct"` (in process), `"enip"` (EtherNet/IP on the loopback, in lock-step with
                virtual time) or `"enip-realtime"` (its cyclic I/O, at the pace of the clock).
            size: Bytes of the PLC's areas, 48 or 256; default: the robot's.
            m: Where the area from the robot begins in the process image, in bytes.
            n: Where the area to the robot begins, in bytes.
            robot: Properties of the robot, or a file of them.
            rpi: Packet interval in both directions.
            jitter: Greatest delay of a packet.
            timeout: See `Timing.make`.
            phases: See `Timing.make`.
            on_loss: The PLC's inputs without a connection: `"hold"` or `"clear"`.
            seed: Of everything that is drawn: phases, jitter, the controller's delays.
            trace: File for the trace.
            watch: Paths of variables that the trace shows in every scan.

        Raises:
            InputError: anything wrong with the sources or the arguments.
        """
        files = source_files(program, lib)
        if trace is not None:
            check_outputs([trace], files, robot)
        controller = make_robot(robot, size=size, seed=seed)
        built = build_program(files.all, engine)
        compiled = built.program
        try:
            period = scan if scan is not None else compiled.tick_us or "10ms"
            timing = Timing.make(
                scan=period, rpi=rpi, jitter=jitter, timeout=timeout, phases=phases, seed=seed
            )
            wire = make_link(link, controller.config.size if size is None else size, timing)
        except BaseException:
            compiled.close()
            raise
        try:
            return cls(
                compiled,
                controller,
                wire,
                timing,
                m=m,
                n=n,
                seed=seed,
                on_loss=on_loss,
                trace=trace,
                watch=watch,
                steady=steady_instances(files.own, files.lib),
                notice=built.notice,
            )
        except BaseException:
            wire.close()
            compiled.close()
            raise

    # --- variables ---------------------------------------------------------------------------

    def __getitem__(self, path: str) -> Value:
        """The value of a variable, `cell["Main.Servo.Done"]`."""
        return self.program.read(path)

    def __setitem__(self, path: str, value: Value) -> None:
        """Set a variable between two scans."""
        self.program.write(path, value)

    # --- time --------------------------------------------------------------------------------

    def scan(self, n: int = 1) -> None:
        """Let time pass until `n` more scans have run."""
        goal = self.scans + n
        while self.scans < goal:
            self._step()

    def run(self, duration: Duration) -> None:
        """Let `duration` pass: everything before `now + duration` happens."""
        end = self.now_us + parse_us(duration)
        while self._agenda.next_us() < end:
            self._step()
        self.now_us = end

    def run_until(self, predicate: Callable[[], bool], within: Duration) -> int:
        """Scan until `predicate()` is true; it is asked at once and after every scan.

        Returns:
            How long it took, in microseconds.

        Raises:
            CellTimeout: it did not become true within this time.
        """
        start = self.now_us
        end = start + parse_us(within)
        while not predicate():
            goal = self.scans + 1
            while self.scans < goal:
                if self._agenda.next_us() > end:
                    self.now_us = end
                    raise CellTimeout(self._timeout_text(end - start))
                self._step()
        return self.now_us - start

    @contextmanager
    def takes(self, *, scans: int) -> Iterator[None]:
        """Assert that what is inside takes exactly so many scans."""
        before = self.scans
        yield
        took = self.scans - before
        assert took == scans, (
            f"took {took} scans, expected {scans} (until scan {self.scans}, "
            f"{format_us(self.now_us)})"
        )

    # --- surroundings ------------------------------------------------------------------------

    def inject(self, event: str, **args: Any) -> None:
        """Let one of `EVENTS` happen now.

        Raises:
            InputError: no such event, or arguments it does not take.
        """
        if event in ("link_down", "link_up"):
            if args:
                raise InputError(f"{event} takes no arguments, got {', '.join(args)}")
            self._network.set_cable(event == "link_up")
        else:
            self.robot.inject(event, **args)

    def at(self, t_us: int, action: Callable[[], None]) -> None:
        """Call `action` at `t_us`, before anything else that happens then."""
        if t_us < self.now_us:
            raise InputError(f"{format_us(t_us)} has passed; it is {format_us(self.now_us)}")
        self._agenda.add(t_us, Kind.STIMULUS, action)

    @property
    def connected(self) -> bool:
        """The status of the PLC's scanner."""
        return self._network.plc_connected(self.now_us)

    @property
    def notice(self) -> str:
        """A line on the engine that was taken, one on the network; or empty."""
        return "\n".join(filter(None, (self._notice, self._network.notice)))

    @property
    def commands(self) -> int:
        """Remote commands whose end the PLC has read."""
        return self._wire.commands

    # --- state -------------------------------------------------------------------------------

    def snapshot(self) -> object:
        """The state of everything: program, robot, network, time and monitors."""
        return _Snapshot(
            self.program.snapshot(),
            self.robot.snapshot(),
            self._network.snapshot(),
            self._agenda.snapshot(),
            (self._wire.snapshot(), self._contract.snapshot()),
            self.trace.snapshot(),
            (self.now_us, self.scans, self.cycles, len(self.violations)),
        )

    def restore(self, snapshot: object) -> None:
        """Go back to what `snapshot` of this cell gave."""
        assert isinstance(snapshot, _Snapshot), "not a snapshot of a cell"
        self.program.restore(snapshot.program)
        self.robot.restore(snapshot.robot)
        self._network.restore(snapshot.network)
        self._agenda.restore(snapshot.agenda)
        self._wire.restore(snapshot.monitors[0])
        self._contract.restore(snapshot.monitors[1])
        self.trace.restore(snapshot.trace)
        self.now_us, self.scans, self.cycles, found = snapshot.counts
        del self.violations[found:]

    def close(self) -> None:
        """End the connection, write out the trace, free the program."""
        self.trace.close()
        self._link.close()
        self.program.close()

    def __enter__(self) -> Cell:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    # --- what happens ------------------------------------------------------------------------

    def _step(self) -> None:
        now, kind, payload = self._agenda.pop()
        self.now_us = now
        if kind == Kind.CYCLE:
            self._agenda.add(now + CYCLE_US, Kind.CYCLE)
            self._cycle(now)
        elif kind == Kind.SCAN:
            self._agenda.add(now + self.timing.scan_us, Kind.SCAN)
            self._scan(now)
        elif kind == Kind.PRODUCE_TO_ROBOT:
            self._agenda.add(now + self.timing.rpi_us, Kind.PRODUCE_TO_ROBOT)
            self._network.produce_to_robot(now, self._image.get)
        elif kind == Kind.PRODUCE_TO_PLC:
            self._agenda.add(now + self.timing.rpi_us, Kind.PRODUCE_TO_PLC)
            self._network.produce_to_plc(now)
        elif kind == Kind.DELIVER:
            self._network.deliver(now, payload)
        else:
            payload()

    def _cycle(self, now: int) -> None:
        connected = self._network.robot_connected(now)
        si = self._link.robot_read() if connected else None
        so = self.robot.cycle(now, si)
        if self.matched:
            self._link.robot_write(so)
        self._network.set_adapter(self.robot.online)
        self.trace.add(Cycle(now, self.cycles, si or b"", so))
        if self.robot.violations:
            self._report(
                Violation(one.t_us, one.rule, f"robot, cycle {self.cycles}: {one.rule}: {one.text}")
                for one in self.robot.drain_violations()
            )
        self.cycles += 1

    def _scan(self, now: int) -> None:
        connected = self._network.plc_connected(now)
        so = self._no_area if self._clear and not connected else self._network.input
        if self._status is not None:
            self.program.write(self._status, connected)
        self._image.put(so)
        self.program.scan(now)
        si = self._image.get()
        self._network.scanned(si)
        number, self.scans = self.scans, self.scans + 1
        watched = {path: self.program.read(path) for path in self._watch} if self._watch else None
        self.trace.add(Scan(now, number, so, si, watched))
        self._report(self._wire.scan(now, number, so, si, connected))
        self._report(self._contract.scan(now, number))

    def _report(self, found: Iterator[Violation] | list[Violation]) -> None:
        for violation in found:
            self.violations.append(violation)
            self.trace.add(Finding(violation.t_us, violation.text))

    def _timeout_text(self, waited_us: int) -> str:
        text = f"not within {format_us(waited_us)} (scan {self.scans}, {format_us(self.now_us)})"
        for path in self._watch:
            text += f"; {path} = {self.program.read(path)}"
        if self.violations:
            text += f"; last violation: {self.violations[-1].text}"
        return text


def _status_path(program: Program) -> str | None:
    """`Main.Connected`, if a program has such a BOOL."""
    for name, kind in program.instances().items():
        assert isinstance(kind, BlockType)
        for variable in kind.variables:
            if variable.name.lower() == "connected" and variable.type == ElementaryType("BOOL"):
                return f"{name}.{variable.name}"
    return None
