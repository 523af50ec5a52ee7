"""Every rule that the virtual controller follows: what the manual says, and what is assumed.

A manual rule has a section. An assumed one, where the manual is silent, has the knobs of
RobotConfig that change it; without a knob it is a simplification of the model.
Sections: `ch. 5, 3.1` is the main manual, `guide, 1.1` the remote command guide in it.
"""

from __future__ import annotations

from rcx_harness.robot.rule import Rule
from rcx_harness.robot.rules_commands import COMMAND_RULES
from rcx_harness.robot.rules_data import DATA_RULES
from rcx_harness.robot.rules_memory import MEMORY_RULES
from rcx_harness.robot.rules_motion import MOTION_RULES
from rcx_harness.robot.rules_movement import MOVEMENT_RULES
from rcx_harness.robot.rules_settings import SETTING_RULES
from rcx_harness.robot.rules_signals import SIGNAL_RULES

__all__ = ["RULES", "Rule"]

#: In the order of the areas: power and link, dedicated signals, remote commands by category.
RULES: tuple[Rule, ...] = (
    *SIGNAL_RULES,
    *COMMAND_RULES,
    *MOTION_RULES,
    *MOVEMENT_RULES,
    *SETTING_RULES,
    *MEMORY_RULES,
    *DATA_RULES,
)
