"""Paths of exported files are resolved, and an export records the files that it has written."""

from __future__ import annotations

from pathlib import Path

import pytest

from structured_text.output.exported import RECORD, own_output, record, resolved


def test_a_link_to_a_file_and_one_to_its_folder_lead_to_the_same_place(tmp_path: Path) -> None:
    """Paths through links to a file or folder are resolved to the same file.

    Source: pathlib.Path.resolve, file by file.
    """
    place = tmp_path / "plc"
    place.mkdir()
    (place / "A.st").touch()
    try:
        (tmp_path / "other").symlink_to(place)
        (tmp_path / "B.st").symlink_to(place / "A.st")
    except OSError:
        pytest.skip("this user may make no links")
    files = [place / "A.st", tmp_path / "other" / "A.st", tmp_path / "B.st", place / "none.st"]
    found = resolved(files)
    assert list(found) == files
    assert list(found.values()) == [file.resolve() for file in files]
    assert len(set(list(found.values())[:3])) == 1


def test_a_record_of_an_export_covers_files_in_subfolders(tmp_path: Path) -> None:
    """A record of an export covers files in subfolders of its folder.

    Source: docs/how-to/export.md: a folder that was exported is known again by its record.
    """
    deep = tmp_path / "made" / "lib" / "A.st"
    deep.parent.mkdir(parents=True)
    deep.touch()
    (deep.parent / "B.st").touch()
    (tmp_path / "made" / RECORD).write_bytes(record({"lib/A.st": b"x"}))
    (deep.parent / RECORD).write_bytes(record({"C.st": b"x"}))
    assert own_output(resolved([deep, deep.parent / "B.st"])) == {deep}
