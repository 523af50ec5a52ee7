"""The virtual controller: signals, handshake, commands, motion, alarms. It knows no network."""

from rcx_harness.robot.config import Axis, RobotConfig, RobotProgram
from rcx_harness.robot.controller import Controller
from rcx_harness.robot.events import EVENTS
from rcx_harness.robot.findings import Violation
from rcx_harness.robot.signals import Led
from rcx_harness.robot.stored import Hand, Pallet, Point

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
