"""The remote commands, one module for one or two of the guide's categories.

Category 1 has three modules.

Each module registers its commands by code. The format of the telegrams is in
spec/remote_commands.toml and is checked before a command is called. Import new modules here.
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
