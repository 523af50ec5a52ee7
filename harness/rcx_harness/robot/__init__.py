"""The virtual robot controller: signals, handshake, commands, motion, alarms; without a network."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rcx_harness.robot.config import Axis, RobotConfig, RobotProgram
    from rcx_harness.robot.controller import Controller
    from rcx_harness.robot.events import EVENTS
    from rcx_harness.robot.signals import Led
    from rcx_harness.robot.stored import Hand, Pallet, Point
    from structured_text.errors import Violation

_HOME = {"Controller": "controller", "EVENTS": "events", "Violation": "findings", "Led": "signals"}
_HOME |= dict.fromkeys(("Axis", "RobotConfig", "RobotProgram"), "config")
_HOME |= dict.fromkeys(("Hand", "Pallet", "Point"), "stored")

__all__ = [
    "EVENTS",
    "Axis",
    "Controller",
    "Hand",
    "Led",
    "Pallet",
    "Point",
    "RobotConfig",
    "RobotProgram",
    "Violation",
]


def __getattr__(name: str) -> Any:
    """Import a public name on first use.

    A program that only reads a trace or a robot file does not need the controller. So the
    controller is not imported for such a program.
    """
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
