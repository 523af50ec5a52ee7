"""Packages, their folders ("rooms") and tests import only allowed modules.

The tests read the sources. An import under TYPE_CHECKING or inside a function counts like any
other.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from imports import Graph, find_cycle, floors, imports, private_names, room_graph, shipped

#: Folders ("rooms") of each package, top first. A room may import only rooms of lower lines.
PLANS = {
    "rcx_harness": (
        ("cli",),
        ("assistant", "editor"),
        ("testing", "new", "bridge", "serve", "look"),
        ("verify",),
        ("cell",),
        ("trace",),
        ("watch",),
        ("robot", "enip"),
        ("spec",),
    ),
    "structured_text": (
        ("debug", "editor", "explore", "testing"),
        ("export", "mutants", "coverage", "prove", "bench"),
        ("projects", "engines", "farm"),
        ("language",),
        ("output",),
        ("errors",),
    ),
}
#: The packages from top to bottom. All of them except rcx_tools are in the wheel.
HOUSES = ("rcx_tools", "rcx_harness", "structured_text")
_MOST_ROOMS, _MOST_FLOORS = 15, 9
#: Names of the robot and of its library, which the toolkit must not contain.
_NAMES = re.compile(r"rcx|yamaha|FB_[A-Z]", re.IGNORECASE)
#: Environment variables that users set.
_NO_NAMES = re.compile(r"RCX_(MATIEC|STRUCPP|CACHE|SANITIZE|MUTANT_ORDER|DIALECT)\b")
_CPPPO = re.compile("cpppo", re.IGNORECASE)


@pytest.fixture(scope="module")
def graph() -> Graph:
    """Return the graph of the imports between the modules of all packages."""
    harness = Path(__file__).parents[1] / "harness"
    return imports(*(harness / house for house in HOUSES))


@pytest.fixture(scope="module", params=PLANS)
def house(request: pytest.FixtureRequest) -> str:
    """Return the name of a package; pytest repeats the test for each package of the wheel."""
    package: str = request.param
    return package


@pytest.fixture(scope="module")
def rooms(graph: Graph, house: str) -> Graph:
    """Return the graph of the imports between the rooms (folders) of a package."""
    within = f"{house}."
    return room_graph(
        {
            name: frozenset(other for other in others if other.startswith(within))
            for name, others in graph.items()
            if name.startswith(within)
        }
    )


def test_a_package_has_the_rooms_of_its_plan_and_at_most_15(rooms: Graph, house: str) -> None:
    """Source: docs/explanation/architecture.md, the rooms."""
    assert set(rooms) == {room for line in PLANS[house] for room in line}
    assert len(rooms) <= _MOST_ROOMS


def test_a_room_imports_only_lower_rooms_with_at_most_9_levels(rooms: Graph, house: str) -> None:
    """A room imports only rooms below it; robot and enip do not import each other.

    Source: docs/explanation/architecture.md, the arrows.
    """
    rank = {room: number for number, line in enumerate(PLANS[house]) for room in line}
    upward = [
        f"{room} -> {other}"
        for room, others in sorted(rooms.items())
        for other in sorted(others)
        if rank[other] <= rank[room]
    ]
    assert upward == []
    assert floors(rooms) <= _MOST_FLOORS


@pytest.mark.parametrize("package", HOUSES)
def test_no_module_imports_itself_through_other_modules(graph: Graph, package: str) -> None:
    """Source: docs/explanation/architecture.md, the arrows."""
    own = {name: others for name, others in graph.items() if name.split(".")[0] == package}
    assert " -> ".join(find_cycle(own)) == ""


def test_a_package_never_imports_one_above_it(graph: Graph) -> None:
    """The toolkit has no dependency on the robot, and the users' packages have none on our tools.

    Source: docs/explanation/architecture.md, the packages.
    """
    rank = {house: number for number, house in enumerate(HOUSES)}
    assert [
        f"{name} -> {other}"
        for name, others in graph.items()
        for other in others
        if rank[other.partition(".")[0]] < rank[name.partition(".")[0]]
    ] == []


def test_the_robot_does_not_import_the_engines_or_enip(graph: Graph) -> None:
    """Source: docs/explanation/architecture.md, the arrows."""
    found = {
        f"{name} -> {other}"
        for name, others in graph.items()
        for other in others
        if name.startswith(("rcx_harness.robot", "rcx_harness.enip"))
        and other.startswith(("structured_text.engines", "structured_text.language"))
    }
    assert found == set()


def test_the_toolkit_has_no_name_of_the_robot_or_its_library(repository: Path) -> None:
    """Source: docs/explanation/architecture.md, the packages."""
    home = repository / "harness" / "structured_text"
    files = [file for file in home.rglob("*") if file.is_file() and file.suffix != ".pyc"]
    found = {
        file.relative_to(home).as_posix()
        for file in files
        if _NAMES.search(_NO_NAMES.sub("", file.read_text(encoding="utf-8")))
    }
    assert found == set()


def test_only_enip_names_cpppo(repository: Path) -> None:
    """Source: docs/explanation/architecture.md, the rooms."""
    found = {
        ".".join(name.split(".")[:2])
        for name, file in shipped(repository).items()
        if _CPPPO.search(file.read_text(encoding="utf-8"))
    }
    assert found == {"rcx_harness.enip"}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("from house import kitchen", {"house.kitchen"}),
        ("import house.kitchen.table", {"house.kitchen.table"}),
        ("from house.kitchen import table, knife", {"house.kitchen", "house.kitchen.table"}),
        ("from house.kitchen.table import leg", {"house.kitchen.table"}),
        ("from .kitchen import table", {"house.kitchen.table"}),
        ("from . import kitchen", {"house.kitchen"}),
        ("from house import *", {"house"}),
        ("def cook():\n    from house.kitchen import table", {"house.kitchen.table"}),
        ("if TYPE_CHECKING:\n    from house.kitchen import table", {"house.kitchen.table"}),
        ("import os\nfrom attic.kitchen import box\nimport housekeeping", set()),
    ],
)
def test_every_way_to_import_a_module_is_seen(
    tmp_path: Path, text: str, expected: set[str]
) -> None:
    house = tmp_path / "house"
    (house / "kitchen").mkdir(parents=True)
    for file in ("__init__.py", "kitchen/__init__.py", "kitchen/table.py"):
        (house / file).touch()
    (house / "hall.py").write_text(text)
    assert imports(house)["house.hall"] == expected


def test_circles_and_floors_are_found() -> None:
    tower = {"c": frozenset("ab"), "b": frozenset("a"), "a": frozenset[str]()}
    assert find_cycle(tower) == []
    assert floors(tower) == 3
    circle = find_cycle(tower | {"a": frozenset("b")})
    assert circle in (["a", "b", "a"], ["b", "a", "b"])


@pytest.mark.exhaustive
def test_no_test_reaches_into_private_names(repository: Path) -> None:
    """Source: CONTRIBUTING.md, tests."""
    files = sorted((repository / "tests").rglob("*.py"))
    found = {file.name: private_names(file.read_text(encoding="utf-8")) for file in files}
    assert {name: names for name, names in found.items() if names} == {}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("from house.kitchen import _knife", {"_knife"}),
        ("from house import hall, _cellar as cellar", {"_cellar"}),
        ("import house._cellar", {"house._cellar"}),
        ("def cook():\n    from house import _cellar", {"_cellar"}),
        ("monkeypatch.setattr('house.kitchen._knife', 1)", {"house.kitchen._knife"}),
        ("monkeypatch.setattr('house.kitchen._Knife.blade', 1)", {"house.kitchen._Knife.blade"}),
        ("monkeypatch.setattr(kitchen, '_knife', 1)", {"_knife"}),
        ("setattr(kitchen, '_knife', 1)", {"_knife"}),
        ("getattr(kitchen, '_knife', None)", {"_knife"}),
        ("hasattr(kitchen, '_knife')", {"_knife"}),
        ("mock.patch.object(kitchen, '_knife')", {"_knife"}),
        ("from house import __main__, kitchen\nfrom __future__ import annotations", set()),
        ("setattr(kitchen, 'knife', '_it')\nsetattr(kitchen, '__exit__', 1)", set()),
        ("say('_knife')", set()),
    ],
)
def test_every_way_to_a_private_name_is_seen(text: str, expected: set[str]) -> None:
    assert private_names(text) == expected
