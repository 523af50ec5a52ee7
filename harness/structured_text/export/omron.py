"""Export for Omron Sysmac Studio (NJ, NX): tables to paste, bodies in ST."""

from __future__ import annotations

import re
from collections.abc import Mapping

from structured_text.export.dialect.dialect import Dialect
from structured_text.export.dialect.folder import Row, Tool, tabbed, to_folder
from structured_text.export.output import Output
from structured_text.export.parts import Sources

__all__ = ["OMRON", "to_omron"]

#: Names of instructions that users may choose for variables. W501, 6-3-12, refuses them as names.
_INSTRUCTIONS = (
    *("SET", "RESET", "OUT", "END", "BREAK", "NEXT", "UP", "DOWN", "CMP", "TIMER", "INC", "DEC"),
    *("RAND", "FRACTION", "ROUND", "ROUNDUP", "BAND", "ZONE", "EXCHANGE", "CLEAR", "SWAP", "NEG"),
    *("DECODER", "ENCODER", "BITCNT", "GRAY", "LOCK", "UNLOCK", "SETALARM", "RESETALARM"),
    *("GETALARM", "SETINFO", "GETTIME", "SETTIME", "STACKPUSH", "PIDAT", "MEMCOPY", "MC", "MCR"),
)

OMRON = Dialect(
    tool="Sysmac Studio",
    listed="omron",
    types={
        **{
            one: one
            for one in (
                *("BOOL", "BYTE", "WORD", "DWORD", "LWORD", "SINT", "INT", "DINT", "LINT", "USINT"),
                *("UINT", "UDINT", "ULINT", "REAL", "LREAL", "TIME", "DATE"),
            )
        },
        "TOD": "TIME_OF_DAY",
        "TIME_OF_DAY": "TIME_OF_DAY",
        "DT": "DATE_AND_TIME",
        "DATE_AND_TIME": "DATE_AND_TIME",
        "STRING": "STRING[81]",
    },
    array="ARRAY[{bounds}] OF {element}",
    refused=re.compile(rf"(?:{'|'.join(_INSTRUCTIONS)})|P_\w*|_\w*"),
    enumerations=True,
    bytes=True,
    arguments={
        **dict.fromkeys(("LEFT", "RIGHT"), ("", "INT_TO_UINT")),
        **dict.fromkeys(("MID", "DELETE"), ("", "INT_TO_UINT", "INT_TO_UINT")),
        "INSERT": ("", "", "INT_TO_UINT"),
        "REPLACE": ("", "", "INT_TO_UINT", "INT_TO_UINT"),
        **dict.fromkeys(("SHL", "SHR", "ROL", "ROR"), ("", "INT_TO_USINT")),
    },
    results=dict.fromkeys(("LEN", "FIND"), "UINT_TO_INT"),
)

_PASSED = {"VAR_INPUT": "Input", "VAR_OUTPUT": "Output", "VAR_IN_OUT": "In/Out", "RESULT": "Return"}

_RETAINED = ("VAR", "VAR_INPUT", "VAR_OUTPUT")

_README = """\
For Omron Sysmac Studio (NJ and NX controllers).
These files have not been opened in Sysmac Studio. Take them as a draft, and build before you run.

The .txt files are tables, cells separated by tabs, without a line of titles (one would become a
variable): open one in an editor, copy all of it and paste it into the first empty cell of the
table. Compare the columns with those of your version first.

1. Data Types, Enumerations: NAME.enumeration.txt. Columns: Name, Value, Comment.
2. Data Types, Structures: NAME.structure.txt, in the order below.
   Columns: Name, Base Type, Comment. (If your version has columns of offsets between them, paste
   Name and Base Type alone.)
3. Functions and function blocks, in the order below, language ST, named as the file:
   NAME.inout.txt      Name, In/Out, Data Type, Edge, Initial Value, Retain, Constant, Comment
                       of a function, the line with Return is its return type
   NAME.internals.txt  Name, Data Type, Initial Value, Retain, Constant, Comment
   NAME.st             the body
4. Process image: two global variables, ARRAY[0..47] OF BYTE, Network Publish Input and Output, in a
   tag set of a connection to the controller (assemblies 100 and 150). The pins Image have
   ARRAY[0..511] OF BYTE: write the size of yours into the tables of the blocks that you use, and
   pass it to their pins ImageSize.
5. Programs: as function blocks. Make their process images external variables. Assign the program to
   a task with a short, fixed period.

Renamed, because instructions have these names: {renamed}.
STRING is STRING[81]: 80 bytes and the NUL. INT becomes UINT or USINT where the text and shift
instructions want it. Variables of functions are set at the beginning of each call, arrays and
structures with initial values in the first one.

Order:
{order}
"""


def to_omron(sources: Sources) -> Output:
    """Write a folder of bodies and tables for Sysmac Studio."""
    return to_folder(sources, Tool(OMRON, _RETAINED, _tables, _README))


def _tables(rows: list[Row]) -> Mapping[str, str]:
    if rows and rows[0].section == "MEMBER":
        return {".enumeration.txt": tabbed((one.name, one.initial, one.comment) for one in rows)}
    if rows and rows[0].section == "FIELD":
        return {".structure.txt": tabbed((one.name, one.type, one.comment) for one in rows)}
    passed = [
        (
            *(one.name, _PASSED[one.section], one.type, "", one.initial),
            *("TRUE" if one.retain else "", "", one.comment),
        )
        for one in rows
        if one.section in _PASSED
    ]
    own = [
        (
            *(one.name, one.type, one.initial, "TRUE" if one.retain else ""),
            *("TRUE" if one.constant else "", one.comment),
        )
        for one in rows
        if one.section not in _PASSED
    ]
    tables = {".inout.txt": tabbed(passed), ".internals.txt": tabbed(own)}
    return {ending: text for ending, text in tables.items() if text}
