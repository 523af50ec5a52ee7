"""The table of tasks, which starts, stops and executes the tasks and determines SO(13) and SO(14).

The number of a program is its position in the list of programs, from 1. Each program has a
`RobotTask`, which is in the table of tasks only while the program is registered. A remote command
or START registers a program; the main program is in task 1 from power-on.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from datetime import datetime
from typing import Any, NamedTuple, Protocol

from rcx_harness.robot.alarms import STOP, AlarmList, CommandError, Place
from rcx_harness.robot.arm import Arm
from rcx_harness.robot.config import RobotConfig
from rcx_harness.robot.controller_memory import Memory
from rcx_harness.robot.data import Data
from rcx_harness.robot.motion import Motion
from rcx_harness.robot.ports import Port, Ports
from rcx_harness.robot.program.execution import Order, execute
from rcx_harness.robot.program.motion import Request, Way
from rcx_harness.robot.program.movements import Statement
from rcx_harness.robot.program.observing import Observers
from rcx_harness.robot.program.syntax import NEXT, STAY
from rcx_harness.robot.program.task import MAIN_PRIORITY, RUN, RobotTask
from rcx_harness.robot.program.values import Value

__all__ = ["TASKS", "Perform", "ProgramError", "Programs"]

#: The numbers of the tasks, 1 to 16.
TASKS = range(1, 17)
_ROBOT_TASK = 2  # the value "task" for `kind` of a Place

#: The type of a function that executes a statement as a remote command; see commands/base.py.
Perform = Callable[[Any, Request], Any]


class ProgramError(NamedTuple):
    """An error that has stopped a robot program.

    Attributes:
        t_us: Time of the error.
        program: Name of the program.
        line: Line with the error.
        number: Number of the alarm.
    """

    t_us: int
    program: str
    line: int
    number: str


class Surroundings(Protocol):
    """The parts of the controller that the robot programs use; see Machine."""

    config: RobotConfig
    now_us: int
    memory: Memory
    motion: Motion
    ports: Ports
    positions: list[int]
    alarms: AlarmList
    perform: Perform
    data: Data

    def arm(self, robot: int) -> Arm:
        """Return a robot by its number, 1 to 4."""

    def raise_alarm(self, number: str, *, serious: bool | None = None) -> None:
        """Raise an alarm."""


class Programs:
    """All tasks of a controller, and the parts of the controller that the programs use.

    Attributes:
        tasks: A RobotTask for each program of the configuration, in the order of the program
            numbers.
        is_reset: Whether the program has been reset and not started since then: SO(14).
        variables: The variables of the programs that are steps of the robot file, by name.
        errors: The errors that have stopped a program since power-on.
        observers: The objects that are called at each instruction.
        ways: The paths that PATH statements have defined, by robot.
    """

    def __init__(self, machine: Surroundings, observers: Observers | None = None) -> None:
        self._machine = machine
        self.config = config = machine.config
        self.variables: dict[str, Value] = {}
        self.errors: list[ProgramError] = []
        self.observers = Observers() if observers is None else observers
        plain = config.plain_variables
        self.tasks = [RobotTask(program, self.variables, plain) for program in config.programs]
        self.tasks[0].number = TASKS[0]
        self.is_reset = config.program_is_reset
        self.ways: dict[int, Way] = {}
        self._counted_from_us = 0
        self._pulses: list[tuple[int, Port]] = []
        self._to_start: dict[int, str] | None = None
        self._to_reset: Collection[int] | None = None

    @property
    def now_us(self) -> int:
        """Return the time of the current controller cycle [us]."""
        return self._machine.now_us

    @property
    def ports(self) -> Ports:
        """Return the controller's general-purpose ports."""
        return self._machine.ports

    @property
    def memory(self) -> Memory:
        """Return the stored data."""
        return self._machine.memory

    @property
    def motion(self) -> Motion:
        """Return the movements of all robots."""
        return self._machine.motion

    @property
    def positions(self) -> list[int]:
        """Return the positions of all axes [pulses]."""
        return self._machine.positions

    def arm(self, robot: int) -> Arm:
        """Return a robot by its number, 1 to 4."""
        return self._machine.arm(robot)

    @property
    def main(self) -> RobotTask:
        """Return the main program: the program in task 1, or else the first program."""
        return self.in_task(TASKS[0]) or self.tasks[0]

    @property
    def running(self) -> bool:
        """Return SO(13), whether a robot program is being executed."""
        if self.config.running_shows_all_tasks:
            return self.busy
        return self.main.state == "running"

    @property
    def busy(self) -> bool:
        """Return whether any task runs."""
        return any(task.state == "running" for task in self.tasks)

    def in_task(self, number: int) -> RobotTask | None:
        """Return the program that is registered in a task, or None."""
        return next((task for task in self.tasks if task.number == number), None)

    def register(
        self, task: RobotTask, number: int, priority: int, *, temporary: bool = False
    ) -> bool:
        """Register a program in a task; the previous program of this task leaves the table.

        `number` is 1 to 16, or 0 for the lowest vacant task. For 0, the program's own task counts
        as vacant.

        Returns:
            False if no task is vacant.
        """
        if number == 0:
            taken = {other.number for other in self.tasks if other is not task}
            number = next((one for one in TASKS if one not in taken), 0)
        if number == 0:
            return False
        before = self.in_task(number)
        if before and before is not task:
            before.reset()
            before.number = 0
        task.number, task.priority, task.temporary = number, priority, temporary
        return True

    def order_start(self, modes: Mapping[int, str] | None, *, beside: bool = False) -> None:
        """Define which tasks the next `start` starts.

        Args:
            modes: Maps an index in `tasks` to RUN, STEP or NEXT_LINE; None: run all tasks that can
                run.
            beside: Whether earlier orders stay valid as well.
        """
        before = self._to_start if beside else {}
        self._to_start = None if before is None or modes is None else {**before, **modes}

    def order_reset(self, places: Collection[int] | None, *, beside: bool = False) -> None:
        """Define which tasks the next `reset` resets.

        `places` are indices in `tasks`; None: all tasks. With `beside`, earlier orders stay valid.
        """
        before = self._to_reset if beside else ()
        self._to_reset = None if before is None or places is None else (*before, *places)

    @property
    def resets_running(self) -> bool:
        """Return whether the next `reset` would reset a running task."""
        places = range(len(self.tasks)) if self._to_reset is None else self._to_reset
        return any(self.tasks[place].state == "running" for place in places)

    def start(self, now_us: int) -> None:
        """Start the tasks that `order_start` has selected."""
        modes = self._to_start
        if modes is None:
            modes = dict.fromkeys(self._startable(), RUN)
        for place, mode in modes.items():
            task = self.tasks[place]
            if self.config.restart_begins_anew and task.state == "stopped" and mode == RUN:
                task.rewind()
            task.go(now_us, mode)
        self.is_reset = False

    def pause(self, now_us: int) -> None:
        """Stop all running tasks; the next start continues them."""
        for task in self.tasks:
            task.pause(now_us)

    def reset(self) -> None:
        """Reset the tasks that `order_reset` has selected."""
        if self._to_reset is not None:
            for place in self._to_reset:
                self.tasks[place].reset()
            self.is_reset = all(task.state == "ready" for task in self.tasks if task.number)
            return
        for task in self.tasks:
            task.reset()
        self.is_reset = True
        self._pulses.clear()
        if self.config.reset_clears_outputs:
            self.ports.clear_outputs()

    def halt(self) -> None:
        """End all tasks, as the statement HALT does."""
        for task in self.tasks:
            task.end()

    def end_main(self) -> None:
        """End the main program."""
        self.main.end()
        if self.config.main_ends_tasks:
            self.halt()

    @property
    def clock(self) -> datetime:
        """Return date and time of the controller."""
        return self._machine.data.clock.now(self.now_us)

    @property
    def counted_us(self) -> int:
        """Return the time since power-on or the last RESET TCOUNTER [us]."""
        return self.now_us - self._counted_from_us

    def reset_counter(self) -> None:
        """Reset the counter of the function TCOUNTER to 0."""
        self._counted_from_us = self.now_us

    def error_of(self, number: int) -> tuple[str, int] | None:
        """Return alarm number and line of the last error that a task has handled.

        Raises:
            CommandError: there is no such task.
        """
        task = self.in_task(number)
        if task is None:
            raise CommandError(self.config.undefined_task_alarm)
        return task.error

    def pulse(self, place: Port, ms: int) -> None:
        """Turn an output ON, and turn it OFF after `ms` milliseconds."""
        self.ports.write(place, 1)
        self._pulses.append((self.now_us + 1000 * ms, place))

    def perform(self, wanted: Request) -> Statement | None:
        """Execute a remote command at once, or begin it if it takes time."""
        statement: Statement | None = self._machine.perform(self._machine, wanted)
        return statement

    def step(self, statement: Statement) -> bool:
        """Execute a remote command for one cycle; return whether the command has ended."""
        return statement.step(self._machine) is not None

    def order(self, task: RobotTask, wanted: Order) -> None:
        """Start, suspend, restart or cut a task.

        Raises:
            CommandError: there is no such program or task, or no task is vacant.
        """
        other = self._ordered(wanted)
        if wanted.what == "SUSPEND":
            other.pause(self.now_us, "suspended")
        elif wanted.what == "RESTART":
            if other.state == "suspended":
                other.go(self.now_us)
        elif wanted.what == "CUT":
            other.end()
        elif other.state in ("ready", "ended"):
            priority = wanted.priority or MAIN_PRIORITY
            if (wanted.task or not other.number) and not self.register(
                other, wanted.task or 0, priority, temporary=True
            ):
                raise CommandError(self.config.undefined_task_alarm)
            other.go(self.now_us)

    def end(self, task: RobotTask, *, everything: bool) -> None:
        """End the program of the task; with `everything`, end all programs."""
        if everything:
            self.halt()
        elif task is self.main:
            self.end_main()
        else:
            task.end()

    def hold(self, task: RobotTask, *, everything: bool) -> None:
        """Stop the program of the task; with `everything`, stop all programs.

        The next start continues the stopped programs.
        """
        for other in self.tasks if everything else (task,):
            other.pause(self.now_us)

    def advance(self, now_us: int) -> None:
        """Execute the instructions of all running tasks, in the order of their priorities."""
        for due_us, place in self._pulses:
            if due_us <= now_us:
                self.ports.write(place, 0)
        if self._pulses:
            self._pulses = [entry for entry in self._pulses if entry[0] > now_us]
        if not self.busy:
            return
        for task in sorted(self.tasks, key=lambda task: task.priority):
            if task.state == "running" and not task.endless:
                self._work(task, now_us)
        self.ports.statement = None

    def next_due_us(self, now_us: int) -> int | None:
        """Return when a task continues or a pulse ends [us]; None if nothing is due."""
        due = [due_us for due_us, _ in self._pulses]
        for task in self.tasks:
            if task.state == "running" and (task_us := task.due_us(now_us)) is not None:
                due.append(task_us)
        return min(due, default=None)

    def _startable(self) -> list[int]:
        """Return the indices in `tasks` of the registered tasks that can start.

        If there are none and no task runs, return the indices of the ended tasks.
        """
        registered = [place for place, task in enumerate(self.tasks) if task.number]
        waiting = [k for k in registered if self.tasks[k].state in ("stopped", "ready")]
        if waiting or self.busy:
            return waiting
        return [k for k in registered if self.tasks[k].state == "ended"]

    def _work(self, task: RobotTask, now_us: int) -> None:
        """Execute a task in this cycle until it waits, ends or has used up its statements."""
        code = task.code.code
        for _ in range(self.config.program_statements):
            at = task.at
            if at >= len(code):
                self._finish(task, now_us)
                return
            if self.ports.accesses is not None:
                self.ports.statement = (task.program.name, code[at].line)
            if task.begun != at:
                task.begun = at
                for observer in self.observers:
                    observer.begins(task, at)
            try:
                to = execute(code[at], task, self)
            except CommandError as error:
                # A stop is not an error of the program, because the stop input also stops the
                # program.
                if error.number == STOP:
                    task.execution = None
                    return
                to = self._failed(task, error.number)
            if task.state in ("ended", "ready") or to == STAY:
                return
            task.begun = -1
            for observer in self.observers:
                observer.ends(task, at, to)
            task.at = at + 1 if to == NEXT else to
            # The task has stopped itself with SUSPEND or HOLD. It later continues after that
            # statement.
            if task.state != "running":
                return
            if task.has_done(at):
                task.pause(now_us)
                task.come_round()
                return
        task.full_cycles += 1
        task.full_line = task.line

    def _failed(self, task: RobotTask, number: str) -> int:
        """Return the position of the error handler; if there is none, stop with an alarm.

        An error in the handler itself stops the program.
        """
        task.until_us, task.waits, task.execution, task.moving_at = None, False, None, -1
        if task.handler >= 0 and task.error_at < 0:
            task.error, task.error_at = (number, task.line), task.at
            return task.handler
        self.errors.append(ProgramError(self.now_us, task.program.name, task.line, number))
        place = Place(_ROBOT_TASK, task.number)
        self._machine.alarms.note(number, self.now_us, place=place)
        if self.config.program_error_is_serious:
            self._machine.raise_alarm(number, serious=True)
        self.hold(task, everything=self.config.program_error_stops_all)
        return STAY

    def _ordered(self, wanted: Order) -> RobotTask:
        """Return the task that an order names.

        Raises:
            CommandError: there is no such program, or no program is in the task.
        """
        if isinstance(wanted.program, int):
            return self.tasks[wanted.program - 1]
        if wanted.program is not None:
            for task in self.tasks:
                if task.program.name == wanted.program:
                    return task
            raise CommandError(self.config.undefined_program_alarm)
        other = self.in_task(wanted.task or 0)
        if other is None:
            raise CommandError(self.config.undefined_task_alarm)
        return other

    def _finish(self, task: RobotTask, now_us: int) -> None:
        if task.program.begins_again:
            task.rewind()
            task.since_us = now_us
        elif task is self.main:
            self.end_main()
        else:
            task.end()
