"""Running, stepping and stopping, forwards and backwards; a `Front` talks to the user.

A scan first runs fast: only lines with breakpoints are traced. If something may stop in it, the
debugger restores the beginning of the scan and runs it again, now with a hook before every
statement. Going back works the same way: the player restores the nearest snapshot before the wanted
moment and runs forwards from there. Both methods rely on a deterministic machine.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from types import FrameType
from typing import Any

from structured_text.debug.breakpoints import Breakpoint, DataWatch
from structured_text.debug.devices import DeviceBreakpoint, DeviceStep
from structured_text.debug.orders import Back, Forward, Front, Order, Quit, Stop
from structured_text.debug.places import Code
from structured_text.debug.player import Moment, Player
from structured_text.debug.values import ProgramVariables
from structured_text.errors import InputError
from structured_text.output.units import format_us

__all__ = ["Debugger"]


#: Stands for the number of the first statement of the PLC's program in a scan. Lines of devices may
#: precede this statement.
_FIRST = -1


class _Leave(BaseException):
    """An exception that leaves a scan in its middle, because the user gave another order."""

    def __init__(self, order: Order) -> None:
        self.order = order


class _Hit(BaseException):
    """An exception that leaves a fast scan at a stop.

    After it, the scan is repeated with a hook before every statement.
    """


@dataclass
class _Step:
    """A step of the user: the moment at which the step began, and the user's order."""

    order: Forward
    scan: int
    depth: int
    roots: int


@dataclass
class Debugger:
    """One run under the debugger.

    Attributes:
        player: The player that moves the run in time.
        memory: The program's variables.
        front: The user interface.
        breakpoints: The breakpoints of the user.
        watches: Variables that stop the run when they change.
        rules: Whether the run stops after a scan in which a rule is broken.
        pausing: Whether the user has requested a pause.
    """

    player: Player
    memory: ProgramVariables
    front: Front
    breakpoints: list[Breakpoint] = field(default_factory=list)
    watches: list[DataWatch] = field(default_factory=list)
    rules: bool = True
    pausing: bool = False
    _going: _Step = field(default_factory=lambda: _Step(Forward(), 0, 0, 0))
    _target: tuple[int, Stop] | None = None
    _said: int = 0
    _unsaid: int = 0
    _quiet: bool = False

    def run(self, first: Order) -> None:
        """Execute orders until the user quits."""
        order = first
        while not isinstance(order, Quit):
            try:
                order = self._obeyed(order)
            except _Leave as leave:
                order = leave.order

    def _obeyed(self, order: Forward | Back) -> Order:
        return self._forward(order) if isinstance(order, Forward) else self._back(order)

    def go_to(self, at: Moment, stop: Stop) -> Order:
        """Go to a moment and stop there."""
        self._quiet = True
        self.player.seek(at.scan, self._poll)
        self._quiet = False
        if not at.step:
            return self._stop(stop)
        self._target = at.step, stop
        return self._on()

    # --- forwards ---

    def _forward(self, order: Forward) -> Order:
        depth = self._depth_of(order.task) if order.task else self.player.tracer.step and 1
        self._going = _Step(order, self.player.machine.scans, depth, 0)
        return self._on()

    def _depth_of(self, task: int) -> int:
        """Return the call depth of a device's task."""
        devices = self.player.machine.devices
        return len(devices.stack(task)) if devices is not None else 1

    def _on(self) -> Order:
        machine = self.player.machine
        while True:
            self._poll()
            if self.pausing:
                self.pausing = False
                return self._stop(Stop("pause"))
            if self._target is None and machine.ended:
                text = machine.ended
                again = self._stop(Stop("pause", text))
                return Quit() if isinstance(again, Forward) else again
            found = self._scan()
            if found is not None:
                return self._stop(found)

    def _stop(self, stop: Stop) -> Order:
        return self.front.wait(stop)

    def _poll(self) -> None:
        quitting = self.front.poll()
        if quitting is not None:
            raise _Leave(quitting)

    def _scan(self) -> Stop | None:
        """Run the next scan, and return the reason to stop after it, if any."""
        machine, scan = self.player.machine, self.player.machine.scans
        broken = len(machine.violations)
        self._begin(scan)
        self._said = self._unsaid = 0
        try:
            looking = self._target is not None or self._steps_in(scan)
            if looking or not self._ran_fast():
                if not looking:
                    self._again(scan)
                self.player.every(self._look)
        except InputError as error:
            return self._fault(scan, error)
        if (
            self._target is not None
        ):  # no program runs in this scan, so the step has not reached its target
            (_, missed), self._target = self._target, None
            return missed
        for watch in self.watches:
            if text := watch.changed():
                return Stop("data breakpoint", text, (watch.number,))
        found = machine.violations[broken:]
        if found and self.rules:
            return Stop("exception", found[0].text)
        return None

    def _begin(self, scan: int) -> None:
        for one in self.breakpoints:
            one.begin(scan)
        for watch in self.watches:
            watch.begin()

    def _again(self, scan: int) -> None:
        """Restore the beginning of a scan that ran fast, so that it can run with hooks.

        Messages that the fast run has printed are not printed again.
        """
        self.player.seek(scan)
        self._begin(scan)
        self._unsaid, self._said = self._said, 0

    def _steps_in(self, scan: int) -> bool:
        """Return whether a step can end in this scan."""
        order = self._going.order
        if order.task:  # the fast scan has a hook that ends steps of device tasks
            return False
        return scan >= self._goal if order.until == "scan" else order.until != "continue"

    @property
    def _goal(self) -> int:
        """Return the number of the scan at which a step by scans ends."""
        return self._going.scan + self._going.order.scans

    def _ran_fast(self) -> bool:
        """Run a scan fast; return False if something stops in it and it must run again."""
        try:
            if self.breakpoints or self._going.order.task:
                self.player.some(self._lines(), self._fast_hit, self._fast_device())
            else:
                self.player.plain()
        except _Hit:
            return False
        # If a watch has changed, the repetition with a hook before every statement stops at the
        # change.
        return not any(watch.changed() for watch in self.watches)

    def _lines(self) -> dict[str, frozenset[int]]:
        lines: dict[str, frozenset[int]] = {}
        for one in self.breakpoints:
            for pou, own in one.lines.items():
                lines[pou] = lines.get(pou, frozenset()) | own
        return lines

    def _fast_hit(self, code: Code, at: int, frame: FrameType) -> None:
        if self._hits(code, at, frame, first=True):
            raise _Hit

    def _fast_device(self) -> Callable[[DeviceStep], None] | None:
        """Return the hook for lines of devices in a fast scan; None if no hook is needed."""
        if not self._going.order.task and not any(map(_of_device, self.breakpoints)):
            return None

        def look(step: DeviceStep) -> None:
            if self._device_hits(step) or self._device_step_ends(step):
                raise _Hit

        return look

    def _look(self) -> None:
        """Decide before a statement whether to stop.

        The method is used in a scan with hooks before all statements.
        """
        tracer = self.player.tracer
        if self._target is not None:
            step, stop = self._target
            if tracer.step == step or (step == _FIRST and tracer.device is None):
                self._target = None
                for watch in self.watches:
                    watch.begin()
                self._halt(stop)
            elif any(one.counting for one in self.breakpoints):
                self._quiet = True
                self._hits_here()
                self._quiet = False
            return
        watches = self.watches if tracer.device is None else ()
        changes = [(one.number, text) for one in watches if (text := one.changed())]
        hits = self._hits_here()
        if changes:
            numbers = tuple(number for number, _ in changes)
            self._halt(Stop("data breakpoint", "; ".join(text for _, text in changes), numbers))
        elif hits:
            self._halt(Stop("breakpoint", "", hits))
        elif self._step_ends():
            self._halt(Stop("step"))

    def _halt(self, stop: Stop) -> None:
        """Stop in the middle of a scan, and return when the user lets the run continue."""
        order = self._stop(stop)
        if not isinstance(order, Forward):
            raise _Leave(order)
        tracer = self.player.tracer
        scan = self.player.machine.scans
        depth = self._depth_of(order.task) if order.task else len(tracer.stack)
        self._going = _Step(order, scan, depth, tracer.roots)

    def _step_ends(self) -> bool:
        """Return whether the current step ends before this statement.

        `over` ends at the same or a smaller depth of calls, `out` at a smaller one. Both also end
        in another program or scan, because the call in which the step began has returned. A step
        `scan` ends in or after the target scan, but not in the program call in which it began.
        """
        going, tracer = self._going, self.player.tracer
        if tracer.device is not None:
            return self._device_step_ends(tracer.device)
        if going.order.task:
            return False
        scan, depth = self.player.machine.scans, len(tracer.stack)
        until = going.order.until
        if until == "scan":
            return scan >= self._goal and (scan, tracer.roots) != (going.scan, going.roots)
        if until == "in":
            return True
        elsewhere = (scan, tracer.roots) != (going.scan, going.roots)
        if until == "over":
            return elsewhere or depth <= going.depth
        return until == "out" and (elsewhere or depth < going.depth)

    def _device_step_ends(self, step: DeviceStep) -> bool:
        """Return whether the current step ends before this line of a device's program.

        A step out of the outermost program continues to the next line of this program.
        """
        going = self._going
        if going.order.task != step.task:
            return False
        until = going.order.until
        if until == "out":
            return step.depth < max(going.depth, 2)
        return until == "in" or step.depth <= going.depth

    def _hits_here(self) -> tuple[int, ...]:
        """Return the breakpoints that stop before the current statement."""
        tracer = self.player.tracer
        if tracer.device is not None:
            return self._device_hits(tracer.device)
        entry = tracer.stack[-1]
        return self._hits(entry.code, entry.at, entry.frame, first=entry.fresh)

    def _device_hits(self, step: DeviceStep) -> tuple[int, ...]:
        """Return the breakpoints that stop before a line of a device's program."""
        hits = []
        for one in self.breakpoints:
            if not isinstance(one, DeviceBreakpoint) or not one.fits(step):
                continue
            try:
                if one.hit_at(step):
                    hits.append(one.number)
            except InputError as error:
                self.front.log(f"breakpoint: {error}")
                hits.append(one.number)
        return tuple(hits)

    def _hits(self, code: Code, at: int, frame: FrameType, *, first: bool) -> tuple[int, ...]:
        """Return the breakpoints that stop before a statement; print the messages of logpoints."""
        pou, hits = code.pou.name.upper(), []
        for one in self.breakpoints:
            if at not in one.lines.get(pou, ()) or (one.entry and not first):
                continue
            variables = {**frame.f_locals, "g": self.memory.shared}
            try:
                if not one.hit(pou, variables):
                    continue
                message = one.messages.get(pou)
                if message is None:
                    hits.append(one.number)
                else:
                    self._say(message.parts, variables)
            except InputError as error:
                self.front.log(f"breakpoint: {error}")
                hits.append(one.number)
        return tuple(hits)

    def _say(self, parts: Iterable[Any], variables: dict[str, Any]) -> None:
        if self._quiet:
            return
        self._said += 1
        if self._unsaid > 0:  # the fast run of this scan has printed its messages
            self._unsaid -= 1
            return
        texts = [
            one if isinstance(one, str) else self.memory.text_of(one.type, one.value(variables))
            for one in parts
        ]
        self.front.log("".join(texts))

    def _fault(self, scan: int, error: InputError) -> Stop | None:
        """Stop at the statement that ends the program with an error.

        The scan is repeated to find the number of this statement, and once more to stop there.
        If the error has no such statement, the stop is between two scans.
        """
        self._target = None
        step = self.player.tracer.step
        if not step:
            self.player.seek(scan)
            try:
                self.player.every(lambda: None)
            except InputError:
                step = self.player.tracer.step
        self.player.seek(scan)
        if not step:
            return Stop("exception", str(error))
        self._target = step, Stop("exception", str(error))
        self._begin(scan)
        try:
            self.player.every(self._look)
        except InputError as again:
            return self._fault(scan, again)
        return None

    # --- backwards ---

    def _back(self, order: Back) -> Order:
        now, tracer = self.player.now, self.player.tracer
        depths = [
            (step, depth)
            for step, (task, depth) in enumerate(zip(tracer.tasks, tracer.depths, strict=True), 1)
            if not task
        ]
        self._quiet, self._going = True, _Step(Forward(), now.scan, 0, 0)
        try:
            found = self._found(order, now, depths)
        finally:
            self._quiet = False
        return self.go_to(*found)

    def _found(
        self, order: Back, now: Moment, depths: list[tuple[int, int]]
    ) -> tuple[Moment, Stop]:
        start = Moment(0, _FIRST), Stop("entry", "the start of the run: there is nothing before it")
        if order.until == "start":
            return start
        if order.until == "scan":
            return Moment(max(0, now.scan - order.scans), _FIRST), Stop("step")
        if order.until == "step" and order.task:
            line = DeviceBreakpoint(0, {}, task=order.task, depth=self._depth_of(order.task))
            before = self._last_in([line], [], now)
            return (before[0], Stop("step")) if before is not None else start
        if order.until == "step":
            return self._step_before(now, depths) or start
        if order.until == "change":
            assert order.watch is not None
            found = self._last_in([], [order.watch], now, before=True)
            if found is None:
                return now, Stop("step", f"{order.watch.name} has not changed before")
            return found
        return self._last_in(self.breakpoints, self.watches, now, rules=self.rules) or start

    def _step_before(
        self, now: Moment, depths: list[tuple[int, int]]
    ) -> tuple[Moment, Stop] | None:
        """Return the previous statement at the same or a smaller depth of calls.

        The statements inside calls between it and the current statement are skipped. `depths`
        contains the call depth of each statement that this scan has run so far.
        """
        here = bool(depths) and depths[-1][0] == now.step
        most = depths[-1][1] if here else 1
        scan, known = now.scan, depths[:-1] if here else depths
        while True:
            fitting = [step for step, depth in known if depth <= most]
            if fitting:
                return Moment(scan, fitting[-1]), Stop("step")
            scan, most = scan - 1, 1
            if scan < 0:
                return None
            self.player.seek(scan, self._poll)
            seen: list[tuple[int, int]] = []
            tracer = self.player.tracer

            def look() -> None:
                if tracer.device is None:  # noqa: B023
                    seen.append((tracer.step, len(tracer.stack)))  # noqa: B023

            self.player.every(look)
            known = seen

    def _last_in(
        self,
        breakpoints: list[Breakpoint],
        watches: list[DataWatch],
        now: Moment,
        *,
        rules: bool = False,
        before: bool = False,
    ) -> tuple[Moment, Stop] | None:
        """Return the last moment before `now` at which something stops.

        With `before`, a changed variable stops before the statement that changes it, not after.
        """
        own = self.breakpoints, self.watches
        self.breakpoints, self.watches = breakpoints, watches
        try:
            if now.step:
                self.player.seek(now.scan, self._poll)
                if found := self._all_in(now.scan, now, rules, before):
                    return found
            for first, end in self.player.stretches(now.scan):
                for scan in reversed(self._scans_with(first, end, rules)):
                    self.player.seek(scan, self._poll)
                    if found := self._all_in(scan, now, rules, before):
                        return found
            return None
        finally:
            self.breakpoints, self.watches = own

    def _scans_with(self, first: int, end: int, rules: bool) -> list[int]:
        """Run the scans from `first` to `end` - 1 fast; return those with a reason to stop."""
        found: list[int] = []
        machine = self.player.machine
        for scan in range(first, end):
            self._poll()
            broken = len(machine.violations)
            self._begin(scan)
            hits: list[bool] = []

            def hit(code: Code, at: int, frame: FrameType) -> None:
                hits.append(bool(self._hits(code, at, frame, first=True)))  # noqa: B023

            def hit_of_device(step: DeviceStep) -> None:
                hits.append(bool(self._device_hits(step)))  # noqa: B023

            if self.breakpoints:
                device = hit_of_device if any(map(_of_device, self.breakpoints)) else None
                self.player.some(self._lines(), hit, device)
            else:
                self.player.plain()
            changed = [bool(watch.changed()) for watch in self.watches]
            if any(hits) or any(changed) or (rules and len(machine.violations) > broken):
                found.append(scan)
        return found

    def _all_in(
        self, scan: int, now: Moment, rules: bool, before: bool
    ) -> tuple[Moment, Stop] | None:
        """Return the last moment of a scan, before `now`, at which something stops."""
        tracer, machine = self.player.tracer, self.player.machine
        found: list[tuple[Moment, Stop]] = []
        broken, last = len(machine.violations), 0
        self._begin(scan)

        def changes(at: Moment) -> None:
            for watch in self.watches:
                if text := watch.changed():
                    found.append((at, Stop("data breakpoint", text, (watch.number,))))

        def look() -> None:
            nonlocal last
            step = tracer.step
            if tracer.device is None:
                changes(Moment(scan, (last or step) if before else step))
                last = step
            if hits := self._hits_here():
                found.append((Moment(scan, step), Stop("breakpoint", "", hits)))

        # If an error ends the program in this scan, the statements up to the error have run.
        with suppress(InputError):
            self.player.every(look)
        changes(Moment(scan, last) if before and last else Moment(scan + 1))
        if rules and len(machine.violations) > broken:
            found.append((Moment(scan + 1), Stop("exception", machine.violations[broken].text)))
        return next((one for one in reversed(found) if one[0] < now), None)

    # --- changes ---

    def edit(self, apply: Callable[[], None]) -> bool:
        """Apply a change at this moment, and repeat it whenever the run passes this moment again.

        Returns:
            Whether the run had already gone beyond this moment. If so, everything after this moment
            is discarded.
        """
        later = self.player.edit(apply)
        for one in self.breakpoints:
            one.forget_after(self.player.now.scan)
        for watch in self.watches:
            watch.begin()
        return later

    def where(self) -> str:
        """Return the current moment as one line of text."""
        machine, now = self.player.machine, self.player.now
        scan = f"scan {now.scan + 1}" if now.step else f"after {now.scan} scans"
        return f"{scan}, {format_us(machine.now_us)}"


def _of_device(one: Breakpoint) -> bool:
    """Return whether a breakpoint is in the program of a device."""
    return isinstance(one, DeviceBreakpoint)
