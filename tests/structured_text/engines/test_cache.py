"""Compiled programs are cached, and a cache entry is used only if nothing has changed."""

from __future__ import annotations

import os
import pickle
import time
from pathlib import Path

import pytest

from structured_text.engines.builtin.statements import Writer
from structured_text.engines.load import build
from structured_text.errors import InputError
from structured_text.language import cache
from structured_text.projects.needed import needed

_TEXT = """PROGRAM Main
  VAR
    Sum : INT;
    Part : INT := {by};
  END_VAR
  Sum := Sum + 12 / Part;
END_PROGRAM
"""


@pytest.fixture
def program(tmp_path: Path) -> Path:
    """Return a program that adds 12."""
    file = tmp_path / "Main.st"
    file.write_text(_TEXT.format(by=1), encoding="utf-8")
    return file


@pytest.fixture
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return an empty cache folder.

    The fixture lets the cache accept temporary files, which it normally ignores.
    """
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.delenv("RCX_CACHE", raising=False)
    monkeypatch.setattr(cache, "is_lasting", lambda _: True)
    _forget(monkeypatch)
    return tmp_path / "cache" / "rcx-harness"


def _forget(monkeypatch: pytest.MonkeyPatch) -> None:
    """Clear the cache in memory, as in a new process."""
    monkeypatch.setattr(cache, "memory", {})


def _sum(program: Path) -> int:
    running = build([program], "builtin").program
    running.scan(0)
    return int(running.read("Main.Sum"))


def _kinds(folder: Path) -> list[str]:
    """Return the kinds of the entries, except the parser's tables, which depend on no source."""
    return sorted(file.suffix for file in folder.iterdir() if file.name != "grammar.tables")


def test_the_same_sources_are_checked_and_written_once(
    program: Path, kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A second compilation of the same sources reads the cache and does not check them again.

    Source: docs/explanation/timing.md: a cache for the second run.
    """
    assert _sum(program) == 12
    assert _kinds(kept) == [".code", ".project"]
    _forget(monkeypatch)
    monkeypatch.setattr("structured_text.language.load.analyse", _fail)
    monkeypatch.setattr(Writer, "write", _fail)
    assert _sum(program) == 12


def _fail(*_: object) -> None:
    raise AssertionError("the cache was not used")


def test_an_unchanged_file_is_read_once(program: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file with the same times and size is not read again; a changed file is.

    Source: the manual of git, index format: files are compared by their times and size.
    """
    monkeypatch.setattr(cache, "SETTLED_NS", -(10**18))
    first = cache.sources_key([program])
    with monkeypatch.context() as again:
        again.setattr(cache, "file_bytes", _fail)
        assert cache.sources_key([program]) == first
    program.write_text(_TEXT.format(by=12), encoding="utf-8")
    assert cache.sources_key([program]) != first


def test_a_change_within_a_tick_is_seen(program: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file that changed a moment ago is read again, even if its time and size are unchanged.

    Source: the manual of git, racy git
    """
    now = time.time_ns()
    monkeypatch.setattr(cache, "file_state", lambda name: (now, now, 1, 1, 1))
    first = cache.sources_key([program])
    program.write_text(_TEXT.format(by=2), encoding="utf-8")
    assert cache.sources_key([program]) != first


def test_a_change_of_the_sources_is_seen(program: Path, kept: Path) -> None:
    """Sources with other contents are compiled again, even if the file time is the same.

    The key of a cache entry contains the contents of all files.
    """
    assert _sum(program) == 12
    stamp = program.stat().st_mtime_ns
    program.write_text(_TEXT.format(by=3), encoding="utf-8")
    os.utime(program, ns=(stamp, stamp))
    assert _sum(program) == 4
    assert len(_kinds(kept)) == 4


def test_the_list_of_needed_library_files_is_cached_until_a_file_changes(
    program: Path, kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The list of needed library files is cached until a file changes.

    The key contains the contents of all files, and tells the library's files from the program's.
    """
    other, two = program.with_name("FC_Two.st"), "FUNCTION FC_Two : INT\nEND_FUNCTION\n"
    other.write_text(two, encoding="utf-8")
    assert needed([program], [other]) == []
    assert needed([program, other], []) == []
    assert needed([], [program, other]) == []
    assert _kinds(kept) == [".needed"] * 3
    _forget(monkeypatch)
    with monkeypatch.context() as again:
        again.setattr("structured_text.projects.needed.source_text", _fail)
        assert needed([program], [other]) == []
    stamp = program.stat().st_mtime_ns
    text = program.read_text(encoding="utf-8")
    program.write_text(text.replace("12 / Part", "FC_Two()"), encoding="utf-8")
    os.utime(program, ns=(stamp + 1, stamp + 1))
    assert needed([program], [other]) == [other]


def test_instances_of_a_cached_program_share_nothing(program: Path) -> None:
    """A second instance of a cached program starts with its initial values.

    Source: engines.base.Program.
    """
    one = build([program], "builtin").program
    one.scan(0)
    two = build([program], "builtin").program
    assert (one.read("Main.Sum"), two.read("Main.Sum")) == (12, 0)


@pytest.mark.parametrize("damage", [b"", b"no pickle", b"\x80\x05."])
def test_a_damaged_entry_is_made_anew(
    program: Path, kept: Path, monkeypatch: pytest.MonkeyPatch, damage: bytes
) -> None:
    """A damaged cache entry is ignored and replaced.

    Source: a process may be ended while it writes, a disk may be full.
    """
    _sum(program)
    for entry in kept.iterdir():
        entry.write_bytes(damage)
    _forget(monkeypatch)
    assert _sum(program) == 12
    assert all(entry.read_bytes() != damage for entry in kept.iterdir())


class _Evil:
    """An object that opens a file for writing when it is unpickled."""

    def __reduce__(self) -> tuple[object, tuple[str, str]]:
        return open, ("executed", "w")


def test_a_planted_entry_is_not_executed(
    program: Path, kept: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A pickle that an attacker puts into the cache is not executed.

    An earlier version read the cache with pickle.
    """
    monkeypatch.chdir(tmp_path)
    _sum(program)
    entries = list(kept.iterdir())
    for planted in (pickle.dumps(_Evil()), pickle.dumps(5), bytes(32) + pickle.dumps(_Evil())):
        for entry in entries:
            entry.write_bytes(planted)
        _forget(monkeypatch)
        assert _sum(program) == 12
    assert not Path("executed").exists()


def test_an_entry_is_read_as_it_was_written_or_not_at_all(kept: Path) -> None:
    """A cache entry with changed, missing or additional bytes is refused."""
    kept.mkdir(parents=True)
    entry = kept / "one.so"
    cache.put(entry, b"library")
    assert cache.content(entry) == b"library"
    data = entry.read_bytes()
    for other in (data[:-1], data + b"y", b"\0" + data[1:], b"library", b""):
        entry.write_bytes(other)
        with pytest.raises(ValueError, match="not signed"):
            cache.content(entry)
    (kept / "two.so").write_bytes(data)
    with pytest.raises(ValueError, match="not signed"):
        cache.content(kept / "two.so")


def test_an_entry_of_another_kind_is_made_anew(
    program: Path, kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A project entry in the place of a code entry is ignored and replaced.

    Both entries have a valid signature of the cache.
    """
    _sum(program)
    (code,), (project,) = kept.glob("*.code"), kept.glob("*.project")
    code.write_bytes(project.read_bytes())
    _forget(monkeypatch)
    assert _sum(program) == 12


def test_with_the_cache_off_nothing_is_saved(
    program: Path, kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With RCX_CACHE=off no cache folder is made.

    Source: RCX_CACHE=off.
    """
    monkeypatch.setenv("RCX_CACHE", "off")
    assert _sum(program) == 12
    assert not kept.exists()


def test_temporary_files_are_not_cached(
    program: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Programs in the folder of temporary files are not cached.

    Source: engines/load.py: nobody compiles them a second time.
    """
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr("tempfile.gettempdir", lambda: str(tmp_path))
    assert _sum(program) == 12
    assert not list((tmp_path / "cache").rglob("*.project"))


def test_an_error_in_a_cached_program_has_its_line(
    program: Path, kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An error in a cached program is reported with file and line, as in a new one.

    Source: engines.builtin: a division by zero is told with file and line.
    """
    program.write_text(_TEXT.format(by=0), encoding="utf-8")
    for _ in range(2):
        with pytest.raises(InputError, match=rf"{program}:6: division by zero"):
            _sum(program)
        _forget(monkeypatch)


def test_a_mistake_is_reported_each_time(program: Path, kept: Path) -> None:
    """Sources with an error are not cached, so each compilation reports the error."""
    program.write_text(_TEXT.format(by=1).replace("Sum +", "Some +"), encoding="utf-8")
    for _ in range(2):
        with pytest.raises(InputError, match="Some"):
            build([program], "builtin")
    assert not list(kept.glob("*.project"))


def test_the_loader_reports_a_missing_file(tmp_path: Path) -> None:
    """A missing source file is reported as one that cannot be read.

    Source: language.load: cannot be read.
    """
    with pytest.raises(InputError, match="cannot be read"):
        build([tmp_path / "missing.st"], "builtin")


def test_a_failed_put_leaves_nothing_behind(kept: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """On Windows, a file that another process reads cannot be replaced."""

    def refuse(source: str, target: Path) -> None:
        raise PermissionError(13, "in use", str(target))

    kept.mkdir(parents=True)
    monkeypatch.setattr("os.replace", refuse)
    with pytest.raises(PermissionError):
        cache.put(kept / "one.program", b"new")
    assert list(kept.iterdir()) == []
    assert cache.kept("program", "one", lambda: 5) == 5


def test_without_a_home_nothing_is_kept_and_all_works(monkeypatch: pytest.MonkeyPatch) -> None:
    def homeless() -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr("pathlib.Path.home", homeless)
    for name in ("XDG_CACHE_HOME", "RCX_CACHE"):
        monkeypatch.delenv(name, raising=False)
    assert cache.folder() is None
