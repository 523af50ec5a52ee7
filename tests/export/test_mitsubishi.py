"""The export for GX Works3 has all statements of the library, and tables with all variables."""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping
from pathlib import Path

import pytest

from exported import example_sources, left_out, written
from exported_dialect import declared, differing, untyped
from rcx_harness.cell.exports import export
from structured_text.export import TARGETS
from structured_text.export.parts import Sources
from structured_text.language import syntax as s
from structured_text.language.printer import init_text

#: Source: MELSEC Communication Protocol Reference Manual, label access, data type ID (page 132).
_TYPES = {
    *("Bit", "Word [Signed]", "Double Word [Signed]", "Word [Unsigned]/Bit String [16-bit]"),
    *("Double Word [Unsigned]/Bit String [32-bit]", "FLOAT [Single Precision]"),
    *("FLOAT [Double Precision]", "Time", "String(80)"),
}
#: Maps IEC 61131-3 types to their names in the label editor.
_CALLED = {"BOOL": "Bit", "INT": "Word [Signed]", "DINT": "Double Word [Signed]",
           "WORD": "Word [Unsigned]/Bit String [16-bit]",
           "UINT": "Word [Unsigned]/Bit String [16-bit]",
           "BYTE": "Word [Unsigned]/Bit String [16-bit]",
           "DWORD": "Double Word [Unsigned]/Bit String [32-bit]",
           "UDINT": "Double Word [Unsigned]/Bit String [32-bit]",
           "REAL": "FLOAT [Single Precision]", "TIME": "Time", "STRING": "String(80)",
           "RCX_WORDS": "Word [Unsigned]/Bit String [16-bit](1..15)",
           "RCX_IMAGE_WORDS": "Word [Unsigned]/Bit String [16-bit](0..255)",
           "RCX_LOG": "RCX_LOG_ENTRY(0..31)", "RCX_PHASE": "Word [Signed]",
           "RCX_REF": "RCX_REF"}  # fmt: skip
_WORDS = {"UINT": "WORD", "UDINT": "DWORD", "BYTE": "WORD"}
_RENAMED = {"m": "m_X", "n": "n_X", "k": "k_X"} | {
    name: f"{name}_X" for name in ("Out", "Read", "Stop", "Sum")
}
#: For each instance of R_TRIG in the library, the exported name of its pin CLK.
_EDGES = {
    f"{name}Edge": "_CLK"
    for name in (
        *("", "Called", "Command", "Done", "Mode", "New", "Next", "One", "Reset", "Start"),
    )
} | {"Falls": "_CLK", "Starts": "_CLK"}
_TITLES = ["Label Name", "Data Type", "Class", "Initial Value", "Constant", "Comment"]


@pytest.fixture(scope="module")
def files(whole: bool) -> Mapping[str, str]:
    """Return the path and the text of each exported file."""
    return written("mitsubishi", whole=whole).files


def _rows(text: str) -> dict[str, list[str]]:
    titles, *lines = csv.reader(text.splitlines())
    assert titles == _TITLES
    return {line[0]: line[1:] for line in lines}


def test_statements_come_back_from_mitsubishi(sources: Sources, files: Mapping[str, str]) -> None:
    assert differing(sources, files, _WORDS, _RENAMED, pins=_EDGES) == []


@pytest.mark.parametrize("name", ["03_general_io", "06_teach_points"])
def test_statements_of_an_example_come_back_from_mitsubishi(name: str) -> None:
    sources = example_sources(name)
    files = TARGETS["mitsubishi"].write(sources).files
    assert differing(sources, files, _WORDS, _RENAMED, pins=_EDGES) == []


def test_a_byte_is_a_word_whose_upper_half_is_zero(files: Mapping[str, str]) -> None:
    """A BYTE is exported as a WORD. After NOT and SHL its upper 8 bits are cleared.

    Source: IEC 61131-3, 2.3.1: a BYTE has 8 bits.
    """
    assert "SHL(WORD#16#01, Digit) AND WORD#16#00FF" in files["core/FC_RcxBitMask.st"]
    assert "Rest := (NOT Mask AND WORD#16#00FF);" in files["core/FC_RcxByteWithBit.st"]
    assert "(SHR(Value, 8) AND WORD#16#00FF);" in files["core/FC_RcxByteOfWord.st"]
    assert "((Value AND WORD#16#00FF) AND WORD#16#00FF);" in files["core/FC_RcxByteOfWord.st"]
    assert "OR SHL(Part, 8);" in files["core/FC_RcxByteIntoWord.st"]
    assert "FC_RcxWord := SHL(HighByte, 8) OR LowByte;" in files["core/FC_RcxWord.st"]


def test_variables_of_functions_are_initialised_at_each_call(files: Mapping[str, str]) -> None:
    """Statements initialise the variables of a function at each call.

    Source: IEC 61131-3, 2.5.1.1.
    """
    begin = files["core/FC_RcxCharCode.st"].partition(" *)\n")[2].splitlines()[:3]
    assert begin == ["  FC_RcxCharCode := WORD#16#0;", "  Place := 0;", "  Letter := '';"]
    block = files["area/FB_ReadAreaWords.st"].partition(" *)\n")[2]
    assert block.startswith("  ErrorID := FC_RcxAreaError("), "a block keeps its variables"


def test_every_variable_is_in_its_table_with_class_type_default_and_comment(
    sources: Sources, files: Mapping[str, str], whole: bool
) -> None:
    seen = 0
    for part in sources.of("TYPE", "FUNCTION", "FUNCTION_BLOCK"):
        path = f"{part.folder}/{part.name}.csv"
        if path not in files:
            continue
        rows = _rows(files[path])
        for name, section, one, note in declared(part):
            kind, place, initial, constant, said = rows.pop(_RENAMED.get(name, name))
            wanted = {"VAR CONSTANT": "VAR_CONSTANT", "FIELD": "", "VAR_TEMP": "VAR"}
            assert (place, said) == (wanted.get(section, section), note), (part.name, name)
            default = "" if one.initial is None else untyped(init_text(one.initial))
            if not isinstance(one.initial, s.Name):  # not the default of an enumeration
                assert initial + constant == default, (part.name, name)
            assert isinstance(one.spec, s.NamedSpec)
            if one.spec.name.text in _CALLED:
                assert kind == _CALLED[one.spec.name.text], (part.name, name)
            seen += 1
        assert rows == {}, part.name
    assert seen > (2000 if whole else 200)


def test_types_are_those_of_the_tool_or_made_in_the_folder(files: Mapping[str, str]) -> None:
    """Each type in the tables is a type of GX Works3 or is exported.

    Source: MELSEC Communication Protocol Reference Manual, data type ID.
    """
    made = {Path(path).stem for path in files if path.endswith(".csv")} | {"TON", "R_TRIG"}
    for path, text in files.items():
        for name, row in _rows(text).items() if path.endswith(".csv") else ():
            kind = re.sub(r"\(\d+\.\.\d+\)$", "", row[0])
            assert kind in _TYPES | made, (path, name)


def test_label_names_have_at_most_32_characters_and_are_no_devices(
    files: Mapping[str, str],
) -> None:
    """Label names have at most 32 characters, and are not names of devices.

    Source: Mitsubishi, character strings that cannot be used in label names (appendix 2).
    """
    for path, text in files.items():
        for name in _rows(text) if path.endswith(".csv") else ():
            assert len(name) <= 32, path
            assert not re.fullmatch(r"[XYMDBWKHNTC]\d*|OUT|SET|RST", name.upper()), (path, name)


def test_enumerations_are_numbers_with_their_names(files: Mapping[str, str]) -> None:
    listed = "RCX_SPEED_MODE: 0 SPEED_PROGRAM, 1 SPEED_DIRECT, 2 SPEED_PERCENT"
    assert listed in files["types/enumerations.txt"]
    assert "        1 (* SPEED_DIRECT *): Data[1] :=" in files["command/movement/FB_MovePtp.st"]
    row = _rows(files["command/movement/FB_MovePtp.csv"])["SpeedMode"]
    assert row == ["Word [Signed]", "VAR_INPUT", "0", "", "unit of Speed"]


def test_a_part_that_is_not_carried_is_named(tmp_path: Path) -> None:
    """LINT, the blocks that need it, and located variables are reported as left out."""
    program = tmp_path / "Own.st"
    program.write_text(
        "FUNCTION_BLOCK FB_Count\n  VAR_OUTPUT\n    Total : LINT;\n  END_VAR\n"
        "  Total := Total + LINT#1;\nEND_FUNCTION_BLOCK\n"
        "FUNCTION_BLOCK FB_Above\n  VAR\n    Count : FB_Count;\n  END_VAR\n"
        "  Count();\nEND_FUNCTION_BLOCK\n"
        "PROGRAM Located\n  VAR\n    Q AT %QX0.0 : BOOL;\n  END_VAR\n  Q := TRUE;\nEND_PROGRAM\n"
        "FUNCTION_BLOCK FB_Carried\n  VAR\n    X1 : BOOL;\n    Set : BOOL;\n  END_VAR\n"
        "  X1 := NOT Set;\nEND_FUNCTION_BLOCK\n"
    )
    output = export("mitsubishi", program=[program], only_needed=True)
    assert sorted(left_out(output)) == [
        "FUNCTION_BLOCK FB_Above: needs FB_Count, which cannot be exported",
        "FUNCTION_BLOCK FB_Count: GX Works3 has no LINT",
        "PROGRAM Located: has global or located variables (Q); declare it again in the tool",
    ]
    assert output.files["program/FB_Carried.st"].endswith("  X1_X := NOT Set_X;\n")
    assert list(_rows(output.files["program/FB_Carried.csv"])) == ["X1_X", "Set_X"]
