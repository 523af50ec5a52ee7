"""Pins change only with a new version: `python -m rcx_tools.docs.pins` checks this."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from plc_bench import ROOT
from rcx_tools.docs import pins
from rcx_tools.docs.blocks.source import kind_of
from rcx_tools.library.version import version

_BEFORE = {
    "FB_A": ["VAR_IN_OUT Robot : RCX_REF", "VAR_INPUT X : INT := 1", "VAR_INPUT Y : BOOL",
             "VAR_OUTPUT Done : BOOL"],
    "RCX_E": ["member E_ONE", "member E_TWO"],
}  # fmt: skip


def _after(name: str, *rows: str) -> dict[str, list[str]]:
    return {**_BEFORE, name: list(rows)}


@pytest.mark.parametrize(
    ("after", "found"),
    [
        ({**_BEFORE, "FB_B": ["VAR_INPUT Z : INT"]}, []),
        (_after("FB_A", *_BEFORE["FB_A"], "VAR_INPUT Z : INT := 3"), []),
        (_after("RCX_E", *_BEFORE["RCX_E"], "member E_THREE"), []),
        ({"RCX_E": _BEFORE["RCX_E"]}, ["FB_A: is not there any more"]),
        (_after("FB_A", *_BEFORE["FB_A"][:3]),
         ["FB_A: VAR_OUTPUT Done : BOOL: is not there any more"]),
        (_after("FB_A", _BEFORE["FB_A"][0], "VAR_INPUT X : INT := 2", *_BEFORE["FB_A"][2:]),
         ["FB_A: VAR_INPUT X : INT := 1: is now VAR_INPUT X : INT := 2"]),
        (_after("FB_A", _BEFORE["FB_A"][0], "VAR_INPUT X : DINT := 1", *_BEFORE["FB_A"][2:]),
         ["FB_A: VAR_INPUT X : INT := 1: is now VAR_INPUT X : DINT := 1"]),
        (_after("FB_A", *(_BEFORE["FB_A"][k] for k in (0, 2, 1, 3))),
         ["FB_A: X: is not at its place any more"]),
        (_after("FB_A", "VAR_IN_OUT Robot : RCX_REF", "VAR_INPUT New : INT",
                *_BEFORE["FB_A"][1:]), ["FB_A: X: is not at its place any more"]),
        (_after("FB_A", *_BEFORE["FB_A"], "VAR_IN_OUT Area : RCX_E"),
         ["FB_A: has a new VAR_IN_OUT, which every call must pass"]),
        (_after("RCX_E", "member E_TWO", "member E_ONE"),
         ["RCX_E: E_ONE: is not at its place any more"]),
    ],
)  # fmt: skip
def test_what_is_new_does_no_harm_what_has_changed_is_named(
    after: dict[str, list[str]], found: list[str]
) -> None:
    assert pins.changes(_BEFORE, after) == found


@pytest.mark.parametrize(
    ("before", "after", "may"),
    [
        *(("0.1.0", "0.1.1", False), ("0.1.0", "0.2.0", True), ("0.1.0", "1.0.0", True)),
        *(("0.9.0", "0.10.0", True), ("1.0.0", "1.1.0", False), ("1.2.3", "2.0.0", True)),
        ("0.2.0", "0.1.9", False),
    ],
)
def test_before_one_the_minor_number_counts_then_the_major_one(
    before: str, after: str, may: bool
) -> None:
    assert pins.is_major(before, after) is may


def test_no_pin_has_changed_since_the_last_release(capsys: pytest.CaptureFixture[str]) -> None:
    assert pins.main([]) == 0, capsys.readouterr().out


def test_a_changed_pin_is_one_clear_message(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    before = {**pins.now(), "FB_ServoOn": [*pins.now()["FB_ServoOn"], "VAR_INPUT Hard : BOOL"]}
    (tmp_path / f"{version()}.toml").write_text(pins.text(before, version()), encoding="utf-8")
    (tmp_path / "0.0.9.toml").write_text("", encoding="utf-8")
    released = pins.last(tmp_path)
    monkeypatch.setattr(pins, "last", lambda: released)
    assert pins.main([]) == 1
    first, said = capsys.readouterr().out.splitlines()
    assert first == "FB_ServoOn: VAR_INPUT Hard : BOOL: is not there any more"
    assert said.startswith(f"1 changes since {version()} that break users' programs: take them")
    monkeypatch.setattr(pins, "version", lambda: "99.0.0")
    assert pins.main([]) == 0


def test_what_is_written_is_read_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(pins, "FOLDER", tmp_path)
    monkeypatch.setattr(pins, "ROOT", tmp_path)
    assert pins.main(["--write"]) == 0
    assert capsys.readouterr().out == f"wrote {version()}.toml\n"
    assert pins.read(tmp_path / f"{version()}.toml") == pins.now()


def test_the_table_has_all_names_that_users_can_use() -> None:
    """The table has all names that users can use. The expected names were found by hand."""
    table = pins.now()
    assert table["FB_SequenceControl"] == [
        "VAR_IN_OUT Robot : RCX_REF",
        "VAR_INPUT Enable : BOOL",
        "VAR_INPUT Timeout : TIME := T#5s",
        *(f"VAR_OUTPUT {name} : BOOL" for name in ("Valid", "Busy", "Error")),
        "VAR_OUTPUT ErrorID : WORD",
    ]
    assert table["FC_SignalName"][0] == "result STRING"
    assert table["RCX_LANGUAGE"] == ["member LANGUAGE_ENGLISH", "member LANGUAGE_JAPANESE"]
    assert table["RCX_WORDS"] == ["1..15 OF WORD"]
    assert table["RCX_IMAGE"] == ["0..511 OF BYTE"]
    assert "field NextTicket : UDINT" in table["RCX_SHARED_AREA"]
    assert "FB_RcxJob" not in table


@pytest.mark.parametrize(
    ("text", "rows"),
    [
        ("  RCX_T : ARRAY [0..511] OF BYTE;\n", ["0..511 OF BYTE"]),
        ("  RCX_T : ARRAY [-2..4] OF RCX_MOVE;\n", ["-2..4 OF RCX_MOVE"]),
        (
            "  RCX_T : STRUCT\n"
            "    A : INT := 3;  (* one *)\n"
            "    B : STRING;\n"
            "    C : TIME := T#1s;\n"
            "  END_STRUCT;\n",
            ["field A : INT := 3", "field B : STRING", "field C : TIME := T#1s"],
        ),
    ],
)
def test_a_change_of_bounds_or_initial_values_is_detected(
    tmp_path: Path, text: str, rows: list[str]
) -> None:
    """A change of array bounds or of initial values of a type counts as a change for users."""
    file = tmp_path / "RCX_T.st"
    file.write_text(f"(*\n * RCX_T: a type.\n *)\nTYPE\n{text}END_TYPE\n", encoding="utf-8")
    now = pins.of_kind(kind_of(file))
    assert now == rows
    other = [re.sub(r"\d+", "7", row, count=1) for row in now]
    assert pins.changes({"RCX_T": now}, {"RCX_T": other})


def test_a_release_has_its_table() -> None:
    """Each released version has a table of pins. It is released if the changelog has its date."""
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    for number, day in re.findall(r"^## (\d+\.\d+\.\d+) \((.+)\)$", text, re.MULTILINE):
        if day != "unreleased":
            assert (pins.FOLDER / f"{number}.toml").is_file(), (
                "python -m rcx_tools.docs.pins --write"
            )
