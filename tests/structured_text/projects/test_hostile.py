"""Wrong numbers, encodings and aliases in project files give one message with its place."""

from __future__ import annotations

from pathlib import Path

import pytest

from structured_text.errors import InputError
from structured_text.language.load import checked
from structured_text.language.source import Extract, source_text
from structured_text.projects.numbers import interval_text, milliseconds_us, whole
from structured_text.projects.open import project_sources, read_project

_PLCOPEN = """\
<?xml version="1.0" encoding="{encoding}"?>
<project><pou name="Own" pouType="program"><interface><localVars><variable name="x"><type><INT/>
</type></variable></localVars></interface><body><ST>x := 1; (* {said} *)
</ST></body></pou>
<task name="T" interval="{interval}" priority="{priority}"><pouInstance name="M" typeName="Own"/>
</task></project>"""
_TWINCAT = """\
<TcPlcObject><Task Name="T">
<CycleTime>{interval}</CycleTime><Priority>{priority}</Priority>
<PouCall><Name>Own</Name></PouCall></Task></TcPlcObject>"""
_L5X = """\
<RSLogix5000Content><Controller><Tags>
{tags}</Tags><Programs><Program Name="Own" MainRoutineName="R"><Tags>
<Tag Name="a" DataType="DINT"/></Tags><Routines><Routine Name="R" Type="ST"><STContent>
<Line Number="0"><![CDATA[{code}]]></Line></STContent></Routine></Routines></Program></Programs>
<Tasks><Task Name="T" Type="PERIODIC" Rate="{interval}" Priority="{priority}"><ScheduledPrograms>
<ScheduledProgram Name="Own"/></ScheduledPrograms></Task></Tasks></Controller>
</RSLogix5000Content>"""
_FILES = {"a.xml": _PLCOPEN, "a.TcTTO": _TWINCAT, "a.L5X": _L5X}
_USUAL = {"encoding": "utf-8", "said": "", "interval": "10", "priority": "1", "tags": "",
          "code": ""}  # fmt: skip


def _written(folder: Path, name: str, **changed: str) -> Path:
    file = folder / name
    values = {**_USUAL, **changed}
    file.write_text(_FILES[name].format(**values), encoding=values["encoding"])
    return file


def _refused(file: Path) -> str:
    with pytest.raises(InputError) as caught:
        read_project([file])
    assert caught.value.line is not None
    assert len(str(caught.value)) < 400
    return str(caught.value)


@pytest.mark.parametrize("name", list(_FILES))
@pytest.mark.parametrize(
    "number",
    [
        "ten",
        "1.5",
        "-1",
        "nan",
        "inf",
        "\u00b2",
        "\u0663",
        "1_0",
        "9" * 5_000,
        "70000",
        "0x10",
        "1e3",
    ],
)
def test_a_priority_is_a_number_up_to_65535(name: str, number: str, tmp_path: Path) -> None:
    """A priority that is not a whole number from 0 to 65535 is refused.

    Python's int() would accept some of these texts.

    Source: docs/reference/limits.md, files.
    """
    text = _refused(_written(tmp_path, name, priority=number))
    assert "the priority of the task T is '" in text
    assert text.endswith("write a whole number from 0 to 65535")


@pytest.mark.parametrize("name", list(_FILES))
@pytest.mark.parametrize(
    "interval",
    ["ten", "-1", "nan", "inf", "1e400", "\u00b2", "0", "9" * 5_000, "9" * 17, f"0.{'1' * 50}"],
)
def test_an_interval_is_a_year_at_most(name: str, interval: str, tmp_path: Path) -> None:
    """A task interval that is not a duration above 0 and up to a year is refused.

    Source: docs/reference/limits.md, files.
    """
    text = _refused(_written(tmp_path, name, interval=interval))
    assert "the interval '" in text or "the cycle time of the task T [us] is '" in text


def test_a_periodic_task_of_logix_without_a_rate_is_not_a_continuous_one(tmp_path: Path) -> None:
    """A missing rate is an error, because the program would run in each scan with wrong timers.

    Source: Logix 5000 Import/Export, Task: Rate, of a periodic task
    """
    assert "the task T has the interval ''" in _refused(_written(tmp_path, "a.L5X", interval=""))


@pytest.mark.parametrize("interval", ["PT" + "9" * 400 + "S", "T#1.2.3s", "T#99999999999d", "PTS"])
def test_a_malformed_or_too_long_interval_in_plcopen_xml_is_refused(
    interval: str, tmp_path: Path
) -> None:
    """A wrong or too long interval is refused with its text.

    Source: docs/reference/limits.md, files; ISO 8601, durations.
    """
    assert "has the interval '" in _refused(_written(tmp_path, "a.xml", interval=interval))


@pytest.mark.parametrize(
    ("text", "us", "literal"),
    [
        ("10", 10_000, "T#10ms"),
        ("0.5", 500, "T#0.5ms"),
        ("1234.567", 1_234_567, "T#1234.567ms"),
        ("2000000", 2_000_000_000, "T#2000000ms"),
    ],
)
def test_an_interval_keeps_all_its_digits(text: str, us: int, literal: str, tmp_path: Path) -> None:
    """An interval keeps all its digits, and is not rounded to T#1234.57ms or T#2e+06ms.

    Source: IEC 61131-3, duration literals.
    """
    assert milliseconds_us(text, "T", tmp_path, 1) == us
    assert interval_text(us) == literal


@pytest.mark.parametrize("dimension", ["nan", "-5", "\u00b2", "9" * 5_000, "3.5", "3 x"])
def test_a_dimension_of_a_tag_is_a_whole_number(dimension: str, tmp_path: Path) -> None:
    """A tag dimension that is not a whole number is refused with its line.

    Source: docs/reference/limits.md, files.
    """
    tag = f'<Tag Name="b" DataType="DINT" Dimensions="{dimension}"/>'
    assert "a.L5X:2: a dimension of b is '" in _refused(_written(tmp_path, "a.L5X", tags=tag))


def test_whole_numbers_have_limits(tmp_path: Path) -> None:
    """`whole` accepts numbers within its limits, and names the limits in its error.

    Source: docs/reference/limits.md, files.
    """
    assert [whole(one, "it", 1, 9, tmp_path, 1) for one in ("1", " 9 ")] == [1, 9]
    for one in ("0", "10", ""):
        with pytest.raises(InputError, match="write a whole number from 1 to 9"):
            whole(one, "it", 1, 9, tmp_path, 1)


@pytest.mark.parametrize(
    ("value", "kind", "told"),
    [("1.#QNAN", "REAL", True), ("1.$", "REAL", True), ("9" * 5_000, "DINT", True),
     ("1e39", "REAL", True), ("1e39", "LREAL", False), ("16#ff", "DINT", False)],
)  # fmt: skip
def test_an_initial_value_that_is_no_number_is_left_out_with_a_note(
    value: str, kind: str, told: bool, tmp_path: Path
) -> None:
    """An initial value that is not a number is left out with a note.

    Studio 5000 writes 1.#QNAN for a REAL that is NaN.

    Source: docs/reference/limits.md, files.
    """
    data = f'<Data Format="Decorated"><DataValue DataType="{kind}" Value="{value}"/></Data>'
    tag = f'<Tag Name="b" DataType="{kind}">{data}</Tag>'
    project = read_project([_written(tmp_path, "a.L5X", tags=tag)])
    assert [f"of a {kind} is not read" in note for note in project.notes] == [True] * told


# --- aliases ----------------------------------------------------------------------------------


def _alias(name: str, target: str) -> str:
    return f'<Tag Name="{name}" TagType="Alias" AliasFor="{target}"/>\n'


@pytest.mark.parametrize(
    ("tags", "told"),
    [
        (_alias("x", "x"), "a.L5X:2: the alias x leads to itself"),
        (_alias("x", "y[1]") + _alias("y", "x.3"), "a.L5X:2: the alias x leads to itself"),
        ("".join(_alias(f"x{k}", f"x{k + 1}") for k in range(99)), "leads to more than 50 others"),
        (_alias("x", ""), "a.L5X:2: the alias x stands for ''"),
        (_alias("x", "y[y[1]]"), "the alias x stands for 'y[y[1]]'"),
    ],
)
def test_an_alias_leads_to_a_tag(tags: str, told: str, tmp_path: Path) -> None:
    """An alias tag accesses the tag that it names.

    Source: Logix 5000 controllers I/O and tag data, 1756-PM004: alias tags.
    """
    assert told in _refused(_written(tmp_path, "a.L5X", tags=tags))


def test_an_alias_of_a_controller_may_be_a_tag_of_a_program(tmp_path: Path) -> None:
    """An alias tag of the controller may refer to a tag of a program.

    Source: Logix 5000 controllers I/O and tag data, 1756-PM004: scope of tags.
    """
    tags = '<Tag Name="b" DataType="DINT"/>' + _alias("a", "b") + _alias("c", "a")
    file = _written(tmp_path, "a.L5X", tags=tags, code="a := c;")
    sources = project_sources([file], {})
    assert checked(sources.paths).instances


@pytest.mark.exhaustive(but=["code1"])
@pytest.mark.parametrize("code", ["a := " + "(" * 9_000 + "a", "a := " + "9" * 5_000 + ";"])
def test_unreadable_statements_of_logix_are_reported(code: str, tmp_path: Path) -> None:
    """Statements in an L5X file that cannot be read are reported with their line.

    Source: docs/reference/limits.md, programs.
    """
    file = _written(tmp_path, "a.L5X", code=code)
    with pytest.raises(InputError, match="the body of Own") as caught:
        project_sources([file], {})
    assert caught.value.line is not None


# --- encodings --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "encoding", ["Shift_JIS", "EUC-JP", "ISO-2022-JP", "GB2312", "GBK", "GB18030", "Big5", "utf-16"]
)
def test_projects_of_east_asia_are_read_in_their_encoding(encoding: str, tmp_path: Path) -> None:
    """Project files in Japanese and Chinese are read with the encoding of their XML header.

    Source: docs/reference/limits.md, files.
    """
    said = "\u5de5\u4f5c" if encoding in ("GB2312", "GBK", "Big5") else "\u30c6\u30b9\u30c8"
    file = _written(tmp_path, "a.xml", encoding=encoding, said=said)
    sources = project_sources([file], {})
    (path,) = (one for one in sources.paths if "x := 1" in source_text(one))
    lines = source_text(path).splitlines()
    assert f"x := 1; (* {said} *)" in [line.strip() for line in lines]


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (
            b'<?xml version="1.0" encoding="klingon"?>\n<project/>',
            ":1: the encoding 'klingon' is not",
        ),
        (b'<?xml version="1.0" encoding="hex"?>\n<project/>', ":1: the encoding 'hex' is not"),
        (
            b'<?xml version="1.0" encoding="Shift_JIS"?>\n\n<p a="\x81"/>',
            ":3: byte 50 is not Shift_JIS",
        ),
        (b'<?xml version="1.0" encoding="utf-8"?>\n<p a="\xff"/>', ":2: byte 45 is not utf-8"),
    ],
)
def test_a_wrong_encoding_has_its_line(content: bytes, told: str, tmp_path: Path) -> None:
    """An unknown encoding, or a byte that does not fit it, is reported with its line.

    Source: docs/reference/limits.md, files.
    """
    file = tmp_path / "a.xml"
    file.write_bytes(content)
    assert told in _refused(file)


def test_comments_of_scl_are_looked_at_once(tmp_path: Path) -> None:
    """Each of 200,000 comments is read once, without a search through all lines of the source.

    Source: docs/reference/limits.md.
    """
    text = "FUNCTION_BLOCK F\nVAR x : INT; END_VAR\nBEGIN\nx := 1; // c\n" + "// c\n" * 20_000
    file = tmp_path / "a.scl"
    file.write_text(f"{text}END_FUNCTION_BLOCK\n", encoding="utf-8")
    (path,) = project_sources([file], {}).paths
    assert isinstance(path, Extract)
    lines = path.lines
    assert lines is not None
    assert len(lines) == 20_005
    hashed = {"lines": 0}

    class Counted(tuple):  # type: ignore[type-arg]
        def __hash__(self) -> int:
            hashed["lines"] += 1
            return 0

    path.lines = Counted(lines)
    assert {path, path, path} == {path}
    assert hashed["lines"] <= 1
