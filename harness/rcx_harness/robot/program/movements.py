"""The execution of movements and of other statements that are remote commands.

A movement begins when the previous movement permits it. Options, such as outputs, take effect
during the movement. A movement ends when its axes are in the OUT position range. The functions
return NEXT or STAY, like the functions of `execution`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Protocol

from rcx_harness.robot.alarms import CommandError
from rcx_harness.robot.arm import Arm
from rcx_harness.robot.motion import Motion, Movement
from rcx_harness.robot.program.expressions import (
    Scope,
    Surroundings,
    evaluate,
    is_true,
    number_of,
    write_ports,
)
from rcx_harness.robot.program.motion import PATH_START, Request, Way, path_part, request
from rcx_harness.robot.program.syntax import NEXT, STAY, Instruction, Node
from rcx_harness.robot.program.values import integer

__all__ = [
    "MovingTask",
    "MovingWorld",
    "Statement",
    "command",
    "define_path",
    "move",
    "wait_arm",
]


class Statement(Protocol):
    """A remote command that a statement of a program has begun."""

    def step(self, machine: Any) -> Mapping[str, Any] | None:
        """Execute the command for one cycle; return its response at its end, else None."""


class MovingTask(Scope, Protocol):
    """The state of a task that movements use; see RobotTask."""

    at: int
    interrupted: bool
    execution: Statement | None
    passed: set[int]
    moving_at: int


class MovingWorld(Surroundings, Protocol):
    """The parts of the controller that movements read and change; see Programs."""

    @property
    def motion(self) -> Motion:
        """Return the movements of all robots."""

    @property
    def positions(self) -> list[int]:
        """Return the positions of all axes [pulses]."""

    @property
    def ways(self) -> dict[int, Way]:
        """Return the paths that PATH statements have defined, by robot."""

    def perform(self, wanted: Request) -> Statement | None:
        """Execute a remote command at once, or begin it if it takes time."""

    def step(self, statement: Statement) -> bool:
        """Execute a remote command for one cycle; return whether the command has ended."""


def move(one: Instruction, task: MovingTask, world: MovingWorld) -> int:
    """Execute a movement until its axes are in the OUT position range or STOPON ends it."""
    robot = one.args[0]
    options = one.args[3] if one.kind in ("move", "movei", "movet") else one.args[2:]
    _drop_interrupted(task)
    if task.execution is None:
        if not _may_begin(robot, world):
            return STAY
        if one.kind == "path_start":
            wanted = _follow(robot, task.moving_at == task.at, world)
        else:
            wanted = request(one, world, task)
        task.execution = world.perform(wanted)
        task.moving_at = task.at
        task.passed = set()
        movement = _movement_of(task.execution)
        movement.by_program = True
        movement.continuous = any(option.kind == "cont" for option in options)
    assert task.execution is not None
    movement = _movement_of(task.execution)
    _switch_on_the_way(options, movement, task, world, robot)
    for option in options:
        if option.kind == "stop_on" and is_true(option.args[0], world, task):
            world.motion.cancel(robot)
            task.execution, task.moving_at = None, -1
            return NEXT
    if not world.step(task.execution) and not (one.kind != "push" and _is_out(movement, world)):
        return STAY
    task.execution, task.moving_at = None, -1
    return NEXT


def _follow(robot: int, resumed: bool, world: MovingWorld) -> Request:
    """Return the command for PATH START with the path that was defined for the robot."""
    way = world.ways.get(robot)
    if way is None or not way.ended or not way.parts:
        raise CommandError(world.config.program_path_alarm)
    return Request(PATH_START, robot, {"way": way, "resumed": resumed})


def define_path(one: Instruction, task: MovingTask, world: MovingWorld) -> int:
    """Execute PATH SET, PATH L, PATH C or PATH END, which define a path."""
    robot = one.args[0]
    way = world.ways.get(robot)
    if one.kind == "path_set":
        arm, given = world.arm(robot), one.args[1]
        start = arm.here
        if given is not None:
            point = evaluate(given, world, task)
            hand = point.hand or arm.hand_system
            start = arm.pulses_of(point.data, mm=point.mm, hand=hand)
        world.ways[robot] = Way(start)
        return NEXT
    if way is None or way.ended:
        raise CommandError(world.config.program_path_alarm)
    if one.kind == "path":
        world.ways[robot] = replace(way, parts=(*way.parts, path_part(one, world, task)))
    else:
        world.ways[robot] = replace(way, ended=True)
    return NEXT


def _may_begin(robot: int, world: MovingWorld) -> bool:
    """Return whether the previous movement permits the next movement to begin.

    The previous movement must have ended, or have CONT and be in the OUT position range.

    If a remote command moves the robot, the program does not wait. It gets an alarm.
    """
    before = world.motion.under_way_of(robot)
    if before is None or before.done or not before.by_program:
        return True
    if before.continuous and _is_out(before, world):
        world.motion.cancel(robot)
        return True
    return False


def _drop_interrupted(task: MovingTask) -> None:
    """Discard a movement that a stop has ended. The continued program begins it again."""
    if not task.interrupted:
        return
    task.interrupted = False
    movement = getattr(task.execution, "movement", None)
    if movement is None or movement.stopped_by:
        task.execution = None


def _movement_of(execution: Statement | None) -> Movement:
    movement: Movement = execution.movement  # type: ignore[union-attr]
    return movement


def _is_out(movement: Movement, world: MovingWorld) -> bool:
    """Return whether all moving axes are in the OUT position range (guide, 4.2.1)."""
    if (world.now_us - movement.start_us) < movement.path.approach * 1e6:
        return False
    if movement.out_positions is None:
        config, get = world.config, world.memory.parameters.get
        movement.out_positions = {
            index: get(robot, "OUTPOS", config.axes_of(robot).index(index))
            for index in movement.path.target
            for robot in (config.axes[index].robot,)
        }
    for index, end in movement.path.target.items():
        if abs(end - world.positions[index]) > movement.out_positions[index]:
            return False
    return True


def _switch_on_the_way(
    options: Sequence[Node], movement: Movement, task: MovingTask, world: MovingWorld, robot: int
) -> None:
    """Write the output of an option such as `DO(20)=1@30.0` once the tool has moved 30.0 mm."""
    pending = [
        (k, option)
        for k, option in enumerate(options)
        if option.kind == "output_at" and k not in task.passed
    ]
    if not pending:
        return
    arm = world.arm(robot)
    begin, here = map(arm.frame.to_mm, (_start(movement, arm), arm.here))
    way = math.dist(begin[:3], here[:3]) / 1000
    for k, option in pending:
        port, value, distance = option.args
        if way >= number_of(evaluate(distance, world, task), world.config) or movement.finished:
            write_ports(port.args, integer(evaluate(value, world, task), world.config), world)
            task.passed.add(k)


def _start(movement: Movement, arm: Arm) -> tuple[float, ...]:
    """Return the positions of all axes of a robot at the start of its movement [pulses]."""
    begin = movement.path.at(0.0)
    return tuple(begin.get(index, now) for index, now in zip(arm.indices, arm.here, strict=True))


def command(one: Instruction, task: MovingTask, world: MovingWorld) -> int:
    """Execute a statement that is a remote command but not a movement with options."""
    _drop_interrupted(task)
    if task.execution is None:
        task.execution = world.perform(request(one, world, task))
    if task.execution is not None and not world.step(task.execution):
        return STAY
    task.execution = None
    return NEXT


def wait_arm(one: Instruction, task: MovingTask, world: MovingWorld) -> int:
    """Execute WAIT ARM: wait for the end of a movement, or for the tolerances of given axes."""
    robot, *axes = one.args
    if axes == [None]:
        return STAY if world.motion.moving(robot) else NEXT
    indices = world.arm(robot).indices
    places = [integer(evaluate(axis, world, task), world.config) for axis in axes if axis]
    if not all(1 <= place <= len(indices) for place in places):
        raise CommandError(world.config.no_axis_alarm)
    if not world.motion.moving(robot):
        return NEXT
    movement = world.motion.under_way_of(robot)
    near = {indices[place - 1] for place in places}
    if movement is None or not near or not movement.is_near(world.now_us, world.positions, near):
        return STAY
    return NEXT
