"""Transfer of stored data over one connection, with remote commands (guide 4.3)."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any

from rcx_harness.look.points.stored import Key, Stored
from rcx_harness.look.probe.asker import Answer, Asker, NoAnswerError
from rcx_harness.look.probe.line import NetworkLine
from rcx_harness.robot.stored import Hand, Pallet, Point
from rcx_harness.spec.wire import NORMAL_END, READY

__all__ = ["TIMEOUT_US", "UNDEFINED", "Carrier", "RefusedError"]

#: Longest wait for each answer; the code stays set until the end status (guide 1.1, note).
TIMEOUT_US = 10_000_000

#: The alarms "Point doesn't exist" and "Undefined pallet". They are assumed, because the manual
#: names no alarm.
UNDEFINED = ("6.204", "6.236")

#: Maps each kind of data to the command name after Read or Write, and to the field with the number.
_COMMANDS = {
    "points": ("Point", "point"),
    "comments": ("PointComment", "point"),
    "shifts": ("Shift", "shift"),
    "hands": ("Hand", "hand_number"),
    "pallets": ("Pallet", "pallet"),
}

#: A function that is called with the finished share, 0 to 1.
Progress = Callable[[float], None]


class RefusedError(Exception):
    """The error if the controller does not execute a request; the text is the reason."""


class Carrier:
    """A connection to a controller; while it is open, this program is the master.

    All dedicated inputs stay OFF. Since SI(00) is OFF, the controller is in emergency stop.

    Args:
        undefined: Alarms that mean "not defined" in the answer to a reference.

    Raises:
        NotConnectedError: the controller does not answer.
        RefusedError: the controller is executing a command.
    """

    def __init__(
        self,
        line: NetworkLine,
        undefined: Collection[str] = UNDEFINED,
        timeout_us: int = TIMEOUT_US,
    ) -> None:
        self._undefined = undefined
        self._ask = Asker(line, lambda text, event: False, patience_us=timeout_us)
        self._ask.open()
        if self._ask.status != READY:
            status = f"16#{self._ask.status:04X}"
            raise RefusedError(f"it shows the remote status {status} without a command")

    def read(self, asked: Sequence[Key], progress: Progress) -> Stored:
        """Read the values of these keys from the controller, without undefined data.

        Raises:
            LostError: the connection is gone.
            RefusedError: a reference ended in an alarm other than "not defined", was not answered
                in time, or was answered with data of another number.
        """
        stored = Stored(asked=list(asked))
        for done, key in enumerate(asked):
            value = self._read(key)
            if value is not None:
                stored.values[key] = value
            progress((done + 1) / len(asked))
        return stored

    def write(self, stored: Stored, wanted: Sequence[Key], progress: Progress) -> None:
        """Write these values to the controller. An undefined comment is written as spaces.

        Raises:
            LostError: the connection is gone.
            RefusedError: a definition ended in an alarm, or did not end in time, so it may have
                been executed. All earlier definitions have been executed.
        """
        for done, key in enumerate(wanted):
            self._run("Write", key, **_fields(key[0], stored.values.get(key, "")))
            progress((done + 1) / len(wanted))

    def _read(self, key: Key) -> Any:
        answer = self._run("Read", key)
        return _value(key[0], answer) if answer.status == NORMAL_END else None

    def _run(self, verb: str, key: Key, **fields: Any) -> Answer:
        kind, robot, number = key
        name, place = _COMMANDS[kind]
        what = f"{'reading' if verb == 'Read' else 'writing'} {kind[:-1]} {number}"
        try:
            answer = self._ask.command(f"{verb}{name}", robot, **{place: number}, **fields)
        except NoAnswerError as error:
            done = "" if verb == "Read" else "; it may be done, compare shows it"
            raise RefusedError(f"{what}: {error}{done}") from None
        if answer.status == NORMAL_END:
            _check_number(what, answer.fields, {place: number, "robot_number": robot})
        elif verb != "Read" or answer.alarm not in self._undefined:
            raise RefusedError(f"{what} ended in the alarm {answer.alarm}")
        return answer


def _check_number(what: str, got: Mapping[str, Any], asked: Mapping[str, int]) -> None:
    """Check that an answer has the requested number, and for hands the requested robot.

    The number is in word m+4 (guide 4.3).
    """
    for name, number in asked.items():
        if name in got and got[name] != number:
            said = name.replace("_number", "")
            raise RefusedError(f"{what}: it was answered with {said} {got[name]}")


def _value(kind: str, answer: Answer) -> Any:
    """Return the value in an answer. Return None if the answer does not contain a definition."""
    got = answer.fields
    if kind == "points":
        return Point.of(got)
    if kind == "comments":
        return got["comment"].rstrip("\0 ") or None
    if kind == "shifts":
        return tuple(got["shift_data"])
    if kind == "hands":
        return Hand.of(got)
    pallet = Pallet.of(got)
    return pallet if pallet.count else None


def _fields(kind: str, value: Any) -> dict[str, Any]:
    """Return the fields of the command that defines a value."""
    if kind == "comments":
        return {"comment": value.ljust(16)}
    if kind == "shifts":
        return {"shift_data": value}
    fields: dict[str, Any] = value.fields
    return fields
