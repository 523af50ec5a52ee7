"""Category 7: utility mode setting operations (guide, 4.8)."""

from __future__ import annotations

from rcx_harness.robot.commands.base import Call, CommandError, Response, act
from rcx_harness.robot.machine import Machine

__all__ = ["reset_alarm"]


@act(0x604)
def reset_alarm(machine: Machine, call: Call) -> Response:
    """Reset the alarms (4.8.3); an alarm that stays ends the command with its own number."""
    remaining = machine.reset_alarms()
    if remaining:
        raise CommandError(remaining)
    return {}
