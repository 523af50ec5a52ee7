"""TOML files, with a line number for each error."""

from __future__ import annotations

import importlib
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from structured_text.errors import InputError, near
from structured_text.output.limits import TABLE
from structured_text.output.reading import file_text

__all__ = ["check_keys", "line_of", "load_toml", "parse_toml", "toml_text", "toml_value"]

#: Matches the name of a table in a text, such as `[recover]` or `[[always]] 2`.
_IN_WORDS = re.compile(r"[\w.]+(?=\])")
_NAME = r"""(?:[\w-]+|"[^"]*"|'[^']*')"""
_PATH = rf"({_NAME}(?:\s*\.\s*{_NAME})*)"
_HEAD, _KEY = re.compile(rf"\s*\[\[?\s*{_PATH}\s*\]"), re.compile(rf"\s*{_PATH}\s*=")
#: Marks the end of a key that is cut for display.
_CUT = "..."
#: Matches input that Python's parser refuses: a number of more than 4300 digits, or deeply nested
#: lists.
_TOO_LONG = re.compile(r"[0-9_]{4301}|[\[{]{50}")


def load_toml(path: Path) -> dict[str, Any]:
    """Read a TOML file, or raise InputError."""
    return parse_toml(toml_text(path), path)


def toml_text(path: Path) -> str:
    """Read the text of a TOML file, or raise InputError."""
    return file_text(path, TABLE)


def parse_toml(text: str, path: Path) -> dict[str, Any]:
    """Return the content of a TOML text; `path` is its file.

    Raise InputError if it is not TOML (with the line).
    """
    try:
        toml: Any = importlib.import_module("tomllib")
    except ModuleNotFoundError:  # Python 3.10 has no tomllib
        toml = importlib.import_module("tomli")
    try:
        content: dict[str, Any] = toml.loads(text)
    except toml.TOMLDecodeError as error:
        raise InputError(f"not valid TOML: {error}", file=path) from error
    except (ValueError, RecursionError) as error:
        long = (n for n, one in enumerate(text.splitlines(), 1) if _TOO_LONG.search(one))
        what = "contains a number with too many digits, or lists nested too deeply"
        raise InputError(what, file=path, line=next(long, None)) from error
    return content


def toml_value(value: Any) -> str:
    """Return a text, number or truth value, or a list of these, as TOML."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        plain = value.replace("\\", "\\\\").replace('"', '\\"')
        return '"' + "".join(c if c.isprintable() else f"\\u{ord(c):04X}" for c in plain) + '"'
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(toml_value, value))}]"
    return repr(value)


def check_keys(
    table: Iterable[str],
    known: Iterable[str],
    where: str = "",
    file: Path | None = None,
    *,
    within: str = "",
    every: str = "there are",
) -> None:
    """Refuse unknown keys.

    Args:
        table: The present keys.
        known: The allowed keys.
        where: The name of the table as in the file, with its number if several tables have this
            name.
        file: The file; None if the caller adds it to the error.
        within: Text that follows the key in the message.
        every: Text before the list of all keys in the hint, which is used if no key is similar.

    Raises:
        InputError: A key is unknown. The error has the line of the key, and suggests similar keys.
    """
    names = list(known)
    for key in table:
        if key not in names:
            text = f"{f'{where}: ' if where else ''}unknown key '{key}'{within}"
            line = line_of(file, ".".join((*_IN_WORDS.findall(where), key))) if file else None
            raise InputError(text, file=file, line=line, hint=near(key, names, every))


def line_of(file: Path, key: str, number: int = 1) -> int | None:
    """Return the line of a key, or None if it does not occur; tomllib gives no lines.

    The key is written with its table, as in `comments.50`, or alone. If the key does not occur, the
    line of its table is returned. A key that is cut for display ends in dots. `number` selects one
    of several tables of this name.
    """
    places = list(_places(toml_text(file)))
    while key:
        ranked = [(rank, line) for path, line in places if (rank := _rank(path, key))]
        if ranked:
            best = [line for rank, line in ranked if rank == min(ranked)[0]]
            return best[min(number, len(best)) - 1]
        key = key.rpartition(".")[0]
    return None


def _rank(path: str, key: str) -> int:
    """Return how well the path of a key in the file matches `key`: 1 is best, 0 is no match."""
    begin = key.removesuffix(_CUT) if key.endswith(_CUT) else f"{key}."
    plain = re.sub(r"(?<=\.)0+(?=\d)", "", path)  # in a robot file, `points.021` is point 21
    fits = (path == key, plain == key, path.endswith(f".{key}"), path.startswith(begin))
    return fits.index(True) + 1 if True in fits else 0


def _places(text: str) -> Iterator[tuple[str, int]]:
    """Yield the path of each table and each key, without quotes, with its line."""
    table = ""
    for number, line in enumerate(text.splitlines(), 1):
        if head := _HEAD.match(line):
            table = _plain(head[1])
            yield table, number
        elif key := _KEY.match(line):
            yield f"{table}.{_plain(key[1])}".removeprefix("."), number


def _plain(path: str) -> str:
    return ".".join(part.strip(" \t\"'") for part in path.split("."))
