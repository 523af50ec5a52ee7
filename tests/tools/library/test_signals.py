"""Handwritten blocks of plc/lib have lines that are generated from spec/signals.toml."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from plc_bench import LIBRARY, ROOT
from rcx_harness import spec
from rcx_tools.library.signals import signal_files
from structured_text.errors import InputError

_FILES = sorted(signal_files())


def _copy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, path: str) -> Path:
    """Copy the tables and this source file, and let the generator use the copies."""
    shutil.copytree(ROOT / "spec", tmp_path / "spec")
    file = tmp_path / path
    file.parent.mkdir(parents=True)
    shutil.copy(ROOT / path, file)
    monkeypatch.setattr(spec, "folder", lambda: tmp_path / "spec")
    return file


@pytest.mark.parametrize("path", _FILES)
def test_the_lines_of_each_bit_are_those_of_the_table(path: str) -> None:
    assert signal_files()[path]() == (ROOT / path).read_text(encoding="utf-8")


@pytest.mark.parametrize("path", _FILES)
def test_a_line_that_was_changed_by_hand_is_written_anew_and_the_rest_is_kept(
    path: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = _copy(tmp_path, monkeypatch, path)
    right = file.read_text(encoding="utf-8")
    first = re.search(r"`make docs`\. \*\)\n(.*\n)", right)
    assert first
    mine = right.replace(first[1], "  Wrong := 1;\n").replace("\n *)", "\n * Mine.\n *)", 1)
    file.write_text(mine, encoding="utf-8")
    assert signal_files()[path]() == right.replace("\n *)", "\n * Mine.\n *)", 1)


@pytest.mark.parametrize("taken", ["(* Each bit, generated", "(* End of the generated"])
def test_lines_without_a_begin_or_an_end_are_an_error_that_says_what_to_put_there(
    taken: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = _copy(tmp_path, monkeypatch, _FILES[0])
    text = file.read_text(encoding="utf-8").replace(taken, "(* Something")
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match="missing, repeated or in the wrong order") as raised:
        signal_files()[_FILES[0]]()
    assert "End of the generated lines" in str(raised.value.hint)


def test_a_mask_next_to_the_number_of_an_input_is_its_bit() -> None:
    """Source: manual chapter 5, 1: SI(00) to SI(07) are byte n + 32, SI(10) to SI(17) n + 33."""
    pattern = r"WORD#16#([0-9A-F]{4}); \(\* SI\((\d)(\d)\) \*\)"
    for file in LIBRARY:
        for mask, byte, bit in re.findall(pattern, file.read_text(encoding="utf-8")):
            assert int(mask, 16) == 1 << 8 * int(byte) + int(bit), file
