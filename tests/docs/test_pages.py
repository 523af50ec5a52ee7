"""The generated pages and the README's output blocks are what their sources say."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rcx_harness import docs

_ROOT = Path(docs.__file__).resolve().parents[2]


@pytest.mark.parametrize("path", docs.pages())
def test_a_generated_page_is_current(path: str) -> None:
    written = (_ROOT / path).read_bytes()
    assert written == docs.pages()[path]().encode(), "run `make docs`"


@pytest.mark.parametrize("page", ["README.md", "plc/examples/README.md", *docs.pages()])
def test_every_link_of_a_page_leads_to_a_file(page: str) -> None:
    text = (_ROOT / page).read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)#:]+)\)", text):
        assert ((_ROOT / page).parent / target).exists(), target


def test_every_link_to_a_chart_leads_to_a_heading() -> None:
    headings = re.findall(r"^## (.+)$", docs.pages()["docs/processes.md"](), re.MULTILINE)
    anchors = {re.sub(r"[^\w -]", "", text.lower()).replace(" ", "-") for text in headings}
    linked = [
        target
        for page in ("docs/processes.md", "docs/blocks.md")
        for target in re.findall(r"\]\((?:processes\.md)?#([^)]+)\)", docs.pages()[page]())
    ]
    assert set(linked) == anchors


def test_a_process_shows_its_chart_its_steps_its_block_its_tests_and_the_manual() -> None:
    page = docs.pages()["docs/processes.md"]()
    part = page.partition("## Servo ON from emergency stop\n")[2].partition("\n## ")[0]
    for expected in (
        "(charts/servo_on_from_emergency_stop.svg)",
        "| 4 | SO(03) OFF | The alarm is reset. | 160 | +40 |",
        "  ServoOnAgain(Robot := Robot, Execute := Again);"[2:],
        "(../plc/lib/sequence/FB_ServoOnFromEmergencyStop.st)",
        "(../tests/sequence/test_servo_on_from_emergency_stop.py)",
        "Manual: chapter 5, 3.1",
    ):
        assert expected in part


def test_writing_says_where_it_is_once_it_takes_long(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(docs, "ROOT", tmp_path)
    monkeypatch.setattr(docs, "every_page", lambda: {"one.md": lambda: "1", "two.md": lambda: "2"})
    assert docs.main([]) == 0
    assert not capsys.readouterr().err
    monkeypatch.setattr(docs, "_PATIENCE_S", -1.0)
    assert docs.main([]) == 0
    assert capsys.readouterr().err.splitlines() == ["1/2 one.md", "2/2 two.md"]


def test_a_stale_page_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(docs, "ROOT", tmp_path)
    monkeypatch.setattr(docs, "every_page", lambda: {"page.md": lambda: "new"})
    (tmp_path / "page.md").write_text("old", encoding="utf-8")
    assert docs.main(["--check"]) == 1
    assert "page.md" in capsys.readouterr().err
    assert docs.main([]) == 0
    assert (tmp_path / "page.md").read_text(encoding="utf-8") == "new"
    assert docs.main(["--check"]) == 0


@pytest.mark.parametrize("page", ["README.md", "plc/examples/README.md", "docs/scan-model.md"])
def test_every_block_of_code_that_is_opened_is_closed(page: str) -> None:
    fences = re.findall(r"^```(.*)$", (_ROOT / page).read_text(encoding="utf-8"), re.MULTILINE)
    assert fences[1::2] == [""] * (len(fences) // 2)
    assert len(fences) % 2 == 0


def test_a_command_is_pasted_between_its_fences_and_nothing_else_is_touched(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = (
        "# A\n\n<!-- output of: echo new -->\n```text\n{}```\n\nKept.\n\n```iecst\nx := 1;\n```\n"
    )
    monkeypatch.setattr(docs, "ROOT", tmp_path)
    for before in ("", "old\n", "old\n\nolder\n"):
        (tmp_path / "README.md").write_text(page.format(before), encoding="utf-8")
        assert docs._readme() == page.format("new\n")
