"""The calls of an assistant stay inside of the folders that the server was given."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest

from rcx_harness.assistant.call import OUT, Call, Ran
from rcx_harness.assistant.fence import Fence
from rcx_harness.assistant.folders import Folders
from structured_text.errors import InputError


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """Return a project with links to the outside, beside a file that must stay unread."""
    folder = tmp_path / "project"
    (folder / "plc").mkdir(parents=True)
    (folder / "plc/main.st").write_text("")
    (tmp_path / "secret.st").write_text("")
    (folder / "link.st").symlink_to(tmp_path / "secret.st")
    (folder / "up").symlink_to(tmp_path)
    (folder / "inside.st").symlink_to(folder / "plc/main.st")
    return folder


@pytest.mark.parametrize(
    "path",
    ["../secret.st", "plc/../../secret.st", "/etc/passwd", "link.st", "up/secret.st", "up", ""],
)
def test_a_path_outside_of_the_folders_is_refused(project: Path, path: str) -> None:
    with pytest.raises(InputError):
        Folders.of([project]).inside(path, project)


def test_the_refusal_does_not_tell_whether_a_file_exists(project: Path) -> None:
    folders = Folders.of([project])
    said = []
    for name in ("../secret.st", "../nothing.st"):
        with pytest.raises(InputError) as refused:
            folders.inside(name, project)
        said.append(str(refused.value).replace(name, ""))
    assert said[0] == said[1]


@pytest.mark.parametrize(
    ("path", "found"),
    [("plc/main.st", "plc/main.st"), ("./plc/../plc", "plc"), ("inside.st", "plc/main.st")],
)
def test_a_path_inside_is_relative_and_has_no_links(project: Path, path: str, found: str) -> None:
    assert Folders.of([project]).inside(path, project) == Path(found)


def test_a_second_folder_is_reached_by_its_path(project: Path, tmp_path: Path) -> None:
    other = tmp_path / "other"
    other.mkdir()
    folders = Folders.of([project, other])
    assert folders.inside(str(other / "a.st"), project) == Path("../other/a.st")
    assert folders.chosen(str(other)) == other
    with pytest.raises(InputError, match="is not a folder of this server"):
        folders.chosen("plc")


@pytest.fixture
def fence(project: Path) -> Fence:
    return Fence.around([project], [project / "out"])


@pytest.mark.parametrize(
    ("event", "arguments"),
    [
        ("open", ("{}/../secret.st", "r", 0)),
        ("open", ("{}/link.st", "r", 0)),
        ("open", ("{}/plc/main.st", "w", 0)),
        ("open", ("{}/plc/main.st", None, 0o1)),
        ("os.remove", ("{}/plc/main.st", -1)),
        ("os.rename", ("{}/out/a", "{}/plc/main.st", -1, -1)),
        ("os.listdir", ("{}/up",)),
        ("socket.connect", (None, ("192.0.2.1", 80))),
        ("socket.connect", (None, ("127.0.0.1", 80))),
        ("socket.getaddrinfo", ("example.org", 80, 0, 0, 0)),
        ("subprocess.Popen", ("/bin/sh", ["sh"], None, None)),
        ("subprocess.Popen", (sys.executable, ["python"], None, None)),
        ("os.system", ("true",)),
    ],
)
def test_the_fence_refuses(
    project: Path, fence: Fence, event: str, arguments: tuple[Any, ...]
) -> None:
    given = tuple(one.format(project) if isinstance(one, str) else one for one in arguments)
    with pytest.raises(PermissionError):
        fence.check(event, given)


@pytest.mark.parametrize(
    ("event", "arguments"),
    [
        ("open", ("{}/plc/main.st", "rb", 0)),
        ("open", ("{}/out/a/trace.jsonl", "wb", 0)),
        ("open", (3, "w", 0)),
        ("os.rename", ("{}/out/a", "{}/out/b", -1, -1)),
        ("os.scandir", ("{}/plc",)),
    ],
)
def test_the_fence_allows(
    project: Path, fence: Fence, event: str, arguments: tuple[Any, ...]
) -> None:
    fence.check(
        event, tuple(one.format(project) if isinstance(one, str) else one for one in arguments)
    )


def test_a_fence_is_the_same_after_it_was_saved(fence: Fence) -> None:
    assert Fence.loaded(fence.saved()) == fence


def _call(folder: Path, **given: Any) -> Call:
    return Call("run", given, Folders.of([folder]), folder, folder, lambda words, tell: Ran(0, ()))


def test_equal_calls_have_the_same_output_folder(project: Path) -> None:
    first = _call(project, files=["a.st"]).out()
    assert first == _call(project, files=["a.st"]).out()
    assert first != _call(project, files=["b.st"]).out()
    assert first.parent == OUT


def test_a_folder_with_files_of_others_is_not_used(project: Path) -> None:
    folder = project / _call(project, files=["a.st"]).out()
    (folder / "call.json").write_text("mine")
    with pytest.raises(InputError, match="contains files of others"):
        _call(project, files=["a.st"]).out()
    assert (folder / "call.json").read_text() == "mine"


def test_an_output_folder_behind_a_link_is_refused(project: Path, tmp_path: Path) -> None:
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (project / "out").symlink_to(elsewhere)
    with pytest.raises(InputError, match="is reached through a link"):
        _call(project, files=["a.st"]).out()
    assert list(elsewhere.iterdir()) == []
