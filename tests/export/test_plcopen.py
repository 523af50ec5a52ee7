"""`rcx export plcopen` writes valid TC6 XML 2.01. `rcx import` reads the same blocks from it."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

from exported import by_position, comments, imported, shapes, written
from plcopen_structure import check_structure
from rcx_harness.cell.exports import export
from structured_text.export.output import write
from structured_text.export.parts import Sources

_MINE = """\
(* everything that the library does without *)
TYPE
  MINE_PAIR : STRUCT
    a, b : INT := 3; (* "both" & < > *)
    c    : ARRAY [0..1, -1..1] OF REAL;
  END_STRUCT;
END_TYPE
TYPE
  MINE_FEW : ARRAY [1..4] OF INT := [1, 2(7), -3]; (* a_few *)
  (* an_alias *)
  MINE_ALIAS : DINT (* its_type *) := 16#7F; (* same_line *)
  MINE_COLOUR : (RED, GREEN) := GREEN; (* last_one *)
END_TYPE
FUNCTION_BLOCK FB_Mine
  VAR CONSTANT
    Most : INT := 5;
  END_VAR
  VAR RETAIN
    Kept  : MINE_PAIR := (a := 1, b := 2);
  END_VAR
  VAR_TEMP
    t1    : STRING := 'it$'s';
  END_VAR
  VAR_OUTPUT
    Seen  : INT;
  END_VAR
  VAR_EXTERNAL
    Shared : INT;
  END_VAR
  Shared := Most;
  Seen := Shared;
END_FUNCTION_BLOCK
PROGRAM Other
  VAR
    Q AT %QX0.0 : BOOL;
    It          : FB_Mine;
  END_VAR
  It();
  Q := It.Seen < 3 AND NOT Q;
END_PROGRAM
CONFIGURATION Mine
  RESOURCE Here ON PLC
    VAR_GLOBAL
      Shared : INT := 2;
    END_VAR
    TASK Slow(INTERVAL := T#100ms, PRIORITY := 3); (* a_task *)
    TASK Fast(INTERVAL := T#10ms, PRIORITY := 1);
    PROGRAM One WITH Slow : Other; (* an_instance *)
    PROGRAM Two WITH Fast : Other;
  END_RESOURCE
END_CONFIGURATION
"""


@pytest.fixture(scope="module")
def document(whole: bool, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the XML file of the exported sample."""
    (file,) = write(written("plcopen", whole=whole), tmp_path_factory.mktemp("xml") / "rcx3.xml")
    return file


@pytest.fixture(scope="module")
def back(document: Path) -> list[Path]:
    """Return the files that `rcx import` writes from the exported XML file."""
    return imported(document, document.parent / "back")


def test_the_import_has_the_same_blocks_and_comments(
    document: Path, back: list[Path], sources: Sources
) -> None:
    """The imported blocks have the same declarations and comments as the sources.

    Source: PLCopen, TC6 XML Formats for IEC 61131-3, version 2.01.
    """
    check_structure(ET.parse(document).getroot())
    original = list(dict.fromkeys(part.file for part in sources.parts))
    assert shapes(back) == by_position(shapes(original))
    assert set(comments(original)) <= set(comments(back))


def test_a_users_program_is_imported_completely(
    tmp_path: Path, schema: Callable[[Path], str] | None
) -> None:
    source, file = tmp_path / "Mine.st", tmp_path / "mine.xml"
    source.write_text(_MINE)
    write(export("plcopen", program=[source], only_needed=True), file)
    check_structure(ET.parse(file).getroot())
    back = imported(file, tmp_path / "back")
    assert shapes(back) == shapes([source])
    assert '"both" & < >' in (tmp_path / "back/MINE_PAIR.st").read_text()
    assert set(comments([source])) <= set(comments(back))
    assert schema is None or schema(file) == ""


@pytest.fixture(scope="module")
def schema() -> Callable[[Path], str] | None:
    """Return a function that checks a file with the official schema.

    Without a copy of the schema, return None.
    """
    place = os.environ.get("RCX_TC6_XSD")
    if place is None:
        return None
    from lxml import etree

    rules = etree.XMLSchema(etree.parse(place))

    def errors(file: Path) -> str:
        rules.validate(etree.parse(str(file)))
        return "\n".join(str(error) for error in rules.error_log)

    return errors


def test_the_official_schema_accepts_the_export(
    document: Path, schema: Callable[[Path], str] | None, tmp_path: Path
) -> None:
    """The schema accepts the export, and rejects files with mistakes.

    Source: PLCopen, TC6 XML Formats for IEC 61131-3, version 2.01.
    """
    if schema is None:
        pytest.skip("set RCX_TC6_XSD to a copy of tc6_xml_v201.xsd")
    assert schema(document) == ""
    wrong = tmp_path / "wrong.xml"
    for old, new in _BROKEN:
        wrong.write_text(re.sub(old, new, document.read_text(), count=1, flags=re.DOTALL))
        assert schema(wrong), old


_BROKEN = [(r' pouType="\w+"', ""), (r"<instances>(.*)</instances>", r"<instance>\1</instance>"),
           (r"<types>", "<types><pous />"), (r"<WORD />", "<WORDS />"), (r' priority="0"', ""),
           (r"(<baseType>.*?</baseType>)(\s*)(<documentation>.*?</documentation>)", r"\3\2\1"),
]  # fmt: skip
