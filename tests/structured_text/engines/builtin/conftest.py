"""A fixture that runs a test's program on the built-in engine."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from structured_text.engines.builtin import BuiltinProgram


@pytest.fixture
def run(build: Callable[[str], BuiltinProgram]) -> Callable[..., Any]:
    """Return a function that runs one scan of a PROGRAM made of variables and statements.

    The function returns the value of the variable in `want`, or a tuple if `want` names several.
    """

    def run_once(variables: str, body: str, want: str, before: str = "") -> Any:
        program = build(f"{before}\nPROGRAM P1\nVAR {variables} END_VAR\n{body}\nEND_PROGRAM\n")
        program.scan(0)
        values = tuple(program.read(f"Main.{name}") for name in want.split())
        return values[0] if len(values) == 1 else values

    return run_once
