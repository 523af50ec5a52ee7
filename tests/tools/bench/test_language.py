"""The share of files of a library: counted by file, with the reason of each refusal."""

from __future__ import annotations

from pathlib import Path

import pytest

from rcx_harness.errors import InputError
from rcx_tools.bench.figure import Options
from rcx_tools.bench.language import accepted, measure

_GOOD = "FUNCTION_BLOCK {0}\nVAR A : INT; END_VAR\nA := A + 1; // counts\nEND_FUNCTION_BLOCK\n"
_BAD = "FUNCTION_BLOCK {0}\nVAR A : INT; END_VAR\nA := TRUE;\nA := FALSE;\nEND_FUNCTION_BLOCK\n"


def _library(folder: Path) -> Path:
    folder.mkdir()
    for name in ("FB_A", "FB_B", "FB_C"):
        (folder / f"{name}.st").write_text(_GOOD.format(name))
    (folder / "FB_D.st").write_text(_BAD.format("FB_D"))
    return folder


def test_the_share_counts_files_and_the_reasons_errors(tmp_path: Path) -> None:
    share = accepted(sorted(_library(tmp_path / "lib").glob("*.st")))
    assert (share.files, len(share.refused), share.percent) == (4, 1, 75.0)
    assert [times for _, times in share.reasons] == [2]


def test_a_library_below_the_target_misses_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RCX_LIBRARIES", str(_library(tmp_path / "lib")))
    figure = measure(Options())["language lib"]
    assert (figure.value, figure.target, figure.met) == (75.0, ">= 95", False)


def test_without_libraries_it_says_how_to_name_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("RCX_LIBRARIES", raising=False)
    with pytest.raises(InputError, match="RCX_LIBRARIES"):
        measure(Options())
