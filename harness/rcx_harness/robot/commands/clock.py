"""Categories 6 and 7: date and time in the controller (guide, 4.7.13, 4.7.14, 4.8.1, 4.8.2)."""

from __future__ import annotations

from rcx_harness.robot.commands.base import Call, CommandError, Response, act
from rcx_harness.robot.machine import Machine

__all__ = ["read_date", "read_time", "set_date", "set_time"]


@act(0x511)
def read_date(machine: Machine, call: Call) -> Response:
    """The date (4.7.13)."""
    now = machine.data.clock.now(machine.now_us)
    return {"year": now.year % 100, "month": now.month, "day": now.day}


@act(0x512)
def read_time(machine: Machine, call: Call) -> Response:
    """The time (4.7.14)."""
    now = machine.data.clock.now(machine.now_us)
    return {"hour": now.hour, "minute": now.minute, "second": now.second}


@act(0x602)
def set_date(machine: Machine, call: Call) -> Response:
    """Set the date (4.8.1), if there is such a day."""
    values = call.values
    try:
        machine.data.clock.set_date(machine.now_us, values["year"], values["month"], values["day"])
    except ValueError:
        raise CommandError(machine.config.impossible_date_alarm) from None
    return {}


@act(0x603)
def set_time(machine: Machine, call: Call) -> Response:
    """Set the time (4.8.2)."""
    hour, minute, second = (call.values[name] for name in ("hour", "minute", "second"))
    machine.data.clock.set_time(machine.now_us, hour, minute, second)
    return {}
