"""Blocks, functions and structures for the tags of instructions."""

from __future__ import annotations

from collections.abc import Mapping

from structured_text.projects.rockwell.data import Data
from structured_text.projects.rockwell.ladder.functions import FUNCTIONS
from structured_text.projects.rockwell.sheets.structures import STRUCTURES

__all__ = ["BLOCKS", "HELPERS", "HELPER_MEMBERS"]

#: Structures for the tags of ladder instructions, and of steps and actions of charts.
_DATA: Mapping[str, Mapping[str, tuple[str, ...]]] = {
    "SFC_STEP": {
        "BOOL": (
            *("X", "FS", "SA", "LS", "DN", "OV", "AlarmEn", "AlarmLow", "AlarmHigh"),
            *("Reset", "PauseTimer"),
        ),
        "DINT": ("Status", "PRE", "T", "TMax", "Count", "LimitLow", "LimitHigh"),
    },
    "SFC_ACTION": {"BOOL": ("A", "Q", "PauseTimer"), "DINT": ("Status", "PRE", "T", "Count")},
    "SFC_STOP": {"BOOL": ("X", "Reset"), "DINT": ("Status", "Count")},
    "TIMER": {"BOOL": ("EN", "TT", "DN"), "DINT": ("PRE", "ACC")},
    "COUNTER": {"BOOL": ("CU", "CD", "DN", "OV", "UN"), "DINT": ("PRE", "ACC")},
    "CONTROL": {
        "BOOL": ("EN", "EU", "DN", "EM", "ER", "UL", "IN", "FD"),
        "DINT": ("LEN", "POS"),
    },
}
#: Members that a structure has in addition, and that no statement of the project can use.
_HIDDEN = {"TIMER": "    Clock : TON;\n    Rest : TIME;\n"}
#: Names of the helper types that are function blocks.
BLOCKS = tuple(name for name, structure in STRUCTURES.items() if structure.body)
#: The Structured Text of the helper types, by name.
HELPERS = {
    **{name: structure.text(name) for name, structure in STRUCTURES.items()},
    **FUNCTIONS,
    **{
        name: f"TYPE {name} : STRUCT\n"
        + "".join(
            f"    {member} : {kind};\n" for kind, names in members.items() for member in names
        )
        + _HIDDEN.get(name, "")
        + "  END_STRUCT;\nEND_TYPE"
        for name, members in _DATA.items()
    },
}
#: The members of the helper types, in upper case.
HELPER_MEMBERS: dict[str, Mapping[str, Data]] = {
    **{name: structure.members() for name, structure in STRUCTURES.items()},
    **{
        name: {one.upper(): Data(kind) for kind, names in members.items() for one in names}
        for name, members in _DATA.items()
    },
}
