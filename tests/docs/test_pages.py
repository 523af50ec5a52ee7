"""The generated pages and the README's output blocks are what their sources say."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rcx_harness import docs

_ROOT = Path(docs.__file__).resolve().parents[2]


@pytest.mark.parametrize("path", docs.pages())
def test_a_generated_page_is_current(path: str) -> None:
    written = (_ROOT / path).read_text(encoding="utf-8")
    assert written == docs.pages()[path](), "run `make docs`"


@pytest.mark.parametrize("page", ["README.md", "plc/examples/README.md", *docs.pages()])
def test_every_link_of_a_page_leads_to_a_file(page: str) -> None:
    text = (_ROOT / page).read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)#:]+)\)", text):
        assert ((_ROOT / page).parent / target).exists(), target


def test_a_stale_page_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(docs, "ROOT", tmp_path)
    monkeypatch.setattr(docs, "pages", lambda: {"page.md": lambda: "new"})
    (tmp_path / "page.md").write_text("old", encoding="utf-8")
    assert docs.main(["--check"]) == 1
    assert "page.md" in capsys.readouterr().err
    assert docs.main([]) == 0
    assert (tmp_path / "page.md").read_text(encoding="utf-8") == "new"
    assert docs.main(["--check"]) == 0
