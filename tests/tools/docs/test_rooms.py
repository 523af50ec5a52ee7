"""The plan of the folders ("rooms") in docs/explanation/architecture.md agrees with the sources."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rcx_tools.docs import rooms

_ROOT = Path(rooms.__file__).resolve().parents[3]
_HARNESS = _ROOT / "harness"
_SUPPORT = _ROOT / "tests/support"

#: Modules that check the rules of the wire, named without .py (docs/explanation/architecture.md).
_JUDGES = {
    "dedicated": _HARNESS / "rcx_harness/robot",
    "handshake": _HARNESS / "rcx_harness/robot",
    "wire": _HARNESS / "rcx_harness/watch",
    "oracle": next(_HARNESS.rglob("explore/oracle.py")).parent,
    "contract_rules": _SUPPORT,
    "head_rules": _SUPPORT,
}


_PACKAGES = tuple(rooms.PLANS)


@pytest.mark.exhaustive
@pytest.mark.parametrize("package", _PACKAGES)
def test_every_room_is_in_the_plan_and_imports_follow_the_plan(package: str) -> None:
    """Each room is in the plan, and imports follow the plan, so there are no circular imports."""
    plan = rooms.PLANS[package]
    assert sorted(name for row in plan for name in row) == sorted(rooms.rooms(package))
    assert rooms.against(plan, rooms.arrows(package)) == []


@pytest.mark.parametrize(("named", "room"), [("cpppo", "enip"), ("rcx_tools", "nowhere")])
def test_only_one_room_imports_the_package(named: str, room: str) -> None:
    """In rcx_harness, only the room enip imports cpppo, and no module imports `rcx_tools`."""
    for file in (_HARNESS / "rcx_harness").rglob("*.py"):
        text = file.read_text(encoding="utf-8")
        if re.search(rf"^\s*(?:import|from) {named}\b", text, re.MULTILINE):
            assert room in file.parts, file


def test_an_import_inside_a_function_or_for_types_is_an_arrow() -> None:
    """An import inside a function or for types counts as well: `testing` imports the cell late."""
    source = (_HARNESS / "rcx_harness/testing/plugin.py").read_text(encoding="utf-8")
    assert re.search(r"^    from rcx_harness", source, re.MULTILINE)
    assert "cell" in rooms.arrows("rcx_harness")["testing"]


def test_an_arrow_that_follows_from_others_is_not_drawn() -> None:
    every = {"a": {"b", "c", "d"}, "b": {"c"}, "c": {"d"}, "d": set[str]()}
    assert rooms.drawn(every) == [("a", "b"), ("b", "c"), ("c", "d")]


def test_an_import_against_the_plan_is_told_and_not_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    every = {**rooms.arrows("rcx_harness"), "robot": {"cell"}}
    assert rooms.against(rooms.PLANS["rcx_harness"], every) == [("robot", "cell")]
    monkeypatch.setattr(rooms, "arrows", lambda _: every)
    with pytest.raises(ValueError, match=r"\('robot', 'cell'\)"):
        rooms.rooms_svg("rcx_harness")


@pytest.mark.parametrize("package", _PACKAGES)
def test_the_page_has_a_row_for_each_room(package: str) -> None:
    page = (_ROOT / "docs/explanation/architecture.md").read_text(encoding="utf-8")
    found = re.findall(rf"^\| \[(\w+)\]\(\.\./\.\./harness/{package}/(\w+)", page, re.MULTILINE)
    assert sorted(found) == sorted((name, name) for name in rooms.rooms(package))


@pytest.mark.parametrize("judge", _JUDGES)
def test_no_module_that_checks_the_wire_imports_another(judge: str) -> None:
    """The modules that check the wire do not import each other.

    An error in one of them then appears as a difference from the others.
    """
    text = (_JUDGES[judge] / f"{judge}.py").read_text(encoding="utf-8")
    imported = set(re.findall(r"^(?:from|import) ([\w.]+)", text, re.MULTILINE))
    others = {f"{folder.name}.{name}" for name, folder in _JUDGES.items()} | set(_JUDGES)
    found = {
        name for name in imported if name in others or ".".join(name.split(".")[-2:]) in others
    }
    assert not found
