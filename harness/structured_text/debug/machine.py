"""The interface between the debugger and a run: a program and the devices around it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol, TypeAlias

from structured_text.debug.devices import Devices
from structured_text.debug.values import Item
from structured_text.engines.base import Program
from structured_text.engines.builtin.program import BuiltinProgram
from structured_text.errors import InputError

__all__ = ["Finding", "Machine", "Scope", "builtin_of"]

#: A group of values that the debugger shows beside the program's variables: the name of the group,
#: and a function that returns the values.
Scope: TypeAlias = tuple[str, Callable[[], list[Item]]]


class Finding(Protocol):
    """A broken rule."""

    @property
    def t_us(self) -> int:
        """Return the time at which the rule was broken, in microseconds."""

    @property
    def text(self) -> str:
        """Return one sentence about the broken rule."""


class Machine(Protocol):
    """A program with the devices around it.

    Attributes:
        program: The program, on the built-in engine.
        devices: The programs of the devices around the program; None if there are none.
    """

    program: BuiltinProgram
    devices: Devices | None

    @property
    def violations(self) -> Sequence[Finding]:
        """Return the broken rules so far."""

    @property
    def around(self) -> Sequence[Scope]:
        """Return the groups of current values that belong to the devices around the program."""

    @property
    def ended(self) -> str:
        """Return the reason why no further scan can run, or an empty text."""

    @property
    def scans(self) -> int:
        """Return the number of scans that have run."""

    @property
    def now_us(self) -> int:
        """Return the time of the last scan in microseconds."""

    def scan(self) -> None:
        """Advance time until one more scan has run."""

    def snapshot(self) -> Any:
        """Return the state between two scans."""

    def restore(self, snapshot: Any) -> None:
        """Restore the state from `snapshot`, also from the middle of a scan."""

    def inject(self, event: str, device: int) -> None:
        """Trigger an event of a device around the program, as in a stimulus."""

    def close(self) -> None:
        """Free all resources."""


def builtin_of(program: Program) -> BuiltinProgram:
    """Return the program if it runs on the built-in engine, or raise InputError."""
    if not isinstance(program, BuiltinProgram):
        hint = "leave the engine out"
        raise InputError(f"the {program.engine} engine cannot be debugged", hint=hint)
    return program
