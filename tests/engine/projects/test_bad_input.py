"""If a project file cannot be read, one message names file and line, and the exit code is 2."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from mistakes import check
from rcx_harness.cli.app import main
from structured_text.language.source import source_text
from structured_text.projects.open import project_sources

_DATA = Path(__file__).parent / "data"
_HEAD = '<?xml version="1.0"?>\n'
_L5X = f"{_HEAD}<RSLogix5000Content><Controller>\n%s</Controller></RSLogix5000Content>"
_PROGRAM = """\
<Programs><Program Name="P" MainRoutineName="M"><Tags>
<Tag Name="a" DataType="DINT"/></Tags><Routines><Routine Name="M" Type="ST"><STContent>
<Line Number="0"><![CDATA[%s]]></Line>
</STContent></Routine></Routines></Program></Programs>
"""
_PROTECTED = """\
<AddOnInstructionDefinitions>
<EncodedData EncodedType="AddOnInstructionDefinition" Name="Secret" EncryptionConfig="8"/>
</AddOnInstructionDefinitions>
"""
_BOMB = """\
<!DOCTYPE p [<!ENTITY a "aaaaaaaaaa">
<!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>
<project>&b;</project>"""
_POU = """\
<TcPlcObject><POU Name="P"><Declaration><![CDATA[%s]]></Declaration>
<Implementation>%s</Implementation></POU></TcPlcObject>"""


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.xml", "", "a.xml:1:1: is not well-formed XML: no element found"),
        ("a.xml", f"{_HEAD}<project>\n<types>", "a.xml:3:8: is not well-formed XML: no element"),
        ("a.xml", "PROGRAM P\nEND_PROGRAM\n", "a.xml:1:1: is not well-formed XML: syntax error"),
        ("a.xml", _BOMB, "a.xml:1: a document type (DOCTYPE) is not read"),
        (
            "a.xml",
            '<!DOCTYPE p [<!ENTITY x SYSTEM "file:///etc/passwd">]><project>&x;</project>',
            "a.xml:1: a document type (DOCTYPE) is not read",
        ),
        ("a.xml", "<a>" * 201 + "</a>" * 201, "more than 200 nested elements"),
        ("a.xml", "<html></html>", "neither a PLCopen XML project nor an L5X, its root is <html>"),
        ("a.xml", "<project></project>", "a.xml: has no POU and no type"),
        (
            "a.xml",
            f'{_HEAD}<project>\n<pou name="P" pouType="program"><body><CFC/></body></pou>'
            "</project>",
            "a.xml:3: the body of P is in Continuous Function Chart (CFC) and is not read; "
            "write it in Structured Text: --replace P=file.st",
        ),
        (
            "a.xml",
            f'{_HEAD}<project>\n<pou pouType="program"/></project>',
            "a.xml:3: <pou> has no name",
        ),
        (
            "a.xml",
            f'{_HEAD}<project><pou name="P" pouType="program"/>\n<task name="T" interval="never">'
            '<pouInstance name="P"/></task></project>',
            "a.xml:3: the task T has the interval 'never'",
        ),
        ("a.TcPOU", "<TcPlcObject/>", "a.TcPOU: has no POU, DUT, GVL or Itf, only nothing"),
        ("a.TcPOU", "<Other/>", "is not an object of TwinCAT, its root is <Other>"),
        ("a.TcPOU", _POU % ("", "<ST/>"), "a.TcPOU:1: P has no declaration"),
        ("a.TcPOU", _POU % ("VAR END_VAR", "<ST/>"), "does not begin with PROGRAM, FUNCTION"),
        (
            "a.TcPOU",
            _POU % ("PROGRAM P", "<SFC/>"),
            "a.TcPOU:2: the body of P is in Sequential Function Chart (SFC)",
        ),
        (
            "a.plcproj",
            '<Project><ItemGroup>\n<Compile Include="A\\B.TcPOU"/></ItemGroup></Project>',
            "a.plcproj:2: names A\\B.TcPOU, which does not exist; copy the whole folder",
        ),
        ("a.plcproj", "<Project/>", "a.plcproj: names no POU, type or list of variables"),
        ("a.L5X", _L5X % "", "a.L5X: has no data type, instruction or program"),
        (
            "a.L5X",
            _L5X % (_PROTECTED + _PROGRAM % "Secret(a);"),
            "a.L5X:8: the body of P is not read: the source of Secret is protected",
        ),
        (
            "a.L5X",
            _L5X % (_PROGRAM % "a [:=] ;"),
            "a.L5X:5: the body of P is not read: a value is expected, not ';'",
        ),
        (
            "a.L5X",
            _L5X % (_PROGRAM % "a := Local:1:I.Data;"),
            "a.L5X:5: the body of P is not read: there is no tag Local:1:I in this file",
        ),
        (
            "a.L5X",
            _L5X % (_PROGRAM % "PIDE(Module, a, b, a);"),
            "a.L5X:5: the body of P is not read: the instruction PIDE is not supported",
        ),
        ("a.scl", "// nothing\nFOO", "a.scl:2: 'FOO' is not expected here"),
        ("a.scl", 'FUNCTION_BLOCK "A"\nBEGIN', "a.scl:1: this FUNCTION_BLOCK has no END_"),
        ("a.scl", "TYPE END_TYPE", "a.scl:1: this TYPE has no name"),
        ("a.project", "PK", "a.project: .project cannot be read; in CODESYS: Project > Export"),
        ("a.zap17", "PK", "a.zap17: .zap17 cannot be read; in TIA Portal: Generate source"),
        ("a.ACD", "PK", "a.ACD: .ACD cannot be read; in Studio 5000: save as .L5X"),
    ],
)
def test_a_mistake_in_a_project_file_is_reported_with_its_line(
    name: str,
    text: str,
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """The message has the file and the line of the mistake. Source: docs/how-to/projects.md."""
    monkeypatch.chdir(tmp_path)
    Path(name).write_text(text, encoding="utf-8")
    assert main(["run", name, "--engine", "builtin"]) == 2
    said = capsys.readouterr()
    assert message in said.err
    assert said.err.removeprefix("compiling ...\n").strip().count("\n") == 0
    assert [file.name for file in tmp_path.iterdir()] == [name]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "iso-8859-1"])
def test_xml_is_read_in_the_encoding_that_it_names(encoding: str, tmp_path: Path) -> None:
    """XML is read in its declared encoding.

    A UTF-8 file that declares UTF-16 can be read as well.
    """
    name = "utf-8" if encoding == "utf-8-sig" else encoding
    text = (_DATA / "beremiz.xml").read_text(encoding="utf-8").replace("starts", "fängt")
    file = tmp_path / "a.xml"
    file.write_bytes(text.replace("'utf-8'", f"'{name}'").encode(encoding))
    texts = [source_text(source) for source in project_sources([file], {}).paths]
    assert any("fängt again" in one for one in texts)
    file.write_bytes(text.replace("'utf-8'", "'utf-16'").encode())
    assert texts == [source_text(source) for source in project_sources([file], {}).paths]
    assert check(list(project_sources([file], {}).paths)) == []


def test_two_pous_with_the_same_name_are_reported_with_both_files(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """If two POUs have the same name, the message names both files.

    Source: docs/how-to/projects.md.
    """
    for name in ("a", "b"):
        text = _POU % ("PROGRAM P", "<ST>RETURN;</ST>")
        (tmp_path / f"{name}.TcPOU").write_text(text, encoding="utf-8")
    assert main(["check", str(tmp_path)]) == 2
    assert "b.TcPOU:1:" in (said := capsys.readouterr().err)
    assert "P is declared twice; remove this one or the one in a.TcPOU, line 1" in said
    out = tmp_path / "out"
    assert main(["import", str(tmp_path), "-o", str(out)]) == 2
    assert "P is declared twice" in capsys.readouterr().err
    assert not out.exists()


def test_a_name_with_a_path_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A name such as ../../evil is refused, and no file is written.

    Source: docs/how-to/projects.md.
    """
    text = '<project><pou name="../../evil" pouType="program"><body/></pou></project>'
    (tmp_path / "a.xml").write_text(text, encoding="utf-8")
    assert main(["import", str(tmp_path / "a.xml"), "-o", str(tmp_path / "x" / "y")]) == 2
    assert "'../../evil' is not a name for a file" in capsys.readouterr().err
    assert [file.name for file in tmp_path.iterdir()] == ["a.xml"]


def test_import_overwrites_files_only_with_force(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Existing files are only overwritten with --force. Source: docs/how-to/projects.md."""
    out = tmp_path / "out"
    given = ["import", str(_DATA / "beremiz.xml"), "-o", str(out)]
    assert main(given) == 0
    (out / "ROWS.st").write_text("mine", encoding="utf-8")
    assert main(given) == 2
    assert "already exists, and 2 more files; nothing was written" in capsys.readouterr().err
    assert (out / "ROWS.st").read_text(encoding="utf-8") == "mine"
    assert main([*given, "--force"]) == 0
    assert (out / "ROWS.st").read_text(encoding="utf-8").startswith("TYPE ROWS")


def test_structured_text_cannot_be_imported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """`rcx import` rejects a file that is already structured text. Source: rcx import --help."""
    shutil.copy(_DATA / "lamp.st", tmp_path)
    assert main(["import", str(tmp_path / "lamp.st"), "-o", str(tmp_path / "out")]) == 2
    assert "lamp.st: is already Structured Text" in capsys.readouterr().err


_LAMP = "PROGRAM Lamp VAR V : BOOL; END_VAR INITIAL_STEP S: V (N); END_STEP END_PROGRAM\n"


def test_a_chart_in_text_form_is_imported_as_statements(tmp_path: Path) -> None:
    """Source: rcx import --help."""
    chart = tmp_path / "Lamp.st"
    chart.write_text(_LAMP)
    assert main(["import", str(chart), "-o", str(tmp_path / "out")]) == 0
    text = (tmp_path / "out" / "Lamp.st").read_text()
    assert "INITIAL_STEP" not in text
    assert "V := " in text


def test_charts_with_the_same_file_name_are_refused_and_nothing_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Otherwise the translation of the second chart would replace that of the first."""
    for folder, name in (("a", "Lamp.st"), ("b", "LAMP.st")):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / name).write_text(_LAMP)
    charts = [str(tmp_path / "a" / "Lamp.st"), str(tmp_path / "b" / "LAMP.st")]
    assert main(["import", *charts, "-o", str(tmp_path / "out")]) == 2
    assert "has the same name as" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_chart_does_not_overwrite_its_own_file_even_with_force(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    chart = tmp_path / "Lamp.st"
    chart.write_text(_LAMP)
    assert main(["import", str(chart), "-o", str(tmp_path), "--force"]) == 2
    assert "would be overwritten" in capsys.readouterr().err
    assert chart.read_text() == _LAMP


def test_a_chart_and_a_project_that_write_the_same_file_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    chart, project = tmp_path / "Lamp.st", tmp_path / "cell.scl"
    chart.write_text(_LAMP)
    project.write_text("FUNCTION_BLOCK Lamp\nBEGIN\nEND_FUNCTION_BLOCK\n")
    assert main(["import", str(chart), str(project), "-o", str(tmp_path / "out")]) == 2
    assert "also writes a file Lamp.st" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
