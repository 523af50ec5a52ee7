"""Results in a file: Ctrl-C keeps what is done, and the next call goes on."""

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

__all__ = ["Kept"]

Item = TypeVar("Item")
Result = TypeVar("Result")

_FORMAT = f"{COMMAND}-results/1"
#: The key of the first line, which says what all others rest on.
_ABOUT = ""


def _as_it_is(value: Any) -> Any:
    return value


class Kept(Generic[Item, Result]):
    """What is known of items from earlier calls.

    Args:
        file: JSON lines; the first says what the others rest on.
        about: What they rest on by its name for people, say `{"sources": digest}`; texts.
        key: Names an item; items of one key have one result.
        to_json: What is written of a result.
        from_json: A result as it was; results are taken as if they had been read.
        fresh: Forget what is there.

    Attributes:
        notice: A line for the user where the file was damaged; else empty.

    Raises:
        InputError: the file has results that rest on something else, or is none of ours.
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
        """Return whether an entry is a result, or says what all rest on."""
        if entry["key"] == _ABOUT:
            return _is_first(entry)
        try:
            self._from_json(entry["result"])
        except (LookupError, TypeError, ValueError, AttributeError):
            return False
        return True

    def knows(self, item: Item) -> bool:
        """Is there a result?"""
        return self._results.get(self.key(item)) is not None

    def get(self, item: Item) -> Result:
        """The result of an item that is known."""
        found = self._results.get(self.key(item))
        assert found is not None
        return self._from_json(json.loads(json.dumps(found["result"])))

    def add(self, item: Item, result: Result) -> None:
        """Keep a result."""
        try:
            self._results.add({"key": self.key(item), "result": self._to_json(result)})
        except OSError as error:
            raise _unusable(self._file, error) from None


def _is_first(entry: Mapping[str, Any]) -> bool:
    return entry.get("format") == _FORMAT and isinstance(entry.get("about"), dict)


def _rescued(file: Path) -> str:
    """Move a file of results aside that has lost what they rest on; return what is to be told."""
    if not file.is_file():
        return ""
    first, *others = file.read_bytes().split(b"\n")
    entry = read_entry(first)
    if entry is not None and _is_first(entry):
        return ""
    if not any(found and {"key", "result"} == found.keys() for found in map(read_entry, others)):
        return ""  # not ours
    aside = move_aside(file)
    return f"{file}: its first line is damaged; the file is now {aside}, and all is done again"


def _first_line(file: Path) -> dict[str, Any] | None:
    """What an earlier call has written first; None: there is no such file, or nothing in it."""
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
        "is there already, and is not a file of results; nothing was written",
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
            f"has results of other sources or options: {which}",
            file=file,
            hint="name another file, or remove this one to begin anew",
        )


def _unusable(file: Path, error: OSError) -> InputError:
    return InputError(f"cannot be used: {error.strerror}", file=file, hint="name another file")
