"""A second, independent model of a job that Execute starts, and of the robot as a block sees it.

The model has no timers; see sequence_rules. Outputs of the controller have names like `SO02`, its
inputs `SI01`. Times are in milliseconds of PLC time.
"""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass
class View:
    """The robot as a block sees it, and the block's requests.

    Attributes:
        now: Time of the scan.
        elapsed: Time since the last scan.
        connected: Whether the link is up.
        so: Dedicated outputs that are ON.
        si: Dedicated inputs that the last scan has written as ON.
        ok: For SI(00) and SI(06): whether the last scan allowed ON, after all holds.
        settled: Whether SI(00) and SI(06) have been unchanged for long enough.
        held: For SI(00) and SI(06): whether a block holds the input OFF. Blocks change it.
        kept: For SI(00) and SI(06): whether no block can release the hold in this scan.
        asked: Inputs requested in this scan.
        turns: The order in which sequences may run.
    """

    now: int = 0
    elapsed: int = 0
    connected: bool = False
    so: frozenset[str] = frozenset()
    si: frozenset[str] = frozenset()
    ok: dict[str, bool] = field(default_factory=lambda: {"SI00": False, "SI06": False})
    settled: bool = False
    held: dict[str, bool] = field(default_factory=lambda: {"SI00": False, "SI06": False})
    kept: dict[str, bool] = field(default_factory=lambda: {"SI00": False, "SI06": False})
    asked: set[str] = field(default_factory=set)
    turns: Turns = field(default_factory=lambda: Turns())

    @property
    def stopped(self) -> bool:
        """Return whether there is an emergency stop, by the controller or by the PLC."""
        return "SO00" in self.so or not self.ok["SI00"]

    def trouble(self, *conditions: tuple[bool, int]) -> int:
        """Return the ErrorID of the first condition that is TRUE, else 0.

        CPU_OK is checked first.
        """
        every = (("SO01" not in self.so, 0x8002), *conditions)
        return next((number for holds, number in every if holds), 0)


@dataclass
class Turns:
    """The waiting sequences in the order of their requests. Only the first may run.

    A job that is not called in a scan is removed.

    Attributes:
        waiting: Tickets of the jobs in their order.
        seen: Tickets of the jobs that were called in this scan.
    """

    waiting: list[object] = field(default_factory=list)
    seen: set[object] = field(default_factory=set)

    def pass_on(self) -> None:
        """At the end of a scan, remove jobs at the front that were not called in this scan."""
        while self.waiting and self.waiting[0] not in self.seen:
            self.waiting.pop(0)
        self.seen.clear()


@dataclass
class Work:
    """The model of a job that a rising edge of Execute starts. `number` is its ErrorID."""

    done: bool = False
    busy: bool = False
    active: bool = False
    number: int = 0
    request: bool = False
    ended: bool = False
    _was: bool = False
    _armed: bool = False
    _limit: int = 0
    _waited: int = 0
    _called: int = 0
    _ticket: object = None

    def scan(
        self,
        view: View,
        turns: Turns,
        execute: bool,
        timeout: int,
        *,
        trouble: int,
        applied: bool,
        answered: bool,
        settled: bool = False,
        offline: int | None = None,
        answer: int = 0,
    ) -> None:
        """Calculate one call of the job. FB_RcxJob describes the arguments."""
        if offline is None:
            offline = 0 if view.connected else 0x8001
        started = execute and not self._was and not self.busy
        skipped = self.busy and self._called != view.now - view.elapsed
        self._was, self.ended, self.request = execute, False, False
        self._called = view.now
        if started:
            self._ticket = None
            self._armed, self._limit, self.busy = False, timeout, True
        if started or not (self.busy or execute):
            self.done, self.number = False, 0
        if not self.busy:
            return
        if skipped:
            self.active = False
        elif self._ticket is None:
            self._ticket = object()
            turns.waiting.append(self._ticket)
        if not skipped and turns.waiting and turns.waiting[0] is self._ticket:
            self._waited = self._waited + view.elapsed if self.active else 0
            self.active = True
            self._armed = self._armed or not applied
        if not started:
            late = self.active and self._limit > 0 and self._waited >= self._limit
            believed = (self._armed and applied) or settled
            ends = (
                (skipped, 0x8013),
                (bool(offline), offline),
                (self.active and bool(trouble) and believed, trouble),
                (self.active and self._armed and applied and answered, answer),
                (late and bool(trouble), trouble),
                (late, 0x8010),
            )
            self._end(turns, next((number for over, number in ends if over), None))
        if self.busy:
            ready = applied or not trouble
            self.request = self.active and self._armed and ready and not offline
            turns.seen.add(self._ticket)

    def _end(self, turns: Turns, number: int | None) -> None:
        if number is None:
            return
        if self.active:
            turns.waiting.remove(self._ticket)
        self.busy = self.active = False
        self.ended, self.number, self.done = True, number, not number


@dataclass
class Rule:
    """The model of a sequence block. The block's pins are attributes of the model."""

    execute: bool = False
    timeout: int = 0
    done: bool = False
    busy: bool = False
    active: bool = False
    number: int = 0
    stage: str = ""

    def scan(self, view: View) -> None:
        """Calculate one call of the block."""
        raise NotImplementedError

    def _show(self, work: Work) -> None:
        self.done, self.busy = work.done, work.busy
        self.active, self.number = work.active, work.number
