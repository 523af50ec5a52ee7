"""The pages of docs/how-to/setup have the right sizes, valid snippets and valid links."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rcx_harness import Cell, RobotConfig
from rcx_harness.cell.stimulus import Stimulus
from rcx_harness.cli.app import main
from rcx_harness.robot import Point
from rcx_harness.spec.wire import EXTENDED_SIZE, SIZE, TO_MASTER, TO_ROBOT
from structured_text.export.refused import tools

_ROOT = Path(__file__).resolve().parents[3]
_FOLDER = _ROOT / "docs/how-to/setup"
#: Maps the tool names of `rcx check --for` to pages.
_PAGES = {
    "codesys": "codesys",
    "twincat": "twincat",
    "siemens": "s7-1500",
    "rockwell": "studio-5000",
    "omron": "sysmac-studio",
    "mitsubishi": "gx-works3",
    "keyence": "kv-studio",
}
_HEADINGS = (
    *("The connection", "The device", "Variables and byte order", "Connected", "The program"),
    *("What is called differently", "Sources"),
)


def _page(name: str) -> str:
    return (_FOLDER / f"{name}.md").read_text(encoding="utf-8")


def test_each_tool_has_its_page_and_readme_and_index_link_it() -> None:
    assert set(_PAGES) == set(tools()) - {"matiec"}
    assert {file.stem for file in _FOLDER.glob("*.md")} == {*_PAGES.values(), "README"}
    readme = (_ROOT / "README.md").read_text(encoding="utf-8")
    index = _page("README")
    for name in _PAGES.values():
        assert f"(docs/how-to/setup/{name}.md)" in readme
        assert f"({name}.md)" in index


@pytest.mark.parametrize("name", _PAGES.values())
def test_sizes_and_assemblies_are_those_of_the_wire(name: str) -> None:
    """Source: manual chapter 1, 4 (sizes) and 4.3 (assemblies)."""
    rows = dict(re.findall(r"^\| (Input|Output) of the PLC [^|]*\| ([^|]*) \|$", _page(name), re.M))
    for side, assembly in (("Input", TO_MASTER), ("Output", TO_ROBOT)):
        found = [int(one) for one in re.findall(r"\d+(?=,| bytes)", rows[side])]
        assert found == [assembly, SIZE, EXTENDED_SIZE], rows[side]
    numbers = re.findall(r"assembly (\d+)", _page(name), re.IGNORECASE)
    assert {int(one) for one in numbers} - {1} == {TO_MASTER, TO_ROBOT}
    wrong = set(re.findall(r"(\d+) bytes", _page(name))) - {str(SIZE), str(EXTENDED_SIZE)}
    assert not wrong


@pytest.mark.parametrize("tool", _PAGES)
def test_a_page_says_what_it_must(tool: str) -> None:
    text = _page(_PAGES[tool])
    assert [one for one in re.findall(r"^## (.+)$", text, re.M) if one in _HEADINGS] == list(
        _HEADINGS
    )
    assert "**Not tried on the tool.**" in text
    assert f"rcx export {tools()[tool].export}" in text
    assert f"rcx check --for {tool}" in text
    for word in ("InputArea", "OutputArea", "Connected :=", "10 ms"):
        assert word in text


@pytest.mark.parametrize("name", _PAGES.values())
def test_the_snippet_compiles(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The snippets of the pages compile, except those of Studio 5000 (Logix Structured Text)."""
    blocks = re.findall(r"```iecst\n(.*?)```", _page(name), re.DOTALL)
    assert len(blocks) == (name != "studio-5000")
    for block in blocks:
        file = tmp_path / "snippet.st"
        file.write_text(block)
        assert main(["check", str(file)]) == 0, capsys.readouterr().err
        out = capsys.readouterr().out
        assert "no errors, no broken rules" in out
        calls = ("ReadArea(", "ServoOn(", "MovePtp(", "WriteArea(")
        assert [block.count(call) for call in calls] == [1, 1, 1, 1]


@pytest.mark.exhaustive(but=["codesys", "siemens", "twincat"])
@pytest.mark.parametrize("tool", sorted(set(_PAGES) - {"rockwell"}))
def test_the_program_of_the_page_runs_unchanged_and_the_robot_moves(
    tool: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The program of each page runs unchanged: the servos turn ON, and the robot moves to point 19.

    `rcx check --for` does not report the constructs that the page uses.

    Source: manual chapter 5, 3.1; guide 4.2.1; docs/how-to/setup/README.md
    """
    (block,) = re.findall(r"```iecst\n(.*?)```", _page(_PAGES[tool]), re.DOTALL)
    file = tmp_path / "cell.st"
    file.write_text(block)
    robot = RobotConfig(points={19: Point((12_000, 0, 0, 0, 0, 0))})
    with Cell.build(file, engine="builtin", robot=robot) as cell:
        Stimulus.load(_FOLDER / "start.toml").schedule(cell)
        cell.run("4s")
        assert cell["Main.Robot.SO.SO02_ServoOn"]
        assert cell["Main.MovePtp.Done"]
        assert cell.robot.positions[0] == 12_000
        assert not cell.violations
        assert not cell.mistakes
    assert main(["check", str(file), "--for", tool]) == 0
    said = capsys.readouterr().out
    assert "nothing refused" in said
    if tool in ("codesys", "twincat"):
        assert "nothing that may be refused" in said


def test_the_snippet_of_the_readme_is_on_every_page(repository: Path) -> None:
    """The snippet of the README is on every page. Only the names of the area pins differ."""
    readme = (repository / "README.md").read_text(encoding="utf-8")
    snippet = re.findall(r"```iecst\n(.*?)```", readme, re.DOTALL)[0]
    wanted = [line.strip() for line in snippet.splitlines()]
    for name in set(_PAGES.values()) - {"studio-5000"}:
        lines = [line.strip() for line in _page(name).splitlines()]
        at = lines.index(wanted[0])
        assert lines[at : at + len(wanted)] == wanted, name
