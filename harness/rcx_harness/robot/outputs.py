"""What the dedicated outputs show of the machine."""

from __future__ import annotations

from rcx_harness.robot.area import OUTPUTS
from rcx_harness.robot.machine import Machine

__all__ = ["dedicated_outputs"]


def dedicated_outputs(machine: Machine) -> int:
    """Ports SO0() (low byte) and SO1() (manual chapter 5, 1)."""
    states = {
        "SO00": machine.emergency,
        "SO01": True,
        "SO02": machine.servo_on,
        "SO03": machine.alarms.serious,
        "SO04": machine.mp_ready,
        "SO10": machine.auto_mode,
        "SO11": machine.origin_complete,
        "SO12": machine.sequence_running,
        "SO13": machine.program.running,
        "SO14": machine.program.is_reset,
        "SO15": machine.alarms.warning,
    }
    return sum(OUTPUTS[name] for name, on in states.items() if on)
