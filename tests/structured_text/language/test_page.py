"""docs/reference/language.md lists every construct, with its replacement."""

from __future__ import annotations

from pathlib import Path

from structured_text.language.constructs import CONSTRUCTS, TRANSLATED


def test_the_page_lists_every_construct_and_no_other(repository: Path) -> None:
    page = (repository / "docs/reference/language.md").read_text(encoding="utf-8")
    table = page.split("|---|---|---|\n")[1].split("\n\n")[0]
    rows = [tuple(cell.strip() for cell in line.split("|")[1:-1]) for line in table.splitlines()]
    assert sorted(rows) == sorted(
        (name, "translated" if name in TRANSLATED else "refused by name", instead)
        for name, instead in CONSTRUCTS.items()
    )
