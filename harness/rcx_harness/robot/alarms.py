"""The controller's alarms: which are active, which are serious, and their history."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from rcx_harness.spec import FieldValue

__all__ = [
    "EMERGENCY_STOP",
    "SOFT_LIMIT",
    "STOP",
    "ActiveAlarm",
    "AlarmList",
    "CommandError",
    "Place",
]

EMERGENCY_STOP = "12.600"
STOP = "12.400"
SOFT_LIMIT = "2.334"


class CommandError(Exception):
    """A remote command ends abnormally with the alarm of that number (`"12.600"`).

    `response` are response fields that are shown beside it (a jog that was stopped); `axis` is that
    of the robot that it comes from, 1 to 6, or 0.
    """

    def __init__(
        self, number: str, response: Mapping[str, FieldValue] | None = None, *, axis: int = 0
    ) -> None:
        self.number = number
        self.axis = axis
        self.response = response or {}
        super().__init__(number)


@dataclass(frozen=True)
class Place:
    """Where an alarm occurred, as the message reference says it (guide, 4.7.7).

    `kind` is 0 robot, 1 controller or 2 task, `detail` within it 0 all, 1 axis, 2 motor, 3 option
    slot or 4 task; each has its number.
    """

    kind: int
    number: int = 1
    detail: int = 0
    detail_number: int = 0


@dataclass(frozen=True)
class ActiveAlarm:
    """An alarm by its number `"12.600"`, and when it was raised [us].

    A serious one turns SO(03) ON until it is reset. Without a `place` it came from the controller.
    """

    number: str
    t_us: int
    serious: bool
    place: Place | None = None


class AlarmList:
    """Active alarms, the history (oldest first, the latest `length` alarms) and the warning.

    `latest_of_command` is the one in which a remote command ended last.
    """

    def __init__(self, length: int = 500) -> None:
        self._length = length
        self.active: list[ActiveAlarm] = []
        self.history: list[ActiveAlarm] = []
        self.warning = False
        self.latest_of_command: ActiveAlarm | None = None

    @property
    def serious(self) -> bool:
        """SO(03) is ON."""
        return any(alarm.serious for alarm in self.active)

    def has(self, number: str) -> bool:
        """That alarm is active."""
        return any(alarm.number == number for alarm in self.active)

    def note(
        self, number: str, t_us: int, *, serious: bool = False, place: Place | None = None
    ) -> ActiveAlarm:
        """Write an alarm into the history only."""
        alarm = ActiveAlarm(number, t_us, serious, place)
        self.history.append(alarm)
        del self.history[: -self._length]
        return alarm

    def activate(self, number: str, t_us: int, *, serious: bool) -> None:
        """Raise an alarm; nothing happens if it is active already."""
        if not self.has(number):
            self.active.append(self.note(number, t_us, serious=serious))

    def clear(self, number: str) -> None:
        """End an alarm without a reset."""
        self.active = [alarm for alarm in self.active if alarm.number != number]

    def reset(self, lasting: Iterable[str]) -> None:
        """Reset all but the `lasting` ones."""
        kept = set(lasting)
        self.active = [alarm for alarm in self.active if alarm.number in kept]
