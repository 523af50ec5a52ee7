"""External compilers are run with a time limit."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from structured_text.engines.native.toolchain import run_tool
from structured_text.errors import InputError
from structured_text.output import programs


def test_a_compiler_that_never_ends_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    """A compiler that has not ended after 900 s is reported with a remedy.

    Source: docs/reference/limits.md, programs: 900 s.
    """
    given: dict[str, object] = {}

    def endless(command: list[str], **options: object) -> None:
        given.update(options)
        raise subprocess.TimeoutExpired(command, 900)

    monkeypatch.setattr(programs, "run", endless)
    with pytest.raises(
        InputError, match="iec2c has not compiled this program within 900 s"
    ) as told:
        run_tool(["/opt/matiec/iec2c", "x.st"], Path("/tmp"))
    assert given["timeout"] == 900
    assert told.value.hint == "make the program smaller, or use --engine builtin"


def test_the_output_of_a_tool_is_returned() -> None:
    """`run_tool` returns the exit code and the output of the tool.

    Source: engines/native/toolchain.py.
    """
    done = run_tool([sys.executable, "-c", "print('said'); raise SystemExit(3)"])
    assert (done.returncode, done.stdout.split()) == (3, [b"said"])
