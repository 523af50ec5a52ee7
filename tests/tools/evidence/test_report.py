"""`make verification` runs checks, reuses earlier results, and writes the page of results."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from rcx_tools.docs import pages as docs
from rcx_tools.evidence import checks, page, report
from rcx_tools.evidence.checks import CHECKS, Check, digest
from structured_text.errors import InputError

_MAKEFILE = (docs.ROOT / "Makefile").read_text(encoding="utf-8")


@pytest.fixture
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a small repository with a library and a check that depends on a folder of tests."""
    for path in ("plc/lib/FB_A.st", "tests/a/test_a.py", "docs/explanation/keep.txt"):
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_text("one", encoding="utf-8")
    here = digest

    def state(names: tuple[str, ...], folder: Path = tmp_path) -> str:
        return here(names, folder)

    monkeypatch.setattr(report, "digest", state)
    monkeypatch.setattr(report, "library_state", lambda: state(("plc/lib",)))
    monkeypatch.setattr(report, "CHECKS", (_CHECK,))
    monkeypatch.setattr(page, "CHECKS", (_CHECK,))
    monkeypatch.setattr(report, "ROOT", tmp_path)
    monkeypatch.setattr(report, "FOLDER", tmp_path / "out/verification")
    monkeypatch.setattr(report, "DOCS", tmp_path / "docs/explanation")
    return tmp_path


_CHECK = Check("a", "All of A", "tested", "About A.", (("cases", lambda f: f["n"]),), ("tests/a",))


class _Tool:
    """A replacement for the program of a check. It records its calls and writes results."""

    def __init__(self, root: Path) -> None:
        self.file = root / "out/verification/a.json"
        self.runs: list[tuple[str, ...]] = []
        self.met = True

    def __call__(self, check: Check, arguments: Sequence[str]) -> int:
        self.runs.append(tuple(arguments))
        content = {"command": "make a", "figures": {"n": "1,234"}, "met": self.met}
        self.file.write_text(json.dumps(content), encoding="utf-8")
        return int(not self.met)


def _write(root: Path, path: str, text: str) -> None:
    (root / path).write_text(text, encoding="utf-8")


def test_a_result_is_reused_until_what_it_depends_on_changes(root: Path) -> None:
    tool = _Tool(root)
    assert report.main([], tool) == 0
    assert report.main([], tool) == 0
    assert len(tool.runs) == 1
    for count, path in enumerate(("plc/lib/FB_A.st", "tests/a/test_a.py"), 2):
        _write(root, path, "two")
        assert report.main([], tool) == 0
        assert len(tool.runs) == count
    _write(root, "docs/explanation/keep.txt", "two")
    report.main([], tool)
    assert len(tool.runs) == 3
    report.main(["--fresh"], tool)
    assert len(tool.runs) == 4


def test_a_result_that_is_not_met_is_never_reused_and_shows(root: Path) -> None:
    tool = _Tool(root)
    tool.met = False
    assert report.main([], tool) == 1
    assert report.main([], tool) == 1
    assert len(tool.runs) == 2
    assert "**not met**" in (root / "docs/explanation/verification.md").read_text(encoding="utf-8")
    assert "not met, not run or older: a" in report.stale(
        root / "docs/explanation/verification.json"
    )


@pytest.mark.parametrize("arguments", [[], ["--only", "a"]])
def test_ctrl_c_ends_it_with_one_line(
    root: Path, arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    def run(check: Check, given: Sequence[str]) -> int:
        raise KeyboardInterrupt

    assert report.main(arguments, run) == 130
    assert capsys.readouterr().err == "stopped; the next run goes on from here\n"
    assert not (root / "docs/explanation/verification.json").exists()


def test_sources_that_change_under_way_give_no_result_to_reuse(root: Path) -> None:
    tool = _Tool(root)

    def run(check: Check, arguments: Sequence[str]) -> int:
        _write(root, "plc/lib/FB_A.st", "changed")
        return tool(check, arguments)

    report.main([], run)
    assert not report.is_current(_CHECK, root / "out/verification")


def test_a_check_that_breaks_off_does_not_leave_its_last_result_as_a_new_one(root: Path) -> None:
    report.main([], _Tool(root))
    _write(root, "plc/lib/FB_A.st", "two")
    assert report.main([], lambda check, arguments: 1) == 1
    assert not report.is_current(_CHECK, root / "out/verification")


def test_one_check_gets_the_other_arguments_and_is_then_no_whole_run(root: Path) -> None:
    tool = _Tool(root)
    assert report.main(["--only", "a", "--fresh", "FB_X"], tool) == 0
    assert tool.runs == [("--fresh", "FB_X")]
    assert not report.is_current(_CHECK, root / "out/verification")
    report.main(["--only", "a"], tool)
    assert report.is_current(_CHECK, root / "out/verification")


def test_the_page_says_of_which_library_its_figures_are(
    root: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert report.main(["--check"]) == 1
    assert "there are no figures yet" in capsys.readouterr().out
    report.main([], _Tool(root))
    state = digest(("plc/lib",), root)
    text = (root / "docs/explanation/verification.md").read_text(encoding="utf-8")
    assert f"library state `{state}`" in text
    assert "| cases | 1,234 |" in text
    assert report.main(["--check"]) == 0
    _write(root, "plc/lib/FB_A.st", "two")
    capsys.readouterr()
    assert report.main(["--check"]) == 1
    assert f"its figures are of library state {state}" in capsys.readouterr().out
    assert report.main(["--remind"]) == 0
    assert state in capsys.readouterr().out


def test_a_check_may_have_tables_of_its_own(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    check = replace(_CHECK, tables=(lambda figures: (["P", "Says"], [["one", figures["n"]]]),))
    monkeypatch.setattr(report, "CHECKS", (check,))
    monkeypatch.setattr(page, "CHECKS", (check,))
    report.main([], _Tool(root))
    text = (root / "docs/explanation/verification.md").read_text(encoding="utf-8")
    assert "| P | Says |\n|---|---|\n| one | 1,234 |\n" in text


def test_all_figures_are_in_one_file(root: Path) -> None:
    report.main([], _Tool(root))
    every: dict[str, Any] = json.loads((root / "out/verification.json").read_text("utf-8"))
    assert every["met"] is True
    assert every["checks"]["a"]["figures"] == {"n": "1,234"}
    assert every["checks"]["a"]["state"]["library"] == every["library"]


def test_a_figure_that_the_check_does_not_give_is_an_error(root: Path) -> None:
    tool = _Tool(root)
    report.main([], tool)
    tool.file.write_text('{"figures": {}, "met": true}', encoding="utf-8")
    with pytest.raises(InputError, match="does not give: cases"):
        report.update(tool.file.parent, root / "docs/explanation")
    assert report.main(["--page"]) == 2


def test_a_result_of_an_older_library_is_not_taken_for_one_of_this(root: Path) -> None:
    report.main([], _Tool(root))
    older = digest(("plc/lib",), root)
    _write(root, "plc/lib/FB_A.st", "two")
    assert report.main(["--page"]) == 1
    text = (root / "docs/explanation/verification.md").read_text(encoding="utf-8")
    assert f"met by library state `{older}`" in text
    assert "older: a" in report.stale(root / "docs/explanation/verification.json")


def test_a_check_that_has_not_run_says_so() -> None:
    text = page.verification_page(Path("nowhere.json"))
    assert text.count("| not run |") == len(CHECKS)


def test_each_check_has_its_target_and_every_source_is_there() -> None:
    targets = re.search(r"^CHECKS := (.+)$", _MAKEFILE, re.MULTILINE)
    assert targets
    assert set(targets[1].split()) == {check.name for check in CHECKS}
    for check in CHECKS:
        for source in check.sources:
            assert list((docs.ROOT / source).parent.glob(f"{Path(source).name}*")), source


def test_the_stored_figures_are_those_of_the_page() -> None:
    """The stored figures are those of the page: every row has its value.

    tests/tools/docs compares the page itself.
    """
    kept = json.loads(page.KEPT.read_text(encoding="utf-8"))
    for check in CHECKS:
        if check.name in kept["checks"]:
            labels = [label for label, _ in kept["checks"][check.name]["rows"]]
            assert labels == [label for label, _ in check.rows], check.name


def test_the_state_depends_on_names_and_contents(tmp_path: Path) -> None:
    (tmp_path / "lib").mkdir()
    one = tmp_path / "lib/a.st"
    one.write_text("x", encoding="utf-8")
    first = checks.digest(("lib",), tmp_path)
    one.write_text("y", encoding="utf-8")
    second = checks.digest(("lib",), tmp_path)
    one.rename(tmp_path / "lib/b.st")
    third = checks.digest(("lib",), tmp_path)
    (tmp_path / "lib/notes.tmp").write_text("z", encoding="utf-8")
    assert len({first, second, third}) == 3
    assert checks.digest(("lib",), tmp_path) == third


def test_each_property_has_a_row_with_its_assumptions() -> None:
    """Each property has a row: a sentence, its assumptions, its goals and the seconds.

    The test uses a small out/prove.json.
    """
    (prove,) = [check for check in CHECKS if check.name == "prove"]
    item: dict[str, Any] = {
        "name": "turn",
        "says": "Turns are once.",
        "section": "guide 4",
        "status": "unknown",
    }
    item |= {"assumes": ["inner", "calls"], "uses": ["functions"], "goals": 1200, "seconds": 3.5}
    agreed = {"scans": 110_400, "blocks": 156, "least_of_a_block": 600, "disagreements": []}
    figures = {
        "properties": [item],
        "assumptions": {"inner": "No program writes."},
        "agreement": {**agreed, "matiec": {"says": "not compared on matiec (none)"}},
        "seeded": {"tried": 2, "as_expected": 2},
    }
    rows = {name: tell(figures) for name, tell in prove.rows}
    assert rows["scans in which translation and engine agree"] == (
        "110,400 of 156 blocks, at least 600 of each "
        "(blocks that call SIN, COS or ATAN are left out); "
        "not compared on matiec (none); differences 0"
    )
    (heads, lines), (_, taken) = (table(figures) for table in prove.tables)
    told = dict(zip(heads, *lines, strict=True))
    assert told["Property"] == "`turn` **unknown**"
    assert told["What is proved"] == "Turns are once."
    assert (told["Assumes"], told["Uses"]) == ("inner, calls", "`functions`")
    assert (told["Goals"], told["Solver [s]"]) == ("1,200", "3.5")
    assert taken == [["inner", "No program writes."]]
