"""PUSH: one axis moves to a target and pushes what stands in its way (guide, 4.2.23)."""

from __future__ import annotations

from dataclasses import replace

from rcx_harness.robot.commands.base import Call, Response, last
from rcx_harness.robot.commands.drive import axis_target
from rcx_harness.robot.commands.moving import Moving, pace, position_output
from rcx_harness.robot.commands.planning import plan_ptp
from rcx_harness.robot.machine import Machine

__all__ = ["Push"]


@last(0x04B, 0x04C, 0x04D)
class Push(Moving):
    """Ends when the axis has pushed for the push time, or has reached its target.

    A time that is not given is the axis' parameter PSHTIME; PSHSPD reduces the speed. The force
    is checked and has no effect in this model.
    """

    def __init__(self, machine: Machine, call: Call) -> None:
        values, parameters = call.values, machine.memory.parameters
        target = axis_target(machine, call)
        (place,) = target

        def parameter(name: str) -> int:
            return parameters.get(call.robot, name, place)

        time_ms = values["push_time"] if values["push_time_flag"] else parameter("PSHTIME")
        self._time_us = time_ms * 1000
        how = pace(machine, call)
        how = replace(how, share=how.share * parameter("PSHSPD") / 100)
        path = plan_ptp(machine, call.robot, target, how)
        super().__init__(call, machine.move(call.robot, path, pushing=True))

    def step(self, machine: Machine) -> Response | None:
        """The completion result: 1 after the push time, 0 at the target."""
        reached = super().step(machine)
        if reached is not None:
            return {**reached, "push_done": 0}
        since = self.movement.blocked_us
        if since is None or machine.now_us - since < self._time_us:
            return None
        machine.motion.cancel(self.call.robot)
        return {**position_output(machine, self.call), "push_done": 1}
