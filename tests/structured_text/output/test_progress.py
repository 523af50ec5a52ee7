"""The progress of long work is shown, tested with a simulated clock."""

from __future__ import annotations

import io

from rich.console import Console

from structured_text.output.progress import progress_bar


def test_without_a_terminal_lines_show_progress_speed_and_remaining_time() -> None:
    """Of 100 items of 2 s each, 16 are done after 32 s.

    The line shows 0.5/s and 168 s for the other 84.
    """
    shown, now_s = io.StringIO(), 1000.0
    console = Console(file=shown, force_terminal=False, width=100)
    with progress_bar(console, clock=lambda: now_s) as progress:
        bar = progress.add_task("seeds", total=100, told="2 fail")
        for _ in range(30):
            now_s += 2.0
            progress.update(bar, advance=1, refresh=True)
    lines = [line for line in shown.getvalue().splitlines() if "16 of" in line]
    assert lines == ["seeds: 16 of 100, 0.5/s, 2 min 48 s left 2 fail"]
    assert len(shown.getvalue().splitlines()) <= 3


def test_on_a_terminal_there_is_a_bar() -> None:
    """On a terminal, a bar is shown. 200 items run at 4/s, so 25 s remain after 100 items."""
    shown, now_s = io.StringIO(), 0.0
    console = Console(file=shown, force_terminal=True, width=100)
    with progress_bar(console, clock=lambda: now_s) as progress:
        bar = progress.add_task("seeds", total=200, told="")
        for _ in range(100):
            now_s += 0.25
            progress.update(bar, advance=1, refresh=True)
    assert "100/200" in shown.getvalue()
    assert "4/s" in shown.getvalue()
    assert "0:00:25" in shown.getvalue()


def test_a_task_without_items_shows_no_bar() -> None:
    """A task with 0 items shows no bar.

    An example is a campaign without failures, which has no classes.

    Source: docs/how-to/campaign.md.
    """
    shown = io.StringIO()
    console = Console(file=shown, force_terminal=True, width=100)
    with progress_bar(console) as progress:
        progress.add_task("seeds", total=1, told="")
    with progress_bar(console) as progress:
        progress.add_task("classes", total=0, told="")
    assert "seeds" in shown.getvalue()
    assert "classes" not in shown.getvalue()
    assert "0/0" not in shown.getvalue()


def test_an_unknown_total_is_shown_at_the_end() -> None:
    """The line shows 2/? while a generator of two items runs, and 2/2 at its end.

    Source: a user's screen.
    """
    shown = io.StringIO()
    console = Console(file=shown, force_terminal=True, width=100)
    with progress_bar(console) as progress:
        bar = progress.add_task("items", total=None, told="")
        for _ in range(2):
            progress.update(bar, advance=1, refresh=True)
    assert "2/?" in shown.getvalue()
    assert "2/2" in shown.getvalue().splitlines()[-1] or "2/2" in shown.getvalue().splitlines()[-2]
