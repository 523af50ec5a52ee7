"""`rcx export` never loses a user's file and never reads its own output."""

from __future__ import annotations

import errno
import hashlib
import resource
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from io import FileIO
from pathlib import Path
from typing import Any

import pytest

from plc_bench import ROOT
from rcx_harness.cli.app import main
from structured_text.projects.sources import st_files

Captured = pytest.CaptureFixture[str]

_RECORD = "rcx-export.json"


@pytest.fixture
def plc(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Write a program that needs a function of the library, and return its folder."""
    folder = tmp_path / "plc"
    folder.mkdir()
    (folder / "Mine.st").write_text(_program("FC_RcxWord(LowByte := BYTE#16#01, HighByte := b)"))
    monkeypatch.chdir(folder)
    return folder


def _program(value: str) -> str:
    variables = "    b : BYTE;\n    w : WORD;\n"
    return f"PROGRAM Mine\n  VAR\n{variables}  END_VAR\n  w := {value};\nEND_PROGRAM\n"


def _export(target: str, out: str, *options: str) -> int:
    return main(["export", target, "--program", ".", "--needed", "-o", out, *options])


def _texts(folder: Path) -> dict[str, bytes]:
    return {
        file.relative_to(folder).as_posix(): file.read_bytes()
        for file in folder.rglob("*")
        if file.is_file()
    }


@contextmanager
def _full() -> Iterator[None]:
    """Limit each file to 600 bytes, which simulates a full disk.

    Python must not write compiled code meanwhile, because it would not notice that such a file is
    cut off. The limit ends within the test, because pytest writes its own output afterwards.
    """
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    with pytest.MonkeyPatch.context() as python:
        python.setattr(sys, "dont_write_bytecode", True)
        resource.setrlimit(resource.RLIMIT_FSIZE, (600, before[1]))
        try:
            yield
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.parametrize("arguments", [["export", "st"], ["export", "plcopen"], ["eds"]])
def test_a_full_disk_leaves_the_old_file_as_it_was(
    plc: Path, arguments: list[str], capsys: Captured
) -> None:
    out = plc / "out" / "cell"
    out.parent.mkdir()
    program = ["--needed", "--program", "Mine.st", "-o", str(out)]
    more = [str(out)] if arguments == ["eds"] else program
    assert main([*arguments, *more]) == 0
    before = out.read_bytes()
    with _full():
        assert main([*arguments, *more, "--force"]) == 2
    assert f"{out}: cannot be written: File too large" in capsys.readouterr().err
    assert _texts(out.parent) == {"cell": before}


def test_a_full_disk_changes_no_folder(plc: Path, capsys: Captured) -> None:
    assert _export("twincat", "out/old") == 0
    before = _texts(plc)
    (plc / "Mine.st").write_text(_program("FC_RcxWord(LowByte := b, HighByte := b)"))
    changed = _texts(plc)
    assert before != changed
    with _full():
        assert _export("twincat", "out/old", "--force") == 2
        assert _export("twincat", "out/new") == 2
    assert "cannot be written" in capsys.readouterr().err
    assert _texts(plc) == changed
    assert not (plc / "out/new").exists()


def test_if_the_record_cannot_be_written_no_file_is_written(
    plc: Path, monkeypatch: pytest.MonkeyPatch, capsys: Captured
) -> None:
    """If the disk is full when the record of an export is written, no file is written.

    Without the record, a later export would treat the files as files of the user.
    """

    class Full(FileIO):
        def write(self, data: Any) -> int:
            if b"`rcx export` wrote here" in data:
                raise OSError(errno.ENOSPC, "No space left on device")
            return super().write(data)

    plain = Path.open

    def opened(path: Path, mode: str = "r", **more: Any) -> Any:
        return Full(path, mode) if mode == "xb" else plain(path, mode, **more)

    monkeypatch.setattr(Path, "open", opened)
    assert _export("twincat", "out") == 2
    assert f"{_RECORD}: cannot be written: No space left on device" in capsys.readouterr().err
    assert not (plc / "out").exists()


@pytest.mark.parametrize("arguments", [["export", "st"], ["export", "plcopen"], ["eds"]])
def test_only_an_earlier_export_is_overwritten(
    plc: Path, arguments: list[str], capsys: Captured
) -> None:
    program = ["--needed", "--program", "Mine.st", "-o", "robot.toml"]
    words = [*arguments, *(["robot.toml"] if arguments == ["eds"] else program), "--force"]
    mine = plc / "robot.toml"
    mine.write_bytes(b"the user's")
    assert main(words) == 2
    said = "rcx: robot.toml: was not written by an export; nothing was written; move it away\n"
    assert capsys.readouterr().err == said
    assert mine.read_bytes() == b"the user's"
    mine.unlink()
    assert main(words) == 0
    assert main(words) == 0


def test_a_link_and_the_permissions_of_its_file_stay(plc: Path) -> None:
    assert _export("st", "real") == 0
    (plc / "real").write_text((plc / "real").read_text()[:1_000])
    (plc / "real").chmod(0o640)
    (plc / "link").symlink_to("real")
    assert _export("st", "link", "--force") == 0
    assert (plc / "link").is_symlink()
    assert "PROGRAM Mine" in (plc / "real").read_text()
    assert (plc / "real").stat().st_mode & 0o777 == 0o640


@pytest.mark.parametrize("target", ["twincat", "omron", "mitsubishi", "keyence"])
def test_files_of_others_in_a_folder_are_kept(plc: Path, target: str, capsys: Captured) -> None:
    out = plc / "out"
    assert _export(target, "out", "--allow-missing") == 0
    names = sorted(name for name in _texts(out) if name != _RECORD)
    for name in names:
        (out / name).unlink()
    (out / _RECORD).unlink()
    theirs = out / names[0]
    theirs.write_bytes(b"the user's")
    (out / "notes.txt").write_bytes(b"the user's, too")
    before = _texts(out)
    assert _export(target, "out", "--allow-missing") == 2
    said = capsys.readouterr().err
    assert "rcx: out: contains files that no export wrote; name an empty or new folder" in said
    assert _export(target, "out", "--allow-missing", "--force") == 2
    said = capsys.readouterr().err
    assert (
        f"rcx: {theirs.relative_to(plc)}: was not written by an export; nothing was written" in said
    )
    assert _texts(out) == before
    theirs.unlink()
    assert _export(target, "out", "--allow-missing", "--force") == 0
    assert (out / "notes.txt").read_bytes() == b"the user's, too"
    assert sorted(_texts(out)) == sorted([*names, "notes.txt", _RECORD])


def test_an_earlier_export_is_replaced_on_request(plc: Path, capsys: Captured) -> None:
    assert _export("twincat", "out") == 0
    before = _texts(plc / "out")
    assert _export("twincat", "out") == 2
    assert (
        capsys.readouterr().err
        == "rcx: out: contains an earlier export; use --force to replace it\n"
    )
    assert _export("twincat", "out", "--force") == 0
    assert _texts(plc / "out") == before


def test_unneeded_objects_of_an_earlier_export_are_removed(plc: Path, capsys: Captured) -> None:
    """A new export removes old objects that are not needed any more.

    It does not remove files that the user has changed or added.
    """
    lib = plc.parent / "lib"
    for name in ("core/FC_RcxWord", "core/FC_RcxBitMask", "core/FC_RcxOutside", "points/FC_One"):
        (lib / name).parent.mkdir(parents=True, exist_ok=True)
        text = (ROOT / "plc/lib/core/FC_RcxBitMask.st").read_text()
        if name == "core/FC_RcxWord":
            text = (ROOT / "plc/lib/core/FC_RcxWord.st").read_text()
        (lib / f"{name}.st").write_text(text.replace("FC_RcxBitMask", name.rpartition("/")[2]))
    library = ["--lib", str(lib)]
    assert main(["export", "twincat", *library, "--program", "Mine.st", "-o", "out"]) == 0
    all_of_it = _texts(plc / "out")
    assert len(all_of_it) == 7
    (plc / "out/RCX3/core/FC_RcxOutside.TcPOU").write_bytes(b"changed")
    (plc / "out/RCX3/core/Mine.TcPOU").write_bytes(b"put there")
    capsys.readouterr()
    assert _export("twincat", "out", "--force", *library) == 0
    said = capsys.readouterr().out.splitlines()
    assert set(_texts(plc / "out")) == {
        *("RCX3.plcproj", "RCX3/core/FC_RcxWord.TcPOU", "RCX3/program/Mine.TcPOU", _RECORD),
        *("RCX3/core/FC_RcxOutside.TcPOU", "RCX3/core/Mine.TcPOU"),
    }
    assert sum(line.startswith("removed: out/RCX3/") for line in said) == len(all_of_it) - 5
    assert (
        "kept: out/RCX3/core/FC_RcxOutside.TcPOU (from the earlier export, changed since then)"
        in said
    )
    assert not (plc / "out/RCX3/points").exists(), "empty folders must be removed"


def test_a_changed_file_of_an_export_is_kept(plc: Path, capsys: Captured) -> None:
    assert _export("omron", "out") == 0
    body = plc / "out/program/Mine.st"
    body.write_bytes(b"(* mine now *)")
    before = _texts(plc / "out")
    assert _export("omron", "out", "--force") == 2
    said = capsys.readouterr().err
    assert "rcx: out/program/Mine.st: was changed since it was exported; nothing was" in said
    assert _texts(plc / "out") == before


@pytest.mark.parametrize(
    "text", ["", "[]", "{}", '{"files": {"../Mine.st": "0"}}', "\x00", "9" * 9]
)
def test_an_invalid_record_is_treated_as_a_file_of_the_user(
    plc: Path, text: str, capsys: Captured
) -> None:
    (plc / "out").mkdir()
    (plc / "out" / _RECORD).write_text(text)
    assert _export("omron", "out", "--force") == 2
    assert "is not a record of an export; move it away" in capsys.readouterr().err
    assert _texts(plc / "out") == {_RECORD: text.encode()}


def test_files_outside_of_the_folder_are_not_removed(plc: Path) -> None:
    assert _export("omron", "out") == 0
    record = plc / "out" / _RECORD
    text = record.read_text()
    mine = plc / "Mine.st"
    known = hashlib.sha256(mine.read_bytes()).hexdigest()
    record.write_text(text.replace('"files": {', f'"files": {{\n  "../Mine.st": "{known}",'))
    assert _export("omron", "out", "--force") == 0
    assert mine.exists()


@pytest.mark.parametrize(
    ("target", "out"), [("st", "cell.st"), ("st", "a.st"), ("omron", "out"), ("keyence", "plc")]
)
def test_an_export_does_not_read_an_earlier_one(plc: Path, target: str, out: str) -> None:
    """`--program .` reads only the user's files, even if the folder contains an earlier export."""
    assert _export(target, out) == 0
    first = _texts(plc)
    assert _export(target, out, "--force") == 0
    assert _export("st", "another.st") == 0
    assert {name: text for name, text in _texts(plc).items() if name != "another.st"} == first
    assert st_files(plc) == [plc / "Mine.st"]


def test_other_commands_do_not_read_an_export(plc: Path, capsys: Captured) -> None:
    """`rcx check .` ignores exported files; otherwise each name would be declared twice."""
    assert _export("st", "cell.st") == 0
    assert _export("keyence", "out", "--allow-missing") == 0
    assert main(["check", "."]) == 0
    assert capsys.readouterr().out.splitlines()[-1].startswith("1 file checked")


def test_a_folder_with_only_an_export_is_reported(plc: Path, capsys: Captured) -> None:
    assert _export("st", "out/cell.st") == 0
    capsys.readouterr()
    assert main(["run", "out", "--for", "20ms"]) == 2
    assert "contains exported .st files only; name a file to use it" in (capsys.readouterr().err)
