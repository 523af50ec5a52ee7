"""The interface of an engine: a compiled program that can be scanned, read and written."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Protocol, runtime_checkable

from structured_text.language.types import Located, Type

__all__ = ["CallLog", "Program", "Value"]

#: BOOL is bool, integers and bit strings int, REAL and LREAL float, STRING str,
#: TIME datetime.timedelta, an enumeration its member's name; arrays are lists (nested
#: for several dimensions), structures dicts by field name.
Value = Any


class CallLog(Protocol):
    """The calls of some types of blocks, as an engine that sees them notes them."""

    def key(self, path: str) -> int:
        """What stands for the instance at `path` in the log."""

    def take(self) -> list[tuple[int, int]]:
        """The calls since the last `take`, in their order: the instance, and its robot or 0."""


@runtime_checkable
class Program(Protocol):
    """One running instance of a compiled program; instances never share state.

    Paths start with the name of a program instance (`Main.Robot.SO.SO02_ServoOn`,
    `Main.Area[3]`, `Main.Grid[1,2]`); names are compared without case. Where there is only
    one program instance, `Main` and the program's type name are accepted for it too.
    """

    engine: str
    """`"matiec"`, `"builtin"` or `"strucpp"`."""
    tick_us: int | None
    """Greatest common divisor of the task intervals; None without a CONFIGURATION."""

    def scan(self, now_us: int) -> None:
        """Run one base tick at PLC time `now_us`: every task that is due, in priority order.

        A task of interval k x `tick_us` runs in every k-th scan, from the first on. Time seen by
        TON, TOF and TP is `now_us`, whatever the configured intervals say.
        """

    def read(self, path: str) -> Value:
        """Value at `path`.

        Raises:
            InputError: no such path (names near it are given), or an index out of range.
        """

    def reader(self, paths: Sequence[str]) -> Callable[[], tuple[Value, ...]]:
        """A function that reads these variables again and again, faster than `read` does.

        Raises:
            InputError: as `read`.
        """

    def write(self, path: str, value: Value) -> None:
        """Set `path`, whole or in part (a dict may name some fields of a structure).

        Raises:
            InputError: no such path, wrong type, or a value out of the type's range.
        """

    def read_bytes(self, path: str, start: int = 0, size: int | None = None) -> bytes:
        """An array of BYTE or WORD (little endian) as bytes; the fast way to a process image.

        Args:
            path: The array.
            start: First byte that is wanted; at the start of an element.
            size: How many; None for all that follow.
        """

    def write_bytes(self, path: str, data: bytes, start: int = 0) -> None:
        """Set `len(data)` bytes of an array of BYTE or WORD (little endian) from `start` on."""

    def type_of(self, path: str) -> Type:
        """Type of the variable at `path`."""

    def instances(self) -> Mapping[str, Type]:
        """The program instances by name, each with its BlockType."""

    def walk(self) -> Iterator[tuple[str, Type]]:
        """Every variable of the program instances and every global one, parents first.

        Arrays are given whole, not per element; the elements of structures and blocks are given.
        """

    def located(self) -> list[Located]:
        """Directly represented variables in order of declaration."""

    def note_calls(self, blocks: Mapping[str, int | None]) -> CallLog | None:
        """Note the calls of some types of blocks from now on; None where the engine cannot.

        Args:
            blocks: Names in upper case, each with the place among its VAR_IN_OUT of the variable
                to note beside it, or None.
        """

    def snapshot(self) -> object:
        """The whole state, as a value that `restore` of the same program takes back."""

    def restore(self, snapshot: object) -> None:
        """Go back to a state that `snapshot` gave."""

    def close(self) -> None:
        """Free what the instance holds; it is not used afterwards."""
