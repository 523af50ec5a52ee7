"""The controller's alarms: which are active, which are serious, and their history."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

__all__ = ["EMERGENCY_STOP", "SOFT_LIMIT", "STOP", "ActiveAlarm", "AlarmList", "CommandError"]

EMERGENCY_STOP = "12.600"
STOP = "12.400"
SOFT_LIMIT = "2.334"


class CommandError(Exception):
    """A remote command ends abnormally with the alarm of that number (`"12.600"`)."""

    def __init__(self, number: str) -> None:
        self.number = number
        super().__init__(number)


@dataclass(frozen=True)
class ActiveAlarm:
    """An alarm by its number `"12.600"`, and when it was raised [us].

    A serious one turns SO(03) ON until it is reset.
    """

    number: str
    t_us: int
    serious: bool


class AlarmList:
    """Active alarms, the history (oldest first, the latest `length` alarms) and the warning."""

    def __init__(self, length: int = 500) -> None:
        self._length = length
        self.active: list[ActiveAlarm] = []
        self.history: list[ActiveAlarm] = []
        self.warning = False

    @property
    def serious(self) -> bool:
        """SO(03) is ON."""
        return any(alarm.serious for alarm in self.active)

    def has(self, number: str) -> bool:
        """That alarm is active."""
        return any(alarm.number == number for alarm in self.active)

    def note(self, number: str, t_us: int, *, serious: bool = False) -> ActiveAlarm:
        """Write an alarm into the history only."""
        alarm = ActiveAlarm(number, t_us, serious)
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
