"""Faults of a cell that interrupt a sequence, and the removal of each fault."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from fault_cell import FaultCell


@dataclass(frozen=True)
class Fault:
    """A fault and the removal of its cause.

    `lasts` is its duration [scans], or None for a fault that lasts until the block has ended.
    """

    name: str
    begin: Callable[[FaultCell], None]
    end: Callable[[FaultCell], None]
    lasts: int | None = None


def _inject(event: str, **args: int) -> Callable[[FaultCell], None]:
    return lambda cell: cell.cell.inject(event, **args)


def _set(name: str, value: bool) -> Callable[[FaultCell], None]:
    def act(cell: FaultCell) -> None:
        cell[name] = value

    return act


def _nothing(cell: FaultCell) -> None:
    """Do nothing, because there is no fault or its cause disappears by itself."""


NONE = Fault("none", _nothing, _nothing)

#: All faults by name.
FAULTS: dict[str, Fault] = {
    fault.name: fault
    for fault in (
        NONE,
        Fault("emergency stop", _inject("emergency_stop"), _inject("emergency_stop_release")),
        Fault(
            "short emergency stop", _inject("emergency_stop"), _inject("emergency_stop_release"), 2
        ),
        Fault("SI00 off", _set("EmergencyStopOk", False), _set("EmergencyStopOk", True)),
        Fault("short SI00 off", _set("EmergencyStopOk", False), _set("EmergencyStopOk", True), 1),
        Fault("stop", _set("StopOk", False), _set("StopOk", True)),
        Fault("short stop", _set("StopOk", False), _set("StopOk", True), 1),
        Fault("alarm", _inject("alarm", group=2, category=334), _nothing),
        Fault("link down", _inject("link_down"), _inject("link_up")),
        Fault("short link down", _inject("link_down"), _inject("link_up"), 7),
        Fault("power cycle", _inject("power_cycle"), _nothing),
        Fault("manual mode", _inject("manual_mode"), _inject("auto_mode")),
        Fault("programming box", _inject("pendant_on"), _inject("pendant_off")),
    )
}
