"""What a controller and its robot are like: every property with its default."""

from rcx_harness.robot.config.config import SECTIONS, Axis, RobotConfig, RobotProgram

__all__ = ["SECTIONS", "Axis", "RobotConfig", "RobotProgram"]
