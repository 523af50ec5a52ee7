"""Export for Mitsubishi GX Works3 (MELSEC iQ-R, iQ-F): label tables as CSV, bodies in ST."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Mapping

from structured_text.export.dialect.dialect import Dialect
from structured_text.export.dialect.folder import Row, Tool, to_folder
from structured_text.export.output import Output
from structured_text.export.parts import Sources

__all__ = ["MITSUBISHI", "to_mitsubishi"]

_WORD = "Word [Unsigned]/Bit String [16-bit]"
_DWORD = "Double Word [Unsigned]/Bit String [32-bit]"

#: Names of devices and instructions, which GX Works3 refuses as labels.
_DEVICES = (
    r"(?:[BWXY]|DX|DY|SB|SW)[0-9A-F]+"
    r"|(?:[MLFVDRTCZPINUJS]|SM|SD|ST|SS|LT|LC|LZ|LST|ZR|RD|FX|FY|FD|BL|TR)\d+"
    r"|K[1-8]\w*|[HKE]\d+|[A-FH-PR-Z]"
)
_INSTRUCTIONS = (
    *("OUT", "SET", "RST", "MOV", "INC", "DEC", "SUM", "SWAP", "MEAN", "SORT", "SEG", "STOP"),
    *("END", "BAND", "ZONE", "SCL", "POP", "PUSH", "ASC", "HEX", "VAL", "STR", "RAMP", "SPD"),
    *("HOUR", "RND", "READ", "WRITE", "SEND", "RECV", "REQ", "PLS", "PLF", "SFT", "CALL", "JMP"),
)

MITSUBISHI = Dialect(
    tool="GX Works3",
    listed="mitsubishi",
    types={
        "BOOL": "Bit",
        "BYTE": _WORD,
        "WORD": _WORD,
        "UINT": _WORD,
        "DWORD": _DWORD,
        "UDINT": _DWORD,
        "INT": "Word [Signed]",
        "DINT": "Double Word [Signed]",
        "REAL": "FLOAT [Single Precision]",
        "LREAL": "FLOAT [Double Precision]",
        "TIME": "Time",
        "STRING": "String(80)",
    },
    array="{element}({bounds})",
    refused=re.compile(rf"{_DEVICES}|{'|'.join(_INSTRUCTIONS)}"),
    words={"UINT": "WORD", "UDINT": "DWORD"},
)

_TITLES = ("Label Name", "Data Type", "Class", "Initial Value", "Constant", "Comment")

_README = """\
For Mitsubishi GX Works3 (MELSEC iQ-R and iQ-F).
These files have not been opened in GX Works3. Take them as a draft, and convert all before you run.

The .csv files are label tables with these titles:
{titles}.
Export a small table of your own first and compare: titles, separator and encoding must be as your
version writes them. If it refuses a file, open it in a spreadsheet and paste the columns.

1. Structured data types: make those of types/*.csv (Class is empty there).
2. Functions and function blocks, in the order below, language ST, named as the file: NAME.csv are
   the local labels, NAME.st is the body; at its head stands the type of a function's result.
3. Process image: {image}
4. Programs: as function blocks; call them in a fixed-cycle or scan program.

Renamed, because a device or an instruction has the name: {renamed}.
Enumerations are numbers with the member in a comment (types/enumerations.txt). UINT and WORD, UDINT
and DWORD are one type here. A BYTE is a word whose upper half is 0. The pin CLK of R_TRIG is _CLK.
STRING is String(80); Japanese texts are bytes of UTF-8, which GX Works3 does not show.
Variables of functions are set at the beginning of each call, arrays and structures with initial
values in the first one.
{times}

Order:
{order}
"""


_NOTES = {
    "image": "there is no type for a byte, so make it of words.",
    "times": "On FX5, check the longest time that TON accepts.",
}


def to_mitsubishi(sources: Sources) -> Output:
    """Write a folder of bodies and label tables for GX Works3."""
    readme = _README.replace("{titles}", ", ".join(_TITLES))
    return to_folder(sources, Tool(MITSUBISHI, ("VAR", "VAR_OUTPUT"), _tables, readme, _NOTES))


def _tables(rows: list[Row]) -> Mapping[str, str]:
    text = io.StringIO()
    table = csv.writer(text, quoting=csv.QUOTE_ALL, lineterminator="\n")
    table.writerow(_TITLES)
    for one in rows:
        if one.section == "RESULT":
            continue
        kind = "" if one.section == "FIELD" else one.section
        if one.constant:
            table.writerow((one.name, one.type, "VAR_CONSTANT", "", one.initial, one.comment))
        else:
            kind += "_RETAIN" if one.retain else ""
            table.writerow((one.name, one.type, kind, one.initial, "", one.comment))
    return {".csv": text.getvalue()}
