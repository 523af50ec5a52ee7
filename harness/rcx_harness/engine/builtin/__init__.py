"""The built-in engine: compiles checked Structured Text to Python and runs it."""

from rcx_harness.engine.builtin.program import BuiltinProgram

__all__ = ["BuiltinProgram"]
