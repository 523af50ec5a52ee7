"""The built-in engine: it compiles checked Structured Text to Python and runs it."""

from structured_text.engines.builtin.program import BuiltinProgram

__all__ = ["BuiltinProgram"]
