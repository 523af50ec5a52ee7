"""The robot programs and their tasks: states, progress, and the sources of SO(13) and SO(14).

Every program has one place in the list of programs, which is its number, and one `RobotTask`. The
task is in the table of tasks once the program is registered there: by a remote command, by START,
or as the main program, which is in task 1 from power-on.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

from rcx_harness.robot.config import RobotConfig, RobotProgram
from rcx_harness.robot.ports import Port, Ports
from rcx_harness.robot.script import Delay, End, Gosub, Return, ScriptStep, TaskStep, Wait, script

__all__ = ["TASKS", "Programs", "RobotTask"]

#: Numbers of the tasks.
TASKS = range(1, 17)
#: Modes of a start: run without limit, one line, or one line with its subroutine.
RUN, STEP, NEXT = "run", "step", "next"

#: Limit of steps of a task in one controller cycle; a program that never waits continues in the
#: next cycle, so an endless loop of steps cannot block the controller.
_STEPS = 100
#: Priority of the main program and of programs that others start.
_PRIORITY = 32


class RobotTask:
    """One program as a task. `elapsed_us` is its progress without the time of its stops.

    `state` is `ready` (reset, or not yet started), `running`, `stopped`, `suspended` or `ended`.

    Attributes:
        number: In the table of tasks; 0 while the program is not registered.
        priority: 1 (first in each cycle) to 64.
        temporary: A program has registered it; it leaves the table at its end or reset.
    """

    def __init__(self, program: RobotProgram, size: int) -> None:
        self.program = program
        self._size = size
        self.state = "ready"
        self.number = 0
        self.priority = _PRIORITY
        self.temporary = False
        self.rewind()
        self.since_us = 0

    def __deepcopy__(self, memo: object) -> RobotTask:
        """Return a copy that shares the program, because programs never change."""
        copied = RobotTask.__new__(RobotTask)
        copied.__dict__.update(self.__dict__)
        return copied

    def rewind(self) -> None:
        """Go back to the first step."""
        self.at = 0
        self.elapsed_us = 0
        self.until_us: int | None = None
        """The end of the delay under way, counted as `elapsed_us`; None without a delay."""
        self.waits = False
        self.calls: tuple[int, ...] = ()
        """The GOSUBs that have not returned yet, by their places."""
        self.mode = RUN
        self.depth = 0

    @property
    def steps(self) -> tuple[ScriptStep, ...]:
        """Return the steps of the program; a program without steps is a delay of `duration`."""
        if self.program.steps:
            return script(self.program.steps, self._size)
        return (Delay(round(self.program.duration * 1000)),)

    @property
    def line(self) -> int:
        """Return the line that is executed, from 1."""
        return self.at + 1

    @property
    def endless(self) -> bool:
        """Return whether the task runs forever without executing any step."""
        return self.program.loop and not self.program.steps and self.mode == RUN

    def go(self, now_us: int, mode: str = RUN) -> None:
        """Start, or continue after a stop, as far as the mode says."""
        self.state = "running"
        self.since_us = now_us
        self.mode = mode
        self.depth = len(self.calls)

    def pause(self, now_us: int, state: str = "stopped") -> None:
        """Stop, or wait in another `state`; the time until the task continues does not count."""
        if self.state == "running":
            self.state = state
            self.elapsed_us += now_us - self.since_us

    def end(self) -> None:
        """End the task; its next start begins at the first step."""
        if self.state in ("running", "stopped", "suspended"):
            self.state = "ended"
            self.rewind()
        self._leave()

    def reset(self) -> None:
        """Reset the task to its first step; it does not run."""
        self.rewind()
        self.state = "ready"
        self._leave()

    def skip(self) -> None:
        """Skip the current line."""
        self.until_us, self.waits = None, False
        self.state = "stopped"
        self.at += 1
        self.come_round()

    def come_round(self) -> None:
        """Go back to the first line, or end, if the task is behind its last line."""
        if self.at < len(self.steps):
            return
        self.rewind()
        if not self.program.loop:
            self.end()

    @property
    def has_done_its_line(self) -> bool:
        """Return whether the task was started for one line only and has finished it."""
        return self.mode == STEP or (self.mode == NEXT and len(self.calls) <= self.depth)

    def due_us(self, now_us: int) -> int | None:
        """Return when the task continues by itself; None if it waits for an input or is stopped."""
        if self.state != "running" or self.endless or self.waits:
            return None
        if self.until_us is None:
            return now_us
        return self.since_us + self.until_us - self.elapsed_us

    def _leave(self) -> None:
        if self.temporary:
            self.number, self.temporary = 0, False


class Programs:
    """All tasks, with the ports and variables on which they act.

    Attributes:
        ports: The controller's general-purpose ports.
        tasks: One for each program of the configuration, in the order of their numbers.
        is_reset: The program has been reset and not started since: SO(14).
        variables: The variables of the programs, by name.
    """

    def __init__(self, config: RobotConfig, ports: Ports) -> None:
        self._config = config
        self.ports = ports
        self.variables: dict[str, int] = {}
        self.tasks = [RobotTask(program, config.size) for program in config.programs]
        self.tasks[0].number = TASKS[0]
        self.is_reset = config.program_is_reset
        self._now_us = 0
        self._pulses: list[tuple[int, Port]] = []
        self._to_start: dict[int, str] | None = None
        self._to_reset: Collection[int] | None = None

    @property
    def main(self) -> RobotTask:
        """Return the main program: the program in task 1, else the first program."""
        return self.in_task(TASKS[0]) or self.tasks[0]

    @property
    def running(self) -> bool:
        """Return SO(13): whether the robot program is being executed."""
        if self._config.running_shows_all_tasks:
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
        """Register a program in a task; the previous program leaves the table.

        `number` is 1 to 16, or 0 for the lowest vacant task, where the program's own task counts as
        vacant.

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

        `modes` has RUN, STEP or NEXT by place in `tasks`; None: all tasks that can run. With
        `beside`, earlier orders stay valid.
        """
        before = self._to_start if beside else {}
        self._to_start = None if before is None or modes is None else {**before, **modes}

    def order_reset(self, places: Collection[int] | None, *, beside: bool = False) -> None:
        """Define which tasks the next `reset` resets.

        `places` are places in `tasks`; None: all tasks. With `beside`, earlier orders stay valid.
        """
        before = self._to_reset if beside else ()
        self._to_reset = None if before is None or places is None else (*before, *places)

    @property
    def resets_running(self) -> bool:
        """Return whether the next `reset` would reset a running task."""
        places = range(len(self.tasks)) if self._to_reset is None else self._to_reset
        return any(self.tasks[place].state == "running" for place in places)

    def start(self, now_us: int) -> None:
        """Start the ordered tasks."""
        modes = self._to_start
        if modes is None:
            modes = dict.fromkeys(self._startable(), RUN)
        for place, mode in modes.items():
            task = self.tasks[place]
            if self._config.restart_begins_anew and task.state == "stopped" and mode == RUN:
                task.rewind()
            task.go(now_us, mode)
        self.is_reset = False

    def pause(self, now_us: int) -> None:
        """Stop all tasks."""
        for task in self.tasks:
            task.pause(now_us)

    def reset(self) -> None:
        """Reset the ordered tasks."""
        if self._to_reset is not None:
            for place in self._to_reset:
                self.tasks[place].reset()
            self.is_reset = all(task.state == "ready" for task in self.tasks if task.number)
            return
        for task in self.tasks:
            task.reset()
        self.is_reset = True
        self._pulses.clear()
        if self._config.reset_clears_outputs:
            self.ports.clear_outputs()

    def halt(self) -> None:
        """End all tasks."""
        for task in self.tasks:
            task.end()

    def end_main(self) -> None:
        """End the main program."""
        self.main.end()
        if self._config.main_ends_tasks:
            self.halt()

    def pulse(self, place: Port, ms: int) -> None:
        """Turn an output ON, and OFF again after `ms`."""
        self.ports.write(place, 1)
        self._pulses.append((self._now_us + 1000 * ms, place))

    def advance(self, now_us: int) -> None:
        """Execute the steps of all running tasks, in the order of their priorities."""
        self._now_us = now_us
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

    def next_due_us(self, now_us: int) -> int | None:
        """Return when a task or a pulse continues by itself; None if nothing is due."""
        due = [due_us for due_us, _ in self._pulses]
        for task in self.tasks:
            if task.state == "running" and (task_us := task.due_us(now_us)) is not None:
                due.append(task_us)
        return min(due, default=None)

    def _startable(self) -> list[int]:
        """Return the places of registered tasks that can start; if none can, of ended tasks."""
        registered = [place for place, task in enumerate(self.tasks) if task.number]
        waiting = [k for k in registered if self.tasks[k].state in ("stopped", "ready")]
        if waiting or self.busy:
            return waiting
        return [k for k in registered if self.tasks[k].state == "ended"]

    def _work(self, task: RobotTask, now_us: int) -> None:
        steps = task.steps
        for _ in range(_STEPS):
            if task.at >= len(steps):
                self._finish(task, now_us)
                return
            if not self._done(task, steps[task.at], now_us):
                return
            if task.state == "suspended":  # by its own SUSPEND: it continues behind that line
                task.at += 1
            if task.state != "running":
                return
            task.at += 1
            if task.has_done_its_line:
                task.pause(now_us)
                task.come_round()
                return

    def _done(self, task: RobotTask, step: ScriptStep, now_us: int) -> bool:
        """Execute a step; return False if the task has to wait in it."""
        if isinstance(step, Wait):
            task.waits = self.ports.read(step.place) != step.value
            return not task.waits
        if isinstance(step, Delay):
            passed_us = task.elapsed_us + now_us - task.since_us
            if task.until_us is None:
                task.until_us = passed_us + step.us if task.program.steps else step.us
            if passed_us < task.until_us:
                return False
            task.until_us = None
        elif isinstance(step, TaskStep):
            self._act_on(step, now_us)
        elif isinstance(step, Gosub):
            task.calls += (task.at,)
            task.at = step.at
        elif isinstance(step, Return) and task.calls:
            task.at, task.calls = task.calls[-1], task.calls[:-1]
        elif isinstance(step, (Return, End)):
            task.at = len(task.steps) - 1
        else:
            step(self)
        return True

    def _act_on(self, step: TaskStep, now_us: int) -> None:
        other = self.tasks[step.number - 1]
        if step.what == "SUSPEND":
            other.pause(now_us, "suspended")
        elif step.what == "RESTART":
            if other.state == "suspended":
                other.go(now_us)
        elif other.state in ("ready", "ended") and (
            other.number or self.register(other, 0, _PRIORITY, temporary=True)
        ):
            other.go(now_us)

    def _finish(self, task: RobotTask, now_us: int) -> None:
        if task.program.loop:
            task.rewind()
            task.since_us = now_us
        elif task is self.main:
            self.end_main()
        else:
            task.end()
