"""Refused files are classified: a gap of the front end, a missing library, or another reason."""

from __future__ import annotations

from pathlib import Path

import pytest

from rcx_tools.bench import language
from rcx_tools.bench.figure import Options
from rcx_tools.bench.language import Result, measure, result
from rcx_tools.bench.refusals import Kind, Reviewed
from rcx_tools.bench.repositories import REPOSITORIES, Repository
from structured_text.errors import InputError

_GOOD = "FUNCTION_BLOCK {0}\nVAR A : INT; END_VAR\nA := A + 1;\nEND_FUNCTION_BLOCK\n"
#: A declared reference of a SIMATIC AX project.
_APAX = 'name: "@x/y"\ndependencies:\n  "@ax/system-timer": ^1.0.0\n'


def _repository(root: Path, sources: dict[str, str], apax: str = "") -> Repository:
    folder = root / "owner+lib" / "src"
    folder.mkdir(parents=True)
    for name, text in sources.items():
        (folder / f"{name}.st").write_text(text)
    if apax:
        (folder.parent / "apax.yml").write_text(apax)
    return Repository("owner/lib", "0", "SIMATIC AX", together=("src",))


def _kinds(found: Result) -> dict[str, Kind]:
    return {file.stem: kind for file, kind in found.refusals.files.items()}


def test_an_unknown_name_is_a_missing_library_only_with_a_declared_reference(
    tmp_path: Path,
) -> None:
    uses = "FUNCTION_BLOCK FB_B\nVAR T : OnDelay; END_VAR\nT();\nEND_FUNCTION_BLOCK\n"
    sources = {"FB_A": _GOOD.format("FB_A"), "FB_B": uses}
    with_reference = result(_repository(tmp_path / "a", sources, _APAX), tmp_path / "a")
    assert _kinds(with_reference) == {"FB_B": Kind.MISSING}
    without = result(_repository(tmp_path / "b", sources), tmp_path / "b")
    assert _kinds(without) == {"FB_B": Kind.OTHER}


@pytest.mark.parametrize(
    "body",
    [
        "VAR A : INT; END_VAR\nA := TRUE;",  # no name is unknown
        "VAR A : INT; END_VAR\nA := TO_INT(X := 1);",
        "VAR A : ARRAY [1..N] OF INT; N : INT; END_VAR\n;",  # a variable, not a constant
        "VAR A : INT; END_VAR\n__DELETE(A);",  # a keyword of the language
    ],
)
def test_everything_else_is_a_gap_also_beside_a_reference(body: str, tmp_path: Path) -> None:
    source = f"FUNCTION_BLOCK FB_B\n{body}\nEND_FUNCTION_BLOCK\n"
    found = result(_repository(tmp_path, {"FB_B": source}, _APAX), tmp_path)
    assert _kinds(found) == {"FB_B": Kind.GAP}
    assert found.percent(Kind.GAP) == 100.0


def test_a_constant_that_nobody_declares_is_an_unknown_name(tmp_path: Path) -> None:
    source = "FUNCTION_BLOCK FB_B\nVAR S : STRING(LENGTH); END_VAR\n;\nEND_FUNCTION_BLOCK\n"
    found = result(_repository(tmp_path, {"FB_B": source}, _APAX), tmp_path)
    assert _kinds(found) == {"FB_B": Kind.MISSING}


def test_a_file_with_a_gap_and_a_missing_library_counts_as_a_gap(tmp_path: Path) -> None:
    source = (
        "FUNCTION_BLOCK FB_B\nVAR T : OnDelay; A : INT; END_VAR\nA := TRUE;\nEND_FUNCTION_BLOCK"
    )
    found = result(_repository(tmp_path, {"FB_B": source}, _APAX), tmp_path)
    assert _kinds(found) == {"FB_B": Kind.GAP}


def test_an_error_that_follows_from_another_declaration_is_classified(tmp_path: Path) -> None:
    """An error that only follows from a refused declaration is classified separately.

    FB_C and FB_E use blocks that are refused, and have no errors themselves.
    """
    sources = {
        "FB_B": "FUNCTION_BLOCK FB_B\nVAR_INPUT A : OnDelay; END_VAR\n;\nEND_FUNCTION_BLOCK\n",
        "FB_C": "FUNCTION_BLOCK FB_C\nVAR B : FB_B; END_VAR\nB(A := 1);\nEND_FUNCTION_BLOCK\n",
        "FB_D": "FUNCTION_BLOCK FB_D\nVAR_INPUT A : INT := TRUE; END_VAR\n;\nEND_FUNCTION_BLOCK\n",
        "FB_E": "FUNCTION_BLOCK FB_E\nVAR D : FB_D; END_VAR\nD(A := 1);\nEND_FUNCTION_BLOCK\n",
    }
    found = result(_repository(tmp_path, sources, _APAX), tmp_path)
    assert _kinds(found) == {
        "FB_B": Kind.MISSING,
        "FB_C": Kind.MISSING,
        "FB_D": Kind.GAP,
        "FB_E": Kind.GAP,
    }


def test_a_reviewed_refusal_is_right(tmp_path: Path) -> None:
    source = "FUNCTION_BLOCK FB_B\nVAR A : INT; END_VAR\nA := TRUE;\nEND_FUNCTION_BLOCK\n"
    plain = _repository(tmp_path, {"FB_B": source})
    reviewed = Repository(
        plain.name,
        plain.commit,
        plain.tool,
        plain.together,
        reviewed=(Reviewed(r"FB_B\.st:3.*a INT is expected", "it is a mistake"),),
    )
    assert _kinds(result(reviewed, tmp_path)) == {"FB_B": Kind.OTHER}


def test_every_file_with_an_error_is_counted(tmp_path: Path) -> None:
    """Every file with an error counts as refused, although the number of messages is limited."""
    body = "".join("A := TRUE;\n" for _ in range(300))
    text = f"FUNCTION_BLOCK {{0}}\nVAR A : INT; END_VAR\n{body}END_FUNCTION_BLOCK\n"
    sources = {f"FB_{number}": text.format(f"FB_{number}") for number in range(4)}
    found = result(_repository(tmp_path, sources), tmp_path)
    assert len(found.refusals.files) == 4


def test_the_table_has_a_row_for_each_repository(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    repository = _repository(tmp_path, {"FB_A": _GOOD.format("FB_A")})
    monkeypatch.setattr(language, "REPOSITORIES", (repository, REPOSITORIES[0]))
    monkeypatch.setenv("RCX_REPOSITORIES", str(tmp_path))
    monkeypatch.delenv("RCX_LIBRARIES", raising=False)
    figure = measure(Options(quick=True))["language owner/lib"]
    assert (figure.value, figure.target, figure.met) == (0.0, "<= 2", True)
    shown = capsys.readouterr().out
    assert "owner/lib: 1 of 1 files, gap 0, missing library 0, other 0" in shown
    assert f"{REPOSITORIES[0].name}: not in " in shown


def test_a_checkout_of_another_commit_is_refused(tmp_path: Path) -> None:
    repository = _repository(tmp_path, {})
    other = Repository(repository.name, "abc", repository.tool, together=("lib/*.plcproj",))
    with pytest.raises(InputError, match="check out abc"):
        result(other, tmp_path)


def test_the_repositories_are_at_least_twelve_of_five_tools() -> None:
    assert len(REPOSITORIES) >= 12
    assert len({one.tool for one in REPOSITORIES}) >= 5
    assert len({one.name for one in REPOSITORIES}) == len(REPOSITORIES)
