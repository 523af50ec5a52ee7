"""`rcx debug` prints help for a person at a terminal, but nothing for an editor."""

from __future__ import annotations

import os
import pty
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from rcx_harness.cli.app import main

Captured = pytest.CaptureFixture[str]
_END_OF_INPUT = b"\x04"  # Ctrl-D


@contextmanager
def _stdin(monkeypatch: pytest.MonkeyPatch, descriptor: int) -> Iterator[None]:
    with os.fdopen(descriptor, encoding="utf-8") as stream:
        monkeypatch.setattr(sys, "stdin", stream)
        yield


def test_at_a_terminal_help_is_printed(monkeypatch: pytest.MonkeyPatch, capfd: Captured) -> None:
    """At a terminal, the help is on standard error. Standard output is reserved for the client.

    Source: docs/how-to/debug.md.
    """
    keyboard, terminal = pty.openpty()
    try:
        os.write(keyboard, _END_OF_INPUT)
        with _stdin(monkeypatch, terminal):
            assert main(["debug"]) == 0
    finally:
        os.close(keyboard)
    said = capfd.readouterr()
    assert said.out == ""
    for word in ("Debug Adapter Protocol", "--vscode", "--port", "Ctrl-C ends it"):
        assert word in said.err


def test_behind_a_pipe_nothing_is_printed(monkeypatch: pytest.MonkeyPatch, capfd: Captured) -> None:
    """Behind a pipe, standard error stays empty, because some clients show its text as an error.

    Source: docs/how-to/debug.md.
    """
    reading, writing = os.pipe()
    os.close(writing)
    with _stdin(monkeypatch, reading):
        assert main(["debug"]) == 0
    assert capfd.readouterr() == ("", "")
