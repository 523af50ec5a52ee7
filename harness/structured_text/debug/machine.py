"""What is debugged: a program and what is around it; scan by scan, and back."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol, TypeAlias

from structured_text.debug.values import Item
from structured_text.engines.base import Program
from structured_text.engines.builtin.program import BuiltinProgram
from structured_text.errors import InputError

__all__ = ["Finding", "Machine", "Scope", "builtin_of"]

#: Something around the program that is shown beside its variables: a name, and what gives it.
Scope: TypeAlias = tuple[str, Callable[[], list[Item]]]


class Finding(Protocol):
    """A rule that was broken."""

    @property
    def t_us(self) -> int:
        """When."""

    @property
    def text(self) -> str:
        """Which, in one sentence."""


class Machine(Protocol):
    """A program and what is around it.

    Attributes:
        program: The program, on the built-in engine.
    """

    program: BuiltinProgram

    @property
    def violations(self) -> Sequence[Finding]:
        """The broken rules so far."""

    @property
    def around(self) -> Sequence[Scope]:
        """What is around the program, as it is at the moment."""

    @property
    def ended(self) -> str:
        """Why there is no further scan; empty while there is one."""

    @property
    def scans(self) -> int:
        """How many scans have run."""

    @property
    def now_us(self) -> int:
        """The time of the last scan."""

    def scan(self) -> None:
        """Let all happen until one more scan has run."""

    def snapshot(self) -> Any:
        """The state between two scans."""

    def restore(self, snapshot: Any) -> None:
        """Go back to what `snapshot` gave, also from the middle of a scan."""

    def inject(self, event: str, device: int) -> None:
        """Let something happen to a device around the program, as in a stimulus."""

    def close(self) -> None:
        """Free what it holds."""


def builtin_of(program: Program) -> BuiltinProgram:
    """The program, if it is one of the built-in engine.

    Raises:
        InputError: it runs on another.
    """
    if not isinstance(program, BuiltinProgram):
        hint = "leave the engine out"
        raise InputError(f"the {program.engine} engine cannot be debugged", hint=hint)
    return program
