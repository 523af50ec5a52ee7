"""Instructions for the standard blocks TON and R_TRIG, and for the first scan of a program."""

from __future__ import annotations

from structured_text.export.l5x.model import FIRST_SCAN, STANDARD_BLOCKS, Aoi, Data, Tag

__all__ = ["FBD_TIMER", "standard_blocks"]

#: Members of the structure that holds the state of the instruction TONR.
FBD_TIMER = {
    "EnableIn": "BOOL",
    "TimerEnable": "BOOL",
    "PRE": "DINT",
    "Reset": "BOOL",
    "EnableOut": "BOOL",
    "ACC": "DINT",
    "EN": "BOOL",
    "TT": "BOOL",
    "DN": "BOOL",
    "Status": "DINT",
    "InstructFault": "BOOL",
    "PresetInv": "BOOL",
}

_BOOL, _DINT = Data("BOOL"), Data("DINT")


def standard_blocks() -> list[Aoi]:
    """Return the instructions for TON, for R_TRIG and for the first scan."""
    return [_ton(), _r_trig(), _first_scan()]


def _ton() -> Aoi:
    """Return TON, implemented with TONR.

    TONR gets the highest preset and only counts the time. The code compares this time with PT.
    Therefore PT may change while the timer runs.
    """
    name = STANDARD_BLOCKS["TON"]
    return Aoi(
        name,
        f"{name}: the on-delay timer TON of IEC 61131-3, its times in milliseconds.",
        [
            Tag("IN", _BOOL, "Input", "0", "TRUE: the time runs"),
            Tag("PT", _DINT, "Input", "0", "[ms] after which Q comes on"),
            Tag("Q", _BOOL, "Output", "0", "IN has been TRUE for PT"),
            Tag("ET", _DINT, "Output", "0", "[ms] for which IN has been TRUE; PT at most"),
        ],
        [Tag("Timer", Data("FBD_TIMER"), "Local", None)],
        [
            "Timer.PRE := 2147483647;",
            "Timer.Reset := 0;",
            "Timer.TimerEnable := IN;",
            "TONR(Timer);",
            "IF NOT IN THEN",
            "  Q := 0;",
            "  ET := 0;",
            "ELSIF NOT Q THEN",
            "  ET := Timer.ACC;",
            "  IF ET >= PT THEN",
            "    ET := PT;",
            "    Q := 1;",
            "  END_IF;",
            "END_IF;",
        ],
        ["Timer.TimerEnable := 0;", "TONR(Timer);", "Q := 0;", "ET := 0;"],
    )


def _r_trig() -> Aoi:
    name = STANDARD_BLOCKS["R_TRIG"]
    return Aoi(
        name,
        f"{name}: the edge detection R_TRIG of IEC 61131-3.",
        [
            Tag("CLK", _BOOL, "Input", "0", "the signal to watch"),
            Tag("Q", _BOOL, "Output", "0", "TRUE for one call after CLK has come on"),
        ],
        [Tag("WasOn", _BOOL, "Local", "0")],
        ["Q := CLK AND NOT WasOn;", "WasOn := CLK;"],
        ["Q := 0;", "WasOn := 0;"],
    )


def _first_scan() -> Aoi:
    """Return the block for the first scan.

    It uses a Prescan routine, which runs when the controller starts (1756-PM010). The flag S:FS is
    not used, because the vendor's help names it for XIC and XIO only.
    """
    return Aoi(
        FIRST_SCAN,
        f"{FIRST_SCAN}: TRUE in the first scan after the controller has started.",
        [Tag("Q", _BOOL, "Output", "0", "TRUE in the first call after the start")],
        [Tag("HasRun", _BOOL, "Local", "0")],
        ["Q := NOT HasRun;", "HasRun := 1;"],
        ["Q := 0;", "HasRun := 0;"],
    )
