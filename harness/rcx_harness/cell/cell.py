"""One PLC, its robots, the network between them, on one virtual clock."""

from __future__ import annotations

import sys
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn, cast

from rcx_harness.cell.build import Areas, Robots, check_outputs, make_agenda, make_members, several
from rcx_harness.cell.clock import Agenda, Duration, Kind, Timing
from rcx_harness.cell.compiled import Compiled
from rcx_harness.cell.image import Image, find_image
from rcx_harness.cell.link import Link, Network, PacketNetwork
from rcx_harness.cell.node import Member, Node
from rcx_harness.cell.plc import Plc
from rcx_harness.cell.sources import source_files
from rcx_harness.cell.surroundings import EVENTS as SURROUNDINGS
from rcx_harness.cell.surroundings import befall, check
from rcx_harness.cell.watched import Watched
from rcx_harness.robot import EVENTS as ROBOT_EVENTS
from rcx_harness.robot import Controller, Violation
from rcx_harness.robot.positions import axes_of
from rcx_harness.robot.shape import shapes
from rcx_harness.spec.wire import CYCLE_US
from rcx_harness.trace import KEPT, Trace
from rcx_harness.watch.calls_source import CallPlan
from structured_text.engines.base import Program, Value
from structured_text.errors import InputError
from structured_text.projects.sources import Files
from structured_text.units import format_us, parse_us, whole

if TYPE_CHECKING:
    from rcx_harness.cell.elsewhere import Elsewhere

__all__ = ["EVENTS", "Cell", "CellTimeout"]

#: What `Cell.inject` and a stimulus can let happen, with a line of help.
EVENTS: dict[str, str] = {**SURROUNDINGS, **ROBOT_EVENTS}

#: A time, or a number of scans, that does not come.
_NEVER = sys.maxsize
#: More scans than any run has, and a delay that no scan has [us].
_MOST_SCANS, _LONGEST_US = 10**10, 365 * 86_400_000_000
#: The largest seed of a command, and of the last of its storms.
_SEED = 2**64


class CellTimeout(AssertionError):  # noqa: N818 - a failed assertion, not a fault of the cell
    """What a test waited for did not come within its time."""


class _ClosedProgram:
    """In place of a cell's program after `close`: a compiled one has no memory then."""

    def __getattr__(self, name: str) -> NoReturn:
        raise _closed()


def _keep() -> None:
    """What was compiled by others is theirs."""


def _closed() -> InputError:
    """The error of everything that a closed cell cannot do."""
    return InputError("the cell is closed", hint="read and scan before close(), inside the `with`")


class _Snapshot(NamedTuple):
    program: object
    agenda: Any
    nodes: tuple[object, ...]
    plc: Any
    trace: Any
    counts: tuple[int, int, int]
    timing: Timing


class Cell:
    """A PLC program and a virtual controller, joined by a network, in virtual time.

    Build it with `Cell.build`. At time 0 both are switched on; the link is there as soon as the
    controller has booted. `now_us` is the time up to which all has happened. A PLC may have
    `further` controllers, each with a link and with areas of its own.
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
        self.robot, self.program, self.timing = robot, program, timing
        self.robots = (robot, *(member.robot for member in further))
        """All controllers; the first is `robot`."""
        self.closed = False
        """After `close`."""
        self._notice, self._leave = notice, leave or program.close
        self.mistakes = mistakes
        """What the source of the program is warned of, a line each; in `notice`, too."""
        self.now_us = 0
        self.scans = 0
        self.violations: list[Violation] = []
        """All broken rules so far, the PLC's and the controllers', in order of time."""
        self._watch = Watched(program, watch)
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
        self.trace = Trace(
            header, trace, keep=keep, watched=self._watch.types, axes=axes, robots=drawn
        )
        self._agenda = Agenda() if agenda is None else agenda
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
        self._agenda.repeat(timing.phases[-1], Kind.SCAN, timing.scan_us, self._scan)
        self.plc = Plc(program, steady, calls or CallPlan({}, {}), retained)
        """STOP and RUN, power, and what a start leaves."""
        self._wanted = False

    @classmethod
    def build(
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
        connect: Elsewhere | None = None,
        keep: int = KEPT,
        through: Callable[[Program], Program] = lambda program: program,
    ) -> Cell:
        """Compile a program with the library and put it into a cell.

        Args:
            program: One ST file or project file, or several; those of the library are added. Or
                what was compiled of them: it is taken from its beginning, and outlives the cell.
            lib: Folder of the library, all `.st` below it; default: the library of this package.
            scan: Period of the PLC's scan; default: the configuration's tick, or 10 ms.
            engine: `"auto"`, `"matiec"`, `"builtin"` or `"strucpp"`.
            link: `"direct"` (in process), `"enip"` (EtherNet/IP on the loopback, in lock-step with
                virtual time) or `"enip-realtime"` (its cyclic I/O, at the pace of the clock).
            size: Bytes of the PLC's areas, 48 or 256; default: the robot's.
            m: Where the area from the robot begins in the process image, in bytes. Of several
                robots one for each; those left out follow the area before.
            n: Where the area to the robot begins; as for m.
            robot: Properties of the robot, or a file of them; or several, each with its areas.
            rpi: Packet interval in both directions.
            jitter: Greatest delay of a packet.
            timeout: See `Timing.make`.
            phases: See `Timing.make`.
            on_loss: The PLC's inputs without a connection: `"hold"` or `"clear"`.
            seed: Of everything that is drawn: phases, jitter, the controllers' delays.
            trace: File for the trace; that of an earlier run is written over.
            watch: Variables that the trace shows in every scan: paths, or patterns with `*`.
            positions: `"pulses"` or `"mm"`: the trace shows where the robots are.
            replace: ST files for POUs of a project, by the POU's name.
            connect: A controller that runs elsewhere, instead of a virtual one; `link` and `robot`
                are then none of the cell's.
            keep: How many records of the trace stay in memory; each snapshot has them.
            through: Puts something around the program that sees all that the cell does with it.

        Raises:
            InputError: anything wrong with the sources or the arguments; the controller elsewhere
                is not there, or refuses.
        """
        whole("seed", seed, 0, _SEED)
        whole("keep", keep, 0, sys.maxsize)
        if isinstance(program, Compiled):
            compiled, leave = program, _keep
            compiled.fresh()
        else:
            files = source_files(program, lib, replace)
            check_outputs({"trace": trace}, files, *several(robot))
            compiled = Compiled.take(files, engine)
            leave = compiled.leave
        try:
            period = scan if scan is not None else compiled.program.tick_us or "10ms"
            timing = Timing.make(
                scan=period, rpi=rpi, jitter=jitter, timeout=timeout, phases=phases, seed=seed
            )
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
                notice=compiled.notice,
                mistakes=compiled.mistakes,
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

    # --- variables ---------------------------------------------------------------------------

    def __getitem__(self, path: str) -> Value:
        """The value of a variable, `cell["Main.Servo.Done"]`."""
        return self.program.read(path)

    def __setitem__(self, path: str, value: Value) -> None:
        """Set a variable between two scans."""
        self.program.write(path, value)
        self.plc.note(path)

    def watched(self) -> dict[str, str]:
        """The watched variables as they stand in Structured Text, by path.

        Structures and arrays are given by their members and elements. After `close` it is how the
        run ended.
        """
        return self._watch.texts()

    # --- time --------------------------------------------------------------------------------

    def scan(self, n: int = 1) -> None:
        """Let time pass until `n` more scans have run.

        Raises:
            InputError: `n` is no number of scans; no scan comes, for the PLC is in STOP or has no
                power.
        """
        goal = self.scans + whole("the number of scans", n, 0, _MOST_SCANS)
        self._wanted = True
        try:
            self._pass(_NEVER, goal)
        finally:
            self._wanted = False

    def run(self, duration: Duration) -> None:
        """Let `duration` pass: everything before `now + duration` happens."""
        end = self.now_us + parse_us(duration)
        self._pass(end)
        self.now_us = end

    def run_until(self, predicate: Callable[[], bool], within: Duration) -> int:
        """Scan until `predicate()` is true; it is asked at once and after every scan.

        Returns:
            How long it took, in microseconds.

        Raises:
            CellTimeout: it did not become true within this time.
            InputError: `predicate` is no function.
        """
        if not callable(predicate):
            hint = 'write run_until(lambda: cell["Main.Done"], within="1s")'
            raise InputError(f"run_until needs a function, not {predicate!r:.40}", hint=hint)
        start = self.now_us
        end = start + parse_us(within)
        while not predicate():
            goal = self.scans + 1
            self._pass(end + 1, goal)
            if self.scans < goal:
                self.now_us = end
                raise CellTimeout(self._timeout_text(end - start))
        return self.now_us - start

    @contextmanager
    def takes(self, *, scans: int) -> Iterator[None]:
        """Assert that what is inside takes exactly so many scans."""
        whole("scans", scans, 0, _MOST_SCANS)
        before = self.scans
        yield
        took = self.scans - before
        assert took == scans, (
            f"took {took} scans, expected {scans} (until scan {self.scans}, "
            f"{format_us(self.now_us)})"
        )

    # --- surroundings ------------------------------------------------------------------------

    def inject(self, event: str, *, controller: int = 1, **args: Any) -> None:
        """Let one of `EVENTS` happen now to a controller or its link.

        Raises:
            InputError: no such event or controller, or arguments it does not take.
        """
        node = self._node(controller)
        if not isinstance(event, str):
            raise InputError(f"{event!r:.40} is no event", hint='write inject("emergency_stop")')
        self.check_near()
        if event in SURROUNDINGS:
            befall(self, event, controller, args)
        else:
            node.robot.inject(event, **args)

    def set_cable(self, up: bool, controller: int = 1) -> None:
        """Plug or unplug a controller's network cable."""
        self._node(controller).network.set_cable(up)

    def network_of(self, controller: int) -> Network:
        """The network between the PLC and a controller."""
        return self._node(controller).network

    def stop_plc(self, *, power: bool = False) -> None:
        """The PLC goes into STOP, or loses its power: no scan runs, its connections end.

        Raises:
            InputError: the network is a real one.
        """
        for network in self._networks():
            network.set_plc(False)
        self.plc.stop(power=power)

    def start_plc(self, start: str = "warm") -> None:
        """The PLC goes into RUN; one that runs already is started anew.

        Args:
            start: `"warm"`: all variables begin anew but those that are retained; `"cold"`: all
                of them; `"continue"`: none, as it stands.
        """
        check("plc_run", {"start": start})
        for network in self._networks():
            network.set_plc(False)
            network.set_plc(True)
        if start != "continue" or not self.plc.powered:
            for node in self._nodes:
                node.begin_anew()
        self.plc.start(start)

    def overrun(self, late_us: int) -> None:
        """The PLC's next scan, and with it all that follow, come so much later [us]."""
        self._agenda.delay(Kind.SCAN, whole("late_us", late_us, 0, _LONGEST_US))

    def change_interval(self, rpi_us: int) -> None:
        """From now on packets go in this interval [us]."""
        self.timing = self.timing.with_rpi(rpi_us)
        for network in self._networks():
            network.change_interval(self.timing)
        for kind in (Kind.PRODUCE_TO_ROBOT, Kind.PRODUCE_TO_PLC):
            self._agenda.periods[kind] = rpi_us

    def _networks(self) -> list[PacketNetwork]:
        found = [one.network for one in self._nodes if isinstance(one.network, PacketNetwork)]
        if len(found) < len(self._nodes):
            hint = "run it without --realtime and --connect"
            raise InputError("that befalls a PLC in virtual time only", hint=hint)
        return found

    def give_area(self, area: bytes | None, connected: bool = True, *, controller: int = 1) -> None:
        """Let the PLC read these bytes from its next scan on, instead of a controller's answer.

        Args:
            area: The first bytes of its input area, the others are 0; None: the answer again.
            connected: What its scanner says of the connection meanwhile.
            controller: Whose area it is, from 1.

        Raises:
            InputError: no such controller, or more bytes than the area has.
        """
        self._node(controller).give_area(area, connected)

    def check_near(self) -> None:
        """Refuse what only a virtual controller can be asked for (InputError)."""
        if any(node.far for node in self._nodes):
            hint = "leave events, hold and release out"
            raise InputError("nothing befalls a controller that runs elsewhere", hint=hint)

    def _node(self, controller: int) -> Node:
        number = isinstance(controller, int) and not isinstance(controller, bool)
        if not number or not 1 <= controller <= len(self._nodes):
            raise InputError(f"no controller {controller!r}; the cell has {len(self._nodes)}")
        return self._nodes[controller - 1]

    def at(self, t_us: int, action: Callable[[], None]) -> None:
        """Call `action` at `t_us`, before anything else that happens then."""
        whole("t_us", t_us, 0, _NEVER)
        if t_us < self.now_us:
            raise InputError(f"{format_us(t_us)} has passed; it is {format_us(self.now_us)}")
        self._agenda.add(t_us, Kind.STIMULUS, lambda _: action())

    @property
    def connected(self) -> bool:
        """The status of the PLC's scanner: it is connected to every controller."""
        return all(node.network.plc_connected(self.now_us) for node in self._nodes)

    @property
    def matched(self) -> bool:
        """Do PLC and robots agree on the areas' sizes? Without that there is no connection."""
        return all(node.matched for node in self._nodes)

    @property
    def images(self) -> list[Image]:
        """The areas of each controller in the PLC's process image."""
        return [node.image for node in self._nodes]

    @property
    def areas(self) -> list[tuple[int, int, int]]:
        """Of each controller the size of its areas, and where they begin: m and n, in bytes."""
        return [(node.link.size, node.m, node.n) for node in self._nodes]

    @property
    def notice(self) -> str:
        """A line on the engine that was taken, one on the network; or empty."""
        return "\n".join(filter(None, (self._notice, self._agenda.notice)))

    @property
    def commands(self) -> int:
        """Remote commands whose end the PLC has read."""
        return sum(node.wire.commands for node in self._nodes)

    @property
    def cycles(self) -> int:
        """Cycles of the controllers."""
        return sum(node.cycles for node in self._nodes)

    # --- state -------------------------------------------------------------------------------

    def snapshot(self) -> object:
        """The state of everything: program, robot, network, time and monitors."""
        return _Snapshot(
            self.program.snapshot(),
            self._agenda.snapshot(),
            tuple(node.snapshot() for node in self._nodes),
            self.plc.snapshot(),
            self.trace.snapshot(),
            (self.now_us, self.scans, len(self.violations)),
            self.timing,
        )

    def restore(self, snapshot: object) -> None:
        """Go back to what `snapshot` of this cell gave."""
        assert isinstance(snapshot, _Snapshot), "not a snapshot of a cell"
        self.program.restore(snapshot.program)
        self._agenda.restore(snapshot.agenda)
        for node, state in zip(self._nodes, snapshot.nodes, strict=True):
            node.restore(state)
        self.plc.restore(snapshot.plc)
        self.trace.restore(snapshot.trace)
        self.now_us, self.scans, found = snapshot.counts
        self.timing = snapshot.timing
        del self.violations[found:]

    def close(self) -> None:
        """End the connection, write out the trace, free the program.

        Afterwards the trace and `violations` can still be read; time, variables and snapshots
        raise `InputError`.
        """
        if self.closed:
            return
        self._watch.keep()
        self.trace.close()
        for node in self._nodes:
            node.link.close()
        self._leave()
        self.closed = True
        self.program = cast(Program, _ClosedProgram())

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

    def _pass(self, end: int, scans: int = _NEVER) -> None:
        """Let everything before `end` happen, or all until so many scans have run."""
        agenda = self._agenda
        while self.scans < scans:
            if self.closed:
                raise _closed()
            if agenda.first()[0] >= end:
                return
            self.now_us, action = agenda.pop()
            action(self.now_us)

    def _scan(self, now: int) -> None:
        if not self.plc.runs:
            if self._wanted:
                hint = "use cell.run(), or let plc_run or plc_power_on happen"
                raise InputError("the PLC does not run: no scan comes", hint=hint)
            return
        for node in self._nodes:
            node.before_scan(now)
        self.program.scan(now)
        number, self.scans = self.scans, self.scans + 1
        watched = self._watch.values() if self._watch.types else None
        for node in self._nodes:
            node.after_scan(now, number, watched if node is self._first else None)
        if found := self.plc.judge(now, number):
            self.report(found)

    def report(self, found: Iterable[Violation]) -> None:
        """Note rules that were broken."""
        for violation in found:
            self.violations.append(violation)
            self.trace.add(violation)

    def _timeout_text(self, waited_us: int) -> str:
        text = f"not within {format_us(waited_us)} (scan {self.scans}, {format_us(self.now_us)})"
        for path, value in self._watch.values().items():
            text += f"; {path} = {value}"
        if self.violations:
            text += f"; last violation: {self.violations[-1].text}"
        return "\n".join((text, *self.mistakes))
