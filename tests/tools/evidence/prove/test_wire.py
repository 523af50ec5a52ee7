"""Properties of the data on the wire are proved, and each is broken by a seeded bug."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from rcx_tools.evidence.prove.jobs import PROPERTIES
from rcx_tools.evidence.prove.library import Library
from rcx_tools.evidence.prove.solve import ask
from structured_text.output.toml_files import load_toml
from structured_text.projects.needed import needed
from structured_text.prove.logic import PROVED, REFUTED

pytestmark = pytest.mark.exhaustive

_LIBRARY = Path(__file__).resolve().parents[4] / "plc/lib"
_BUGS = load_toml(Path(__file__).parents[1] / "proof_bugs/wire.toml")["bug"]
_LIMIT_S = 30.0
_SEQUENCES = [
    f"sequence/FB_{name}.st" for name in ("ServoOn", "ProgramStop", "AutoStart", "Status")
]
#: For each property: a part that is quick to prove, and a bug that breaks this part.
_CASES = [
    ("interval", "FB_WRITEAREAWORDS", "negative-margin"),
    ("guarantee", "FB_SERVOON", "other-requests-lost"),
    ("bytes", "FB_WRITEDOUBLEWORDINWORDS", "words-of-a-double-word-swapped"),
    ("reserved", "FB_WRITEAREAWORDS", "general-word-1-goes-out"),
    ("stop-inputs", "FB_PROGRAMSTOP", "stop-held-while-busy-only"),
    ("restart", "FB_AUTOSTART", "start-waits-for-the-link"),
    ("handshake", "FB_WRITEAREAWORDS", "data-changed-before-the-code"),
    ("response", "FB_REMOTECOMMAND", "response-of-an-abnormal-end-lost"),
]


def _copy(folder: Path) -> Path:
    """Copy the part of plc/lib that the cases need, because it is faster to read."""
    shutil.copytree(_LIBRARY / "types", folder / "types")
    own = [*(_LIBRARY / "area").glob("*.st")]
    own += [_LIBRARY / file for file in (*_SEQUENCES, "command/FB_RemoteCommand.st")]
    for file in {*own, *needed(own, sorted(_LIBRARY.rglob("*.st")))}:
        copy = folder / file.relative_to(_LIBRARY)
        copy.parent.mkdir(exist_ok=True)
        shutil.copy(file, copy)
    return folder


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Library:
    return Library(_copy(tmp_path_factory.mktemp("lib")))


@pytest.fixture(scope="module")
def broken(tmp_path_factory: pytest.TempPathFactory) -> Library:
    """Return a copy of plc/lib with the seeded bugs of all cases.

    Each bug breaks another property.
    """
    folder = _copy(tmp_path_factory.mktemp("broken"))
    wanted = {name for _, _, name in _CASES}
    for bug in _BUGS:
        if bug["name"] in wanted:
            file = folder / bug["file"]
            text = file.read_text(encoding="utf-8")
            file.write_text(text.replace(bug["old"], bug["new"]), encoding="utf-8")
    return Library(folder)


def _statuses(library: Library, name: str, part: str) -> Iterator[str]:
    """Return the status (proved or not) of each goal of a part.

    Slow goals, with running timers, are left to `make prove`.
    """
    found = next(item for item in PROPERTIES if item.name == name)
    for goal in found.goals(library, part):
        if "(the timer" not in goal.name:
            yield ask(goal.assumed, goal.claim, _LIMIT_S).status


@pytest.mark.exhaustive(
    but=[
        "guarantee-FB_SERVOON",
        "stop-inputs-FB_PROGRAMSTOP",
        "restart-FB_AUTOSTART",
    ]
)
@pytest.mark.parametrize(("name", "part"), [case[:2] for case in _CASES])
def test_the_property_is_proved_of_a_part_of_the_library(
    library: Library, name: str, part: str
) -> None:
    assert set(_statuses(library, name, part)) == {PROVED}


@pytest.mark.exhaustive(
    but=["guarantee-FB_SERVOON", "stop-inputs-FB_PROGRAMSTOP", "restart-FB_AUTOSTART"]
)
@pytest.mark.parametrize(("name", "part"), [case[:2] for case in _CASES])
def test_the_property_is_refuted_where_it_does_not_hold(
    broken: Library, name: str, part: str
) -> None:
    assert REFUTED in _statuses(broken, name, part)


def test_any_number_of_calls_keeps_what_one_call_does(library: Library) -> None:
    assert set(_statuses(library, "guarantee", "any number of calls")) == {PROVED}


@pytest.mark.parametrize("bug", _BUGS, ids=lambda bug: str(bug["name"]))
def test_a_seeded_bug_changes_one_place_and_breaks_properties_that_exist(
    bug: dict[str, str],
) -> None:
    text = (_LIBRARY / bug["file"]).read_text(encoding="utf-8")
    assert text.count(bug["old"]) == 1
    assert set(bug["breaks"]) <= {item.name for item in PROPERTIES}


def test_each_property_has_two_seeded_bugs_at_least() -> None:
    for name in {case[0] for case in _CASES}:
        assert sum(name in bug["breaks"] for bug in _BUGS) >= 2, name
