"""docs/how-to/view.md has the same keys as the page of `rcx view`."""

from __future__ import annotations

import re
from importlib.resources import files
from pathlib import Path

import pytest


@pytest.fixture
def page(repository: Path) -> str:
    return (repository / "docs/how-to/view.md").read_text(encoding="utf-8")


def test_the_page_has_every_key_and_no_other(page: str) -> None:
    """The page has every key of the chart of `rcx view`, and no other.

    The key Enter belongs to the rows and to the search.
    """
    folder = files("rcx_harness.trace.view").joinpath("page")
    script = folder.joinpath("page.js").read_text(encoding="utf-8")
    acts = script.partition("const acts = {")[2].partition("};")[0]
    keys = set(re.findall(r'^ +"?([^\s":]+|:)"?: \(\) =>', acts, re.MULTILINE)) - {"="}
    arrows = {"ArrowLeft": "←", "ArrowRight": "→", "ArrowUp": "↑", "ArrowDown": "↓"}
    table = page.partition("| To | Key |")[2].partition("\n\n")[0]
    told = {key for row in table.splitlines()[2:] for key in re.findall(r"`(.)`|`(\w+)`", row)}
    in_keys = {one or other for one, other in told} - {"▾", "▴"}
    assert in_keys == {arrows.get(key, key) for key in keys}
