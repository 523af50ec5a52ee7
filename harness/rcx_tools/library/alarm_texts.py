"""Texts of alarms and ErrorIDs for a panel: blocks of plc/lib, and a table as CSV.

The texts are in spec/alarms.toml and spec/errors.toml, in English and Japanese. A STRING of a PLC
holds bytes, on many PLCs at most 80. A text therefore becomes up to two lines of up to 80 bytes.
Japanese is UTF-8 in escapes, so that the source stays ASCII.
"""

from __future__ import annotations

import csv
import io
import re
import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import groupby
from typing import Any

from rcx_harness import spec
from structured_text.errors import InputError
from structured_text.output.toml_files import load_toml

__all__ = ["LANGUAGES", "literal", "text_files", "wrapped"]

#: Maps each language to the suffix of its keys in spec/.
LANGUAGES = {"English": "", "Japanese": "_ja"}

_WIDTH, _LINES = 80, 2
#: Pattern of text parts between which a line may break: ASCII without spaces, or another character
#: together with its closing punctuation.
_PIECE = re.compile("[!-~]+|[^ -~][、。\N{FULLWIDTH RIGHT PARENTHESIS}]*| ")
#: The range of the error numbers in each block of texts, and the subject of these errors.
_ERROR_BLOCKS = {
    "ErrorText": ("errors of states and answers", range(0x8000, 0x8021)),
    "InputErrorText": ("errors of inputs and tables", range(0x8021, 0x8058)),
    "WorkErrorText": ("errors of parts, points and panels", range(0x8058, 0x8080)),
    "CallErrorText": ("errors of jobs for a robot program", range(0x8080, 0x8100)),
}

_HEXADECIMAL = "0123456789ABCDEFabcdef"
_KEYS = ("name", "cause", "remedy")
_ALARMS = "spec/alarms.toml"
_ERRORS = "spec/errors.toml"
_TESTS = "tests/diagnosis/test_alarm_texts.py"
_PANEL_TESTS = "tests/operator/test_operator_texts.py"

Row = Mapping[str, Any]


def text_files() -> dict[str, Callable[[], str]]:
    """Return the generators of the files, by the path in the repository."""
    folder = "plc/lib/diagnosis"
    written: dict[str, Callable[[], str]] = {}
    for language in LANGUAGES:
        written[f"plc/lib/core/FB_RcxPanelText{language}.st"] = partial(_panel_block, language)
        name = f"FB_RcxAlarmText{language}"
        written[f"plc/lib/core/{name}.st"] = partial(_alarm_block, name, language)
        for kind in _ERROR_BLOCKS:
            written[f"plc/lib/core/FB_Rcx{kind}{language}.st"] = partial(
                _error_block, kind, language
            )
    written[f"{folder}/FC_CommandName.st"] = _command_names
    written[f"{folder}/FC_SignalName.st"] = _signal_names
    written["docs/reference/texts.csv"] = _table
    return written


def wrapped(text: str) -> list[str]:
    """Return a text as lines of up to 80 bytes.

    Raises:
        InputError: the text needs more than two lines.
    """
    lines = [""]
    if text.isascii():
        lines = textwrap.wrap(text, _WIDTH)
    else:
        for piece in _PIECE.findall(text):
            if len((lines[-1] + piece).encode()) > _WIDTH:
                lines.append("")
            lines[-1] += piece
    if len(lines) > _LINES or any(len(line.encode()) > _WIDTH for line in lines):
        raise InputError(
            f"a text is too long for {_LINES} lines of {_WIDTH} bytes: {text}",
            hint="shorten it in spec/alarms.toml or spec/errors.toml",
        )
    return lines


def literal(text: str) -> str:
    """Return a text as STRING literal in UTF-8. Bytes beyond ASCII are written as escapes.

    If a digit or a letter from A to F follows an escape, this character is also escaped. A C
    compiler would otherwise read the character as a part of the escape.
    """
    made, escaped = [], False
    for byte in text.encode():
        character = chr(byte)
        escaped = byte > 0x7E or character in "$'" or (escaped and character in _HEXADECIMAL)
        made.append(f"${byte:02X}" if escaped else character)
    return f"'{''.join(made)}'"


def _assigned(row: Row, suffix: str) -> Iterator[str]:
    yield f"Text.Name := {literal(row[f'name{suffix}'])};"
    for key in ("cause", "remedy"):
        for number, line in enumerate(wrapped(row[f"{key}{suffix}"]), 1):
            yield f"Text.{key.capitalize()}{number} := {literal(line)};"


def _block(
    name: str,
    head: Sequence[str],
    inputs: Sequence[str],
    body: Sequence[str],
    text: str = "must be empty at the call",
    tests: str = _TESTS,
) -> str:
    comment = ["(*", *(f" * {line}".rstrip() for line in head), " *", f" * Tests: {tests}", " *)"]
    pins = [
        *("  VAR_IN_OUT", f"    Text : RCX_TEXT;  (* {text} *)", "  END_VAR"),
        *("  VAR_INPUT", *(f"    {line}" for line in inputs), "  END_VAR"),
    ]
    rows = [f"  {line}" for line in body]
    return "\n".join([*comment, f"FUNCTION_BLOCK {name}", *pins, "", *rows, "END_FUNCTION_BLOCK\n"])


def _alarm_block(name: str, language: str) -> str:
    head = [
        f"{name}: look up the {language} texts of the alarms of the manual, and of 4.202",
        "(chapter 4, 4).",
        *("", f"Part of FB_AlarmText. Generated from {_ALARMS} by `make docs`."),
    ]
    body = ["CASE WORD_TO_INT(Group) OF"]
    rows = load_toml(spec.folder() / "alarms.toml")["alarm"]
    for group, alarms in groupby(rows, key=lambda row: int(row["group"])):
        body += [f"  {group}:", "    CASE WORD_TO_INT(Category) OF"]
        for row in alarms:
            body.append(f"      {row['category']}:  (* {row['number']} *)")
            body += [f"        {line}" for line in _assigned(row, LANGUAGES[language])]
        body.append("    END_CASE;")
    return _block(name, head, ["Group    : WORD;", "Category : WORD;"], [*body, "END_CASE;"])


def _error_block(kind: str, language: str) -> str:
    name = f"FB_Rcx{kind}{language}"
    what, numbers = _ERROR_BLOCKS[kind]
    head = [
        f"{name}: look up the {language} texts of {what}",
        "(errors.md).",
        *("", f"Part of FB_ErrorText. Generated from {_ERRORS} by `make docs`."),
    ]
    body = ["CASE Number OF"]
    for row in load_toml(spec.folder() / "errors.toml")["error"]:
        if row["id"] in numbers:
            body.append(f"  {row['id'] & 0xFF}:  (* 16#{row['id']:04X} *)")
            body += [f"    {line}" for line in _assigned(row, LANGUAGES[language])]
    inputs = ["Number : INT;  (* lower byte of the ErrorID *)"]
    return _block(name, head, inputs, [*body, "END_CASE;"])


def _panel_block(language: str) -> str:
    name, suffix = f"FB_RcxPanelText{language}", LANGUAGES[language]
    head = [
        f"{name}: look up cause and remedy for an operator, in {language} (errors.md).",
        "",
        "Part of FB_RcxPanelMessage, which shows these texts instead of those for programmers.",
        f"Generated from {_ERRORS} by `make docs`.",
    ]
    body = ["CASE Number OF"]
    for row in load_toml(spec.folder() / "errors.toml")["error"]:
        if f"panel_remedy{suffix}" not in row:
            continue
        body.append(f"  {row['id'] & 0xFF}:  (* 16#{row['id']:04X} *)")
        for key in ("cause", "remedy"):
            first, second = [*wrapped(row[f"panel_{key}{suffix}"]), ""][:2]
            body.append(f"    Text.{key.capitalize()}1 := {literal(first)};")
            body.append(f"    Text.{key.capitalize()}2 := {literal(second)};")
    inputs = ["Number : INT;  (* lower byte of the ErrorID *)"]
    return _block(name, head, inputs, [*body, "END_CASE;"], "texts of the ErrorID", _PANEL_TESTS)


def _command_names() -> str:
    rows = [(str(code), command.name, f"16#{code:03X}") for code, command in _named_commands()]
    about = [
        "FC_CommandName: return the name of a remote command (guide 3), see reference/commands.md.",
        "The result is empty for an unknown code. The robot number is ignored.",
        "Generated from spec/remote_commands.toml by `make docs`.",
    ]
    inputs = ["Code : WORD;  (* with the robot number in bits 15-12 *)"]
    cases = _cases("Code AND WORD#16#0FFF", "FC_CommandName", rows)
    return _function("FC_CommandName", about, inputs, cases)


def _signal_names() -> str:
    about = [
        "FC_SignalName: return the manual's name of a dedicated bit (chapter 5, 2).",
        "The result is empty for a reserved number.",
        "Generated from spec/signals.toml by `make docs`.",
    ]
    inputs = [
        "Output : BOOL;  (* TRUE: SO, of the controller; FALSE: SI, of the PLC *)",
        "Number : WORD;  (* 16#0012 = SI(12), SO(12) *)",
    ]
    sides = []
    for signals in (spec.signals().output, spec.signals().input):
        rows = [
            (str(int(one.short[2:], 16)), f"{one.signal} {one.title}", f"16#{one.short[2:]}")
            for one in signals
        ]
        sides.append([f"  {line}" for line in _cases("Number", "FC_SignalName", rows)])
    body = ["IF Output THEN", *sides[0], "ELSE", *sides[1], "END_IF;"]
    return _function("FC_SignalName", about, inputs, body)


def _cases(of: str, name: str, rows: Sequence[tuple[str, str, str]]) -> list[str]:
    """Return a CASE that assigns a name to each number, and '' to all other numbers."""
    texts = [f"  {number}: {name} := {literal(text)};" for number, text, _ in rows]
    width = max(map(len, texts)) + 2
    lines = [f"{text:<{width}}(* {row[2]} *)" for text, row in zip(texts, rows, strict=True)]
    return [
        f"CASE WORD_TO_INT({of}) OF",
        *lines,
        *("ELSE", f"  {name} := '';", "END_CASE;"),
    ]


def _function(name: str, about: Sequence[str], inputs: Sequence[str], body: Sequence[str]) -> str:
    lines = [
        *("(*", f" * {about[0]}", " *", *(f" * {line}" for line in about[1:])),
        *(" *", f" * Tests: {_TESTS}", " *)", f"FUNCTION {name} : STRING", "  VAR_INPUT"),
        *(f"    {line}" for line in inputs),
        *("  END_VAR", "", *(f"  {line}" for line in body), "END_FUNCTION\n"),
    ]
    return "\n".join(lines)


def _named_commands() -> list[tuple[int, spec.Command]]:
    """Return all commands except the status reset. No block sends the status reset as a command."""
    return [(code, one) for code, one in sorted(spec.commands().items()) if code]


def _table() -> str:
    """Return all texts for the text lists of a panel.

    The table begins with a byte order mark, for spreadsheets.
    """
    columns = [f"{key}{suffix}" for suffix in LANGUAGES.values() for key in _KEYS]
    page = io.StringIO()
    page.write("\N{ZERO WIDTH NO-BREAK SPACE}")
    writer = csv.writer(page, lineterminator="\n")
    writer.writerow(["list", "number", *columns])
    alarms = load_toml(spec.folder() / "alarms.toml")["alarm"]
    for row in alarms:
        writer.writerow(["alarm", row["number"], *(row[column] for column in columns)])
    known, blank = {row["number"] for row in alarms}, [""] * (len(columns) - 1)
    for number, name in spec.public_alarms().items():
        if number not in known:
            writer.writerow(["alarm, public list", number, name, *blank])
    for row in load_toml(spec.folder() / "errors.toml")["error"]:
        number = f"16#{row['id']:04X}"
        writer.writerow(["ErrorID", number, *(row[column] for column in columns)])
        if "panel_remedy" in row:
            words = [row.get(f"panel_{column}", row[column]) for column in columns]
            writer.writerow(["ErrorID, for an operator", number, *words])
    for code, command in _named_commands():
        writer.writerow(["command", f"16#{code:04X}", command.name, *blank])
    every = spec.signals()
    for signal in every.output + every.input:
        writer.writerow(["signal", signal.signal, signal.title, *blank])
    return page.getvalue()
