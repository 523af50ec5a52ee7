"""Results of standard functions with known arguments, from the code of the built-in engine."""

from __future__ import annotations

import math
from typing import Any

from structured_text.engines.builtin.runtime import NAMES, ProgramError
from structured_text.engines.builtin.standard import settle, standard_call
from structured_text.language import tree as t
from structured_text.language.dialects import Dialect
from structured_text.language.types import type_name
from structured_text.prove import reals, texts, values
from structured_text.prove.values import Value

__all__ = ["result"]


def result(node: t.Standard, arguments: list[Value], rules: Dialect) -> tuple[Value, str]:
    """Return the result of a call, and the kind of the broken obligation or "".

    The call breaks an obligation if the engine's code raises an error. Its result is then 0 or an
    empty text.
    """
    plain = [_plain(argument) for argument in arguments]
    code = settle(standard_call(node, [_code(item) for item in plain], rules), node.type)
    try:
        return values.constant(node.type, eval(code, dict(NAMES))), ""
    except (ArithmeticError, ValueError, ProgramError):
        empty = values.constant(node.type, "" if type_name(node.type) == "STRING" else 0)
        return empty, _refusal(node.name)


def _refusal(name: str) -> str:
    """Return the kind of the obligation that an illegal argument of this function breaks."""
    if name in ("SHL", "SHR"):
        return "shift"
    if name in ("DIV", "MOD"):
        return "division"
    if name in ("LEFT", "RIGHT", "MID", "INSERT", "DELETE", "REPLACE"):
        return "text"
    return "conversion" if "_TO_" in name else "argument"


def _plain(value: Value) -> Any:
    """Return a known value as the Python value that the engine uses."""
    if isinstance(value, reals.Real):
        return value.value
    return texts.plain(value) if isinstance(value, texts.Text) else value


def _code(value: Any) -> str:
    """Return the Python code of a known value, including infinities and NaN."""
    if isinstance(value, float) and not math.isfinite(value):
        return f"float({str(value)!r})"
    return f"({value!r})" if isinstance(value, (int, float)) and value < 0 else repr(value)
