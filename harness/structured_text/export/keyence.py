"""Export for Keyence KV STUDIO (KV-X500, KV-8000): tables to paste, bodies in ST."""

from __future__ import annotations

import re
from collections.abc import Mapping

from structured_text.export.dialect.dialect import Dialect
from structured_text.export.dialect.folder import Row, Tool, tabbed, to_folder
from structured_text.export.output import Output
from structured_text.export.parts import Sources

__all__ = ["KEYENCE", "to_keyence"]

KEYENCE = Dialect(
    tool="KV STUDIO",
    listed="keyence",
    types={
        **{one: one for one in ("BOOL", "INT", "DINT", "UINT", "UDINT", "REAL", "LREAL", "TIME")},
        "BYTE": "UINT",
        "WORD": "UINT",
        "DWORD": "UDINT",
        "STRING": "STRING[80]",
    },
    array="ARRAY[{bounds}] OF {element}",
    refused=re.compile(
        r"(?:X|Y|R|MR|LR|CR|B|VB|DM|EM|FM|ZF|W|TM|TC|TS|CM|CC|CS|T|C|D|E|F|L|M|V|Z|AT)\d*"
    ),
    words={"WORD": "UINT", "DWORD": "UDINT"},
)

_PASSED = {"VAR_INPUT": "IN", "VAR_OUTPUT": "OUT", "VAR_IN_OUT": "IN-OUT"}

_README = """\
For Keyence KV STUDIO (KV-X500 and KV-8000 series).
These files have not been opened in KV STUDIO, and its manuals were not at hand when they were made.
Take them as a draft: try {first}, and convert it.

The .txt files are tables, cells separated by tabs, without a line of titles: open one in an editor,
copy all of it and paste it into the table. Compare the columns with those of your version first.

1. Data types: a structure for each NAME.structure.txt. Columns: Name, Data Type, Comment.
2. Functions and function blocks, in the order below, language ST, named as the file:
   NAME.arguments.txt  Name, IN/OUT/IN-OUT, Data Type, Initial Value, Comment
   NAME.locals.txt     Name, Data Type, Initial Value, Comment; a constant has its value there
   NAME.st             the body
   The type of a function's result stands at the head of its body. If your version has no functions
   of your own, nearly nothing of the library can be brought in.
3. Process image: {image}
4. Programs: as function blocks; make a program of them that runs in every scan.

Renamed, because a device has the name: {renamed}.
Enumerations are numbers with the member in a comment (types/enumerations.txt). WORD is UINT,
DWORD is UDINT, a BYTE is a UINT whose upper half is 0. STRING is STRING[80]; Japanese texts are
bytes of UTF-8.
Variables of functions are set at the beginning of each call, arrays and structures with initial
values in the first one.
Not known, look them up: whether AND, OR, SHL and SHR take UINT, how typed literals such as
UINT#16#00FF are written, and whether TON, R_TRIG and the conversions have these names.

Order:
{order}
"""


_NOTES = {
    "first": "one small function block first",
    "image": "there is no type for a byte, so make it of words.",
}


def to_keyence(sources: Sources) -> Output:
    """Write a folder of bodies and tables for KV STUDIO."""
    return to_folder(sources, Tool(KEYENCE, (), _tables, _README, _NOTES))


def _tables(rows: list[Row]) -> Mapping[str, str]:
    if rows and rows[0].section == "FIELD":
        return {".structure.txt": tabbed((one.name, one.type, one.comment) for one in rows)}
    passed = [
        (one.name, _PASSED[one.section], one.type, one.initial, one.comment)
        for one in rows
        if one.section in _PASSED
    ]
    own = [(one.name, one.type, one.initial, one.comment) for one in rows if one.section == "VAR"]
    tables = {".arguments.txt": tabbed(passed), ".locals.txt": tabbed(own)}
    return {ending: text for ending, text in tables.items() if text}
