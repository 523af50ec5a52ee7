"""A second, independent model of FB_Jog and FB_ContinuousPosition.

One call of `scan` is one call of the block. The model follows the remote command guide, 4.2.6 and
4.7.4, and the heads of the blocks, and has no timers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from command_rules import CommandRule, RobotView
from head_rules import Since

_AXES = 6


@dataclass
class LevelView(RobotView):
    """The data of the robot that only level blocks use.

    Attributes:
        released: Whether SI(06) is ON and settled.
        stop_ok: Whether SI(06) was allowed to be ON in the last scan.
        stopped: Whether there is an emergency stop, by the controller or by the PLC.
        response: The words of the response.
        stop_jog: Whether the block requests that its jog stops.
    """

    released: bool = False
    stop_ok: bool = False
    stopped: bool = False
    response: list[int] = field(default_factory=lambda: [0] * 15)
    stop_jog: bool = False

    def number(self, axis: int) -> int:
        """Return the signed double word of an axis (counted from 0) in the response."""
        low, high = self.response[3 + 2 * axis : 5 + 2 * axis]
        value = high << 16 | low
        return value - (1 << 32) if value >> 31 else value


@dataclass
class LevelRule:
    """The model of a level block. The block's pins are attributes of the model."""

    enable: bool = False
    timeout: int = 0
    robot: int = 0
    valid: bool = False
    busy: bool = False
    number: int = 0
    alarm: tuple[int, int] = (0, 0)
    pulses: list[int] = field(default_factory=lambda: [0] * _AXES)
    millimetres: list[float] = field(default_factory=lambda: [0.0] * _AXES)
    code: int = 0
    data: list[int] = field(default_factory=lambda: [0] * 15)
    job: CommandRule = field(default_factory=CommandRule)
    _asked: bool = False
    _out: bool = False
    _limit: int = 0
    _waits: Since = field(default_factory=Since)

    def scan(self, view: LevelView) -> None:
        """Calculate one call of the block."""
        raise NotImplementedError

    def _late(self, view: LevelView, waits: bool) -> bool:
        """Return whether the block has waited for longer than its Timeout, as set at the start."""
        return self._waits.look(view.now, self._limit > 0 and waits, self._limit)

    def _clear(self) -> None:
        if not self.enable:
            self.number, self.alarm = 0, (0, 0)


@dataclass
class JogRule(LevelRule):
    """A model of FB_Jog, with the pins of that block."""

    frame: int = 0
    axis: int = 1
    minus: bool = False
    output: int = 0
    stopping: bool = False
    _illegal: int = 0
    _halt: bool = False
    _locked: bool = False
    _recovering: bool = False

    def scan(self, view: LevelView) -> None:
        """Calculate one call of FB_Jog."""
        job = self.job
        self._clear()
        self._locked = self._locked and self.enable
        self._halt = job.busy and (self._halt or not self.enable)
        lost = 0x8001 if not view.connected else 0x8002 if not view.cpu_ok else 0
        if self.enable and lost and (self._halt or self._recovering):
            self._locked, self.number = True, lost
        still_off = view.connected and view.stop_ok and not view.released
        self._recovering = self._recovering and still_off
        wanted = self.enable and not (self._halt or self._locked or self._recovering)
        if wanted and not job.busy:
            self._sample()
        self._out = job.busy and (self._out or (self._asked and view.out))
        waits_for_turn = job.busy and (job.active or view.channel.orphan)
        late = self._late(view, self._halt if self._out else waits_for_turn)
        job.execute, job.refused = wanted, self._refused(view, late)
        job.scan(view)
        if view.asking is job:
            if view.released:
                self._asked = True
            else:
                view.asking = None
        if self._out and self._halt and job.busy:
            view.stop_jog = True
        if job.ended:
            self._end(view)
        failed = self.number != 0
        moves = (self._out and not self._halt) or self._locked
        self.valid = self.enable and not failed and moves
        self.busy = self.enable and not failed and not moves
        self.stopping = not self.enable and (job.busy or self._recovering)

    def _sample(self) -> None:
        self.code = 0x0020 + self.frame | self.robot << 12
        self._limit = self.timeout
        self.data = [0] * 15
        self.data[0] = (0, 0x4000, 0x8000)[self.output]
        self._illegal = 0
        if not 0 <= self.robot <= 4:
            self._illegal = 0x8040
        elif not 1 <= self.axis <= _AXES:
            self._illegal = 0x8041
        else:
            self.data[1] = 1 << (self.axis - 1) | self.minus << 7

    def _refused(self, view: LevelView, late: bool) -> int:
        if self._out:
            return 0x8011 if late else 0
        late_id = 0x8015 if self.job.active else 0x8012
        reasons = (
            (self._halt, 0x8013),
            (self._illegal != 0, self._illegal),
            (view.stopped, 0x8003),
            (not view.stop_ok, 0x8007),
            (late, late_id),
        )
        return next((number for holds, number in reasons if holds), 0)

    def _end(self, view: LevelView) -> None:
        answered = self.job.number in (0, 0x8020)
        for axis in range(_AXES):
            value = view.number(axis) if answered else 0
            self.pulses[axis] = value if self.data[0] == 0x4000 else 0
            self.millimetres[axis] = value / 1000 if self.data[0] == 0x8000 else 0.0
        self._locked = self.enable and not self._halt
        if self._locked:
            self.number, self.alarm = self.job.number, self.job.alarm
        self._recovering = self._out and self._halt
        self._out = self._asked = False


@dataclass
class ContinuousRule(LevelRule):
    """A model of FB_ContinuousPosition. `hand` and `arms` are decoded from word m + 6."""

    unit_mm: bool = False
    hand: int = 0
    arms: tuple[int, int] = (0, 0)

    def scan(self, view: LevelView) -> None:
        """Calculate one call of FB_ContinuousPosition."""
        job = self.job
        self._clear()
        if self.enable and not self.number and not job.busy:
            self.code = (0x0506 if self.unit_mm else 0x0505) | (self.robot << 12) % (1 << 16)
            self._limit = self.timeout
            self.number = 0 if 0 <= self.robot <= 4 else 0x8040
        self._out = job.busy and (self._out or (self._asked and view.out))
        waits = job.busy and not self.valid and (job.active or view.channel.orphan)
        late = self._late(view, waits)
        late_id = 0x8011 if self._out else 0x8015 if job.active else 0x8012
        job.refused = 0x8013 if not self.enable else late_id if late else 0
        job.execute = self.enable and not self.number
        job.scan(view)
        if view.asking is job:
            self.data, self._asked = [1] + [0] * 14, True
        if job.ended:
            self._asked = self._out = False
            if self.enable:
                self.number, self.alarm = job.number or 0x8014, job.alarm
        self.valid = self.enable and self._out and view.status == 0x0100
        self.busy = self.enable and not self.valid and not self.number
        if self.valid:
            self._show(view)

    def _show(self, view: LevelView) -> None:
        for axis in range(_AXES):
            if self.code & 0x0FFF == 0x0505:
                self.pulses[axis] = view.number(axis)
            else:
                self.millimetres[axis] = view.number(axis) / 1000
        if self.code & 0x0FFF == 0x0506:
            word = view.response[2]
            self.hand = {1: 1, 2: 2}.get(word >> 1 & 3, 0)
            rotation = {0x0001: 1, 0x000F: -1}
            self.arms = (rotation.get(word >> 3 & 0xF, 0), rotation.get(word >> 7 & 0xF, 0))


#: Maps the name of a level block to the class of its model.
LEVELS: dict[str, Callable[[], LevelRule]] = {
    "FB_ContinuousPosition": ContinuousRule,
    "FB_Jog": JogRule,
}
