"""An unchanged folder is scanned once, and every change in it is noticed."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from structured_text.projects.sources import st_files

_LONG_AGO = 1_000_000_000  # [s]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder with a file, and a subfolder with a file."""
    (tmp_path / "plc/below").mkdir(parents=True)
    (tmp_path / "plc/a.st").touch()
    (tmp_path / "plc/below/b.st").touch()
    for place in ("plc", "plc/below"):
        os.utime(tmp_path / place, (_LONG_AGO, _LONG_AGO))
    return tmp_path / "plc"


@pytest.fixture
def later(monkeypatch: pytest.MonkeyPatch) -> None:
    """Set the clock ten seconds ahead. All files then count as old."""
    now = time.time_ns
    monkeypatch.setattr(time, "time_ns", lambda: now() + 10_000_000_000)


@pytest.fixture
def looked(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return a list that collects the folders that are scanned."""
    found: list[str] = []
    scan = os.scandir

    def counted(place: str) -> Iterator[os.DirEntry[str]]:
        found.append(Path(place).name)
        return scan(place)

    monkeypatch.setattr(os, "scandir", counted)
    return found


def _names(folder: Path) -> list[str]:
    return [file.relative_to(folder).as_posix() for file in st_files(folder)]


@pytest.mark.usefixtures("later")
def test_an_unchanged_folder_is_read_once(folder: Path, looked: list[str]) -> None:
    assert _names(folder) == _names(folder) == ["a.st", "below/b.st"]
    assert looked == ["plc", "below"]


@pytest.mark.usefixtures("later")
def test_a_file_that_comes_or_goes_below_it_is_seen(folder: Path, looked: list[str]) -> None:
    _names(folder)
    (folder / "below/c.st").touch()
    assert _names(folder) == ["a.st", "below/b.st", "below/c.st"]
    (folder / "a.st").unlink()
    assert _names(folder) == ["below/b.st", "below/c.st"]
    assert looked[2:] == ["below", "plc"]


def test_a_folder_that_changed_just_now_is_read_again(folder: Path, looked: list[str]) -> None:
    """A folder that changed just now is scanned again.

    Two changes within a clock tick have the same time.
    """
    _names(folder)
    _names(folder)
    assert looked == ["plc", "below"] * 2


@pytest.mark.usefixtures("later")
def test_a_folder_with_an_older_time_is_read_again(folder: Path) -> None:
    """A folder is scanned again if its time is older than before.

    Programs that unpack or copy files restore older times.
    """
    if os.name == "nt":
        pytest.skip("Windows has no time of the last change that a program cannot set")
    before = folder.stat()
    _names(folder)
    (folder / "c.st").touch()
    # wait until the file system's clock advances
    while folder.stat().st_ctime_ns == before.st_ctime_ns:
        os.utime(folder, (_LONG_AGO, _LONG_AGO))
    os.utime(folder, (_LONG_AGO, _LONG_AGO))
    assert folder.stat().st_mtime_ns == before.st_mtime_ns
    assert _names(folder) == ["a.st", "below/b.st", "c.st"]


@pytest.mark.usefixtures("later")
def test_folders_with_the_same_relative_name_are_not_mixed_up(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    other = folder.parent / "other/plc"
    other.mkdir(parents=True)
    (other / "d.st").touch()
    os.utime(other, (_LONG_AGO, _LONG_AGO))
    monkeypatch.chdir(folder.parent)
    assert st_files(Path("plc")) == [Path("plc/a.st"), Path("plc/below/b.st")]
    monkeypatch.chdir(other.parent)
    assert st_files(Path("plc")) == [Path("plc/d.st")]
