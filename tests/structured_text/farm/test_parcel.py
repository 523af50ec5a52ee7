"""The user's files are packed and sent to a worker."""

from __future__ import annotations

import pickle
import shutil
from pathlib import Path

import pytest

from structured_text.errors import InputError
from structured_text.farm import Parcel


@pytest.fixture
def files(tmp_path: Path) -> list[Path]:
    """Return a program, and a file outside its folder."""
    found = [tmp_path / "cell/plc/Main.st", tmp_path / "cell/robot.toml"]
    for number, file in enumerate(found):
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(b"content %d\r\n" % number)
    return found


def test_an_unpacked_parcel_has_the_files_as_they_were_when_packed(files: list[Path]) -> None:
    parcel = pickle.loads(pickle.dumps(Parcel.of(files)))
    shutil.rmtree(files[1].parent)
    with parcel.unpacked() as there:
        assert [file.read_bytes() for file in there] == [b"content 0\r\n", b"content 1\r\n"]
        assert there[0].parent.parent == there[1].parent
        assert not set(there) & set(files)
    assert not there[0].exists()


def test_an_error_names_the_file_as_the_user_has_it(
    files: list[Path], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path / "cell")
    parcel = Parcel.of([Path("plc/Main.st"), Path("robot.toml")])
    with pytest.raises(InputError) as caught, parcel.unpacked() as there:
        raise InputError(f"is beside {there[1]}", file=there[0], line=3, hint=f"see {there[1]}")
    assert str(caught.value) == "plc/Main.st:3: is beside robot.toml; see robot.toml"


def test_a_digest_depends_on_contents_and_not_on_paths(files: list[Path], tmp_path: Path) -> None:
    digest = Parcel.of(files).digest()
    shutil.copytree(tmp_path / "cell", tmp_path / "copy")
    copies = [tmp_path / "copy/plc/Main.st", tmp_path / "copy/robot.toml"]
    assert Parcel.of(copies).digest() == digest
    copies[1].write_bytes(b"content 2\r\n")
    assert Parcel.of(copies).digest() != digest
    assert Parcel.of(files[:1]).digest() != digest


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"a\.st: cannot be read: No such file"):
        Parcel.of([tmp_path / "a.st"])


def test_a_parcel_may_be_empty() -> None:
    with Parcel.of([]).unpacked() as there:
        assert there == []
