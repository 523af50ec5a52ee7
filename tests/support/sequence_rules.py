"""A second, independent model of the sequence blocks.

One call of `scan` is one call of the block. The model follows the manual's chapter 5 and the heads
of the blocks, and has no timers; see head_rules for the outputs.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from head_rules import Since
from sequence_work import Rule, Turns, View, Work


@dataclass
class _Plain(Rule):
    """The model of a sequence that requests one input and waits for the controller's answer."""

    work: Work = field(default_factory=Work)
    signal: str = ""
    answered: Callable[[View], bool] = lambda view: False
    trouble: Callable[[View], int] = lambda view: 0

    def scan(self, view: View) -> None:
        self.work.scan(
            view,
            view.turns,
            self.execute,
            self.timeout,
            trouble=self.trouble(view),
            settled=view.settled,
            applied=self.signal in view.si,
            answered=self.answered(view),
        )
        if self.work.request:
            view.asked.add(self.signal)
        self._show(self.work)


def _alarm_reset() -> Rule:
    return _Plain(
        signal="SI16",
        answered=lambda view: "SO03" not in view.so,
        trouble=lambda view: 0x8003 if view.stopped else 0,
    )


def _servo_on() -> Rule:
    return _Plain(
        signal="SI01",
        answered=lambda view: "SO02" in view.so,
        trouble=lambda view: view.trouble(
            (view.stopped, 0x8003), ("SO03" in view.so, 0x8004), ("SO04" not in view.so, 0x8005)
        ),
    )


def _program_reset() -> Rule:
    return _Plain(
        signal="SI15",
        answered=lambda view: "SO14" in view.so,
        trouble=lambda view: view.trouble(("SO10" not in view.so, 0x8006)),
    )


def _auto_start() -> Rule:
    return _Plain(
        signal="SI12",
        answered=lambda view: "SO13" in view.so,
        trouble=lambda view: view.trouble(
            (view.stopped, 0x8003),
            ("SO03" in view.so, 0x8004),
            ("SO10" not in view.so, 0x8006),
            (not view.ok["SI06"], 0x8007),
            ("SO13" in view.so and "SI12" not in view.si, 0x8008),
        ),
    )


@dataclass
class _Origin(Rule):
    axes: str = "ORIGIN_INCREMENTAL"
    confirm: int = 60
    _work: Work = field(default_factory=Work)
    _chosen: str = "ORIGIN_INCREMENTAL"
    _fresh: bool = False
    _stays: Since = field(default_factory=Since)

    def scan(self, view: View) -> None:
        if self.execute and not self._work.busy:
            self._chosen = self.axes
        signal = "SI17" if self._chosen == "ORIGIN_ABSOLUTE" else "SI14"
        applied, complete = signal in view.si, "SO11" in view.so
        self._fresh = not complete or (self._fresh and applied)
        stays = self._stays.look(view.now, applied and complete, self.confirm)
        trouble = view.trouble(
            (view.stopped, 0x8003),
            ("SO03" in view.so, 0x8004),
            (not view.ok["SI06"], 0x8007),
            ("SO02" not in view.so, 0x800C),
            ("SO13" in view.so and not applied, 0x8008),
        )
        self._work.scan(
            view,
            view.turns,
            self.execute,
            self.timeout,
            trouble=trouble,
            settled=view.settled,
            applied=applied,
            answered=complete and (self._fresh or stays),
        )
        if self._work.request:
            view.asked.add(signal)
        self._show(self._work)


@dataclass
class _Stop(Rule):
    """The model of a sequence that switches SI(00) or SI(06) OFF at once and holds it OFF."""

    signal: str = "SI06"
    _work: Work = field(default_factory=Work)
    _own: Turns = field(default_factory=Turns)
    _ran: bool = False

    def scan(self, view: View) -> None:
        work, so = self._work, view.so
        self._ran = (self._ran and work.busy) or "SO13" in so
        if self.signal == "SI00":
            trouble = 0x8002 if not {"SO00", "SO01"} & so else 0
            answered = "SO00" in so and "SO02" not in so
        else:
            trouble = view.trouble()
            answered = "SO13" not in so and (self._ran or view.settled)
        if not work.busy:
            self._own.waiting.clear()
        work.scan(
            view,
            self._own,
            self.execute,
            self.timeout,
            trouble=trouble,
            settled=True,
            applied=work.busy and self.signal not in view.si,
            answered=answered,
        )
        if self.execute or work.busy or work.ended:
            view.held[self.signal] = view.kept[self.signal] = True
        self._show(work)


@dataclass
class _Continue(Rule):
    _start: Rule = field(default_factory=_auto_start)
    _was: bool = False
    _held: bool = False

    def scan(self, view: View) -> None:
        if self.execute and not self._was and not self.busy:
            self._held, view.held["SI06"] = view.held["SI06"], False
        self._was = self.execute
        self._held = self._held and "SI06" not in view.si
        start = self._start
        start.execute, start.timeout = self.execute, self.timeout
        start.scan(view)
        if self.busy and start.number and self._held:
            view.held["SI06"] = True
        self.done, self.busy, self.active, self.number = (
            start.done,
            start.busy,
            start.active,
            start.number,
        )


@dataclass
class _Staged(Rule):
    """The model of a sequence with stages. Timeout limits each stage; `_step` calculates a scan."""

    _was: bool = False
    _last: str = ""
    _entered: int = 0
    _limit: int = 0
    _started: bool = False
    _called: int = 0
    _skipped: bool = False
    parts: dict[str, Rule] = field(default_factory=dict)

    def scan(self, view: View) -> None:
        busy = self.busy
        self._started = self.execute and not self._was and not busy
        self._was = self.execute
        if self._started:
            self._limit = self.timeout
            self._begin(view)
        elif not busy and not self.execute:
            self.stage = "IDLE"
        if self._started or self.stage != self._last:
            self._entered = view.now
        self._last = self.stage
        skipped = busy and self._called != view.now - view.elapsed
        self._called, self._skipped = view.now, skipped
        failure = self._step(view, busy)
        failure = 0x8013 if skipped else failure
        if self._started:
            self.busy, self.done, self.number = True, False, 0
        elif busy and (failure or self.stage == "COMPLETE"):
            self.busy, self.done, self.number = False, not failure, failure
            self._end(view)
        elif not busy and not self.execute:
            self.done, self.number = False, 0
        self.active = any(part.active for part in self.parts.values())

    def _late(self, view: View) -> bool:
        return 0 < self._limit <= view.now - self._entered

    def _part(self, view: View, name: str, execute: bool) -> Rule:
        part = self.parts[name]
        part.execute, part.timeout = execute and not self._skipped, self._limit
        part.scan(view)
        return part

    def _begin(self, view: View) -> None: ...

    def _step(self, view: View, busy: bool) -> int:
        raise NotImplementedError

    def _end(self, view: View) -> None: ...


@dataclass
class _Release(_Staged):
    """The model of the recovery from an emergency stop: release, alarm reset, MP RDY, servo on."""

    parts: dict[str, Rule] = field(
        default_factory=lambda: {"reset": _alarm_reset(), "servo": _servo_on()}
    )
    _held: bool = False

    def _begin(self, view: View) -> None:
        self.stage = "EMERGENCY_RELEASE"
        self._held, view.held["SI00"] = view.held["SI00"], False

    def _end(self, view: View) -> None:
        if self.number and self._held:
            view.held["SI00"] = True

    def _step(self, view: View, busy: bool) -> int:
        failure = 0
        if busy and self.stage == "EMERGENCY_RELEASE":
            self._held = self._held and "SI00" not in view.si
            if not view.connected:
                failure = 0x8001
            elif not view.ok["SI00"]:
                failure = 0x8003
            elif "SI00" in view.si and "SO00" not in view.so:
                self.stage = "ALARM_RESET" if "SO03" in view.so else "MP_READY"
            elif self._late(view):
                failure = 0x8009
        reset = self._part(view, "reset", busy and self.stage == "ALARM_RESET")
        if reset.done:
            self.stage = "MP_READY"
        elif reset.number:
            failure = 0x800A if reset.number == 0x8010 else reset.number
        if busy and self.stage == "MP_READY":
            refused = view.trouble((view.stopped or "SO03" in view.so, 1))
            if "SO04" in view.so or refused:
                self.stage = "SERVO_ON"
            elif self._last == "MP_READY" and self._late(view):
                failure = 0x8005
        servo = self._part(view, "servo", busy and self.stage == "SERVO_ON")
        if servo.done:
            self.stage = "COMPLETE"
        elif servo.number:
            failure = 0x800B if servo.number == 0x8010 else servo.number
        return failure


_INNER = ("EMERGENCY_RELEASE", "ALARM_RESET", "MP_READY", "SERVO_ON")


@dataclass
class _PowerUp(_Staged):
    program: bool = True
    _with: bool = True
    parts: dict[str, Rule] = field(
        default_factory=lambda: {
            "release": _Release(),
            "reset": _program_reset(),
            "start": _auto_start(),
        }
    )

    def _begin(self, view: View) -> None:
        self.stage, self._with = "CONNECTION", self.program

    def _waits(self, view: View) -> tuple[bool, str, int] | None:
        """Return whether the stage's condition holds, the next stage, and the time-out ErrorID."""
        free = view.ok["SI00"] and not view.held["SI00"]
        return {
            "CONNECTION": (view.connected, "CPU_OK", 0x8001),
            "CPU_OK": ("SO01" in view.so, "CELL_SAFE", 0x8002),
            "CELL_SAFE": (free, "EMERGENCY_RELEASE", 0x8003),
            "STOP_RELEASE": (view.ok["SI06"], "AUTO_MODE", 0x8007),
            "AUTO_MODE": ("SO10" in view.so, "PROGRAM_RESET", 0x8006),
        }.get(self.stage)

    def _step(self, view: View, busy: bool) -> int:
        failure = self._wait(view) if busy else 0
        release = self._part(view, "release", busy and self.stage in _INNER)
        if release.execute:
            self.stage = release.stage
        if release.done:
            self.stage = "STOP_RELEASE" if self._with else "COMPLETE"
        reset = self._part(view, "reset", busy and self.stage == "PROGRAM_RESET")
        if reset.done:
            self.stage = "PROGRAM_START"
        start = self._part(view, "start", busy and self.stage == "PROGRAM_START")
        if start.done:
            self.stage = "COMPLETE"
        failure = failure or release.number or reset.number or start.number
        return 0x800C if start.done and "SO02" not in view.so else failure

    def _wait(self, view: View) -> int:
        found = self._waits(view)
        if found is None:
            return 0
        there, following, late = found
        if self.stage != "CONNECTION" and not view.connected:
            return 0x8001
        if self.stage in ("STOP_RELEASE", "AUTO_MODE"):
            lost = view.trouble(
                (view.stopped, 0x8003),
                ("SO03" in view.so, 0x8004),
                ("SO02" not in view.so, 0x800C),
                ("SO13" in view.so, 0x8008),
            )
            if lost:
                return lost
        if there:
            self.stage = following
        return late if not there and self._late(view) else 0


def missing(view: View) -> str:
    """Return the first missing condition of a program start.

    A condition that must hold for some time counts as fulfilled from its first scan.
    """
    so = view.so
    conditions = (
        (not view.connected, "CONNECTION"),
        ("SO01" not in so, "CPU_OK"),
        (not view.ok["SI00"] or view.held["SI00"], "CELL_SAFE"),
        ("SO00" in so, "EMERGENCY_RELEASE"),
        ("SO03" in so, "ALARM_RESET"),
        ("SO04" not in so, "MP_READY"),
        ("SO02" not in so, "SERVO_ON"),
        (not view.ok["SI06"] or view.held["SI06"], "STOP_RELEASE"),
        ("SO10" not in so, "AUTO_MODE"),
        ("SO13" not in so, "PROGRAM_START"),
    )
    return next((stage for lacks, stage in conditions if lacks), "COMPLETE")


#: Maps the name of a sequence block to a function that makes its model.
RULES: dict[str, Callable[[], Any]] = {
    "FB_AlarmReset": _alarm_reset,
    "FB_AutoStart": _auto_start,
    "FB_EmergencyStop": lambda: _Stop(signal="SI00"),
    "FB_PowerUp": _PowerUp,
    "FB_ProgramContinue": _Continue,
    "FB_ProgramReset": _program_reset,
    "FB_ProgramStop": _Stop,
    "FB_ReturnToOrigin": _Origin,
    "FB_ServoOn": _servo_on,
    "FB_ServoOnFromEmergencyStop": _Release,
}
