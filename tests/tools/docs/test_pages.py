"""The generated pages and the README's output blocks agree with their sources."""

from __future__ import annotations

import os
import re
from importlib import metadata
from pathlib import Path

import pytest

from for_each import for_each
from rcx_tools.docs import pages as docs

_ROOT = Path(docs.__file__).resolve().parents[3]
_WRITTEN = {path.relative_to(_ROOT).as_posix() for path in (_ROOT / "docs").rglob("*.md")}
_START_PAGES = ["README.md", "CONTRIBUTING.md", "plc/examples/README.md"]
_BY_HAND = [*_START_PAGES, *sorted(_WRITTEN - set(docs.pages()))]


@pytest.mark.exhaustive
@pytest.mark.parametrize("path", docs.pages())
def test_a_generated_page_is_current(path: str) -> None:
    written = (_ROOT / path).read_bytes()
    assert written == docs.pages()[path]().encode(), "run `make docs`"


def _links(page: str) -> list[tuple[str, str]]:
    """Return file and heading of every link of a page. The heading may be empty."""
    text = (_ROOT / page).read_text(encoding="utf-8")
    return re.findall(r"\]\(([^)#:]*)(?:#([^)]+))?\)", text)


@for_each("page", docs.pages())
def test_every_link_of_a_page_leads_to_a_file(page: str) -> None:
    for target, _ in _links(page):
        assert ((_ROOT / page).parent / target).exists(), target


@for_each("page", _BY_HAND)
def test_every_link_of_a_page_written_by_hand_leads_to_a_file_and_a_heading(page: str) -> None:
    for target, anchor in _links(page):
        there = (_ROOT / page).parent / target if target else _ROOT / page
        assert there.exists(), target
        if anchor:
            headings = re.findall(r"^#+ (.+)$", there.read_text(encoding="utf-8"), re.MULTILINE)
            plain = {re.sub(r"[^\w -]", "", one.lower()).replace(" ", "-") for one in headings}
            assert anchor in plain, f"{target}#{anchor}"


def test_every_page_is_in_the_index_or_in_the_one_of_its_folder() -> None:
    home = _ROOT / "docs"
    indexes = ["README.md", "tutorial/README.md", "how-to/setup/README.md", "reference/cli.md"]
    listed = {
        os.path.normpath(Path(index).parent / target)
        for index in indexes
        for target, _ in _links(f"docs/{index}")
    }
    pages = {path.relative_to(home).as_posix() for path in home.rglob("*.md")}
    ours = {page for page in pages if not page.startswith("reference/blocks/")}
    assert not ours - listed - {"README.md"}


@pytest.mark.exhaustive
def test_two_clicks_lead_from_the_readme_to_each_block_and_its_tests() -> None:
    """From the README, two clicks lead to each block, its tests and the folder of a rule.

    The page of a block names its section of the manual.
    """
    ways = [_ROOT / target for target, _ in _links("README.md") if target.endswith(".md")]
    ways.append(_ROOT / "docs/reference/internal-blocks.md")  # a third click, for few readers
    reached = {
        (page.parent / target).resolve()
        for page in ways
        for target, _ in _links(page.relative_to(_ROOT).as_posix())
    }
    for head in docs.headers():
        page = (
            [_ROOT / f"docs/reference/blocks/{head.name}.md"] if head.name.startswith("FB_") else []
        )
        wanted = {head.file, *(_ROOT / test for test in head.tests), *page}
        assert not wanted - reached, head.name
    assert {_ROOT / "harness/rcx_harness/robot", _ROOT / "spec/rules.toml"} <= reached


def test_the_index_of_blocks_has_no_internal_block_and_no_empty_cell_of_the_manual() -> None:
    index = docs.pages()["docs/reference/blocks.md"]()
    rows = re.findall(r"^\| \[?(F[BC]_\w+).*$", index, re.MULTILINE)
    assert not [name for name in rows if name.startswith(("FB_Rcx", "FC_Rcx"))]
    cells = [line.split(" | ") for line in index.splitlines() if line.startswith("| [FB_")]
    assert len(cells) > 150
    assert all(row[3].strip() for row in cells)
    tasks = re.findall(r"\[(FB_\w+)\]\(blocks", index.partition("\n## area")[0])
    assert set(tasks) <= set(rows)


def test_the_changelog_begins_with_the_version_of_the_package() -> None:
    headings = re.findall(r"^## (.+)$", (_ROOT / "CHANGELOG.md").read_text("utf-8"), re.MULTILINE)
    assert headings[0].split()[0] == metadata.version("rcx-harness")


@for_each("page", _BY_HAND)
def test_a_page_names_the_wheel_by_its_path_and_version(page: str) -> None:
    """A page installs the wheel by its path, since the package is not on an index.

    `pip install` uses the file that `pip wheel` has written.
    """
    text = (_ROOT / page).read_text(encoding="utf-8")
    assert "rcx-harness[" not in text
    for line in re.findall(r"^pip install .*rcx_harness.*$", text, re.MULTILINE):
        wheel = rf"rcx_harness-{metadata.version('rcx-harness')}-py3-none-any\.whl"
        assert re.match(rf"pip install 'dist/{wheel}\[[\w,]+\]'", line)
        assert "pip wheel --no-deps -w dist ." in text.partition(line)[0].splitlines()[-1]


def test_the_readme_installs_what_its_commands_need() -> None:
    """The README installs the extras that its commands need.

    `rcx prove` in the section on tests needs z3 from the extra prove.

    Source: pyproject.toml, optional-dependencies
    """
    section = (_ROOT / "README.md").read_text(encoding="utf-8").partition("**Test your")[2]
    section = section.partition("**Connect")[0]
    assert "prove.md" in section
    extras = re.findall(r"^pip install .*\[([\w,]+)\]", section, re.MULTILINE)
    assert {"test", "prove"} <= set(extras[0].split(","))


@pytest.mark.exhaustive
def test_every_link_to_a_chart_leads_to_a_heading() -> None:
    headings = re.findall(
        r"^## (.+)$", docs.pages()["docs/explanation/processes.md"](), re.MULTILINE
    )
    anchors = {re.sub(r"[^\w -]", "", text.lower()).replace(" ", "-") for text in headings}
    linked = [
        target
        for page in ("docs/explanation/processes.md", "docs/reference/blocks.md")
        for target in re.findall(
            r"\]\((?:(?:\.\./explanation/)?processes\.md)?#([^)]+)\)", docs.pages()[page]()
        )
    ]
    assert set(linked) == anchors


@pytest.mark.exhaustive
def test_a_process_shows_its_chart_its_steps_its_block_its_tests_and_the_manual() -> None:
    page = docs.pages()["docs/explanation/processes.md"]()
    part = page.partition("## Servo ON from emergency stop\n")[2].partition("\n## ")[0]
    for expected in (
        "(charts/servo_on_from_emergency_stop.svg)",
        "| 4 | SO(03) OFF | The alarm is reset. | 160 | +40 |",
        "  ServoOnAgain(Robot := Robot, Execute := Again);"[2:],
        "(../../plc/lib/sequence/FB_ServoOnFromEmergencyStop.st)",
        "(../../tests/sequence/test_servo_on_from_emergency_stop.py)",
        "Manual: chapter 5, 3.1",
    ):
        assert expected in part


def test_writing_says_where_it_is_once_it_takes_long(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(docs, "ROOT", tmp_path)
    every = {f"{number}.md": lambda: "text" for number in range(1, 121)}
    monkeypatch.setattr(docs, "every_page", lambda: every)
    assert docs.main([]) == 0
    assert not capsys.readouterr().err
    monkeypatch.setattr(docs, "PATIENCE_S", -1.0)
    assert docs.main([]) == 0
    assert capsys.readouterr().err.splitlines() == ["50/120 pages, 50.md", "100/120 pages, 100.md"]


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


@pytest.mark.parametrize(
    "page", ["README.md", "plc/examples/README.md", "docs/explanation/scan-model.md"]
)
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
        assert docs.pages()["README.md"]() == page.format("new\n")


def test_the_logix_example_sets_execute_of_each_block_that_has_it() -> None:
    """The Logix example in docs/how-to/export.md calls each block with the pin Execute.

    tests/export/test_l5x.py checks pins and arguments.
    """
    page = (_ROOT / "docs/how-to/export.md").read_text(encoding="utf-8")
    code = page.partition("```\nRCX_FirstScan(")[2].partition("```")[0]
    calls = re.findall(r"^(FB_\w+)\((\w+), ", code, re.MULTILINE)
    assert len(calls) == 4
    for block, tag in calls:
        source = next((_ROOT / "plc/lib").rglob(f"{block}.st")).read_text(encoding="utf-8")
        if re.search(r"^\s*Execute\s*:", source, re.MULTILINE):
            assert f"\n{tag}.Execute := " in code.partition(f"{block}(")[0], block


def test_a_head_names_its_tests_and_they_exist() -> None:
    """The head of each POU names its tests, which exist.

    The head of `FB_Jog` names tests/command/test_jog.py. `FC_RcxArmRotation`, in the folder core,
    names test_arm_rotation.py.
    """
    for head in docs.headers():
        name = head.name.partition("_")[2].removeprefix("Rcx")
        words = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()
        folder = "*" if head.folder == "core" else head.folder.partition("/")[0]
        for own in _ROOT.glob(f"tests/{folder}/test_{words}.py"):
            assert own.relative_to(_ROOT).as_posix() in head.tests or head.name.startswith("RCX_")
        assert [test for test in head.tests if not (_ROOT / test).is_file()] == [], head.name
