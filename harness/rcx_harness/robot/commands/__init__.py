"""What the remote commands do: one module per category of the guide.

A module registers its commands by code; the format of their telegrams is in
spec/remote_commands.toml and checked before they are called. A new module is imported here.
"""

from rcx_harness.robot.commands import (  # noqa: F401  (register)
    clock,
    comments,
    data,
    drive,
    elements,
    hands,
    jog,
    messages,
    movement,
    moves_relative,
    movet,
    origins,
    pallet_moves,
    pallets,
    parameters,
    points,
    ports,
    programs,
    push,
    realtime,
    servo,
    settings,
    shifts,
    states,
    task_states,
    teaching,
    utility,
    variables,
)
from rcx_harness.robot.commands.base import Call, CommandError, Execution, Response, start

__all__ = ["Call", "CommandError", "Execution", "Response", "start"]
