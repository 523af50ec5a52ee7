"""The front end of both engines: parses Structured Text, checks it, names what is wrong."""

from rcx_harness.engine.frontend.load import analyse, check, load
from rcx_harness.engine.frontend.paths import Resolved, resolve, walk
from rcx_harness.engine.frontend.project import Project, Run, Task, Unit
from rcx_harness.engine.frontend.values import (
    array_length,
    from_python,
    nest,
    scalar_to_python,
)

__all__ = [
    "Project",
    "Resolved",
    "Run",
    "Task",
    "Unit",
    "analyse",
    "array_length",
    "check",
    "from_python",
    "load",
    "nest",
    "resolve",
    "scalar_to_python",
    "walk",
]
