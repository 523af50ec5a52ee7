"""Fixtures of the tests of the debugger."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from editor import Editor

LAMPS = Path(__file__).parent / "programs" / "Lamps.st"


@pytest.fixture
def lamps() -> Path:
    """Return a program with known values: in the nth scan, C.Value is n and Doubled is 2 n.

    Lamp is DIM from the third scan on, and BRIGHT from the sixth.
    """
    return LAMPS


@pytest.fixture
def editor() -> Iterator[Editor]:
    """Return a client (editor) of the debugger that has not launched a program."""
    made = Editor()
    yield made
    made.close()


@pytest.fixture
def at_entry(editor: Editor, lamps: Path) -> Callable[..., Editor]:
    """Return an editor that has launched Lamps.st and has stopped before the first statement."""

    def start(**launch: Any) -> Editor:
        editor.start(sources=[str(lamps)], stopOnEntry=True, **launch)
        return editor

    return start


@pytest.fixture
def stopped(editor: Editor, lamps: Path) -> Callable[..., Editor]:
    """Launch Lamps.st with these breakpoints, and run to the first stop."""

    def start(*breakpoints: Any, **launch: Any) -> Editor:
        editor.start({lamps: list(breakpoints)}, sources=[str(lamps)], **launch)
        return editor

    return start
