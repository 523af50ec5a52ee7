"""What a controller and its robot are like: every property with its default."""

from rcx_harness.robot.config.config import RobotConfig
from rcx_harness.robot.config.sections import SECTIONS, Axis, RobotProgram

__all__ = ["SECTIONS", "Axis", "RobotConfig", "RobotProgram"]
