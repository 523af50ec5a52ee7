"""The properties of a controller and its robots, with their defaults."""

from rcx_harness.robot.config.config import SECTIONS, Axis, RobotConfig, RobotProgram

__all__ = ["SECTIONS", "Axis", "RobotConfig", "RobotProgram"]
