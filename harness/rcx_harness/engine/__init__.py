"""Engines: compile Structured Text and scan it; matiec where it is found, else the built-in one."""

from rcx_harness.engine.base import Located, Program, Value
from rcx_harness.engine.load import ENGINES, Built, build

__all__ = ["ENGINES", "Built", "Located", "Program", "Value", "build"]
