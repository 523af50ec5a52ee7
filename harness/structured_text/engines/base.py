"""The interface that every engine offers for a compiled program: scan, read, write, snapshot."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Protocol, runtime_checkable

from structured_text.language.paths import walk
from structured_text.language.project import Project
from structured_text.language.types import Located, Type

__all__ = ["CallLog", "OfProject", "Program", "Value"]

#: The Python form of each type: bool for BOOL, int for integers and bit strings, float for REAL and
#: LREAL, str for STRING, datetime.timedelta for TIME, the member's name for an enumeration. An
#: array is a list (nested for several dimensions), a structure a dict by field name.
Value = Any


class CallLog(Protocol):
    """A log of the calls of selected block types.

    Only engines that can observe calls offer a log; see `Program.note_calls`.
    """

    def key(self, path: str) -> int:
        """Return the number that identifies the instance at `path` in the log."""

    def take(self) -> list[tuple[int, int]]:
        """Return the calls since the last `take`, in order of execution.

        Each call is a pair: the key of the instance, and the key of its VAR_IN_OUT variable or 0.
        """


class OfProject:
    """The part of a program that depends only on its checked project."""

    project: Project

    def instances(self) -> Mapping[str, Type]:
        """Return the program instances by name, each with its BlockType."""
        return dict(self.project.instances)

    def pace(self, scan_us: int) -> None:
        """Set the time from one scan to the next; see `Program.pace`."""

    def walk(self) -> Iterator[tuple[str, Type]]:
        """Yield every variable; see `Program.walk`."""
        return walk(self.project)

    def located(self) -> list[Located]:
        """Return the variables with an address (`AT %QX0.1`), in order of declaration."""
        return list(self.project.located)


@runtime_checkable
class Program(Protocol):
    """One running instance of a compiled program; instances never share state.

    Paths start with the name of a program instance (`Main.Robot.SO.SO02_ServoOn`, `Main.Area[3]`,
    `Main.Grid[1,2]`). Names are compared without case. If there is only one program instance,
    `Main` and the program's type name are accepted as its name as well.
    """

    engine: str
    """The name of the engine: `"matiec"`, `"builtin"` or `"strucpp"`."""
    tick_us: int | None
    """Greatest common divisor of the task intervals [µs]; None without a CONFIGURATION."""

    def scan(self, now_us: int) -> None:
        """Run one base tick at PLC time `now_us` [µs]: every task that is due, in priority order.

        A task of interval k x `tick_us` runs in every k-th scan, beginning with the first. TON, TOF
        and TP see `now_us` as the time, whatever the configured intervals are.
        """

    def pace(self, scan_us: int) -> None:
        """Set the time from one scan to the next [µs].

        This time matters only if the project has both tasks and a program without a task. Such a
        program runs in each scan, and each task runs in the scan that is nearest to its interval.
        Otherwise `scan` counts ticks.
        """

    def read(self, path: str) -> Value:
        """Return the value at `path`.

        Raise InputError if the path does not exist (the message suggests similar names), or an
        index is out of range.
        """

    def reader(self, paths: Sequence[str]) -> Callable[[], tuple[Value, ...]]:
        """Return a function that reads the variables at `paths`, faster than `read`.

        Raises:
            InputError: A path does not exist, or an index is out of range, as for `read`.
        """

    def write(self, path: str, value: Value) -> None:
        """Write a value to `path`.

        A dict for a structure may name only some of its fields.

        Raise InputError if the path does not exist, the type is wrong, or the value is out of the
        type's range.
        """

    def read_bytes(self, path: str, start: int = 0, size: int | None = None) -> bytes:
        """Return an array of BYTE or WORD as bytes (little endian), as for a process image.

        This is faster than `read`.

        Args:
            path: The array.
            start: First byte to read. It must be the start of an element.
            size: Number of bytes. None reads to the end of the array.
        """

    def write_bytes(self, path: str, data: bytes, start: int = 0) -> None:
        """Write `data` into an array of BYTE or WORD (little endian), from byte `start` on."""

    def type_of(self, path: str) -> Type:
        """Return the type of the variable at `path`."""

    def instances(self) -> Mapping[str, Type]:
        """Return the program instances by name, each with its BlockType."""

    def walk(self) -> Iterator[tuple[str, Type]]:
        """Yield every global variable and every variable of the program instances.

        Arrays are yielded whole, without their elements. Structures and blocks are followed by
        their members.
        """

    def located(self) -> list[Located]:
        """Return the variables with an address (`AT %QX0.1`), in order of declaration."""

    def note_calls(self, blocks: Mapping[str, int | None]) -> CallLog | None:
        """Record the calls of some block types from now on; return None if the engine cannot.

        Args:
            blocks: The blocks to record, by upper-case name. The value is the index of a VAR_IN_OUT
                that each call records as well, or None.
        """

    def snapshot(self) -> object:
        """Return the whole state, as a value that `restore` of the same program accepts."""

    def restore(self, snapshot: object) -> None:
        """Restore a state that `snapshot` has returned."""

    def close(self) -> None:
        """Free the resources of the instance; it must not be used afterwards."""
