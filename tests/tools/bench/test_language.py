"""The accepted files of a library are counted, with the reason of each refused file."""

from __future__ import annotations

from pathlib import Path

import pytest

from rcx_tools.bench.agreement import candidates, compared
from rcx_tools.bench.figure import Options
from rcx_tools.bench.language import accepted, measure, sources_of
from structured_text.engines.matiec.build import find_matiec
from structured_text.engines.native.toolchain import find_c_compiler
from structured_text.errors import InputError

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
    figure = measure(Options(quick=True))["language lib"]
    assert (figure.value, figure.target, figure.met) == (75.0, ">= 95", False)


def test_without_libraries_it_says_how_to_name_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("RCX_LIBRARIES", raising=False)
    monkeypatch.delenv("RCX_REPOSITORIES", raising=False)
    monkeypatch.setattr("rcx_tools.bench.language.find_matiec", lambda: None)
    with pytest.raises(InputError, match="RCX_LIBRARIES"):
        measure(Options())


def test_a_declaration_of_a_project_counts_as_a_file(tmp_path: Path) -> None:
    file = tmp_path / "blocks.scl"
    body = "BEGIN\n  #A := {};\nEND_FUNCTION_BLOCK\n"
    head = 'FUNCTION_BLOCK "{}"\nVAR A : Int; END_VAR\n'
    file.write_text(head.format("B1") + body.format("1") + head.format("B2") + body.format("TRUE"))
    share = accepted(sources_of(file))
    assert (share.files, len(share.refused)) == (2, 1)


_FUNCTIONS = (
    "FUNCTION Half : INT\nVAR_INPUT A : INT; END_VAR\nHalf := A / 2;\nEND_FUNCTION\n",
    "FUNCTION_BLOCK Count\nVAR_INPUT Go : BOOL; END_VAR\nVAR_OUTPUT N : INT; END_VAR\n"
    "IF Go THEN N := N + 1; END_IF;\nEND_FUNCTION_BLOCK\n",
    # With more than one character the two engines differ (docs/reference/language.md).
    "FUNCTION Place : INT\nVAR_INPUT A : INT; END_VAR\nPlace := FIND('aab', 'ab');\nEND_FUNCTION\n",
    "FUNCTION Loose : INT\nVAR_INPUT A : INT; END_VAR\nLoose := A; // ours\nEND_FUNCTION\n",
    "FUNCTION Uses : INT\nVAR_INPUT A : INT; END_VAR\nUses := Loose(A);\nEND_FUNCTION\n",
)


def _functions(folder: Path) -> list[Path]:
    files = [folder / f"F{number}.st" for number in range(len(_FUNCTIONS))]
    for file, text in zip(files, _FUNCTIONS, strict=True):
        file.write_text(text)
    return files


def test_what_uses_the_language_of_the_field_is_not_compared(tmp_path: Path) -> None:
    names = [one.pou.name for one in candidates(_functions(tmp_path))]
    assert sorted(names) == ["Count", "Half", "Place"]


def test_calls_are_compared_and_a_difference_is_named(tmp_path: Path) -> None:
    matiec, compiler = find_matiec(), find_c_compiler()
    if matiec is None or compiler is None:
        pytest.skip("matiec or a C compiler is not found")
    found = compared([_functions(tmp_path)], matiec, compiler, 60)
    assert found.pous == 3
    assert 41 <= found.calls <= 63
    (text,) = found.differences
    assert text.startswith("Place: 2 here")
