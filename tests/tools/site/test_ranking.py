"""The index of the search is ranked, and internal items are marked."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from rcx_tools.site.ranking import rank, ranked
from structured_text.errors import InputError

_BLOCKS = "docs/reference/blocks"


def _item(location: str, title: str, text: str = "text") -> dict[str, Any]:
    return {"location": location, "title": title, "text": text, "path": [title], "tags": []}


def _index() -> dict[str, Any]:
    items = [
        _item("docs/how-to/explore.html", "Explore"),
        _item(f"{_BLOCKS}/FB_RcxGrip.html#fb_rcxgrip", "FB_RcxGrip"),
        _item("docs/reference/errors.html", "Errors"),
        _item(f"{_BLOCKS}/FB_PickPlace.html", "FB_PickPlace", ""),
        _item(f"{_BLOCKS}/FB_PickPlace.html#fb_pickplace", "FB_PickPlace"),
        _item(f"{_BLOCKS}/FB_PickPlace.html#inputs", "Inputs"),
    ]
    return {"config": {"separator": "[_]+"}, "items": items}


def test_blocks_of_users_come_first_and_internal_ones_last() -> None:
    index, first_internal = ranked(_index(), {"grip a part": ["FB_PickPlace"]})
    found = [item["location"].rpartition("/")[2] for item in index["items"]]
    assert found == [
        "FB_PickPlace.html#fb_pickplace",
        "FB_PickPlace.html#inputs",
        "errors.html",
        "explore.html",
        "FB_RcxGrip.html#fb_rcxgrip",
    ]
    assert first_internal == 4


def test_a_block_is_found_by_its_tasks_and_by_its_name_without_fb() -> None:
    index, _ = ranked(_index(), {"grip a part": ["FB_PickPlace"]})
    assert [item["path"] for item in index["items"][:2]] == [
        ["Blocks", "grip a part"],
        ["Blocks", "FB_PickPlace"],
    ]
    assert index["config"]["separator"] == r"[_]+|\bF[BC]_"


def test_a_search_of_another_version_is_refused_with_what_to_do(tmp_path: Path) -> None:
    (tmp_path / "search.json").write_text(json.dumps(_index()), "utf-8")
    workers = tmp_path / "assets/javascripts/workers"
    workers.mkdir(parents=True)
    (workers / "search.1.min.js").write_text("l.items.sort(ht(...s))", "utf-8")
    rank(tmp_path)
    assert (workers / "search.1.min.js").read_text("utf-8") == (
        "l.items.sort(ht((o,u)=>(o.id>=4)-(u.id>=4),...s))"
    )
    with pytest.raises(InputError, match="does not sort as expected"):
        rank(tmp_path)
