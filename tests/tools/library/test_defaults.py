"""Inputs that a program leaves out have the right values in the handwritten blocks."""

from __future__ import annotations

from datetime import timedelta
from pathlib import Path

import pytest

from fault_cell import heads
from plc_bench import LIBRARY
from structured_text.engines import build
from structured_text.engines.base import Value
from structured_text.language import syntax as s
from structured_text.language.types import BlockType
from structured_text.projects.needed import needed
from tiers import sampled

_ANY = timedelta(seconds=5)
#: Defaults that differ from the default of the type. Size is 256 for words beyond 48 bytes.
_USUAL: dict[str, Value] = {
    "Axes": "ORIGIN_INCREMENTAL",
    "Axis": 1,
    "Confirm": timedelta(milliseconds=500),
    "ImageSize": 512,
    "Interval": timedelta(milliseconds=100),
    "Margin": timedelta(milliseconds=150),
    "Number": 2,
    "OutputWord": 24,
    "Size": 48,
    "StartProgram": True,
    "Timeout": _ANY,
}
_SPECIAL: dict[tuple[str, str], Value] = {
    ("FB_CommandRecorder", "After"): 8,
    ("FB_CommandRecorder", "LogSize"): 32,
    ("FB_ChannelStatus", "CommandLimit"): 60_000,
    ("FB_ChannelStatus", "SequenceLimit"): 60_000,
    **{("FB_PickPlace", f"{place}Pallet"): -1 for place in ("Source", "Target")},
    **{("FB_PickPlace", f"{place}Position"): 1 for place in ("Source", "Target")},
    ("FB_PickPlace", "Timeout"): timedelta(seconds=60),
    ("FB_MoveTable", "ArchAxis"): 3,
    ("FB_MoveTable", "MovesSize"): 50,
    ("FB_MoveTable", "Rows"): 50,
    ("FB_MoveTable", "Timeout"): timedelta(seconds=60),
    ("FB_MoveTable", "WorkPosition"): 1,
    ("FB_Override", "Percent"): 10,
    ("FB_Override", "Rise"): 10,
    ("FB_Override", "Pace"): timedelta(milliseconds=200),
    ("FB_PointBackup", "Count"): 100,
    ("FB_PointRestore", "FirstRow"): 1,
    ("FB_Operator", "HmiOk"): True,
    ("FB_Operator", "Timeout"): timedelta(seconds=10),
    ("FB_Interlock", "Timeout"): timedelta(seconds=60),
    ("FB_PowerUp", "Timeout"): timedelta(seconds=60),
    ("FB_RcxProgramCall", "Timeout"): timedelta(0),  # all callers of this block pass the value
    ("FB_ReturnToOrigin", "Timeout"): timedelta(seconds=60),
    ("FB_RealTimeValue", "Size"): 256,
    ("FB_RealTimeValueInWords", "Size"): 256,
    ("FB_ToolPosition", "Period"): timedelta(milliseconds=500),
    **{
        (f"FB_ProgramCall{words}", pin): value
        for words in ("", "InWords")
        for pin, value in (
            *(("JobNumber", 1), ("StrobeBit", 20), ("AcknowledgeBit", 20), ("CompleteBit", 21)),
            *(("FirstWord", 2), ("AcknowledgeTimeout", _ANY), ("Timeout", timedelta(seconds=60))),
        )
    },
    **{
        (f"FB_{verb}Bit{words}", "Port"): 20
        for verb in ("Read", "Write")
        for words in ("", "InWords")
    },
    **{
        (f"FB_{verb}Port{words}", "Port"): 2
        for verb in ("Read", "Write")
        for words in ("", "InWords")
    },
}
_NOTHING = {"BOOL": False, "WORD": 0, "INT": 0, "DINT": 0, "REAL": 0.0, "STRING": ""}


def _blocks() -> dict[str, dict[str, str]]:
    """Return the in-out pins, with types, of each block that has the robot or an image."""
    found = {}
    for file, pou in heads():
        if "Generated from" in file.read_text(encoding="utf-8").partition("*)")[0]:
            continue
        pins = {
            name.text: declaration.spec.name.text
            for section in pou.sections
            if section.kind == "VAR_IN_OUT"
            for declaration in section.variables
            if isinstance(declaration.spec, s.NamedSpec)
            for name in declaration.names
        }
        if {"RCX_REF", "RCX_IMAGE", "RCX_IMAGE_WORDS"} & set(pins.values()):
            found[pou.name.text] = pins
    return found


_BLOCKS = _blocks()
#: Parts of other blocks, which pass all of their inputs.
_PARTS = {
    *("FB_RcxAwaitInput", "FB_RcxCommandWhile", "FB_RcxDedicatedInputs", "FB_RcxGrip"),
    *("FB_RcxPickLook", "FB_RcxHandshake", "FB_RcxMakeHead", "FB_RcxPlaceMove", "FB_RcxPointRow"),
    *("FB_RcxPanelCommands", "FB_RcxPanelJog", "FB_RcxPanelLamps", "FB_RcxPanelPlace"),
    *("FB_RcxPanelReasons", "FB_RcxPanelSequences", "FB_RcxTakeHead", "FB_RcxSharedWords"),
    *("FB_RcxArrival", "FB_RcxMove", "FB_RcxRow"),
}


@pytest.mark.parametrize("block", sampled(sorted(set(_BLOCKS) - _PARTS), 3))
def test_an_input_that_is_left_out_has_its_default(block: str, tmp_path: Path) -> None:
    """Source: design of the library, 7, and the comments of the pins."""
    pins = _BLOCKS[block]
    program = tmp_path / "Defaults.st"
    declared = "".join(f"    Own{name} : {kind};\n" for name, kind in pins.items())
    given = ", ".join(f"{name} := Own{name}" for name in pins)
    program.write_text(
        f"PROGRAM Defaults\n  VAR\n    Block : {block};\n{declared}  END_VAR\n"
        f"  Block({given});\nEND_PROGRAM\n",
        encoding="utf-8",
    )
    running = build([program, *needed([program], LIBRARY)], "builtin").program
    running.scan(0)
    kind = running.type_of("Main.Block")
    assert isinstance(kind, BlockType)
    inputs = [pin for pin in kind.variables if pin.section == "VAR_INPUT"]
    assert inputs or block == "FB_DedicatedBits"
    for pin in inputs:
        name = getattr(pin.type, "name", "")
        nothing = timedelta(0) if name == "TIME" else _NOTHING.get(name)
        expected = _SPECIAL.get((block, pin.name), _USUAL.get(pin.name, nothing))
        if expected is not None:
            assert running.read(f"Main.Block.{pin.name}") == expected, pin.name
