"""Short forms of JSON Schema for the parameters and the results of the tools."""

from __future__ import annotations

from typing import Any

__all__ = ["FOLDER", "array", "choice", "duration", "integer", "paths", "record", "text"]

Schema = dict[str, Any]

_MOST_PATHS, _MOST_TEXT = 200, 4096


def text(about: str, most: int = _MOST_TEXT, default: str | None = None) -> Schema:
    """Return the schema of a text."""
    found: Schema = {"type": "string", "description": about, "maxLength": most}
    return found if default is None else {**found, "default": default}


def integer(about: str, low: int, high: int | None, default: int | None = None) -> Schema:
    """Return the schema of a whole number in a range."""
    found: Schema = {"type": "integer", "description": about, "minimum": low}
    if high is not None:
        found["maximum"] = high
    return found if default is None else {**found, "default": default}


def choice(about: str, values: list[str]) -> Schema:
    """Return the schema of a text that is one of several."""
    return {"type": "string", "description": about, "enum": values}


def duration(about: str, default: str | None = None) -> Schema:
    """Return the schema of a duration such as `10ms`."""
    found = text(about, 32, default)
    return {**found, "pattern": r"^[0-9]+(\.[0-9]+)?(us|ms|s|m|h)$"}


def array(about: str, item: Schema | None = None) -> Schema:
    """Return the schema of a list; without an item it is a list of texts."""
    return {"type": "array", "description": about, "items": item or {"type": "string"}}


def paths(about: str, least: int = 0) -> Schema:
    """Return the schema of a list of paths."""
    item = {"type": "string", "minLength": 1, "maxLength": _MOST_TEXT}
    found = {**array(about, item), "maxItems": _MOST_PATHS}
    return {**found, "minItems": least} if least else found


def record(needed: dict[str, Schema], optional: dict[str, Schema] | None = None) -> Schema:
    """Return the schema of an object with these properties and no others."""
    return {
        "type": "object",
        "properties": {**needed, **(optional or {})},
        "required": sorted(needed),
        "additionalProperties": False,
    }


FOLDER = text(
    "Folder of the server to work in; paths are relative to it. Default: the first one.", default=""
)
