"""The remote commands, by the guide's categories; category 1 is in three modules.

A module registers its commands by code. The format of their telegrams is in
spec/remote_commands.toml and is checked before they are called. New modules are imported here.
"""

from rcx_harness.robot.commands import (  # noqa: F401  (register)
    data,
    jog,
    moves,
    programs,
    references,
    setup,
    utility,
)
from rcx_harness.robot.commands.base import Call, Execution, Response, perform, start

__all__ = ["Call", "Execution", "Response", "perform", "start"]
