"""No arithmetic in the library overflows, except in the cases of wraps.toml."""

from __future__ import annotations

from pathlib import Path

import pytest

from proving import library, statuses
from rcx_tools.evidence.prove import overflow
from structured_text.errors import InputError

pytestmark = pytest.mark.exhaustive

(_OVERFLOW,) = overflow.PROPERTIES
_ROW = '[[wrap]]\nfile = "{}"\npou = "{}"\noperation = "{}"\nreason = "why"\n'


def _table(folder: Path, monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    table = folder / "wraps.toml"
    table.write_text(text, encoding="utf-8")
    monkeypatch.setattr(overflow, "WRAPS", table)


@pytest.mark.parametrize("name", ["FB_ReadWord", "FB_RcxChannelTurn", "FC_RcxTickets"])
def test_all_stays_in_its_type_but_what_is_meant_not_to(name: str, tmp_path: Path) -> None:
    assert statuses(_OVERFLOW, library(tmp_path, name), name.upper()) == {"proved"}


@pytest.mark.parametrize(
    ("bug", "name"),
    [
        ("turn-that-begins-again-after-24-days", "FB_RcxChannelTurn"),
        ("page-of-any-first-entry", "FB_EventLog"),
        ("margin-of-any-length", "FB_RcxMakeHead"),
    ],
)
def test_what_leaves_its_type_is_not_proved(bug: str, name: str, tmp_path: Path) -> None:
    broken = library(tmp_path, name, bug=bug, bugs="overflow")
    assert "refuted" in statuses(_OVERFLOW, broken, name.upper())


@pytest.mark.parametrize(
    "row",
    [
        _ROW.format("core/FC_RcxTickets.st", "FC_RcxTickets", "Last + First"),
        _ROW.format("core/FC_RcxWaited.st", "FC_RcxTickets", "Last - First"),
        _ROW.format("core/FC_RcxWaited.st", "FC_RcxWaited", "Before + UINT_TO_DINT(Elapsed)"),
    ],
)
def test_a_row_of_what_is_not_there_or_cannot_happen_is_refuted(
    row: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _table(tmp_path, monkeypatch, row)
    name = row.split('"')[3]
    copy = library(tmp_path / "lib", name)
    goals = list(_OVERFLOW.goals(copy, name.upper()))
    assert str(goals[-1].claim) == "False"
    assert goals[-1].name.endswith("leaves its type, as wraps.toml says")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('[[wrap]]\nfile = "a"\n', "wrap 1 has file"),
        (2 * _ROW.format("a", "FC_RcxTickets", "b"), "a second row for b of FC_RcxTickets"),
        (_ROW.format("a", "FC_Gone", "b"), "a row is about FC_Gone, which does not exist"),
    ],
)
def test_a_row_that_is_wrong_gets_one_message(
    text: str, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _table(tmp_path, monkeypatch, text)
    with pytest.raises(InputError, match=message):
        _OVERFLOW.parts(library(tmp_path / "lib", "FC_RcxTickets"))
