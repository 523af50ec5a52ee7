"""The cell: one PLC, its robots, and the network between them, on one virtual clock."""

from __future__ import annotations

import sys
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rcx_harness.cell.build import Areas, Robots, make_agenda, make_members, several
from rcx_harness.cell.clock import Kind, Timing
from rcx_harness.cell.compiled import Compiled
from rcx_harness.cell.counted_programs import count_programs
from rcx_harness.cell.image import Image, find_image
from rcx_harness.cell.link import Link, Network, PacketNetwork
from rcx_harness.cell.node import Member, Node
from rcx_harness.cell.sources import source_files
from rcx_harness.cell.surroundings import EVENTS as SURROUNDINGS
from rcx_harness.cell.surroundings import befall, check
from rcx_harness.robot import EVENTS as ROBOT_EVENTS
from rcx_harness.robot import Controller
from rcx_harness.robot.listing import listings
from rcx_harness.robot.positions import axes_of
from rcx_harness.robot.shape import shapes
from rcx_harness.spec.wire import CYCLE_US
from rcx_harness.trace import KEPT, Scan, Trace
from rcx_harness.watch.calls import CallMonitor
from rcx_harness.watch.calls_source import CallPlan
from rcx_harness.watch.contract import ContractMonitor
from structured_text.bench import Bench, BenchTimeout
from structured_text.bench.agenda import Agenda, Duration
from structured_text.bench.outputs import check_outputs
from structured_text.bench.plc import Plc
from structured_text.bench.watched import Watched
from structured_text.engines.base import Program
from structured_text.errors import InputError
from structured_text.output.units import whole
from structured_text.projects.sources import Files

__all__ = ["EVENTS", "Cell", "CellTimeout"]

if TYPE_CHECKING:
    from rcx_harness.cell.elsewhere import Elsewhere

#: Maps each event of `Cell.inject` and of a stimulus to a line of help.
EVENTS: dict[str, str] = {**SURROUNDINGS, **ROBOT_EVENTS}

#: The largest seed that a cell accepts. It is larger than the largest seed that a command accepts,
#: because a campaign counts up from that seed.
_SEED = 2**64


class CellTimeout(BenchTimeout):
    """The error for a condition that does not become true within the time of a test."""


def _keep() -> None:
    """Do not close the program, because the caller has compiled it and may use it again."""


class _Snapshot(NamedTuple):
    bench: object
    nodes: tuple[object, ...]
    timing: Timing


class Cell(Bench):
    """A PLC program and a virtual controller, connected by a network, in virtual time.

    Build it with `Cell.build`. At time 0 both are switched on; the link is up as soon as the
    controller has booted. `now_us` is the time up to which the cell has been simulated. A PLC may
    have `further` controllers, each with its own link and its own areas.
    """

    place, late = "cell", CellTimeout
    trace: Trace

    def __init__(
        self,
        program: Program,
        robot: Controller,
        link: Link,
        timing: Timing,
        *,
        m: int = 0,
        n: int = 0,
        far: bool = False,
        further: Sequence[Member] = (),
        seed: int = 0,
        on_loss: str = "hold",
        trace: str | Path | None = None,
        watch: str | Sequence[str] = (),
        positions: str = "",
        steady: Collection[str] = (),
        calls: CallPlan | None = None,
        notice: str = "",
        mistakes: Sequence[str] = (),
        located: bool = False,
        agenda: Agenda | None = None,
        keep: int = KEPT,
        retained: Sequence[str] = (),
        leave: Callable[[], None] | None = None,
    ) -> None:
        if on_loss not in ("hold", "clear"):
            raise InputError(f"on_loss is {on_loss!r}", hint="use 'hold' or 'clear'")
        self.robot, self.timing = robot, timing
        self.robots = (robot, *(member.robot for member in further))
        """All controllers; the first is `robot`."""
        watched = Watched(program, watch)
        header: dict[str, Any] = {
            "scan_us": timing.scan_us,
            "cycle_us": CYCLE_US,
            "size": link.size,
        }
        header |= {"engine": program.engine, "link": link.name, "seed": seed}
        if further:
            header["controllers"] = len(self.robots)
        members = [Member(robot, link, m, n, far), *further]
        images = [
            find_image(program, size=one.link.size, m=one.m, n=one.n, located=located)
            for one in members
        ]
        axes = axes_of(self.robots, positions)
        drawn = [shapes(one) for one in self.robots] if axes else ()
        self._calls = CallMonitor(program, calls or CallPlan({}, {}))
        super().__init__(
            program,
            timing.scan_us,
            watched=watched,
            trace=Trace(
                header,
                trace,
                keep=keep,
                watched=watched.types,
                axes=axes,
                robots=drawn,
                programs=[listings(one) for one in self.robots],
            ),
            plc=Plc(
                program,
                retained,
                (ContractMonitor(program, steady), self._calls),
            ),
            first_us=timing.phases[-1],
            notice=notice,
            mistakes=mistakes,
            agenda=agenda,
            leave=leave,
        )
        self._nodes = [
            Node(
                number,
                member,
                image,
                program,
                timing,
                self._agenda,
                self.trace,
                self.report,
                seed=seed + number - 1,
                clear=on_loss == "clear",
                positions=positions,
            )
            for number, (member, image) in enumerate(zip(members, images, strict=True), 1)
        ]
        self._first = self._nodes[0]

    @classmethod
    def build(  # type: ignore[override]
        cls,
        program: Files | Compiled,
        *,
        lib: str | Path | None = None,
        scan: Duration | None = None,
        engine: str = "auto",
        link: str = "direct",
        size: int | None = None,
        m: Areas = 0,
        n: Areas = 0,
        robot: Robots = None,
        rpi: Duration = "10ms",
        jitter: Duration = 0,
        timeout: Duration | None = None,
        phases: str | Mapping[str, Duration] = "zero",
        on_loss: str = "hold",
        seed: int = 0,
        trace: str | Path | None = None,
        watch: str | Sequence[str] = (),
        positions: str = "",
        replace: Mapping[str, str | Path] | None = None,
        dialect: str | None = None,
        device: str = "",
        connect: Elsewhere | None = None,
        keep: int = KEPT,
        through: Callable[[Program], Program] = lambda program: program,
    ) -> Cell:
        """Compile a program with the library and put it into a cell.

        Args:
            program: ST file or project file, or several; files of the library are added. Or a
                compiled program, which is restarted and stays usable after the cell.
            lib: Folder of the library, all `.st` below it; default: the library of this package.
            scan: Period of the PLC's scan; default: the configuration's tick, or 10 ms.
            engine: `"auto"`, `"matiec"`, `"builtin"` or `"strucpp"`.
            link: `"direct"` (in process), `"enip"` (EtherNet/IP on the loopback, in lock-step with
                virtual time) or `"enip-realtime"` (its cyclic I/O, at the pace of the clock).
            size: Bytes of the PLC's areas, 48 or 256; default: the robot's.
            m: Offset of the area from the robot in the process image, in bytes. For several
                robots a list; areas without an offset follow the previous area.
            n: Offset of the area to the robot; as for m.
            robot: Properties of the robot, or a robot file; for several robots a list.
            rpi: Packet interval in both directions.
            jitter: Greatest delay of a packet.
            timeout: See `Timing.make`.
            phases: See `Timing.make`.
            on_loss: The PLC's inputs without a connection: `"hold"` or `"clear"`.
            seed: Seed of all random values: phases, jitter, the controllers' delays.
            trace: File for the trace; the trace of an earlier run is overwritten.
            watch: Variables that the trace shows in every scan: paths, or patterns with `*`.
            positions: `"pulses"` or `"mm"`: the trace records the positions of the robots.
            replace: ST files for POUs of a project, by the POU's name.
            dialect: The PLC tool whose behaviour the program gets; default: the tool of the
                project's format, or plain Structured Text.
            device: The device to read if a project has several devices.
            connect: An external controller instead of a virtual controller; `robot` must then be
                None, and `link` is not used.
            keep: Number of trace records in memory; each snapshot contains them.
            through: Function that wraps the program in an object through which the cell accesses
                it.

        Raises:
            InputError: the sources or the arguments are wrong, or the external controller does not
                answer or refuses.
        """
        whole("seed", seed, 0, _SEED)
        whole("keep", keep, 0, sys.maxsize)
        if isinstance(program, Compiled):
            compiled, leave = program, _keep
            compiled.fresh()
        else:
            files = source_files(program, lib, replace, dialect, device)
            check_outputs({"trace": trace}, files, *several(robot))
            compiled = Compiled.take(files, engine)
            leave = compiled.leave
        try:
            period = scan if scan is not None else compiled.program.tick_us or "10ms"
            timing = Timing.make(
                scan=period, rpi=rpi, jitter=jitter, timeout=timeout, phases=phases, seed=seed
            )
            compiled.program.pace(timing.scan_us)
            members = make_members(
                *(robot, link),
                size=size,
                m=m,
                n=n,
                timing=timing,
                seed=seed,
                connect=connect,
            )
        except BaseException:
            leave()
            raise
        first, *further = members
        try:
            mistakes = compiled.warned(timing.rpi_us, timing.jitter_us)
            count_programs([member.robot for member in members])
            return cls(
                through(compiled.program),
                first.robot,
                first.link,
                timing,
                m=first.m,
                n=first.n,
                far=first.far,
                further=further,
                seed=seed,
                on_loss=on_loss,
                trace=trace,
                watch=watch,
                positions=positions,
                steady=compiled.steady,
                calls=compiled.calls,
                notice="\n".join(filter(None, (compiled.notice, *mistakes))),
                mistakes=mistakes,
                located=compiled.located,
                retained=compiled.retained,
                leave=leave,
                agenda=make_agenda(link, connect),
                keep=keep,
            )
        except BaseException:
            for member in members:
                member.link.close()
            leave()
            raise

    # --- surroundings ------------------------------------------------------------------------

    def inject(self, event: str, *, controller: int = 1, **args: Any) -> None:
        """Inject one of `EVENTS` now into a controller or its link."""
        node = self._node(controller)
        if not isinstance(event, str):
            hint = 'write inject("emergency_stop")'
            raise InputError(f"{event!r:.40} is not an event", hint=hint)
        self.check_near()
        if event in SURROUNDINGS:
            befall(self, event, controller, args)
        else:
            node.robot.inject(event, **args)

    def set_cable(self, up: bool, controller: int = 1) -> None:
        """Plug or unplug a controller's network cable."""
        self._node(controller).network.set_cable(up)

    def network_of(self, controller: int) -> Network:
        """Return the network between the PLC and a controller."""
        return self._node(controller).network

    def stop_plc(self, *, power: bool = False) -> None:
        """Put the PLC into STOP or switch it off. No scan runs, and the PLC's connections end."""
        for network in self._networks():
            network.set_plc(False)
        super().stop_plc(power=power)

    def start_plc(self, start: str = "warm") -> None:
        """Put the PLC into RUN; a running PLC is restarted.

        Args:
            start: `"warm"`: initialise all variables except retained ones; `"cold"`: initialise all
                variables; `"continue"`: keep all values.
        """
        check("plc_run", {"start": start})
        for network in self._networks():
            network.set_plc(False)
            network.set_plc(True)
        if start != "continue" or not self.plc.powered:
            for node in self._nodes:
                node.begin_anew()
        super().start_plc(start)

    def change_interval(self, rpi_us: int) -> None:
        """Change the packet interval of a controller [us] from now on."""
        self.timing = self.timing.with_rpi(rpi_us)
        for network in self._networks():
            network.change_interval(self.timing)
        for kind in (Kind.PRODUCE_TO_ROBOT, Kind.PRODUCE_TO_PLC):
            self._agenda.periods[kind] = rpi_us

    def _networks(self) -> list[PacketNetwork]:
        found = [one.network for one in self._nodes if isinstance(one.network, PacketNetwork)]
        if len(found) < len(self._nodes):
            hint = "run it without --realtime and --connect"
            raise InputError("packet intervals can be changed in virtual time only", hint=hint)
        return found

    def give_area(self, area: bytes | None, connected: bool = True, *, controller: int = 1) -> None:
        """From the next scan on, let the PLC read `area` instead of a controller's answer.

        Args:
            area: The first bytes of the PLC's input area; further bytes are 0. None: the
                controller's answer.
            connected: The connection status that the PLC's scanner shows while the PLC reads the
                bytes of `area`.
            controller: The number of the controller, from 1.
        """
        self._node(controller).give_area(area, connected)

    def check_near(self) -> None:
        """Raise InputError if a controller is external, and so supports neither events nor hold."""
        if any(node.far for node in self._nodes):
            hint = "leave events, hold and release out"
            raise InputError(
                "an external controller accepts neither events nor hold and release", hint=hint
            )

    def _node(self, controller: int) -> Node:
        number = isinstance(controller, int) and not isinstance(controller, bool)
        if not number or not 1 <= controller <= len(self._nodes):
            raise InputError(
                f"there is no controller {controller!r}; the cell has {len(self._nodes)}"
            )
        return self._nodes[controller - 1]

    @property
    def connected(self) -> bool:
        """Return whether the PLC's scanner is connected to every controller."""
        return all(node.network.plc_connected(self.now_us) for node in self._nodes)

    @property
    def matched(self) -> bool:
        """Return whether the areas of PLC and robots have equal sizes, as a connection requires."""
        return all(node.matched for node in self._nodes)

    @property
    def images(self) -> list[Image]:
        """Return the areas of each controller in the PLC's process image."""
        return [node.image for node in self._nodes]

    @property
    def areas(self) -> list[tuple[int, int, int]]:
        """Return for each controller the size of its areas and their offsets m and n, in bytes."""
        return [(node.link.size, node.m, node.n) for node in self._nodes]

    def exchanged(self) -> list[tuple[bytes, bytes]]:
        """Return for each controller the areas that the PLC read and wrote in the last scan."""
        return [node.exchanged for node in self._nodes]

    @property
    def commands(self) -> int:
        """Return the number of remote commands whose end status the PLC has read."""
        return sum(node.wire.commands for node in self._nodes)

    @property
    def cycles(self) -> int:
        """Return the number of controller cycles, over all controllers."""
        return sum(node.cycles for node in self._nodes)

    @contextmanager
    def trying(self) -> Iterator[None]:
        """Undo all changes of the `with` block at its end; no virtual time passes in the block."""
        before = [robot.snapshot() for robot in self.robots]
        try:
            with super().trying():
                yield
        finally:
            for robot, state in zip(self.robots, before, strict=True):
                robot.restore(state)

    @contextmanager
    def trial_of_program(self) -> Iterator[None]:
        """Undo all scans of the program in the `with` block at its end."""
        before = self.program.snapshot()
        with self._calls.apart():
            try:
                yield
            finally:
                self.program.restore(before)

    def ends_scan(self, record: object) -> bool:
        """Return whether a record of the trace is the first of the records of a scan."""
        return isinstance(record, Scan) and record.controller == 1

    # --- state -------------------------------------------------------------------------------

    def snapshot(self) -> object:
        """Return the complete state: program, robots, network, time and monitors."""
        nodes = tuple(node.snapshot() for node in self._nodes)
        return _Snapshot(super().snapshot(), nodes, self.timing)

    def restore(self, snapshot: object) -> None:
        """Restore the state of a snapshot of this cell."""
        assert isinstance(snapshot, _Snapshot), "not a snapshot of a cell"
        super().restore(snapshot.bench)
        for node, state in zip(self._nodes, snapshot.nodes, strict=True):
            node.restore(state)
        self.timing = snapshot.timing

    def _part(self) -> None:
        for node in self._nodes:
            node.link.close()

    # --- before and after a scan --------------------------------------------------------------

    def _before_scan(self, now: int) -> None:
        for node in self._nodes:
            node.before_scan(now)

    def _after_scan(self, now: int, number: int, watched: dict[str, Any] | None) -> None:
        for node in self._nodes:
            node.after_scan(now, number, watched if node is self._first else None)
