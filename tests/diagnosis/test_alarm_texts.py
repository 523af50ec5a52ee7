"""The panel texts cover every alarm, error and name, in each language."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import pytest

from both_engines import ENGINES
from for_each import for_each
from plc_bench import ROOT, compiled
from rcx_harness import spec
from rcx_tools.library.alarm_texts import literal, text_files, wrapped
from structured_text.engines.base import Program
from structured_text.errors import InputError
from structured_text.output.toml_files import load_toml

_PROGRAM = """\
PROGRAM Texts
  VAR
    Group, Category, ErrorID, Code : WORD;
    Language  : RCX_LANGUAGE;
    AlarmText : FB_AlarmText;
    ErrorText : FB_ErrorText;
    Name      : STRING;
    Output    : BOOL;
    Number    : WORD;
    Signal    : STRING;
  END_VAR
  AlarmText(Group := Group, Category := Category, Language := Language);
  ErrorText(ErrorID := ErrorID, Language := Language);
  Name := FC_CommandName(Code := Code);
  Signal := FC_SignalName(Output := Output, Number := Number);
END_PROGRAM
"""
_LANGUAGES = {"LANGUAGE_ENGLISH": "", "LANGUAGE_JAPANESE": "_ja"}
_ALARMS = load_toml(spec.folder() / "alarms.toml")["alarm"]
_ERRORS = load_toml(spec.folder() / "errors.toml")["error"]
_SILENT = dict.fromkeys(("Name", "Cause1", "Cause2", "Remedy1", "Remedy2"), "")
_IN_BOTH = pytest.mark.parametrize("language", _LANGUAGES)


@pytest.fixture(scope="module", params=ENGINES)
def plc(request: pytest.FixtureRequest) -> Program:
    return compiled(_PROGRAM, request.param)


def _shown(plc: Program, block: str, **inputs: object) -> tuple[bool, dict[str, str]]:
    """Run a text block, and return its output Known and the lines of its text, decoded as UTF-8."""
    for name, value in inputs.items():
        plc.write(f"Main.{name}", value)
    plc.scan(0)
    lines = {
        name: text.encode("latin-1").decode("utf-8")
        for name, text in plc.read(f"Main.{block}.Text").items()
    }
    for line in lines.values():
        assert len(line.encode()) <= 80
    return bool(plc.read(f"Main.{block}.Known")), lines


def _joined(first: str, second: str) -> str:
    """Join the two lines of a text and remove all spaces."""
    return (first + second).replace(" ", "")


def _is_told(lines: dict[str, str], row: dict[str, str], suffix: str) -> None:
    assert lines["Name"] == row[f"name{suffix}"]
    for key in ("Cause", "Remedy"):
        text = row[f"{key.lower()}{suffix}"]
        assert lines[f"{key}1"], "the first line must not be empty"
        assert _joined(lines[f"{key}1"], lines[f"{key}2"]) == text.replace(" ", "")


@_IN_BOTH
@pytest.mark.parametrize("row", _ALARMS, ids=lambda row: str(row["number"]))
def test_each_alarm_that_the_manual_names_has_its_text(
    plc: Program, language: str, row: dict[str, str]
) -> None:
    """Source: manual chapter 4, 4, and guide 1.1 and 4.2.1."""
    known, lines = _shown(
        plc, "AlarmText", Group=row["group"], Category=row["category"], Language=language
    )
    assert known
    _is_told(lines, row, _LANGUAGES[language])


@_IN_BOTH
@for_each("row", _ERRORS)
def test_each_error_id_has_its_text(plc: Program, language: str, row: dict[str, str]) -> None:
    """Source: docs/reference/errors.md."""
    known, lines = _shown(plc, "ErrorText", ErrorID=row["id"], Language=language)
    assert known
    _is_told(lines, row, _LANGUAGES[language])


@_IN_BOTH
def test_an_alarm_that_the_manual_does_not_name_has_no_text(plc: Program, language: str) -> None:
    """Source: manual chapter 4, 4: for other alarms see the controller's manual."""
    named = {(row["group"], row["category"]) for row in _ALARMS}
    groups = {0, 65535} | {group + step for group, _ in named for step in (-1, 0, 1, 256)}
    categories = {0, 65535} | {number + step for _, number in named for step in (-1, 0, 1, 1000)}
    plc.write("Main.Language", language)
    for group in sorted(groups):
        for category in sorted(categories):
            plc.write("Main.Group", group)
            plc.write("Main.Category", category)
            plc.scan(0)
            assert plc.read("Main.AlarmText.Known") is ((group, category) in named)
    assert _shown(plc, "AlarmText", Group=17, Category=600) == (False, _SILENT)


@_IN_BOTH
def test_a_number_that_is_no_error_id_has_no_text(plc: Program, language: str) -> None:
    """Source: docs/reference/errors.md."""
    listed = {row["id"] for row in _ERRORS}
    plc.write("Main.Language", language)
    for error in (*range(0x8000, 0x8100), *range(0x80), *range(0x8100, 0x8180), 0xFFFF):
        plc.write("Main.ErrorID", error)
        plc.scan(0)
        assert plc.read("Main.ErrorText.Known") is (error in listed), hex(error)
    for error in (0x9003, 0x0003, 0x0000):
        plc.write("Main.ErrorID", 0x8003)
        plc.scan(0)
        assert _shown(plc, "ErrorText", ErrorID=error) == (False, _SILENT)


def test_a_shorter_text_leaves_nothing_of_the_one_before(plc: Program) -> None:
    _, lines = _shown(plc, "ErrorText", ErrorID=0x8003, Language="LANGUAGE_ENGLISH")
    assert lines["Cause2"]
    _, lines = _shown(plc, "ErrorText", ErrorID=0x8004, Language="LANGUAGE_ENGLISH")
    assert lines["Cause2"] == ""
    _, lines = _shown(plc, "AlarmText", Group=12, Category=400, Language="LANGUAGE_ENGLISH")
    assert lines["Cause2"]
    _, lines = _shown(plc, "AlarmText", Group=2, Category=334, Language="LANGUAGE_JAPANESE")
    assert lines["Cause2"] == ""


def test_english_texts_are_plain_ascii_and_each_has_a_japanese_one() -> None:
    for row in (*_ALARMS, *_ERRORS):
        for key in ("name", "cause", "remedy"):
            assert row[key].isascii(), row
            assert not row[f"{key}_ja"].isascii(), row
    for row in _ERRORS:
        keys = [key for key in row if key.startswith("panel_")]
        assert len(keys) in (0, 4), row
        assert [row[key].isascii() for key in sorted(keys)] == [True, False] * (len(keys) // 2)


def test_each_remote_command_has_its_name_for_every_robot(plc: Program) -> None:
    """The name does not depend on the robot number in the code.

    Source: guide 3, table of commands.
    """
    for code, command in spec.commands().items():
        for robot in (0, 1, 4) if code else ():
            plc.write("Main.Code", code | robot << 12)
            plc.scan(0)
            assert plc.read("Main.Name") == command.name


def test_a_code_without_a_command_has_no_name(plc: Program) -> None:
    """A code without a command gives an empty name, as does the status reset 16#0000.

    Source: guide 4.1.
    """
    for code in (0x0000, 0x1000, 0x0005, 0x0FFF, 0x0700 + 0x50):
        plc.write("Main.Code", 0x0001)
        plc.scan(0)
        plc.write("Main.Code", code)
        plc.scan(0)
        assert plc.read("Main.Name") == "", hex(code)


def test_only_dedicated_bits_have_names_and_the_names_are_those_of_the_manual(
    plc: Program,
) -> None:
    """Source: manual chapter 5, 2."""
    for output, signals in ((True, spec.signals().output), (False, spec.signals().input)):
        names = {int(one.short[2:], 16): f"{one.signal} {one.title}" for one in signals}
        plc.write("Main.Output", output)
        for number in (*range(0x20), 0x100, 0x8000, 0xFFFF):
            plc.write("Main.Number", number)
            plc.scan(0)
            assert plc.read("Main.Signal") == names.get(number, ""), hex(number)


# ---- the generated texts in structured text


@pytest.mark.parametrize("path", text_files())
def test_the_generated_files_are_current_and_marked_as_generated(path: str) -> None:
    text = text_files()[path]()
    assert (ROOT / path).read_bytes() == text.encode(), "the file is out of date: run `make docs`"
    if path.endswith(".st"):
        assert "by `make docs`" in text.partition("*)")[0]
        assert text.isascii()
        assert Path(path).stem in text


def test_a_text_is_broken_between_words_or_characters_and_closing_marks_do_not_begin_a_line() -> (
    None
):
    assert wrapped("word " * 20) == [("word " * 16).strip(), ("word " * 4).strip()]
    assert wrapped("あ" * 30) == ["あ" * 26, "あ" * 4]
    assert wrapped("あ" * 26 + "。い") == ["あ" * 25, "あ。い"]
    assert wrapped("あ" * 26 + "AB") == ["あ" * 26 + "AB"]
    assert wrapped("あ" * 26 + "ABC") == ["あ" * 26, "ABC"]


@pytest.mark.parametrize("text", ["word " * 33, "あ" * 53, "x" * 161, "あ" + "x" * 81])
def test_a_text_that_does_not_fit_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="too long for 2 lines of 80 bytes"):
        wrapped(text)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("plain 8", "'plain 8'"),
        ("it's $5", "'it$27s $24$35'"),
        ("あ", "'$E3$81$82'"),
        ("あ8", "'$E3$81$82$38'"),
        ("あABz", "'$E3$81$82$41$42z'"),
        ("あz8", "'$E3$81$82z8'"),
    ],
)
def test_bytes_beyond_ascii_and_hexadecimal_digits_after_them_are_escaped(
    text: str, expected: str
) -> None:
    """A byte beyond ASCII is written as `$` and two hexadecimal digits, and so is a digit after it.

    Source: IEC 61131-3, character strings.
    """
    assert literal(text) == expected


def test_the_table_for_panels_has_every_alarm_error_command_and_signal() -> None:
    """The table for panels is complete. The status reset is left out, because no panel shows it."""
    text = (ROOT / "docs/reference/texts.csv").read_text(encoding="utf-8-sig")
    rows = list(csv.DictReader(io.StringIO(text)))
    counts: dict[str, int] = {}
    for row in rows:
        counts[row["list"]] = counts.get(row["list"], 0) + 1
        assert row["name"]
    signals = len(spec.signals().input) + len(spec.signals().output)
    assert counts == {
        "alarm": len(_ALARMS),
        "alarm, public list": len(spec.public_alarms().keys() - spec.alarms().keys()),
        "ErrorID": len(_ERRORS),
        "ErrorID, for an operator": sum("panel_remedy" in row for row in _ERRORS),
        "command": len(spec.commands()) - 1,
        "signal": signals,
    }
    by_number = {(row["list"], row["number"]): row for row in rows}
    assert by_number["alarm", "12.600"]["name_ja"] == "非常停止中"
    assert by_number["alarm", "4.202"]["name"] == by_number["alarm", "4.2"]["name"]
    assert by_number["alarm, public list", "6.301"]["name"] == "Servo off"
    assert by_number["ErrorID", "16#8001"]["name"] == "Not connected"
    assert by_number["command", "16#0001"]["name"] == "MovePtp"
    assert by_number["signal", "SI(06)"]["name"] == "Stop input"
