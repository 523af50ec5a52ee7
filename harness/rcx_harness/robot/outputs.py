"""What the dedicated outputs show of the machine."""

from __future__ import annotations

from itertools import compress

from rcx_harness.robot.area import OUTPUTS
from rcx_harness.robot.machine import Machine

__all__ = ["dedicated_outputs"]

_SHOWN = ("SO00", "SO01", "SO02", "SO03", "SO04", "SO10", "SO11", "SO12", "SO13", "SO14", "SO15")
_MASKS = tuple(OUTPUTS[name] for name in _SHOWN)


def dedicated_outputs(machine: Machine) -> int:
    """Ports SO0() (low byte) and SO1() (manual chapter 5, 1)."""
    faults = machine.config.cpu_fault_alarms
    states = (
        machine.emergency,  # SO00
        not any(map(machine.alarms.has, faults)),  # SO01
        machine.servo_on,  # SO02
        machine.alarms.serious,  # SO03
        machine.mp_ready,  # SO04
        machine.auto_mode,  # SO10
        machine.origin_complete,  # SO11
        machine.sequence_running,  # SO12
        machine.program.running,  # SO13
        machine.program.is_reset,  # SO14
        machine.alarms.warning,  # SO15
    )
    return sum(compress(_MASKS, states))
