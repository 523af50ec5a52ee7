"""The progress of long work is shown, tested with a simulated clock."""

from __future__ import annotations

import io

from rich.console import Console

from structured_text.output.progress import progress_bar


def test_without_a_terminal_a_line_says_now_and_then_how_far_how_fast_and_how_long() -> None:
    """100 items take 2 s each. At 32 s, 16 are done at 0.5/s, and the other 84 need 168 s."""
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
    """200 items run at 4/s. After 100 items, 25 s remain."""
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


def test_a_task_of_nothing_shows_no_bar() -> None:
    """A campaign without failures has 0 classes, so only the bar of the seeds is shown.

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
