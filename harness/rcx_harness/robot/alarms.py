"""The controller's alarms: active alarms, serious alarms and the history."""

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
    """The abnormal end of a remote command, with the number of its alarm (`"12.600"`).

    `response` has the fields of the response that the master gets in spite of the alarm, such as
    the position of a stopped jog. `axis` is the robot axis that caused the alarm, 1 to 6; 0: no
    single axis.
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
    """The place where an alarm occurred, as the message reference reports it (guide, 4.7.7).

    `kind` is 0 (robot), 1 (controller) or 2 (task), and `number` is its number. `detail` is 0
    (all), 1 (axis), 2 (motor), 3 (option slot) or 4 (task), and `detail_number` is its number.
    """

    kind: int
    number: int = 1
    detail: int = 0
    detail_number: int = 0


@dataclass(frozen=True)
class ActiveAlarm:
    """An alarm with its number, such as `"12.600"`, and the time at which it was raised [us].

    A serious alarm turns SO(03) ON until it is reset. If `place` is None, the controller itself
    raised the alarm.
    """

    number: str
    t_us: int
    serious: bool
    place: Place | None = None


class AlarmList:
    """The active alarms, the alarm history (oldest first, at most `length` alarms) and the warning.

    `latest_of_command` is the alarm of the latest remote command that ended abnormally.
    """

    def __init__(self, length: int = 500) -> None:
        self._length = length
        self.active: list[ActiveAlarm] = []
        self.history: list[ActiveAlarm] = []
        self.warning = False
        self.latest_of_command: ActiveAlarm | None = None

    @property
    def serious(self) -> bool:
        """Return whether a serious alarm is active, which turns SO(03) ON."""
        return any(alarm.serious for alarm in self.active)

    def has(self, number: str) -> bool:
        """Return whether the alarm with this number is active."""
        return any(alarm.number == number for alarm in self.active)

    def note(
        self, number: str, t_us: int, *, serious: bool = False, place: Place | None = None
    ) -> ActiveAlarm:
        """Add an alarm to the history without activating it; return the alarm."""
        alarm = ActiveAlarm(number, t_us, serious, place)
        self.history.append(alarm)
        del self.history[: -self._length]
        return alarm

    def activate(self, number: str, t_us: int, *, serious: bool) -> None:
        """Activate an alarm and add it to the history; do nothing if it is already active."""
        if not self.has(number):
            self.active.append(self.note(number, t_us, serious=serious))

    def clear(self, number: str) -> None:
        """Remove an alarm from the active alarms, because its cause has ended."""
        self.active = [alarm for alarm in self.active if alarm.number != number]

    def reset(self, lasting: Iterable[str]) -> None:
        """Reset all active alarms except the alarms whose numbers are in `lasting`."""
        kept = set(lasting)
        self.active = [alarm for alarm in self.active if alarm.number in kept]
