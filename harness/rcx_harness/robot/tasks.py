"""The robot programs: which task runs, how far it has come, and what SO(13) and SO(14) show."""

from __future__ import annotations

from rcx_harness.robot.config import RobotConfig, RobotProgram
from rcx_harness.robot.ports import Port, Ports
from rcx_harness.robot.script import Delay, Start, Step, Wait, script

__all__ = ["Programs", "Task"]

#: Steps of a task in one controller cycle; a program that never waits goes on in the next one.
_STEPS = 100


class Task:
    """One program as a task. `elapsed_us` is how far it has come without counting its stops.

    `state` is `ready` (reset, or not yet started), `running`, `stopped` or `ended`.
    """

    def __init__(self, program: RobotProgram, size: int) -> None:
        self.program = program
        self._size = size
        self.state = "ready"
        self.rewind()
        self.since_us = 0

    def __deepcopy__(self, memo: object) -> Task:
        """A copy; the program never changes."""
        copied = Task.__new__(Task)
        copied.__dict__.update(self.__dict__)
        return copied

    def rewind(self) -> None:
        """To the first step."""
        self.at = 0
        self.elapsed_us = 0
        self.until_us: int | None = None
        """When the delay under way ends, counted as `elapsed_us`; None without one."""
        self.waits = False

    @property
    def steps(self) -> tuple[Step, ...]:
        """Its steps; without any it lasts `duration`."""
        if self.program.steps:
            return script(self.program.steps, self._size)
        return (Delay(round(self.program.duration * 1000)),)

    @property
    def endless(self) -> bool:
        """It runs and does nothing at all, for ever."""
        return self.program.loop and not self.program.steps

    def go(self, now_us: int) -> None:
        """Start, or go on after a stop."""
        if self.state != "stopped":
            self.rewind()
        self.state = "running"
        self.since_us = now_us

    def pause(self, now_us: int) -> None:
        """A stop: the time until it goes on does not count."""
        if self.state == "running":
            self.state = "stopped"
            self.elapsed_us += now_us - self.since_us

    def end(self) -> None:
        """It has come to its end; its next start begins at the beginning."""
        if self.state in ("running", "stopped"):
            self.state = "ended"

    def due_us(self, now_us: int) -> int | None:
        """When it goes on by itself; None if it waits for an input, or does not run."""
        if self.state != "running" or self.endless or self.waits:
            return None
        if self.until_us is None:
            return now_us
        return self.since_us + self.until_us - self.elapsed_us


class Programs:
    """All tasks, and what they act on: ports and variables.

    Attributes:
        tasks: One for each program of the configuration; the first is the main program.
        is_reset: The program has been reset and not started since: SO(14).
        variables: The variables of the programs, by name.
    """

    def __init__(self, config: RobotConfig, is_reset: bool) -> None:
        self._config = config
        self.ports = Ports(config.size)
        self.variables: dict[str, int] = {}
        self.tasks = [Task(program, config.size) for program in config.programs]
        self.is_reset = is_reset
        self._now_us = 0
        self._pulses: list[tuple[int, Port]] = []

    @property
    def running(self) -> bool:
        """The robot program is being executed: SO(13)."""
        if self._config.running_shows_all_tasks:
            return self.busy
        return self.tasks[0].state == "running"

    @property
    def busy(self) -> bool:
        """Any task runs."""
        return any(task.state == "running" for task in self.tasks)

    def start(self, now_us: int) -> None:
        """SI(12): go on with what was stopped, else start the main program."""
        stopped = [task for task in self.tasks if task.state == "stopped"]
        for task in stopped or self.tasks[:1]:
            task.go(now_us)
        self.is_reset = False

    def pause(self, now_us: int) -> None:
        """A stop of all tasks."""
        for task in self.tasks:
            task.pause(now_us)

    def reset(self) -> None:
        """SI(15): all tasks to their beginning."""
        for task in self.tasks:
            task.rewind()
            task.state = "ready"
        self.is_reset = True
        self._pulses.clear()
        if self._config.reset_clears_outputs:
            self.ports.clear_outputs()

    def halt(self) -> None:
        """End all tasks."""
        for task in self.tasks:
            task.end()

    def end_main(self) -> None:
        """The main program has come to its end."""
        self.tasks[0].end()
        if self._config.main_ends_tasks:
            self.halt()

    def pulse(self, place: Port, ms: int) -> None:
        """Turn an output ON, and OFF again after `ms`."""
        self.ports.write(place, 1)
        self._pulses.append((self._now_us + 1000 * ms, place))

    def advance(self, now_us: int) -> None:
        """Let every running task do what it can."""
        self._now_us = now_us
        for due_us, place in self._pulses:
            if due_us <= now_us:
                self.ports.write(place, 0)
        if self._pulses:
            self._pulses = [entry for entry in self._pulses if entry[0] > now_us]
        for task in self.tasks:
            if task.state == "running" and not task.endless:
                self._work(task, now_us)

    def next_due_us(self, now_us: int) -> int | None:
        """When something goes on by itself."""
        due = [due_us for due_us, _ in self._pulses]
        for task in self.tasks:
            if task.state == "running" and (task_us := task.due_us(now_us)) is not None:
                due.append(task_us)
        return min(due, default=None)

    def _work(self, task: Task, now_us: int) -> None:
        steps = task.steps
        for _ in range(_STEPS):
            if task.at == len(steps):
                self._finish(task, now_us)
                return
            if not self._done(task, steps[task.at], now_us):
                return
            if task.state != "running":
                return
            task.at += 1

    def _done(self, task: Task, step: Step, now_us: int) -> bool:
        """Do a step; False if the task has to wait in it."""
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
        elif isinstance(step, Start):
            other = self.tasks[step.number - 1]
            if other.state in ("ready", "ended"):
                other.go(now_us)
        else:
            step(self)
        return True

    def _finish(self, task: Task, now_us: int) -> None:
        if task.program.loop:
            task.rewind()
            task.since_us = now_us
        elif task is self.tasks[0]:
            self.end_main()
        else:
            task.end()
