"""How far long work is: a bar on a terminal, a line now and then elsewhere."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    Task,
    TaskID,
    TextColumn,
    TimeRemainingColumn,
)
from rich.text import Text

__all__ = ["progress_bar"]

#: Between two lines of progress where there is no terminal [s].
_PATIENCE_S = 30.0


def progress_bar(console: Console, clock: Callable[[], float] = time.monotonic) -> Progress:
    """A bar, or a line each half minute where there is no terminal.

    Its tasks have a field `told`: what else is to be said.

    Args:
        console: Where it is shown.
        clock: Real time [s].
    """
    # No thread of its own: a process that shows it may make copies of itself.
    return _Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        _SpeedColumn(),
        TimeRemainingColumn(),
        TextColumn("{task.fields[told]}"),
        console=console,
        auto_refresh=False,
        redirect_stdout=not console.stderr,  # it may be a file
        get_time=clock,
    )


class _SpeedColumn(ProgressColumn):
    def render(self, task: Task) -> Text:
        """What is done in a second."""
        return Text(_speed(task), style="progress.data.speed")


class _Progress(Progress):
    _told = 0.0

    def __enter__(self) -> _Progress:
        """Return it; it is shown from the first task on that has anything to do."""
        return self

    def add_task(self, description: str, *args: Any, **kwargs: Any) -> TaskID:
        """Add a task. One of 0 items is not shown: its bar would end as `0/0 -:--:--`."""
        number = super().add_task(description, *args, **kwargs)
        if kwargs.get("total") != 0:
            self.start()
        return number

    def stop(self) -> None:
        """End it. How much there was of what nobody had counted is known now."""
        if not self.live.is_started:
            return
        for task in self.tasks:
            if task.total is None:
                self.update(task.id, total=task.completed)
        super().stop()

    def refresh(self) -> None:
        """Show it."""
        if self.console.is_terminal:
            super().refresh()
        elif self.get_time() - self._told > _PATIENCE_S and self.tasks:
            self._told = self.get_time()
            task = self.tasks[-1]
            done = f"{task.completed:.0f}"
            parts = [f"{done} of {task.total:.0f}" if task.total else f"{done} done"]
            parts += [_speed(task), f"{left} left" if (left := _left(task)) else ""]
            told = ", ".join(part for part in parts if part)
            text = f"{task.description}: {told} {task.fields['told']}".rstrip()
            self.console.print(text, highlight=False)


def _speed(task: Task) -> str:
    speed = task.finished_speed or task.speed
    if not speed:
        return ""
    return f"{speed:.0f}/s" if speed >= 10 else f"{speed:.2g}/s"


def _left(task: Task) -> str:
    seconds = task.time_remaining
    if not seconds:
        return ""
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest} s" if minutes else f"{rest} s"
