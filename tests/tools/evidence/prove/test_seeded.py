"""Each seeded bug of `make prove` breaks exactly the properties that it should."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from rcx_tools.evidence.prove import interval, jobs, seeded
from rcx_tools.evidence.prove.library import BLOCK, Library
from rcx_tools.evidence.prove.property import Goal, Property
from rcx_tools.evidence.results import ROOT
from structured_text.errors import InputError
from structured_text.prove.logic import UnsupportedError

_LIBRARY = ROOT / "plc" / "lib"
_A = """FUNCTION_BLOCK FB_A
  VAR_INPUT x : INT; END_VAR
  VAR_OUTPUT y : INT; z : INT; END_VAR
  y := x;
  z := x;
END_FUNCTION_BLOCK
"""


def _is(pin: str) -> Any:
    def goals(library: Library, part: str) -> Iterator[Goal]:
        if part != "FB_A":
            raise UnsupportedError(f"{part} was asked for")
        step = library.step(part)
        yield Goal(f"{pin} is x", (), step.now((*BLOCK, pin)) == step.now((*BLOCK, "X")))

    return goals


def _part(part: str) -> tuple[str]:
    return (part,)


def _property(name: str, goals: Any, block: str) -> Property:
    return Property(name, "", "", (), goals, lambda _: (block,), _part)


@pytest.fixture
def library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a library of two blocks with two properties of the first and one of the second."""
    folder = tmp_path / "lib"
    folder.mkdir()
    (folder / "FB_A.st").write_text(_A, encoding="utf-8")
    (folder / "FB_B.st").write_text(_A.replace("FB_A", "FB_B"), encoding="utf-8")
    properties = (
        _property("y", _is("Y"), "FB_A"),
        _property("z", _is("Z"), "FB_A"),
        _property("other", _is("Z"), "FB_B"),
    )
    for module in (interval, jobs, seeded):
        monkeypatch.setattr(module, "PROPERTIES", properties)
    return folder


def _row(**more: Any) -> str:
    row = {"name": "n", "file": "FB_A.st", "old": "y := x", "new": "y := 0", "breaks": ["y"]} | more
    return (
        "[[bug]]\n" + "\n".join(f"{key} = {json.dumps(value)}" for key, value in row.items()) + "\n"
    )


def _judged(library: Path, *rows: str) -> dict[str, Any]:
    (library.parent / "bugs.toml").write_text("\n".join(rows), encoding="utf-8")
    jobs.library_at.cache_clear()
    work = seeded.tasks(Library(library), [], 5.0, library.parent / "out", library.parent)
    judged = {task.key: seeded.judge(task) for task in work}
    return seeded.summary(work, judged, whole=False)


def test_a_bug_that_breaks_exactly_its_properties_is_as_expected(library: Path) -> None:
    summary = _judged(library, _row())
    assert (summary["tried"], summary["as_expected"], summary["defects"]) == (1, 1, [])
    (task,) = seeded.tasks(Library(library), [], 5.0, library.parent / "out", library.parent)
    assert seeded.judge(task)["broken"]["y"]["goal"] == "Y is x"


def test_only_what_rests_on_the_changed_file_is_asked(library: Path) -> None:
    work = seeded.tasks(Library(library), [], 5.0, library.parent / "out", _table(library, _row()))
    assert [job.property for job in work[0].parts] == ["y", "z"]


def _table(library: Path, *rows: str) -> Path:
    (library.parent / "bugs.toml").write_text("\n".join(rows), encoding="utf-8")
    return library.parent


@pytest.mark.parametrize(
    ("row", "defect"),
    [
        (_row(breaks=["y", "z"]), "z is still proved"),
        (_row(new="y := 0; z := 1", old="y := x;\n  z := x"), "z is not proved any more: FB_A"),
        (_row(new="y := 1 + x - 1"), "y is still proved"),
        (_row(new="y := w"), "it does not compile: "),
    ],
    ids=["one too few", "one too many", "none", "no Structured Text"],
)
def test_a_bug_that_breaks_less_or_more_is_a_defect(library: Path, row: str, defect: str) -> None:
    summary = _judged(library, row)
    assert summary["as_expected"] == 0
    assert defect in summary["defects"][0]
    assert summary["defects"][0].startswith("the seeded bug n in FB_A.st: ")


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ([_row(old="x")], "the seeded bug 'n': `old` stands 3 times in FB_A.st"),
        ([_row(old="y := 2")], "stands 0 times"),
        ([_row(file="FB_C.st")], "stands 0 times in FB_C.st"),
        ([_row(new="y := x")], "`old` must occur exactly once, and `new` must differ from it"),
        ([_row(breaks=["x"])], "there is no property 'x'; use y, z, other"),
        ([_row(breaks=[])], "none of them empty"),
        ([_row(what="more")], "it needs name, file, old, new, breaks"),
        ([_row(), _row()], "a second seeded bug 'n'"),
    ],
    ids=lambda one: one if isinstance(one, str) else "",
)
def test_a_row_that_cannot_be_put_in_gets_one_message(
    library: Path, rows: list[str], message: str
) -> None:
    with pytest.raises(InputError, match=re.escape(message)):
        _judged(library, *rows)


def test_a_property_that_no_bug_breaks_is_a_defect(library: Path) -> None:
    tables = _table(library, _row())
    work = seeded.tasks(Library(library), [], 5.0, library.parent / "out", tables)
    summary = seeded.summary(work, {task.key: seeded.judge(task) for task in work}, whole=True)
    assert summary["defects"] == ["no seeded bug breaks z", "no seeded bug breaks other"]


def test_an_earlier_verdict_holds_until_something_it_rests_on_changes(library: Path) -> None:
    tables, out = _table(library, _row()), library.parent / "out"

    def key() -> str:
        return seeded.tasks(Library(library), [], 5.0, out, tables)[0].key

    before = key()
    (library / "FB_B.st").write_text(_A.replace("FB_A", "FB_B") + "\n", encoding="utf-8")
    assert key() == before
    (library / "FB_A.st").write_text(_A + "\n", encoding="utf-8")
    assert key() != before


def test_every_seeded_bug_can_be_put_in_and_names_properties() -> None:
    rows = seeded.bugs(seeded.BUGS)
    for bug in rows:
        bug.check(_LIBRARY)
    assert rows


def test_of_other_properties_only_parts_of_the_file_and_short_goals_are_run(
    library: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of other properties, only the parts of the changed file and the short goals are run.

    The choice does not depend on measured time, so it is the same on every machine.
    """
    calls = _A.replace("END_VAR\n  y := x;", "END_VAR\n  VAR a : FB_A; END_VAR\n  a(x := x);")
    for name, more in (("FB_C", 40), ("FB_D", 4), ("FB_E", 4)):
        text = calls.replace("BLOCK FB_A", f"BLOCK {name}").replace(
            "z := x", "z := x" + " + 0" * more
        )
        (library / f"{name}.st").write_text(text, encoding="utf-8")
    every = ("FB_C", "FB_D", "FB_E", "FB_A")
    named = Property("all", "", "", (), _is("Z"), lambda _: every, _part)
    properties = (_property("y", _is("Y"), "FB_A"), named)
    for module in (interval, jobs, seeded):
        monkeypatch.setattr(module, "PROPERTIES", properties)

    def asked() -> tuple[list[str], tuple[str, ...]]:
        (task,) = seeded.tasks(Library(library), [], 5.0, library.parent / "o", tables)
        return [job.part for job in task.parts if job.property == "all"], task.left_out

    tables = _table(library, _row())
    assert asked() == (["FB_A", "FB_D"], ())
    monkeypatch.setattr(seeded, "SLOW", {"all": ("FB_A",)})
    assert asked() == (["FB_D", "FB_E"], ())
    monkeypatch.setattr(seeded, "SLOW", {"all": ()})
    assert asked() == ([], ("all",))


@pytest.mark.exhaustive
def test_the_slow_parts_are_parts() -> None:
    library = Library(_LIBRARY)
    for name, parts in seeded.SLOW.items():
        assert set(parts) <= set(jobs.property_of(name).parts(library))


@pytest.mark.exhaustive
def test_a_copy_is_the_same_whether_its_files_are_parsed_or_taken_from_another(
    tmp_path: Path,
) -> None:
    bug = next(one for one in seeded.bugs(seeded.BUGS) if one.name == "interval-not-waited-for")
    shutil.copytree(_LIBRARY, tmp_path / "lib")
    bug.put_into(tmp_path / "lib")
    one, two = Library(tmp_path / "lib"), Library(tmp_path / "lib", _LIBRARY)
    assert one.project.files == two.project.files
    assert {name: pou.file for name, pou in one.project.pous.items()} == {
        name: pou.file for name, pou in two.project.pous.items()
    }
    body = repr(two.pou("FB_RCXDEDICATEDINPUTS").body)
    assert body == repr(one.pou("FB_RCXDEDICATEDINPUTS").body)
    assert body != repr(Library(_LIBRARY).pou("FB_RCXDEDICATEDINPUTS").body)
