"""`make prove` runs goals again only if needed, writes its files, and reports bad input."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from rcx_tools.evidence.prove import __main__ as runner
from rcx_tools.evidence.prove import interval, jobs, seeded
from rcx_tools.evidence.prove.agreement import jobs as agreeing
from rcx_tools.evidence.prove.library import BLOCK, Library
from rcx_tools.evidence.prove.property import Goal, Property
from rcx_tools.evidence.prove.running import DIED, outcomes
from structured_text.prove.logic import UnsupportedError

_CLAMP = """FUNCTION FC_Clamp : INT
  VAR_INPUT v : INT; END_VAR
  FC_Clamp := v;
  IF v > 10 THEN FC_Clamp := 10; END_IF;
END_FUNCTION
"""
_A = """FUNCTION_BLOCK FB_A
  VAR_INPUT x : INT; END_VAR
  VAR_OUTPUT y : INT; END_VAR
  y := FC_Clamp(v := x);
END_FUNCTION_BLOCK
"""
_B = """FUNCTION_BLOCK FB_B
  VAR_INPUT x : INT; END_VAR
  VAR_OUTPUT y : INT; z : INT; END_VAR
  y := x; IF y > 10 THEN y := 9; END_IF;
  z := x;
END_FUNCTION_BLOCK
"""


def _small(library: Library, part: str) -> Iterator[Goal]:
    step = library.step(part)
    y = step.now((*BLOCK, "Y"))
    yield Goal(f"{part}: y is small", tuple(step.machine.assumptions), y <= 10, {"y": y})


def _same(library: Library, part: str) -> Iterator[Goal]:
    step = library.step(part)
    yield Goal("z is x", (), step.now((*BLOCK, "Z")) == step.now((*BLOCK, "X")))


_PROPERTIES = (
    Property(
        *("small", "y is at most 10.", "chapter 5, 3", ("inner",), _small),
        lambda library: library.blocks,
        lambda part: (part,),
    ),
    Property(
        *("same", "z is x.", "chapter 5, 1", ("clock",), _same),
        lambda _: ("FB_B",),
        lambda part: (part,),
    ),
)
_ROW = '[[bug]]\nname = "{}"\nfile = "{}"\nold = "{}"\nnew = "{}"\nbreaks = {}\n'
_GOOD = (
    _ROW.format("clamps-at-11", "FC_Clamp.st", "Clamp := 10", "Clamp := 11", '["small"]'),
    _ROW.format("z-is-y", "FB_B.st", "z := x", "z := y", '["same"]'),
)


@pytest.fixture
def library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a library of two blocks and a function.

    It has two properties, and a seeded bug for each of them.
    """
    folder = tmp_path / "lib"
    folder.mkdir()
    for name, text in (("FC_Clamp", _CLAMP), ("FB_A", _A), ("FB_B", _B)):
        (folder / f"{name}.st").write_text(text, encoding="utf-8")
    for module in (interval, jobs, seeded):
        monkeypatch.setattr(module, "PROPERTIES", _PROPERTIES)
    monkeypatch.setattr(seeded, "BUGS", tmp_path)
    monkeypatch.setattr(runner, "LIBRARY", folder)
    monkeypatch.setattr(agreeing, "comparisons", lambda _: ())
    _bugs(folder, *_GOOD)
    return folder


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return a list that collects the goals that are passed to the solver."""
    names: list[str] = []
    real = jobs.answers

    def noted(job: jobs.Job, library: Library, *more: Any) -> Iterator[dict[str, Any]]:
        for answer in real(job, library, *more):
            names.append(f"{job.property} {job.part}")
            yield answer

    monkeypatch.setattr(jobs, "answers", noted)
    return names


def _bugs(library: Path, *rows: str) -> None:
    (library.parent / "bugs.toml").write_text("\n".join(rows), encoding="utf-8")


def _prove(library: Path, *arguments: str) -> int:
    # Compiled sources are cached by name and time, so each run here needs its own.
    jobs.library_at.cache_clear()
    return runner.main(["--jobs", "0", "--out", str(library.parent / "out"), *arguments])


def _report(library: Path, file: str = "prove.json") -> Any:
    return json.loads((library.parent / "out" / file).read_text(encoding="utf-8"))


def test_the_report_names_each_property_with_status_seconds_and_assumptions(library: Path) -> None:
    assert _prove(library) == 0
    report = _report(library)
    small, same = report["properties"]
    assert (small["name"], same["name"]) == ("small", "same")
    assert (small["status"], small["assumes"], small["goals"]) == ("proved", ["inner"], 2)
    assert small["seconds"] >= 0
    assert set(report["assumptions"]) == {"inner", "clock"}
    assert (report["seeded"]["tried"], report["seeded"]["as_expected"]) == (2, 2)


def test_what_is_proved_is_asked_again_only_where_its_sources_have_changed(
    library: Path, asked: list[str]
) -> None:
    assert _prove(library) == 0
    asked.clear()
    assert _prove(library) == 0
    assert asked == []
    (library / "FB_A.st").write_text(_A.replace("y :=", "y := 0 +"), encoding="utf-8")
    assert _prove(library, "small", "same") == 0
    assert asked == ["small FB_A"]
    asked.clear()
    (library / "FC_Clamp.st").write_text(_CLAMP.replace("= 10", "= 9"), encoding="utf-8")
    assert _prove(library, "small", "same") == 0
    assert asked == ["small FB_A"]


def test_what_is_not_proved_is_told_with_a_state_and_asked_again(
    library: Path, asked: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    (library / "FB_A.st").write_text(_A.replace("y := FC", "y := 1 + FC"), encoding="utf-8")
    for _ in range(2):
        asked.clear()
        assert _prove(library, "small") == 1
        assert "small FB_A" in asked
    (goal,) = _report(library, "prove/part.json")["properties"][0]["not_proved"]
    assert (goal["status"], goal["part"], goal["values"]) == ("refuted", "FB_A", {"y": 11})
    assert "refuted: small: FB_A: y is small: for example y = 11" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (UnsupportedError("FOR of a REAL"), "FOR of a REAL"),
        (KeyError("Q"), "'Q', which does not exist"),
    ],
)
def test_what_cannot_be_asked_is_unknown_with_its_reason(
    library: Path, monkeypatch: pytest.MonkeyPatch, error: Exception, reason: str
) -> None:
    def refuse(*_: object) -> None:
        raise error

    monkeypatch.setattr(Library, "step", refuse)
    assert _prove(library, "same") == 1
    (item,) = _report(library, "prove/part.json")["properties"]
    assert item["status"] == "unknown"
    assert reason in item["not_proved"][0]["reason"]


def test_a_part_of_the_properties_leaves_the_report_of_all_as_it_is(library: Path) -> None:
    _prove(library)
    before = _report(library)
    assert _prove(library, "same") == 0
    assert _prove(library, "--bug", "z-is-y") == 0
    assert _report(library) == before


def test_another_copy_is_proved_without_the_seeded_bugs(
    library: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert _prove(library, "--lib", str(library)) == 0
    assert "seeded" not in _report(library)
    assert "are only for the library of this project" in capsys.readouterr().err


def _no_folder(copy: Path) -> None:
    for file in copy.iterdir():
        file.unlink()
    copy.rmdir()


def _empty(copy: Path) -> None:
    for file in copy.iterdir():
        file.unlink()


def _syntax(copy: Path) -> None:
    (copy / "FB_A.st").write_text(_A + "y := ;", encoding="utf-8")


def _lacking(copy: Path) -> None:
    (copy / "FB_A.st").unlink()


def _used(copy: Path) -> None:
    (copy / "FC_Clamp.st").unlink()


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (_no_folder, "copy is not a folder; name a copy of plc/lib"),
        (_empty, "copy contains no .st file; name a copy of plc/lib"),
        (_syntax, "FB_A.st:6:1: 'y' is not expected here"),
        (_lacking, "copy has no FB_A; a copy of plc/lib must contain all its blocks"),
        (_used, "FB_A.st:4:8: "),
    ],
)
def test_a_folder_that_is_no_copy_of_the_library_gets_one_message(
    library: Path, spoil: Any, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    copy = library.parent / "copy"
    copy.mkdir()
    for file in library.iterdir():
        (copy / file.name).write_text(file.read_text(encoding="utf-8"), encoding="utf-8")
    spoil(copy)
    assert _prove(library, "--lib", str(copy)) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert message in line


def test_a_name_that_is_none_gets_the_names_there_are(
    library: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert _prove(library, "sane") == 2
    assert "there is no property 'sane'; use small, same" in capsys.readouterr().err
    assert _prove(library, "--bug", "none") == 2
    assert "there is no seeded bug 'none'" in capsys.readouterr().err


class _Deadly:
    """An object that ends the process that unpickles it."""

    def __reduce__(self) -> tuple[Any, tuple[int]]:
        return os._exit, (3,)


def test_a_process_that_dies_is_an_outcome_of_its_job_and_the_others_go_on() -> None:
    work = [SimpleNamespace(key=str(number)) for number in range(4)]
    work[1].more = _Deadly()
    found = outcomes(vars, work, 2, lambda job: {"key": job.key, "reason": DIED})
    assert sorted((one["key"], one.get("reason")) for one in found) == [
        *(("0", None), ("1", DIED), ("2", None), ("3", None))
    ]
