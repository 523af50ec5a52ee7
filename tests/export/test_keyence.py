"""The export for KEYENCE has all statements of the library, and tables with all variables."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

import pytest

from exported import example_sources, written
from exported_dialect import declared, differing, untyped
from structured_text.export import TARGETS
from structured_text.export.parts import Sources
from structured_text.language import syntax as s
from structured_text.language.printer import init_text

#: Types that occur in a public project of KV STUDIO 12 (KV-X520); see docs/how-to/export.md.
_TYPES = {*("BOOL", "INT", "DINT", "UINT", "UDINT", "REAL", "LREAL", "TIME", "STRING[80]")}
#: Maps IEC 61131-3 types to their names in the tables.
_CALLED = {**{one: one for one in ("BOOL", "INT", "DINT", "UINT", "UDINT", "REAL", "TIME",
                                   "RCX_REF")}, "WORD": "UINT", "BYTE": "UINT", "DWORD": "UDINT",
           "STRING": "STRING[80]", "RCX_WORDS": "ARRAY[1..15] OF UINT",
           "RCX_LOG": "ARRAY[0..31] OF RCX_LOG_ENTRY", "RCX_PHASE": "INT"}  # fmt: skip
_WORDS = {"WORD": "UINT", "DWORD": "UDINT", "BYTE": "UINT"}
_RENAMED = {"m": "m_X"}
_KINDS = {"VAR_INPUT": "IN", "VAR_OUTPUT": "OUT", "VAR_IN_OUT": "IN-OUT"}


@pytest.fixture(scope="module")
def files(whole: bool) -> Mapping[str, str]:
    """Return the path and the text of each exported file."""
    return written("keyence", whole=whole).files


def _rows(files: Mapping[str, str], path: str) -> dict[str, list[str]]:
    """Read the tables of a block or structure: name to direction, type, default and comment."""
    found = {}
    for line in files.get(f"{path}.arguments.txt", "").splitlines():
        name, *row = line.split("\t")
        found[name] = row
    for line in files.get(f"{path}.locals.txt", "").splitlines():
        name, *row = line.split("\t")
        found[name] = ["VAR", *row]
    for line in files.get(f"{path}.structure.txt", "").splitlines():
        name, kind, note = line.split("\t")
        found[name] = ["FIELD", kind, "", note]
    return found


def test_statements_come_back_from_keyence(sources: Sources, files: Mapping[str, str]) -> None:
    assert differing(sources, files, _WORDS, _RENAMED, pins={}) == []


@pytest.mark.parametrize("name", ["03_general_io", "06_teach_points"])
def test_statements_of_an_example_come_back_from_keyence(name: str) -> None:
    sources = example_sources(name)
    files = TARGETS["keyence"].write(sources).files
    assert differing(sources, files, _WORDS, _RENAMED, pins={}) == []


def test_every_variable_is_in_its_table_with_direction_type_default_and_comment(
    sources: Sources, files: Mapping[str, str], whole: bool
) -> None:
    seen = 0
    for part in sources.of("TYPE", "FUNCTION", "FUNCTION_BLOCK"):
        rows = _rows(files, f"{part.folder}/{part.name}")
        for name, section, one, note in declared(part) if rows else ():
            place, kind, initial, said = rows.pop(_RENAMED.get(name, name))
            wanted = "FIELD" if section == "FIELD" else _KINDS.get(section, "VAR")
            assert (place, said) == (wanted, note), (part.name, name)
            if not isinstance(one.initial, s.Name):  # not the default of an enumeration
                default = "" if one.initial is None else untyped(init_text(one.initial))
                assert initial == default, (part.name, name)
            assert isinstance(one.spec, s.NamedSpec)
            assert kind == _CALLED.get(one.spec.name.text, kind), (part.name, name)
            seen += 1
        assert rows == {}, part.name
    assert seen > (2000 if whole else 200)


def test_types_are_those_of_the_tool_or_made_in_the_folder(files: Mapping[str, str]) -> None:
    """Each type in the tables is a type of KV STUDIO or is exported.

    Source: export.md, `keyence`.
    """
    made = {Path(path).stem.split(".")[0] for path in files} | {"TON", "R_TRIG"}
    for path in {path.rpartition("/")[0] + "/" + Path(path).stem.split(".")[0] for path in files}:
        for name, row in _rows(files, path).items() if path != "types/enumerations" else ():
            kind = re.sub(r"^ARRAY\[\d+\.\.\d+\] OF ", "", row[1])
            assert kind in _TYPES | made, (path, name)


def test_words_are_uint_and_device_names_are_changed(files: Mapping[str, str]) -> None:
    """WORD becomes UINT, and names of devices such as m are changed.

    Source: export.md, `keyence`.
    """
    assert "SHL(UINT#16#01, Digit) AND UINT#16#00FF" in files["core/FC_RcxBitMask.st"]
    assert "Rest := (NOT Mask AND UINT#16#00FF);" in files["core/FC_RcxByteWithBit.st"]
    assert "(SHR(Value, 8) AND UINT#16#00FF);" in files["core/FC_RcxByteOfWord.st"]
    assert "Start := m_X / 2;" in files["area/FB_ReadAreaWords.st"]
    assert (
        "m_X\tIN\tINT\t0\tfirst byte of the area in Image, even\n"
        in (files["area/FB_ReadAreaWords.arguments.txt"])
    )
