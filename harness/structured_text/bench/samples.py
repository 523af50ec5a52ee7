"""The trace of a run: a line of JSON for each scan, each broken rule and each further record."""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, Generic, NamedTuple, Protocol, TypeVar

from structured_text.errors import COMMAND, InputError, Violation
from structured_text.language.displayed import described, literal
from structured_text.language.types import Type
from structured_text.output.files import OutputFile

__all__ = ["COMPACT", "FORMAT", "KEPT", "Sample", "Trace"]

#: Value of `format`, the first entry of the first line.
FORMAT = f"{COMMAND}-trace/1"

#: Number of records in memory: about two minutes of a 10 ms scan. The file has all records.
KEPT = 40_000

COMPACT: dict[str, Any] = {"separators": (",", ":"), "ensure_ascii": False}


class _Record(Protocol):
    @property
    def t_us(self) -> int:
        """Return the time of the record in microseconds."""


_R = TypeVar("_R", bound=_Record)
_K = TypeVar("_K")


class Sample(NamedTuple):
    """A record of one scan, with the watched variables at the end of the scan."""

    t_us: int
    scan: int
    vars: Mapping[str, Any] | None = None

    def line(self) -> str:
        """Return the record as JSON; `vars` is present only if variables are watched."""
        head = f'{{"t_us":{self.t_us},"scan":{self.scan}'
        if self.vars is None:
            return head + "}"
        shown = json.dumps({path: literal(value) for path, value in self.vars.items()}, **COMPACT)
        return f'{head},"vars":{shown}}}'


def _line(record: Any) -> str:
    """Return a record as a line of the trace file; of a broken rule, only the text is written."""
    if isinstance(record, Violation):
        return json.dumps({"t_us": record.t_us, "violation": record.text}, **COMPACT)
    line: str = record.line()
    return line


class Trace(Generic[_R]):
    """The records of a run, streamed to a file as they come; the latest are also in memory.

    Args:
        header: Entries of the first line after `format`, in this order.
        path: File to write; None for memory only.
        new: Refuse a file that exists.
        keep: Number of records in memory.
        watched: Types of the watched variables by path; the header contains them as `watch`.
        last: Further entries at the end of the first line.

    Raises:
        InputError: The file cannot be written.
    """

    def __init__(
        self,
        header: Mapping[str, Any],
        path: str | Path | None = None,
        *,
        new: bool = False,
        keep: int = KEPT,
        watched: Mapping[str, Type] | None = None,
        last: Mapping[str, Any] | None = None,
    ) -> None:
        self.header: dict[str, Any] = {"format": FORMAT, **header}
        self.watched = dict(watched or {})
        if self.watched:
            self.header["watch"] = {path: described(kind) for path, kind in self.watched.items()}
        self.header |= last or {}
        self.path = Path(path) if path is not None else None
        self._kept: deque[_R] = deque(maxlen=keep)
        self._listeners: list[Callable[[_R], None]] = []
        self._file: OutputFile | None = None
        if self.path is not None:
            if new and self.path.exists():
                raise InputError("already exists", file=self.path, hint="name another one")
            self._file = OutputFile(self.path, new=new)
            self._file.write(json.dumps(self.header, **COMPACT) + "\n")

    def listen(self, listener: Callable[[_R], None]) -> None:
        """Call `listener` with every record from now on."""
        self._listeners.append(listener)

    def add(self, record: _R) -> None:
        """Add a record to memory and file, and pass it to all listeners."""
        self._kept.append(record)
        if self._file is not None:
            self._file.write(_line(record) + "\n")
        for listener in self._listeners:
            listener(record)

    def __iter__(self) -> Iterator[_R]:
        """Iterate over the records in memory, oldest first."""
        return iter(self._kept)

    def __len__(self) -> int:
        return len(self._kept)

    def findings(self) -> list[Violation]:
        """Return the broken rules in memory."""
        return self._of(Violation)

    def lines(self) -> Iterator[str]:
        """Yield the header and the records in memory as lines of a file."""
        yield json.dumps(self.header, **COMPACT)
        for record in self._kept:
            yield _line(record)

    def snapshot(self) -> tuple[_R, ...]:
        """Return the records in memory.

        Raise InputError if the trace is written to a file, which cannot go back in time.
        """
        if self._file is not None:
            raise InputError(
                "a cell that writes a trace file cannot go back in time",
                file=self.path,
                hint="build the cell without trace= to use snapshot and restore",
            )
        return tuple(self._kept)

    def restore(self, snapshot: tuple[_R, ...]) -> None:
        """Restore the records from `snapshot`."""
        self._kept = deque(snapshot, maxlen=self._kept.maxlen)

    def flush(self) -> None:
        """Write buffered lines to the file, so that a run in real time can be watched."""
        if self._file is not None:
            self._file.flush()

    def close(self) -> None:
        """Write the buffered records and close the file."""
        if self._file is not None:
            self._file.close()
            self._file = None

    def _of(self, kind: type[_K]) -> list[_K]:
        return [record for record in self._kept if isinstance(record, kind)]
