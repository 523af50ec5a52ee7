"""How a robot file is read: tables to the fields of RobotConfig, and where a mistake stands."""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path
from typing import Any

from rcx_harness.errors import InputError
from rcx_harness.robot.config.checks import check_value, near
from rcx_harness.robot.config.data import read_items
from rcx_harness.robot.config.stored import STORED, read_stored

__all__ = ["line_of", "read_value"]


def read_value(kind: type[Any], key: str, value: Any, tables: dict[str, type[Any]]) -> Any:
    """A TOML value as the field `key` of the data class `kind` wants it.

    Args:
        kind: The class whose fields are the keys.
        key: The key.
        value: The value under that key.
        tables: Classes of the keys that are lists of tables.

    Raises:
        InputError: unknown key, or a value that is written otherwise; the key is in single quotes.
    """
    _known(kind, key)
    if key in tables:
        return tuple(_table(tables[key], entry, key) for entry in _tables(value, key))
    if key in STORED:
        return read_stored(key, value)
    if key == "real_time_items":
        return read_items(key, value)
    return tuple(value) if isinstance(value, list) else value


def line_of(file: Path, message: str) -> int | None:
    """The line with the key that the message has in single quotes, as tomllib does not tell."""
    quoted = re.search(r"'([\w.]+)'", message)
    if not quoted:
        return None
    lines = file.read_text(encoding="utf-8").splitlines()
    key = quoted[1]
    while key:
        pattern = re.compile(rf"^\s*(\[+\s*)?{re.escape(key)}\b")
        for number, line in enumerate(lines, 1):
            if pattern.match(line):
                return number
        key = key.rpartition(".")[0]  # `comments.50` stands in the table [comments]
    return None


def _tables(value: Any, key: str) -> list[dict[str, Any]]:
    if not isinstance(value, list) or not all(isinstance(entry, dict) for entry in value):
        raise InputError(f"'{key}' must be tables", hint=f"write [[{key}]]")
    return value


def _table(kind: type[Any], entry: dict[str, Any], key: str) -> Any:
    values = {name: tuple(v) if isinstance(v, list) else v for name, v in entry.items()}
    for name, value in values.items():
        _known(kind, name, f" in [[{key}]]")
        declared = next(str(one.type) for one in fields(kind) if one.name == name)
        check_value(name, declared, value)
    return kind(**values)


def _known(kind: type[Any], key: str, where: str = "") -> None:
    names = [entry.name for entry in fields(kind)]
    if key not in names:
        raise InputError(f"unknown key '{key}'{where}", hint=near(key, names))
