"""`rcx export plcopen`: valid TC6 XML 2.01 that comes back as the same blocks."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path

import pytest

from example_runs import EXAMPLES
from exported import EXPORTED, by_position, comments, recorded, shapes, trace_of
from plc_bench import ROOT
from plcopen_reader import read_plcopen
from rcx_harness.cell.exports import export
from rcx_harness.cli.app import main
from rcx_tools.docs.examples import Example
from structured_text.errors import InputError
from structured_text.export.output import write

LIB = sorted((ROOT / "plc/lib").rglob("*.st"))
CELL = sorted(EXAMPLES[0].folder.glob("*.st"))

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
def document(needed: bool, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The library and the first example in one project."""
    output = export("plcopen", program=[EXAMPLES[0].folder], only_needed=needed)
    (file,) = write(output, tmp_path_factory.mktemp("plcopen") / "rcx3.xml")
    return file


@pytest.fixture(scope="module")
def back(document: Path) -> list[Path]:
    """The files that the reader makes of it."""
    return write(read_plcopen(document), document.parent / "back")


def test_read_back_it_declares_the_same_blocks(back: list[Path], original: list[Path]) -> None:
    assert shapes(back) == by_position(shapes(original))


def test_no_comment_is_lost(back: list[Path], original: list[Path]) -> None:
    lost = set(comments(original)) - set(comments(back))
    assert not lost


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('value="T#5s"', 'value="T#6s"'),
        ('name="Execute"', 'name="Start"'),
        ("<WORD />", "<DWORD />"),
        ("Robot.SO.SO03_Alarm", "Robot.SO.SO04_MpRdy"),
        ("inputVars", "outputVars"),
        ('interval="T#10ms"', 'interval="T#20ms"'),
        ('<value name="STAGE_FAULT" />', '<value name="STAGE_TROUBLE" />'),
    ],
)
def test_a_wrong_element_would_be_seen(
    document: Path, back: list[Path], tmp_path: Path, old: str, new: str
) -> None:
    text = document.read_text()
    assert old in text
    wrong = tmp_path / "wrong.xml"
    wrong.write_text(text.replace(old, new))
    assert read_plcopen(wrong).files != {file.name: file.read_text() for file in back}


@pytest.mark.exhaustive(but=["01_power_up", "03_general_io", "06_teach_points"])
@pytest.mark.parametrize("example", EXPORTED, ids=lambda example: example.folder.name)
def test_an_example_read_back_has_the_same_trace(example: Example, tmp_path: Path) -> None:
    file = tmp_path / "one.xml"
    options = ["--needed", "--program", str(example.folder), "-o", str(file)]
    assert main(["export", "plcopen", *options]) == 0
    program = write(read_plcopen(file), tmp_path / "back")
    assert trace_of(example, program, tmp_path) == recorded(example)


def test_what_a_users_program_may_have_besides_comes_back_too(
    tmp_path: Path, schema: Callable[[Path], str] | None
) -> None:
    source, file = tmp_path / "Mine.st", tmp_path / "mine.xml"
    source.write_text(_MINE)
    write(export("plcopen", program=[source], only_needed=True), file)
    back = write(read_plcopen(file), tmp_path / "back")
    assert shapes(back) == shapes([source])
    assert '"both" & < >' in (tmp_path / "back/MINE_PAIR.st").read_text()
    assert set(comments([source])) <= set(comments(back))
    assert schema is None or schema(file) == ""


@pytest.fixture(scope="module")
def schema() -> Callable[[Path], str] | None:
    """What the official schema has against a file; None where there is no copy of it."""
    place = os.environ.get("RCX_TC6_XSD")
    if place is None:
        return None
    from lxml import etree

    rules = etree.XMLSchema(etree.parse(place))

    def errors(file: Path) -> str:
        rules.validate(etree.parse(str(file)))
        return "\n".join(str(error) for error in rules.error_log)

    return errors


def test_the_official_schema_accepts_it(
    document: Path, schema: Callable[[Path], str] | None, tmp_path: Path
) -> None:
    """Source: PLCopen, TC6 XML Formats for IEC 61131-3, version 2.01."""
    if schema is None:
        pytest.skip("set RCX_TC6_XSD to a copy of tc6_xml_v201.xsd")
    assert schema(document) == ""
    wrong = tmp_path / "wrong.xml"
    for old, new in _BROKEN:
        wrong.write_text(re.sub(old, new, document.read_text(), count=1, flags=re.DOTALL))
        assert schema(wrong), old


_BROKEN = [
    (r' pouType="\w+"', ""),
    (r"<instances>(.*)</instances>", r"<instance>\1</instance>"),
    (r"<types>", "<types><pous />"),
    (r"<WORD />", "<WORDS />"),
    (r' priority="0"', ""),
    (r"(<baseType>.*?</baseType>)(\s*)(<documentation>.*?</documentation>)", r"\3\2\1"),
]


_LADDER = (r"<body>", "<body><LD /></body><body>")


@pytest.mark.parametrize(("old", "new"), [*_BROKEN, _LADDER])
def test_the_reader_refuses_what_is_not_as_the_schema_says(
    document: Path, tmp_path: Path, old: str, new: str
) -> None:
    text = re.sub(old, new, document.read_text(), count=1, flags=re.DOTALL)
    assert text != document.read_text()
    wrong = tmp_path / "wrong.xml"
    wrong.write_text(text)
    with pytest.raises(InputError, match=r"wrong\.xml: /project"):
        read_plcopen(wrong)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<project>", "not well-formed XML"),
        ("<project />", "is not a project of PLCopen TC6 XML 2.01"),
        ('<project xmlns="http://www.plcopen.org/xml/tc6_0200" />', "is not a project of PLCopen"),
    ],
)
def test_another_file_is_refused(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "other.xml"
    file.write_text(text)
    with pytest.raises(InputError, match=message):
        read_plcopen(file)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        read_plcopen(tmp_path / "none.xml")


def test_it_is_the_same_every_time(document: Path, needed: bool) -> None:
    again = export("plcopen", program=[EXAMPLES[0].folder], only_needed=needed)
    assert again.files[""] == document.read_text(encoding="utf-8")
