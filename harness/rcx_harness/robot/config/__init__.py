"""What a controller and its robot are like: every property with its default."""

from rcx_harness.robot.config.config import Axis, RobotConfig, RobotProgram

__all__ = ["Axis", "RobotConfig", "RobotProgram"]
