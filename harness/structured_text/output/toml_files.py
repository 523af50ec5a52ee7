"""Files of TOML, with the line of what cannot be read."""

from __future__ import annotations

import importlib
import re
from pathlib import Path
from typing import Any

from structured_text.errors import InputError
from structured_text.output.limits import TABLE
from structured_text.output.reading import file_text

__all__ = ["load_toml", "parse_toml", "toml_text"]

#: What Python does not read: numbers of more than 4300 digits, and lists in lists.
_TOO_LONG = re.compile(r"[0-9_]{4301}|[\[{]{50}")


def load_toml(path: Path) -> dict[str, Any]:
    """Read a TOML file.

    Raises:
        InputError: it cannot be read, or is not TOML (with the line).
    """
    return parse_toml(toml_text(path), path)


def toml_text(path: Path) -> str:
    """Read the text of a TOML file.

    Raises:
        InputError: it cannot be read.
    """
    return file_text(path, TABLE)


def parse_toml(text: str, path: Path) -> dict[str, Any]:
    """The content of a TOML text; `path` is where it comes from.

    Raises:
        InputError: it is not TOML (with the line).
    """
    try:
        toml: Any = importlib.import_module("tomllib")
    except ModuleNotFoundError:  # Python 3.10
        toml = importlib.import_module("tomli")
    try:
        content: dict[str, Any] = toml.loads(text)
    except toml.TOMLDecodeError as error:
        raise InputError(f"not valid TOML: {error}", file=path) from error
    except (ValueError, RecursionError) as error:
        long = (n for n, one in enumerate(text.splitlines(), 1) if _TOO_LONG.search(one))
        what = "has a number too long, or lists in lists too deep"
        raise InputError(what, file=path, line=next(long, None)) from error
    return content
