"""If a user names a special file or a file that is too large, one message reports it.

Such a file is never read.
"""

from __future__ import annotations

import os
import re
import socket
from dataclasses import replace
from pathlib import Path

import pytest

from rcx_harness.cli.app import main
from structured_text.errors import InputError
from structured_text.output import limits
from structured_text.output.limits import CAPTURE, MOST_BLOCKS, SOURCE, TABLE, Kind
from structured_text.output.reading import check_file, file_bytes, file_text, open_file

_SMALL = Kind("a source", 1 << 20, "divide it into several files")


def _pipe(folder: Path) -> Path:
    os.mkfifo(folder / "pipe.st")
    return folder / "pipe.st"


def test_a_pipe_a_device_a_socket_and_a_folder_are_refused_before_they_are_opened(
    tmp_path: Path,
) -> None:
    """Opening a pipe waits for a writer, and a device may have no end.

    Source: docs/reference/limits.md, files.
    """
    place = tmp_path / "socket"
    with socket.socket(socket.AF_UNIX) as one:
        one.bind(os.fspath(place))
        for path, what in (
            (_pipe(tmp_path), "a pipe"),
            (Path("/dev/zero"), "a device"),
            (place, "a socket"),
            (tmp_path, "a folder"),
        ):
            for reads in (check_file, lambda path: open_file(path, CAPTURE)):
                with pytest.raises(InputError, match=f"is {what}, not a file; name a file"):
                    reads(path)


@pytest.mark.parametrize(
    "words",
    [
        ["check", "@"],
        ["run", "@"],
        ["export", "st", "--program", "@"],
        ["prove", "@"],
        ["explore", "@"],
        ["campaign", "@"],
        ["mutants", "@", "--", "pytest"],
        ["judge", "@"],
        ["view", "@", "-o", "page.html"],
        ["compare", "@"],
        ["run", "own.st", "--robot", "@"],
        ["run", "own.st", "--stimulus", "@"],
        ["run", "own.st", "--properties", "@"],
        ["run", "own.st", "--replace", "P=@"],
        ["serve", "--robot", "@"],
    ],
)
def test_every_command_refuses_a_pipe_where_it_takes_a_file(
    words: list[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """If a command read the pipe, this test would never end.

    Source: docs/reference/limits.md, files.
    """
    monkeypatch.chdir(tmp_path)
    areas = "VAR InputArea, OutputArea : ARRAY [0..511] OF BYTE; END_VAR"
    Path("own.st").write_text(f"PROGRAM Own\n{areas}\nEND_PROGRAM\n", encoding="utf-8")
    pipe = _pipe(tmp_path)
    assert main([word.replace("@", os.fspath(pipe)) for word in words]) == 2
    assert "pipe.st: is a pipe, not a file" in capsys.readouterr().err


def test_a_file_that_is_too_large_is_not_read(tmp_path: Path) -> None:
    """A file of exactly the largest size is read; a file with one more byte is refused.

    Source: docs/reference/limits.md, files.
    """
    file = tmp_path / "large.st"
    with file.open("wb") as stream:
        stream.truncate(1 << 20)  # a sparse file uses no space on the disk
    assert len(file_bytes(file, _SMALL)) == 1 << 20
    with file.open("ab") as stream:
        stream.write(b"x" * 100_000)
    text = "is too large for a source: 1.1 MB, and the limit is 1 MB; divide it into several files"
    with pytest.raises(InputError, match=re.escape(text)):
        file_bytes(file, _SMALL)
    assert open_file(file, replace(_SMALL, most_bytes=None)).read(1) == b"\0"


def test_a_text_that_is_not_utf_8_has_the_line_of_the_byte(tmp_path: Path) -> None:
    """Source: docs/reference/limits.md: robot files and stimuli are UTF-8."""
    file = tmp_path / "robot.toml"
    file.write_bytes(b"size = 48\r\n# f\xe4ngt\r\n")
    with pytest.raises(InputError, match=r"robot\.toml:2: byte 14 is not UTF-8; save the file"):
        file_text(file, TABLE)
    file.write_bytes(b"\xef\xbb\xbfsize = 48\r\n")
    assert file_text(file, TABLE) == "size = 48\n"


def test_the_page_of_limits_names_every_limit() -> None:
    """Source: docs/reference/limits.md."""
    page = (
        Path(__file__).parents[2].joinpath("docs/reference/limits.md").read_text(encoding="utf-8")
    )
    numbers = {
        getattr(limits, name)
        for name in vars(limits)
        if name.startswith("MOST_") and not name.endswith(("_US", "_BYTES"))
    }
    assert MOST_BLOCKS in numbers
    assert [one for one in sorted(numbers) if not re.search(rf"\b{one:,}\b", page)] == []
    kinds = (limits.SOURCE, limits.PROJECT, limits.TABLE, limits.OTHER)
    sizes = [(kind.most_bytes or 0) >> 20 for kind in kinds]
    assert sizes == [8, 128, 16, 512]
    assert all(f"| {size} MB" in page for size in sizes)
    assert limits.MOST_LINE_BYTES == 16 << 20
    assert (limits.MOST_TRACE_US, limits.MOST_REPLAYED_US) == (366 * 86_400 * 10**6, 86_400 * 10**6)
    assert SOURCE.hint in page
