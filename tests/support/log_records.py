"""Collect the log messages of a section of a test.

The log plugin of pytest is not used, because it costs time in each of 20,000 tests.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def log_messages(level: int = logging.WARNING) -> Iterator[list[str]]:
    """Collect the messages that any logger writes.

    Args:
        level: The lowest level that is collected.

    Yields:
        The messages, in their order. The list grows while the context is open.
    """
    messages: list[str] = []
    handler = logging.Handler(level)
    handler.emit = lambda record: messages.append(record.getMessage())  # type: ignore[method-assign]
    root = logging.getLogger()
    before = root.level
    root.addHandler(handler)
    root.setLevel(level)
    try:
        yield messages
    finally:
        root.removeHandler(handler)
        root.setLevel(before)
