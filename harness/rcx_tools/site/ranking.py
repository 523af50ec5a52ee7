"""The search of the site: blocks for users come first, internal blocks last.

Zensical ranks a page by the field that matches (title, path, text), and then by the position of the
match. Pages with equal rank keep the order of the index. This module writes the index in an order
that is useful for readers. It also changes the search, so that internal blocks are last.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rcx_tools.docs.blocks import tasks
from rcx_tools.docs.blocks.source import pous
from structured_text.errors import InputError

__all__ = ["rank", "ranked"]

_BLOCKS = "docs/reference/blocks/"
#: Order of pages with equal rank. The first prefix that a path begins with determines the position.
_ORDER = (
    "docs/reference/errors",
    "docs/reference/signals",
    "docs/tutorial/",
    "docs/how-to/",
    "docs/reference/",
    "docs/explanation/",
    "",
)
#: FB_ and FC_ also separate words, so that "MovePtp" matches FB_MovePtp from its first letter on.
_PREFIX = r"\bF[BC]_"
_SORT = "l.items.sort(ht(...s))"
_SORT_INTERNAL_LAST = "l.items.sort(ht((o,u)=>(o.id>={0})-(u.id>={0}),...s))"


def rank(site: Path) -> None:
    """Rewrite the search index of a site, and the code of its search.

    Raises:
        InputError: the search differs from the version that this module supports.
    """
    file = site / "search.json"
    index, first_internal = ranked(json.loads(file.read_text(encoding="utf-8")), tasks())
    file.write_text(json.dumps(index, ensure_ascii=False, separators=(",", ":")), "utf-8")
    scripts = [*(site / "assets/javascripts/workers").glob("search.*.js")]
    text = scripts[0].read_text(encoding="utf-8") if len(scripts) == 1 else ""
    if text.count(_SORT) != 1:
        hint = "adapt rcx_tools/site/ranking.py to this version of zensical"
        raise InputError("the search does not sort as expected", hint=hint)
    scripts[0].write_text(text.replace(_SORT, _SORT_INTERNAL_LAST.format(first_internal)), "utf-8")


def ranked(
    index: Mapping[str, Any], tasks: Mapping[str, Sequence[str]]
) -> tuple[dict[str, Any], int]:
    """Return a search index in our order, and the number of its first internal block.

    Args:
        index: The index that zensical has written: `config` and `items`.
        tasks: The blocks for each task. The path of a block, which the search shows, then contains
            the task.
    """
    named = {item["title"]: item for item in index["items"] if "#" in item["location"]}
    kept = [
        _placed(item, tasks)
        for item in index["items"]
        # If the heading of a page had an item of its own, the search would find the page twice.
        if "#" in item["location"] or item["text"] or item["title"] not in named
    ]
    kept.sort(key=lambda item: _tier(item["location"]))
    first_internal = sum(not _is_internal(item["location"]) for item in kept)
    separator = f"{index['config']['separator']}|{_PREFIX}"
    return {"config": {**index["config"], "separator": separator}, "items": kept}, first_internal


def _block(location: str) -> str:
    """Return the name of the block that a page describes; empty for other pages."""
    found = re.match(rf"{_BLOCKS}(FB_\w+)\.html", location)
    return found[1] if found else ""


def _is_internal(location: str) -> bool:
    name = _block(location)
    is_block = bool(name) and name in pous() and pous()[name].internal
    return is_block or location.startswith("docs/reference/internal-blocks.")


def _placed(item: dict[str, Any], tasks: Mapping[str, Sequence[str]]) -> dict[str, Any]:
    """Return an item with the path that the search shows: for a block, the tasks of the block."""
    name = _block(item["location"])
    if not name:
        return item
    if item["title"] != name:
        return {**item, "path": ["Blocks", name]}
    fitting = [task for task, blocks in tasks.items() if name in blocks]
    kind = "Internal blocks" if _is_internal(item["location"]) else "Blocks"
    return {**item, "path": [kind, *fitting]}


def _tier(location: str) -> tuple[int, int]:
    if _is_internal(location):
        return (2, 0)
    if _block(location):
        return (0, 0)
    return (1, next(place for place, begin in enumerate(_ORDER) if location.startswith(begin)))
