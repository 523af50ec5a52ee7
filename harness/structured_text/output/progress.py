"""The progress of a long job: a bar on a terminal, otherwise a line at intervals."""

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

#: Time between two lines of progress without a terminal [s].
_PATIENCE_S = 30.0


def progress_bar(console: Console, clock: Callable[[], float] = time.monotonic) -> Progress:
    """Return a progress bar; without a terminal it prints a line each half minute.

    The tasks of the bar have a field `told` for further text. `clock` returns real time [s].
    """
    # Do not refresh in a thread, since the process may fork while the bar is shown.
    return _Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        _SpeedColumn(),
        TimeRemainingColumn(),
        TextColumn("{task.fields[told]}"),
        console=console,
        auto_refresh=False,
        redirect_stdout=not console.stderr,  # stdout may be redirected to a file
        get_time=clock,
    )


class _SpeedColumn(ProgressColumn):
    def render(self, task: Task) -> Text:
        """Return the speed in items per second."""
        return Text(_speed(task), style="progress.data.speed")


class _Progress(Progress):
    _told = 0.0

    def __enter__(self) -> _Progress:
        """Return the bar.

        It is shown as soon as a task has items.
        """
        return self

    def add_task(self, description: str, *args: Any, **kwargs: Any) -> TaskID:
        """Add a task. A task of 0 items is not shown: its bar would end as `0/0 -:--:--`."""
        number = super().add_task(description, *args, **kwargs)
        if kwargs.get("total") != 0:
            self.start()
        return number

    def stop(self) -> None:
        """Stop the bar.

        The number of completed items becomes the total of a task without a total.
        """
        if not self.live.is_started:
            return
        for task in self.tasks:
            if task.total is None:
                self.update(task.id, total=task.completed)
        super().stop()

    def refresh(self) -> None:
        """Draw the bar, or print a line if there is no terminal and enough time has passed."""
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
