"""A file of results: after Ctrl-C, the next call continues with the results in the file."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Generic, TypeVar

from structured_text.errors import COMMAND, InputError
from structured_text.output.limits import MOST_LINE_BYTES, OTHER
from structured_text.output.reading import open_file
from structured_text.output.results import Results, move_aside, read_entry

__all__ = ["Item", "Result", "ResultFile"]

Item = TypeVar("Item")
Result = TypeVar("Result")

_FORMAT = f"{COMMAND}-results/1"
#: The JSON key in the first line of the file. The first line states the basis of all results.
_ABOUT = ""


def _as_it_is(value: Any) -> Any:
    return value


class ResultFile(Generic[Item, Result]):
    """The results of items from earlier calls, in a file; used by `Farm`.

    Args:
        file: The file in JSON lines. Its first line states the basis of the results.
        about: The basis of the results, as texts with names for users: `{"sources": digest}`.
        key: A function that returns the key of an item; items with equal keys have equal results.
        to_json: A function that returns the JSON form of a result.
        from_json: A function that returns the result of a JSON form. All results pass through it,
            including new results.
        fresh: Discard the content of the file.

    Attributes:
        notice: A line for the user if the file was damaged; else empty.

    Raises:
        InputError: The results in the file have another basis, or the file is not a file of
            results.
    """

    def __init__(
        self,
        file: Path,
        about: Mapping[str, str],
        *,
        key: Callable[[Item], str] = str,
        to_json: Callable[[Result], Any] = _as_it_is,
        from_json: Callable[[Any], Result] = _as_it_is,
        fresh: bool = False,
    ) -> None:
        self.key = key
        self._to_json, self._from_json = to_json, from_json
        try:
            self.notice = _rescued(file)
            there = _first_line(file)
            if there is not None and not fresh:
                _check(file, there, about)
            self._results = Results(file, fresh=fresh, is_whole=self._is_whole)
            self.notice = self.notice or self._results.notice
            if self._results.get(_ABOUT) is None:
                self._results.add({"key": _ABOUT, "format": _FORMAT, "about": dict(about)})
        except OSError as error:
            raise _unusable(file, error) from None
        self._file = file

    def _is_whole(self, entry: Mapping[str, Any]) -> bool:
        """Return whether an entry is a result, or the first line with the basis."""
        if entry["key"] == _ABOUT:
            return _is_first(entry)
        try:
            self._from_json(entry["result"])
        except (LookupError, TypeError, ValueError, AttributeError):
            return False
        return True

    def knows(self, item: Item) -> bool:
        """Return whether there is a result of the item."""
        return self._results.get(self.key(item)) is not None

    def get(self, item: Item) -> Result:
        """Return the result of a known item."""
        found = self._results.get(self.key(item))
        assert found is not None
        return self._from_json(json.loads(json.dumps(found["result"])))

    def add(self, item: Item, result: Result) -> None:
        """Save a result."""
        try:
            self._results.add({"key": self.key(item), "result": self._to_json(result)})
        except OSError as error:
            raise _unusable(self._file, error) from None


def _is_first(entry: Mapping[str, Any]) -> bool:
    return entry.get("format") == _FORMAT and isinstance(entry.get("about"), dict)


def _rescued(file: Path) -> str:
    """Move a file of results aside if its first line is damaged; return a notice for the user."""
    if not file.is_file():
        return ""
    first, *others = file.read_bytes().split(b"\n")
    entry = read_entry(first)
    if entry is not None and _is_first(entry):
        return ""
    if not any(found and {"key", "result"} == found.keys() for found in map(read_entry, others)):
        return ""  # this is not a file of results, so it is not renamed
    aside = move_aside(file)
    return (
        f"{file}: its first line is damaged; the file is now {aside}, "
        "and all results are computed again"
    )


def _first_line(file: Path) -> dict[str, Any] | None:
    """Return the basis in the first line; None if the file is missing or empty.

    Raise InputError if it is not a file of results.
    """
    if not os.path.lexists(file):
        return None
    with open_file(file, OTHER) as stream:
        line = stream.readline(MOST_LINE_BYTES)
    if not line:
        return None
    found = read_entry(line)
    if found is not None and _is_first(found):
        return dict(found["about"])
    raise InputError(
        "already exists and is not a file of results; nothing was written",
        file=file,
        hint="name another file, or remove this one",
    )


def _check(file: Path, there: Mapping[str, Any], about: Mapping[str, str]) -> None:
    names = (*about, *(one for one in there if one not in about))
    differ = [one for one in names if there.get(one) != about.get(one)]
    if differ:
        which = ", ".join(
            f"{one} {there.get(one, 'none')} there, {about.get(one, 'none')} now" for one in differ
        )
        raise InputError(
            f"contains results of other sources or options: {which}",
            file=file,
            hint="name another file, or remove this one to begin anew",
        )


def _unusable(file: Path, error: OSError) -> InputError:
    return InputError(f"cannot be used: {error.strerror}", file=file, hint="name another file")
