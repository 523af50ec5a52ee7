"""What the tables say about the blocks of the library: legal values, ErrorIDs and their pages."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from rcx_harness.spec import folder
from structured_text.language.cache import folder as cache_folder
from structured_text.output.toml_files import load_toml

__all__ = ["Facts", "facts_of", "more_about", "page_of"]

#: Written by `make docs` from plc/lib and spec.
_FILE = Path(__file__).with_name("blocks.json")
_PAGES = Path(__file__).resolve().parents[3] / "docs" / "reference" / "blocks"
_ERROR_PINS = ("ERROR", "ERRORID")


@dataclass(frozen=True)
class Facts:
    """The facts about a block or function.

    Attributes:
        ranges: The legal values of inputs, by upper-case name of the pin.
        errors: The possible ErrorIDs.
    """

    name: str
    ranges: dict[str, str]
    errors: tuple[int, ...]


@cache
def _every() -> dict[str, Facts]:
    table: dict[str, Any] = json.loads(_FILE.read_text(encoding="utf-8"))
    return {
        name.upper(): Facts(
            name,
            {pin.upper(): text for pin, text in row["ranges"].items()},
            tuple(row["errors"]),
        )
        for name, row in table.items()
    }


def facts_of(block: str) -> Facts | None:
    """Return the facts about a block of the library, or None."""
    return _every().get(block.upper())


def more_about(block: str, pin: str = "") -> str:
    """Return Markdown about a block of the library or about one of its pins; empty for others."""
    facts = facts_of(block)
    if facts is None:
        return ""
    parts: list[str] = []
    if pin and (legal := facts.ranges.get(pin.upper())):
        parts.append(f"Legal values: {legal}")
    if facts.errors and (not pin or pin.upper() in _ERROR_PINS):
        parts.append("\n".join(["ErrorIDs:", "", *_errors(facts)]))
    if (page := page_of(facts.name)) is not None:
        parts.append(f"[{facts.name}]({page})")
    return "\n\n".join(parts)


def _errors(facts: Facts) -> Iterator[str]:
    names = _error_names()
    for number in facts.errors:
        yield f"- `16#{number:04X}` {names.get(number, '')}".rstrip()


@cache
def _error_names() -> dict[int, str]:
    return {row["id"]: row["name"] for row in load_toml(folder() / "errors.toml")["error"]}


@cache
def page_of(block: str) -> str | None:
    """Return the address of the page of a block; None if it cannot be written.

    In the repository it is the page of the documentation. The package has no pages, so the page is
    made from the source of the block, in the cache folder.
    """
    page = _PAGES / f"{block}.md"
    if page.is_file():
        return page.as_uri()
    from rcx_harness.assistant.blocks import blocks
    from rcx_harness.assistant.blocks import page as text_of

    place = cache_folder()
    if place is None or block not in blocks():
        return None
    made = place / "pages" / f"{block}.md"
    with suppress(OSError):
        made.parent.mkdir(exist_ok=True)
        made.write_text(text_of(block), encoding="utf-8")
        return made.as_uri()
    return None
